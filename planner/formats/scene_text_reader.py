"""Reader of the scene's text (:mod:`planner.formats.scene_text`), line by line."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any, get_args

from planner.formats.line_scanner import SEPARATOR, Scanner
from planner.scene import (
    Arc,
    ArcRecord,
    Binarisation,
    Bounds,
    CircleRecord,
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
    derived_bounds,
    extent_points,
)

HEADER = "#@ clearway.scene/1"
ARC_END_TOLERANCE = 0.25
"""Largest distance of an arc's ends from its circle, as a part of the radius: fitted arcs are a
fraction of a pixel off; with more, the numbers belong to another edge."""


class SceneReader:
    """Collector of records into objects, and of extensions."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.extended: bool | None = None
        self.fields: dict[str, Any] = {}
        self.remarks: list[str] = []
        self.objects: list[SceneObject] = []
        self.ids: set[int] = set()
        self.in_object = False
        self.target: list[Record] | None = None
        self.borders: list[list[Record]] = []

    def take_line(self, scan: Scanner) -> None:
        """Read the next line of the text."""
        if scan.rest() == "":
            return
        if self.extended is None:
            self.extended = scan.rest().split() == HEADER.split()
            if self.extended:
                return
        if scan.rest().startswith("#@") and self.extended:
            scan.at += 2
            scan.skip_space()
            self._extension(scan)
        elif not scan.at_end():
            self._record(scan)

    def _record(self, scan: Scanner) -> None:
        record = _read_record(scan)
        scan.end()
        if self.in_object:
            self.borders[-1].append(record)
            return
        if not self.extended:
            record = _clockwise(record)
        self.objects.append(SceneObject(len(self.objects), (record,)))

    def _extension(self, scan: Scanner) -> None:
        at = scan.at
        match scan.word("an extension"):
            case "units":
                self._set(scan, "units", _read_units(scan))
            case "bounds":
                given, bounds = _read_bounds(scan)
                self._set(scan, "bounds", bounds)
                self.fields["bounds_given"] = given
            case "size":
                self._set(scan, "size", (scan.count("width", 1), scan.count("height", 1)))
            case "border_pixels":
                self._set(scan, "border_pixels", scan.count("border_pixels", 0))
            case "binarisation":
                self._set(scan, "binarisation", _read_binarisation(scan))
            case "timings_ms":
                self._set(scan, "timings_ms", _read_timings(scan))
            case "remark":
                self.remarks.append(_read_remark(scan))
            case "object":
                self._begin_object(scan)
            case "hole":
                if not self.in_object:
                    raise scan.error("a hole needs an object above it", at)
                self._check_border(scan)
                self.borders.append([])
            case "arc":
                self._set_arc(scan)
            case "residual_px":
                self._set_last(scan, residual_px=scan.number("residual_px"))
            case word:
                raise scan.error(f"{word[:24]!r} is not an extension of clearway.scene/1", at)
        if not scan.at_end():
            scan.end()

    def _set(self, scan: Scanner, key: str, value: object) -> None:
        if key in self.fields:
            raise scan.error(f"{key} is given twice")
        self.fields[key] = value

    def _begin_object(self, scan: Scanner) -> None:
        at = scan.at
        if not self.in_object and self.objects:
            raise scan.error("records stand above the first object", at)
        identity = scan.count("object", 0)
        if identity in self.ids:
            raise scan.error(f"object {identity} is given twice", at)
        self.ids.add(identity)
        if self.in_object:
            self._check_border(scan)
            self._end_object()
        self.in_object = True
        self.borders = [[]]
        self.identity = identity

    def _check_border(self, scan: Scanner) -> None:
        if not self.borders[-1]:
            raise scan.error("the object or hole above has no records")

    def _end_object(self) -> None:
        outline, *holes = (tuple(border) for border in self.borders)
        self.objects.append(SceneObject(self.identity, outline, tuple(holes)))

    def _last(self, scan: Scanner) -> Record:
        if self.in_object:
            if self.borders[-1]:
                return self.borders[-1][-1]
        elif self.objects:
            return self.objects[-1].records[-1]
        raise scan.error("no record comes before this one")

    def _replace_last(self, record: Record) -> None:
        if self.in_object:
            self.borders[-1][-1] = record
        else:
            self.objects[-1] = replace(self.objects[-1], records=(record,))

    def _set_last(self, scan: Scanner, **changes: Any) -> None:
        self._replace_last(replace(self._last(scan), **changes))

    def _set_arc(self, scan: Scanner) -> None:
        record = self._last(scan)
        if not isinstance(record, ArcRecord | PolygonRecord):
            raise scan.error("only the edges of A and L can be arcs")
        at = scan.at
        index = scan.count("the edge's number", 1) - 1
        if index >= len(record.edges):
            raise scan.error(f"edge {index + 1}: the record has {len(record.edges)}", at)
        center = (scan.number("x"), scan.number("y"))
        radius = scan.radius()
        sense_at = scan.at
        sense = scan.word("cw or ccw")
        if sense not in ("cw", "ccw"):
            raise scan.error(f"{sense[:24]!r}: must be cw or ccw", sense_at)
        chord = record.edges[index]
        arc = Arc(chord.start, chord.end, center, radius, sense == "ccw")
        problem = arc_problem(arc)
        if problem:
            raise scan.error(problem, at)
        edges = (*record.edges[:index], arc, *record.edges[index + 1 :])
        self._replace_last(replace(record, edges=edges))

    def finish(self) -> Scene:
        """Return the scene after all lines."""
        if self.in_object:
            if not self.borders[-1]:
                raise SceneError(f"{self.name}: the last object or hole has no records")
            self._end_object()
        if "bounds" not in self.fields:
            points = [p for o in self.objects for p in extent_points(o)]
            if not points:
                raise SceneError(f"{self.name}: no records (P, S, C, A or L) and no bounds in it")
            self.fields |= {"bounds": derived_bounds(points), "bounds_given": False}
        units = self.fields.pop("units", "px")
        return Scene(
            units=units,
            objects=tuple(self.objects),
            remarks=tuple(self.remarks),
            **self.fields,
        )


def _read_record(scan: Scanner) -> Record:
    at = scan.at
    letter = scan.word("a record").upper()
    match letter:
        case "P":
            return PointRecord(scan.point())
        case "S":
            return SegmentRecord(scan.point(), scan.point())
        case "C":
            center = scan.point()
            scan.skip_space(SEPARATOR)
            return CircleRecord(center, scan.radius())
        case "A":
            points = scan.points(least=2)
            return ArcRecord(_chords(points))
        case "L":
            points = scan.points(least=1)
            return PolygonRecord(_chords([*points, points[0]]))
    raise scan.error(f"{letter[:24]!r} is not a record: one of P, S, C, A, L is expected", at)


def _chords(points: list[Vec]) -> tuple[Segment, ...]:
    return tuple(Segment(a, b) for a, b in pairwise(points))


def _clockwise(record: Record) -> Record:
    """The same polygon, clockwise as seen on a screen with y down."""
    if not isinstance(record, PolygonRecord):
        return record
    corners = [edge.start for edge in record.edges]
    x0, y0 = corners[0]
    twice_area = sum(
        (a.start[0] - x0) * (a.end[1] - y0) - (a.end[0] - x0) * (a.start[1] - y0)
        for a in record.edges
    )
    if twice_area >= 0.0:
        return record
    turned = [corners[0], *reversed(corners[1:])]
    return replace(record, edges=_chords([*turned, turned[0]]))


def _read_units(scan: Scanner) -> str:
    at = scan.at
    units = scan.word("units")
    if units not in get_args(Units):
        raise scan.error(f"units {units[:24]!r}: must be px, m or cells", at)
    return units


def _read_bounds(scan: Scanner) -> tuple[bool, Bounds]:
    at = scan.at
    how = scan.word("given or derived")
    if how not in ("given", "derived"):
        raise scan.error(f"bounds {how[:24]!r}: must be given or derived", at)
    numbers = [scan.number(what) for what in ("x_min", "y_min", "x_max", "y_max")]
    if not (numbers[0] < numbers[2] and numbers[1] < numbers[3]):
        raise scan.error("bounds: must have a positive width and height", at)
    return how == "given", Bounds(*numbers)


def _read_binarisation(scan: Scanner) -> Binarisation:
    at = scan.at
    match scan.json("binarisation"):
        case {
            "method": str(method),
            "threshold": float(threshold) | int(threshold),
            "polarity": ("dark" | "light") as polarity,
            "reason": str(reason),
        }:
            return Binarisation(method, float(threshold), polarity, reason)
    raise scan.error("binarisation: needs method, threshold, polarity and reason", at)


def _read_timings(scan: Scanner) -> dict[str, float]:
    at = scan.at
    value = scan.json("timings_ms")
    if isinstance(value, dict) and all(type(v) in (int, float) for v in value.values()):
        return {key: float(v) for key, v in value.items()}
    raise scan.error("timings_ms: must be an object of numbers", at)


def _read_remark(scan: Scanner) -> str:
    at = scan.at
    value = scan.json("remark")
    if not isinstance(value, str):
        raise scan.error("remark: must be a JSON string", at)
    return value


def arc_problem(arc: Arc) -> str | None:
    """Description of a fault in an arc's ends, or None."""
    for which, end in (("start", arc.start), ("end", arc.end)):
        off = abs(math.dist(arc.center, end) - arc.radius)
        if off > ARC_END_TOLERANCE * arc.radius:
            limit = f"at most {ARC_END_TOLERANCE:g} of the radius {arc.radius:g}"
            return f"the arc's {which} lies {off:g} off its circle: {limit}"
    return None
