"""The scene as text: the paper's records (section 3.3), one a line, read and written without loss.

The plain format
    P (x,y)                     a point
    S (x0,y0) (x1,y1)           a segment
    C (xc,yc) r                 a circle
    A N (x1,y1)...(xn,yn)       an open chain of N vertices
    L N (x1,y1)...(xn,yn)       a generalized polygon of N vertices, closed from last to first
``#`` begins a comment. Spaces, tabs and commas between coordinates are all the same.

The extensions, for what the plain format cannot say, hide in comments. They count only where
the first line that is not blank is ``#@ clearway.scene/1``; any other reader skips them.
    #@ units px|m|cells
    #@ bounds given|derived x_min y_min x_max y_max
    #@ size width height            of the picture, in pixels, or of the grid, in cells
    #@ border_pixels n
    #@ binarisation {...}           JSON, as are the next two
    #@ timings_ms {...}
    #@ remark "..."
    #@ object id                    the records below belong to this object
    #@ hole                         the records below are the border of a hole of the object
    #@ arc k xc yc r cw|ccw         edge k (from 1) of the record above is this arc
    #@ residual_px d                how far the record above lies from its pixels

A file without extensions is in px; each record is an object of its own; polygons are turned to
run clockwise as seen on the screen; the bounds are derived, generously: the records' bounding
box, grown by its diagonal on every side. Numbers are written as Python's shortest ``repr``.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import pairwise
from typing import Any, get_args

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
    object_records,
    record_edges,
)

HEADER = "#@ clearway.scene/1"
MAX_COORDINATE = 1e15
"""Beyond this, sums of squares of coordinates are no use to the planner."""
ARC_END_TOLERANCE = 0.25
"""How far an arc's ends may lie off its circle, as a part of the radius: fitted arcs are a
fraction of a pixel off; more means that the numbers belong to another edge."""

_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?(?![\w.])")
_WORD = re.compile(r"[^\s(),#]+")
_SPACE = re.compile(r"\s*")
_SEPARATOR = re.compile(r"[\s,]*")


def read_scene_text(text: str, name: str = "<text>") -> Scene:
    """The scene that ``text`` holds; ``name`` stands for the file in errors.

    Raises :class:`SceneError` ("name:line:column: what") for anything that is not the format of
    this module: unknown records, wrong counts, numbers that are not finite or beyond
    ``MAX_COORDINATE``, radii <= 0, trailing characters. O(length of the text).
    """
    reader = _Reader(name)
    for number, line in enumerate(text.removeprefix("\ufeff").splitlines(), start=1):
        reader.take_line(_Scanner(name, number, line))
    return reader.finish()


def write_scene_text(scene: Scene) -> str:
    """The scene as text with all extensions; ``read_scene_text`` gives an equal scene back.

    Raises :class:`SceneError` where a record cannot be written: edges that do not connect,
    numbers that are not finite, arcs off their circles.
    """
    return "\n".join(_scene_lines(scene)) + "\n"


def derived_bounds(points: Iterable[Vec]) -> Bounds:
    """A generous rectangle: the bounding box of ``points``, grown by its diagonal (at least 1)."""
    xs, ys = zip(*points, strict=True)
    grow = max(1.0, math.dist((min(xs), min(ys)), (max(xs), max(ys))))
    return Bounds(min(xs) - grow, min(ys) - grow, max(xs) + grow, max(ys) + grow)


def extent_points(obj: SceneObject) -> Iterator[Vec]:
    """Points whose bounding box holds the object; an arc counts as its whole circle."""
    for record in object_records(obj):
        if isinstance(record, PointRecord):
            yield record.at
        for edge in record_edges(record):
            if isinstance(edge, Arc):
                (x, y), r = edge.center, edge.radius
                yield from ((x - r, y - r), (x + r, y + r))
            yield from (edge.start, edge.end)


# Reading -----------------------------------------------------------------------------------


class _Scanner:
    """One line, read from left to right; knows where it is for the error messages."""

    def __init__(self, name: str, line_number: int, line: str) -> None:
        self.name = name
        self.line_number = line_number
        self.line = line
        self.at = 0
        self.skip_space()

    def error(self, what: str, at: int | None = None) -> SceneError:
        column = (self.at if at is None else at) + 1
        return SceneError(f"{self.name}:{self.line_number}:{column}: {what}")

    def skip_space(self, pattern: re.Pattern[str] = _SPACE) -> None:
        match = pattern.match(self.line, self.at)
        self.at = match.end() if match else self.at

    def rest(self) -> str:
        return self.line[self.at :]

    def at_end(self) -> bool:
        return self.at >= len(self.line) or self.line[self.at] == "#"

    def end(self) -> None:
        if not self.at_end():
            raise self.error(f"nothing more is expected here, found {self.found()}")

    def found(self) -> str:
        rest = self.rest()
        if not rest:
            return "the end of the line"
        word = _WORD.match(rest)
        return repr(word.group()[:24] if word else rest[0])

    def word(self, what: str) -> str:
        match = _WORD.match(self.line, self.at)
        if match is None:
            raise self.error(f"expected {what}, found {self.found()}")
        self.at = match.end()
        self.skip_space()
        return match.group()

    def number(self, what: str) -> float:
        match = _NUMBER.match(self.line, self.at)
        if match is None:
            raise self.error(f"expected {what}, a finite number, found {self.found()}")
        value = float(match.group())
        if abs(value) > MAX_COORDINATE:
            raise self.error(f"{what} = {value:g}: must lie within +-{MAX_COORDINATE:g}")
        self.at = match.end()
        self.skip_space()
        return value

    def radius(self) -> float:
        at = self.at
        value = self.number("a radius")
        if value <= 0.0:
            raise self.error(f"radius = {value:g}: must be > 0", at)
        return value

    def count(self, what: str, least: int) -> int:
        at = self.at
        word = self.word(what)
        if re.fullmatch(r"[0-9]{1,9}", word) is None or int(word) < least:
            raise self.error(f"{what} = {word[:24]}: must be a whole number >= {least}", at)
        return int(word)

    def point(self) -> Vec:
        self.skip_space(_SEPARATOR)
        self.symbol("(")
        x = self.number("x")
        self.skip_space(_SEPARATOR)
        y = self.number("y")
        self.symbol(")")
        return x, y

    def symbol(self, symbol: str) -> None:
        if not self.line.startswith(symbol, self.at):
            raise self.error(f"expected {symbol!r}, found {self.found()}")
        self.at += 1
        self.skip_space()

    def points(self, least: int) -> list[Vec]:
        at = self.at
        count = self.count("the number of vertices", least)
        points: list[Vec] = []
        while self.rest().lstrip(" \t,").startswith("("):
            points.append(self.point())
        if len(points) != count:
            raise self.error(f"{count} vertices announced, {len(points)} found", at)
        return points

    def json(self, what: str) -> Any:
        try:
            value = json.loads(self.rest(), parse_constant=_refuse_constant)
        except ValueError as error:
            raise self.error(f"{what}: not JSON ({error})") from None
        except RecursionError:
            raise self.error(f"{what}: JSON nested too deeply") from None
        self.at = len(self.line)
        return value


def _refuse_constant(constant: str) -> None:
    raise ValueError(f"{constant} is not a finite number")


class _Reader:
    """Collects records into objects and the extensions into the scene's fields."""

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

    def take_line(self, scan: _Scanner) -> None:
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

    def _record(self, scan: _Scanner) -> None:
        record = _read_record(scan)
        scan.end()
        if self.in_object:
            self.borders[-1].append(record)
            return
        if not self.extended:
            record = _clockwise(record)
        self.objects.append(SceneObject(len(self.objects), (record,)))

    def _extension(self, scan: _Scanner) -> None:
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

    def _set(self, scan: _Scanner, key: str, value: object) -> None:
        if key in self.fields:
            raise scan.error(f"{key} is given twice")
        self.fields[key] = value

    def _begin_object(self, scan: _Scanner) -> None:
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

    def _check_border(self, scan: _Scanner) -> None:
        if not self.borders[-1]:
            raise scan.error("the object or hole above has no records")

    def _end_object(self) -> None:
        outline, *holes = (tuple(border) for border in self.borders)
        self.objects.append(SceneObject(self.identity, outline, tuple(holes)))

    def _last(self, scan: _Scanner) -> Record:
        if self.in_object:
            if self.borders[-1]:
                return self.borders[-1][-1]
        elif self.objects:
            return self.objects[-1].records[-1]
        raise scan.error("no record stands above this")

    def _replace_last(self, record: Record) -> None:
        if self.in_object:
            self.borders[-1][-1] = record
        else:
            self.objects[-1] = replace(self.objects[-1], records=(record,))

    def _set_last(self, scan: _Scanner, **changes: Any) -> None:
        self._replace_last(replace(self._last(scan), **changes))

    def _set_arc(self, scan: _Scanner) -> None:
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
        problem = _arc_problem(arc)
        if problem:
            raise scan.error(problem, at)
        edges = (*record.edges[:index], arc, *record.edges[index + 1 :])
        self._replace_last(replace(record, edges=edges))

    def finish(self) -> Scene:
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


def _read_record(scan: _Scanner) -> Record:
    at = scan.at
    letter = scan.word("a record").upper()
    match letter:
        case "P":
            return PointRecord(scan.point())
        case "S":
            return SegmentRecord(scan.point(), scan.point())
        case "C":
            center = scan.point()
            scan.skip_space(_SEPARATOR)
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
    """The same polygon, clockwise as seen on a screen whose y grows downwards."""
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


def _read_units(scan: _Scanner) -> str:
    at = scan.at
    units = scan.word("units")
    if units not in get_args(Units):
        raise scan.error(f"units {units[:24]!r}: must be px, m or cells", at)
    return units


def _read_bounds(scan: _Scanner) -> tuple[bool, Bounds]:
    at = scan.at
    how = scan.word("given or derived")
    if how not in ("given", "derived"):
        raise scan.error(f"bounds {how[:24]!r}: must be given or derived", at)
    numbers = [scan.number(what) for what in ("x_min", "y_min", "x_max", "y_max")]
    if not (numbers[0] < numbers[2] and numbers[1] < numbers[3]):
        raise scan.error("bounds: must have a positive width and height", at)
    return how == "given", Bounds(*numbers)


def _read_binarisation(scan: _Scanner) -> Binarisation:
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


def _read_timings(scan: _Scanner) -> dict[str, float]:
    at = scan.at
    value = scan.json("timings_ms")
    if isinstance(value, dict) and all(type(v) in (int, float) for v in value.values()):
        return {key: float(v) for key, v in value.items()}
    raise scan.error("timings_ms: must be an object of numbers", at)


def _read_remark(scan: _Scanner) -> str:
    at = scan.at
    value = scan.json("remark")
    if not isinstance(value, str):
        raise scan.error("remark: must be a JSON string", at)
    return value


def _arc_problem(arc: Arc) -> str | None:
    for which, end in (("start", arc.start), ("end", arc.end)):
        off = abs(math.dist(arc.center, end) - arc.radius)
        if off > ARC_END_TOLERANCE * arc.radius:
            limit = f"at most {ARC_END_TOLERANCE:g} of the radius {arc.radius:g}"
            return f"the arc's {which} lies {off:g} off its circle: {limit}"
    return None


# Writing -----------------------------------------------------------------------------------


def _scene_lines(scene: Scene) -> Iterator[str]:
    b = scene.bounds
    corners = " ".join(_number(v) for v in (b.x_min, b.y_min, b.x_max, b.y_max))
    yield HEADER
    yield f"#@ units {scene.units}"
    yield f"#@ bounds {'given' if scene.bounds_given else 'derived'} {corners}"
    if scene.size is not None:
        yield f"#@ size {int(scene.size[0])} {int(scene.size[1])}"
    if scene.border_pixels:
        yield f"#@ border_pixels {int(scene.border_pixels)}"
    if scene.binarisation is not None:
        how = scene.binarisation
        fields = {
            "method": how.method,
            "threshold": float(how.threshold),
            "polarity": how.polarity,
            "reason": how.reason,
        }
        yield f"#@ binarisation {_json(fields)}"
    if scene.timings_ms:
        yield f"#@ timings_ms {_json({k: float(v) for k, v in scene.timings_ms.items()})}"
    for remark in scene.remarks:
        yield f"#@ remark {_json(remark)}"
    for obj in scene.objects:
        yield f"#@ object {obj.id}"
        for record in obj.records:
            yield from _record_lines(record)
        for hole in obj.holes:
            yield "#@ hole"
            for record in hole:
                yield from _record_lines(record)


def _json(value: object) -> str:
    try:
        return json.dumps(value, allow_nan=False)
    except ValueError as error:
        raise SceneError(f"the scene cannot be written: {error}") from None


def _record_lines(record: Record) -> Iterator[str]:
    match record:
        case PointRecord(at):
            yield f"P {_point(at)}"
        case SegmentRecord(start, end):
            yield f"S {_point(start)} {_point(end)}"
        case CircleRecord(center, radius):
            yield f"C {_point(center)} {_radius(radius)}"
        case ArcRecord(edges):
            yield from _chain_lines("A", edges, closed=False)
        case PolygonRecord(edges):
            yield from _chain_lines("L", edges, closed=True)
    if record.residual_px != 0.0:
        yield f"#@ residual_px {_number(record.residual_px)}"


def _chain_lines(letter: str, edges: tuple[Edge, ...], *, closed: bool) -> Iterator[str]:
    if not edges:
        raise SceneError(f"the scene cannot be written: a record {letter} without edges")
    follow = [*edges[1:], edges[0]] if closed else edges[1:]
    for number, (edge, after) in enumerate(zip(edges, follow, strict=False), start=1):
        if edge.end != after.start:
            raise SceneError(
                f"the scene cannot be written: in a record {letter}, edge {number} ends at"
                f" {edge.end} but the next begins at {after.start}"
            )
    vertices = [edge.start for edge in edges]
    if not closed:
        vertices.append(edges[-1].end)
    yield f"{letter} {len(vertices)} {''.join(_point(v) for v in vertices)}"
    for number, edge in enumerate(edges, start=1):
        if isinstance(edge, Arc):
            problem = _arc_problem(edge)
            if problem:
                raise SceneError(f"the scene cannot be written: {problem}")
            x, y = (_number(v) for v in edge.center)
            sense = "ccw" if edge.ccw else "cw"
            yield f"#@ arc {number} {x} {y} {_radius(edge.radius)} {sense}"


def _number(value: float) -> str:
    value = float(value)
    if not abs(value) <= MAX_COORDINATE:
        raise SceneError(
            f"the scene cannot be written: {value!r} must lie within +-{MAX_COORDINATE:g}"
        )
    return repr(value)


def _radius(value: float) -> str:
    if not value > 0.0:
        raise SceneError(f"the scene cannot be written: radius = {value!r}: must be > 0")
    return _number(value)


def _point(point: Vec) -> str:
    return f"({_number(point[0])},{_number(point[1])})"
