"""The robots of ``clearway fleet``: a CSV or JSON file of names, places and radii.

- CSV has a header row with the columns ``name, start_x, start_y, goal_x, goal_y, radius``; JSON is
  a list of objects with these fields, or an object with that list as ``robots``.
- ``name`` may be omitted: robot1, robot2 and so on. Lengths are in the source's units.
- Errors name the file, the row and the column; rows count from 1, in CSV as an editor counts lines.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

NUMBERS = ("start_x", "start_y", "goal_x", "goal_y", "radius")
COLUMNS = ("name", *NUMBERS)


class RobotsError(ValueError):
    """Error: the robots' file is invalid."""


@dataclass(frozen=True, slots=True)
class FleetRobot:
    """A robot with its start and goal."""

    name: str
    start: tuple[float, float]
    goal: tuple[float, float]
    radius: float


def load_robots(path: Path) -> list[FleetRobot]:
    """Robots in a file; :class:`RobotsError` if it is invalid."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise RobotsError(f"{path}: byte {error.start}: must be UTF-8 text") from None
    except OSError as error:
        raise RobotsError(f"{path}: {error.strerror or error}") from None
    is_json = path.suffix.lower() == ".json" or text.lstrip()[:1] in ("[", "{")
    rows = list(_json_rows(path, text) if is_json else _csv_rows(path, text))
    if not rows:
        raise RobotsError(f"{path}: no robots: must hold one at least")
    robots: dict[str, FleetRobot] = {}
    for place, row in rows:
        robot = _robot(f"{path}: {place}", row, len(robots) + 1)
        if robot.name in robots:
            raise RobotsError(f"{path}: {place}, column name: {robot.name!r} is there twice")
        robots[robot.name] = robot
    return list(robots.values())


def _csv_rows(path: Path, text: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    reader = csv.reader(io.StringIO(text), skipinitialspace=True)
    try:
        lines = [(reader.line_num, [cell.strip() for cell in row]) for row in reader]
    except csv.Error as error:
        raise RobotsError(f"{path}: row {reader.line_num}: {error}") from None
    lines = [(number, row) for number, row in lines if any(row)]
    if not lines:
        return
    header_row, header = lines[0]
    for column in NUMBERS:
        if column not in header:
            raise RobotsError(
                f"{path}: row {header_row}: there is no column {column}:"
                f" must be {', '.join(COLUMNS)}"
            )
    for number, row in lines[1:]:
        if len(row) != len(header):
            raise RobotsError(
                f"{path}: row {number}: has {len(row)} columns, must have {len(header)}"
            )
        yield f"row {number}", dict(zip(header, row, strict=True))


def _json_rows(path: Path, text: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    try:
        content = json.loads(text)
    except json.JSONDecodeError as error:
        where = f"row {error.lineno}, column {error.colno}"
        raise RobotsError(f"{path}: {where}: {error.msg}") from None
    except RecursionError:
        raise RobotsError(f"{path}: nested too deeply") from None
    if isinstance(content, dict):
        content = content.get("robots")
    if not isinstance(content, list):
        raise RobotsError(f"{path}: must be a list of robots, or an object with it as robots")
    for number, row in enumerate(content, start=1):
        if not isinstance(row, dict):
            raise RobotsError(f"{path}: row {number}: must be an object with {', '.join(COLUMNS)}")
        yield f"row {number}", row


def _robot(place: str, row: Mapping[str, Any], number: int) -> FleetRobot:
    name = row.get("name", "")
    if not isinstance(name, str | int) or isinstance(name, bool):
        raise RobotsError(f"{place}, column name: {name!r}: must be a word")
    values = {column: _number(place, column, row.get(column)) for column in NUMBERS}
    if values["radius"] <= 0.0:
        raise RobotsError(f"{place}, column radius: {values['radius']:g}: must be > 0")
    return FleetRobot(
        str(name) or f"robot{number}",
        (values["start_x"], values["start_y"]),
        (values["goal_x"], values["goal_y"]),
        values["radius"],
    )


def _number(place: str, column: str, value: Any) -> float:
    if value is None or value == "":
        raise RobotsError(f"{place}, column {column}: is missing: must be a number")
    try:
        number = float(value) if not isinstance(value, bool) else math.nan
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number) or "_" in str(value):
        raise RobotsError(f"{place}, column {column}: {value!r}: must be a finite number")
    return number
