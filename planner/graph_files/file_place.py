"""Values of a file, checked, with errors that name the file, the place and the limit."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any, NoReturn

from planner.graph_files.route_graph import ExchangeError, GraphId
from planner.scene import Vec

LARGEST_WRITTEN = 1e12
"""The squares of larger numbers lose all small parts."""
MOST_SHOWN = 40


@dataclass(frozen=True, slots=True)
class FilePlace:
    """A place in a file, such as ``features[3].properties.id``."""

    file: str
    path: str = ""

    def at(self, key: str | int) -> FilePlace:
        """Place of a member."""
        if isinstance(key, int):
            return FilePlace(self.file, f"{self.path}[{key}]")
        return FilePlace(self.file, f"{self.path}.{key}" if self.path else key)

    def error(self, what: str) -> ExchangeError:
        """Error at this place."""
        return ExchangeError(": ".join(part for part in (self.file, self.path, what) if part))

    def mapping(self, value: Any) -> dict[str, Any]:
        """Check that the value is an object; return a copy."""
        if not isinstance(value, dict):
            raise self.error(f"{shown(value)}: must be an object of keys and values")
        return dict(value)

    def sequence(self, value: Any) -> list[Any]:
        """Check that the value is a list."""
        if not isinstance(value, list):
            raise self.error(f"{shown(value)}: must be a list")
        return value

    def needed(self, record: dict[str, Any], key: str) -> Any:
        """Remove and return the value of a key that must exist."""
        if key not in record:
            raise self.error(f"has no {key}: must have one")
        return record.pop(key)

    def number(self, value: Any) -> float:
        """Check that the value is a finite number within ``LARGEST_WRITTEN``."""
        number = as_number(value)
        if number is None:
            raise self.error(
                f"{shown(value)}: must be a finite number within +-{LARGEST_WRITTEN:g}"
            )
        return number

    def identity(self, value: Any) -> GraphId:
        """Check that the value is an id: a whole number or a string."""
        if isinstance(value, bool) or not isinstance(value, str | int):
            raise self.error(f"{shown(value)}: must be a whole number or a string")
        return value

    def place(self, value: Any) -> tuple[Vec, list[Any]]:
        """Check that the value is a list of two coordinates or more; return two and the rest."""
        row = self.sequence(value)
        if len(row) < 2:
            raise self.error(f"{shown(value)}: must be [x, y]")
        return (self.at(0).number(row[0]), self.at(1).number(row[1])), row[2:]


def as_number(value: Any) -> float | None:
    """Return a finite number within ``LARGEST_WRITTEN`` as a float, otherwise None."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    if isinstance(value, int) and abs(value) > LARGEST_WRITTEN:
        return None
    return float(value) if math.isfinite(value) and abs(value) <= LARGEST_WRITTEN else None


def take_number(record: dict[str, Any], key: str) -> float | None:
    """Remove and return a number; leave anything else."""
    number = as_number(record.get(key))
    if number is not None:
        del record[key]
    return number


def shown(value: Any) -> str:
    """Write the value in at most ``MOST_SHOWN`` characters."""
    text = repr(value) if not isinstance(value, dict | list) else type(value).__name__
    return text if len(text) <= MOST_SHOWN else f"{text[:MOST_SHOWN]}..."


def parse_json(text: str, file: str) -> dict[str, Any]:
    """Parse a JSON object; :class:`ExchangeError` with line and column if it is none."""

    def refuse(constant: str) -> NoReturn:
        raise ExchangeError(f"{file}: {constant}: must be a finite number")

    try:
        document = json.loads(text, parse_constant=refuse)
    except json.JSONDecodeError as error:
        raise ExchangeError(f"{file}:{error.lineno}:{error.colno}: not JSON: {error.msg}") from None
    except RecursionError:
        raise ExchangeError(f"{file}: nested too deeply") from None
    except ExchangeError:
        raise
    except ValueError as error:  # a number of thousands of digits
        raise ExchangeError(f"{file}: not JSON: {error}") from None
    return FilePlace(file).mapping(document)


def json_text(document: Any) -> str:
    """Write strict JSON with one line for each value."""
    return json.dumps(document, allow_nan=False, indent=1) + "\n"
