"""Reader of the scene's JSON (:mod:`planner.formats.scene_json`).

Errors name the file and the member, as in ``objects[3].records[0].radius``. Unknown members are
skipped.
"""

from __future__ import annotations

import json
import reprlib
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NoReturn, get_args

from planner.formats.line_scanner import MAX_COORDINATE
from planner.formats.scene_json import SCHEMA
from planner.formats.scene_text_reader import arc_problem
from planner.scene import (
    Arc,
    ArcRecord,
    Binarisation,
    Bounds,
    CircleRecord,
    Edge,
    PointRecord,
    PolygonRecord,
    Record,
    Scene,
    SceneError,
    SceneObject,
    Segment,
    SegmentRecord,
    Units,
    Vec,
)


def read_scene_json(text: str, name: str = "<text>") -> Scene:
    """Read the scene in ``text``; ``name`` is the file's name in errors.

    Raises :class:`SceneError` on other text, numbers beyond ``MAX_COORDINATE``, edges that do not
    connect, and arcs off their circles.
    """
    try:
        document = json.loads(text.removeprefix("\ufeff"), parse_constant=_refuse_constant)
    except json.JSONDecodeError as error:
        raise SceneError(f"{name}:{error.lineno}:{error.colno}: not JSON ({error.msg})") from None
    except ValueError as error:
        raise SceneError(f"{name}: not JSON ({error})") from None
    except RecursionError:
        raise SceneError(f"{name}: JSON nested too deeply") from None
    top = _Member(name, "", document)
    schema = document.get("schema") if isinstance(document, dict) else None
    if schema != SCHEMA:
        kind = document.get("type") if isinstance(document, dict) else None
        hint = "; Scene.from_geo takes GeoJSON" if isinstance(kind, str) else ""
        raise SceneError(
            f"{name}: schema {reprlib.repr(schema)}: must be {SCHEMA!r}, as clearway extract "
            f"--format json writes it{hint}"
        )
    return _scene(top)


def _refuse_constant(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is not a finite number")


class _Member:
    def __init__(self, name: str, place: str, value: Any) -> None:
        self.name, self.place, self.value = name, place, value

    def refuse(self, must: str) -> NoReturn:
        where = f"{self.name}: {self.place or 'the document'}"
        if self.value is None:
            raise SceneError(f"{where}: is missing: must be {must}")
        raise SceneError(f"{where} = {reprlib.repr(self.value)}: must be {must}")

    def get(self, key: str) -> _Member:
        """Member of an object, with the value None if it is missing."""
        if not isinstance(self.value, dict):
            self.refuse("an object")
        place = f"{self.place}.{key}" if self.place else key
        return _Member(self.name, place, self.value.get(key))

    def rows(self) -> list[_Member]:
        if not isinstance(self.value, list):
            self.refuse("a list")
        return [
            _Member(self.name, f"{self.place}[{number}]", value)
            for number, value in enumerate(self.value)
        ]

    def number(self) -> float:
        is_number = isinstance(self.value, int | float) and not isinstance(self.value, bool)
        if not is_number or not abs(self.value) <= MAX_COORDINATE:
            self.refuse(f"a number within +-{MAX_COORDINATE:g}")
        return float(self.value)

    def count(self, least: int) -> int:
        if type(self.value) is not int or self.value < least:
            self.refuse(f"a whole number >= {least}")
        return int(self.value)

    def text(self) -> str:
        """A string that can be written again: JSON may hold halves of characters."""
        if not isinstance(self.value, str) or any("\ud800" <= c <= "\udfff" for c in self.value):
            self.refuse("a string of whole characters")
        return str(self.value)

    def flag(self) -> bool:
        if not isinstance(self.value, bool):
            self.refuse("true or false")
        return bool(self.value)

    def one_of(self, *words: str) -> str:
        if not isinstance(self.value, str) or self.value not in words:
            self.refuse(f"one of {', '.join(words)}")
        return str(self.value)

    def numbers(self, count: int) -> list[float]:
        if not isinstance(self.value, list) or len(self.value) != count:
            self.refuse(f"a list of {count} numbers")
        return [row.number() for row in self.rows()]

    def point(self) -> Vec:
        x, y = self.numbers(2)
        return x, y


def _scene(top: _Member) -> Scene:
    units: Any = top.get("units").one_of(*get_args(Units))
    size, how = top.get("size"), top.get("binarisation")
    given, pixels = top.get("bounds_given"), top.get("counts")
    objects: list[SceneObject] = []
    ids: set[int] = set()
    for row in top.get("objects").rows():
        one = _object(row)
        if one.id in ids:
            row.get("id").refuse("another number: it is there twice")
        ids.add(one.id)
        objects.append(one)
    bounds = Bounds(*top.get("bounds").numbers(4))
    if not (bounds.width > 0.0 and bounds.height > 0.0):
        top.get("bounds").refuse("x_min, y_min, x_max, y_max, the least first")
    return Scene(
        units=units,
        bounds=bounds,
        objects=tuple(objects),
        bounds_given=given.value is None or given.flag(),
        size=None if size.value is None else _size(size),
        border_pixels=0 if pixels.value is None else pixels.get("border_pixels").count(0),
        binarisation=None if how.value is None else _binarisation(how),
        timings_ms=_timings(top.get("timings_ms")),
        remarks=tuple(row.text() for row in _optional(top.get("remarks"))),
    )


def _optional(member: _Member) -> list[_Member]:
    return [] if member.value is None else member.rows()


def _size(member: _Member) -> tuple[int, int]:
    if not isinstance(member.value, list) or len(member.value) != 2:
        member.refuse("width and height")
    width, height = (row.count(1) for row in member.rows())
    return width, height


def _binarisation(member: _Member) -> Binarisation:
    polarity: Any = member.get("polarity").one_of("dark", "light")
    return Binarisation(
        member.get("method").text(),
        member.get("threshold").number(),
        polarity,
        member.get("reason").text(),
    )


def _timings(member: _Member) -> dict[str, float]:
    if member.value is None:
        return {}
    if not isinstance(member.value, dict):
        member.refuse("an object of numbers")
    return {key: member.get(key).number() for key in member.value}


def _object(member: _Member) -> SceneObject:
    holes = tuple(_border(hole) for hole in _optional(member.get("holes")))
    return SceneObject(member.get("id").count(0), _border(member.get("records")), holes)


def _border(member: _Member) -> tuple[Record, ...]:
    rows = member.rows()
    if not rows:
        member.refuse("a list of one record at least")
    return tuple(map(_record, rows))


def _record(member: _Member) -> Record:
    kind = member.get("type").one_of("P", "S", "C", "A", "L")
    residual_px = member.get("residual_px")
    residual = 0.0 if residual_px.value is None else residual_px.number()
    match kind:
        case "P":
            return PointRecord(member.get("at").point(), residual)
        case "S":
            return SegmentRecord(member.get("from").point(), member.get("to").point(), residual)
        case "C":
            return CircleRecord(member.get("center").point(), _radius(member), residual)
        case "A":
            return ArcRecord(_edges(member.get("edges"), closed=False), residual)
        case _:
            return PolygonRecord(_edges(member.get("edges"), closed=True), residual)


def _radius(member: _Member) -> float:
    radius = member.get("radius")
    if radius.number() < 0.0:
        radius.refuse(">= 0")
    return radius.number()


def _edges(member: _Member, *, closed: bool) -> tuple[Edge, ...]:
    rows = member.rows()
    if not rows:
        member.refuse("a list of one edge at least")
    edges = [_edge(row) for row in rows]
    around: Sequence[tuple[Edge, Edge]] = list(pairwise([*edges, edges[0]] if closed else edges))
    for row, (edge, after) in zip(rows, around, strict=False):
        if edge.end != after.start:
            row.get("to").refuse(f"{list(after.start)}, where the next edge begins")
    return tuple(edges)


def _edge(member: _Member) -> Edge:
    kind = member.get("kind").one_of("segment", "arc")
    start, end = member.get("from").point(), member.get("to").point()
    if kind == "segment":
        return Segment(start, end)
    ccw = member.get("ccw").flag()
    arc = Arc(start, end, member.get("center").point(), _radius(member), ccw)
    if problem := arc_problem(arc):
        raise SceneError(f"{member.name}: {member.place}: {problem}")
    return arc
