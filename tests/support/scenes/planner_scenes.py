"""Scenes for the planner's tests, and a slow distance of their own to judge by."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from planner.scene import (
    Arc,
    ArcRecord,
    Bounds,
    CircleRecord,
    Edge,
    FloatArray,
    PointRecord,
    PolygonRecord,
    Record,
    Scene,
    SceneObject,
    Segment,
    SegmentRecord,
    object_records,
    record_edges,
)

ARENA = Bounds(-0.5, -0.5, 159.5, 119.5)


def scene_of(*objects: Record | SceneObject, bounds: Bounds = ARENA) -> Scene:
    """A scene in pixels of one-record objects, or of objects as they are."""
    made = tuple(
        o if isinstance(o, SceneObject) else SceneObject(i, (o,)) for i, o in enumerate(objects)
    )
    return Scene("px", bounds, made)


def polygon(points: Sequence[tuple[float, float]]) -> PolygonRecord:
    """A closed outline with straight sides."""
    vs = [(float(x), float(y)) for x, y in points]
    return PolygonRecord(
        tuple(Segment(a, b) for a, b in zip(vs, vs[1:] + vs[:1], strict=True) if a != b)
    )


def box(x0: float, y0: float, x1: float, y1: float) -> PolygonRecord:
    """A rectangle."""
    return polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])


def with_hole(outline: Record, *holes: Record) -> SceneObject:
    """An object with holes in it."""
    return SceneObject(0, (outline,), tuple((h,) for h in holes))


def stadium(x0: float, x1: float, y: float, r: float) -> PolygonRecord:
    """Two half circles and two sides, joined smoothly; clockwise with y down."""
    return PolygonRecord(
        (
            Segment((x0, y - r), (x1, y - r)),
            Arc((x1, y - r), (x1, y + r), (x1, y), r, ccw=False),
            Segment((x1, y + r), (x0, y + r)),
            Arc((x0, y + r), (x0, y - r), (x0, y), r, ccw=False),
        )
    )


def bay(cx: float, cy: float, r: float, opening_rad: float, wall: float) -> PolygonRecord:
    """A thick circular wall with an opening towards +x."""
    h = opening_rad / 2.0

    def at(radius: float, a: float) -> tuple[float, float]:
        return (cx + radius * math.cos(a), cy + radius * math.sin(a))

    outer = Arc(at(r + wall, h), at(r + wall, -h), (cx, cy), r + wall, ccw=False)
    inner = Arc(at(r, -h), at(r, h), (cx, cy), r, ccw=True)
    return PolygonRecord(
        (
            outer,
            Segment(at(r + wall, -h), at(r, -h)),
            inner,
            Segment(at(r, h), at(r + wall, h)),
        )
    )


def hand_made() -> dict[str, Scene]:
    """Scenes that go wrong easily, by name."""
    u = polygon(
        [(40, 30), (120, 30), (120, 90), (40, 90), (40, 80), (110, 80), (110, 40), (40, 40)]
    )
    room = polygon(
        [(30, 20), (130, 20), (130, 100), (86, 100), (86, 94), (124, 94), (124, 26), (36, 26),
         (36, 94), (74, 94), (74, 100), (30, 100)]
    )  # fmt: skip
    comb = [(20, 100), (20, 20), (26, 20), (26, 94)]
    for i in range(6):
        x = 40 + 18 * i
        comb += [(x, 94), (x, 20), (x + 5, 20), (x + 5, 94)]
    comb += [(152, 94), (152, 100)]
    regular = [
        (80 + 30 * math.cos(t), 60 + 30 * math.sin(t))
        for t in np.linspace(0, math.tau, 40, endpoint=False)
    ]
    return {
        "empty": scene_of(),
        "one box": scene_of(box(60, 40, 100, 80)),
        "one point": scene_of(PointRecord((80.0, 60.0))),
        "one circle": scene_of(CircleRecord((80.0, 60.0), 25.0)),
        "U": scene_of(u),
        "room of one wall": scene_of(room),
        "comb": scene_of(polygon(comb)),
        "regular 40-gon": scene_of(polygon(regular)),
        "hole": scene_of(with_hole(box(20, 20, 140, 100), box(40, 35, 120, 85))),
        "round hole": scene_of(with_hole(box(20, 10, 140, 110), CircleRecord((80.0, 60.0), 40.0))),
        "stadium hole": scene_of(with_hole(box(20, 10, 140, 110), stadium(60, 100, 60, 30))),
        "bay": scene_of(bay(70, 60, 35, 0.9, 6)),
        "wide bay": scene_of(bay(70, 60, 35, 2.2, 6)),
        "touching boxes": scene_of(box(40, 40, 80, 80), box(80, 40, 120, 80)),
        "boxes that share a corner": scene_of(box(40, 20, 80, 60), box(80, 60, 120, 100)),
        "crossing boxes": scene_of(box(30, 50, 130, 70), box(70, 20, 90, 100)),
        "nested boxes": scene_of(box(30, 20, 130, 100), box(60, 40, 100, 80)),
        "coincident boxes": scene_of(box(50, 40, 110, 80), box(50, 40, 110, 80)),
        "crossing segments": scene_of(
            SegmentRecord((30.0, 20.0), (130.0, 100.0)), SegmentRecord((30.0, 100.0), (130.0, 20.0))
        ),
        "wall to wall": scene_of(SegmentRecord((80.0, -0.5), (80.0, 119.5))),
        "wall with a door": scene_of(
            SegmentRecord((80.0, -0.5), (80.0, 50.0)), SegmentRecord((80.0, 68.0), (80.0, 119.5))
        ),
        "zigzag": scene_of(
            ArcRecord(
                tuple(
                    Segment(a, b)
                    for a, b in [
                        ((40.0, -0.5), (40.0, 90.0)),
                        ((40.0, 90.0), (70.0, 90.0)),
                        ((70.0, 90.0), (70.0, 30.0)),
                        ((70.0, 30.0), (100.0, 30.0)),
                        ((100.0, 30.0), (100.0, 119.5)),
                    ]
                )
            )
        ),
        "lattice of points": scene_of(
            *(
                PointRecord((float(x), float(y)))
                for x in range(20, 150, 20)
                for y in range(20, 110, 20)
            )
        ),
        "lattice of boxes": scene_of(
            *(box(x, y, x + 10, y + 10) for x in range(15, 150, 24) for y in range(12, 110, 24))
        ),
        "concentric circles": scene_of(
            with_hole(CircleRecord((80.0, 60.0), 55.0), CircleRecord((80.0, 60.0), 48.0)),
            CircleRecord((80.0, 60.0), 20.0),
        ),
        "box out of bounds": scene_of(box(-30, 40, 60, 80), box(90, 60, 200, 200)),
    }


def random_scene(rng: np.random.Generator, bounds: Bounds = ARENA) -> Scene:
    """Polygons, circles, bars, points and stadiums anywhere: they may touch and cross."""
    objects: list[Record] = []
    for _ in range(int(rng.integers(1, 14))):
        x = float(rng.uniform(bounds.x_min, bounds.x_max))
        y = float(rng.uniform(bounds.y_min, bounds.y_max))
        size = float(rng.uniform(4.0, 25.0))
        match int(rng.integers(0, 6)):
            case 0:
                objects.append(CircleRecord((x, y), size))
            case 1:
                a = float(rng.uniform(0, math.pi))
                dx, dy = 1.5 * size * math.cos(a), 1.5 * size * math.sin(a)
                objects.append(SegmentRecord((x - dx, y - dy), (x + dx, y + dy)))
            case 2:
                objects.append(stadium(x - size / 2, x + size / 2, y, size / 2))
            case 3:
                w, h = rng.integers(3, 30, 2)
                x, y = round(x), round(y)
                objects.append(box(x, y, x + int(w), y + int(h)))
            case 4:
                objects.append(PointRecord((x, y)))
            case _:
                k = int(rng.integers(3, 9))
                a = np.sort(rng.uniform(0, math.tau, k))
                r = size * rng.uniform(0.3, 1.0, k)
                corners = zip(x + r * np.cos(a), y + r * np.sin(a), strict=True)
                objects.append(polygon([(float(u), float(v)) for u, v in corners]))
    return scene_of(*objects, bounds=bounds)


def all_edges(scene: Scene) -> list[list[Edge] | tuple[float, float]]:
    """Every record of every object as its edges, or a point."""
    return [
        r.at if isinstance(r, PointRecord) else list(record_edges(r))
        for o in scene.objects
        for r in object_records(o)
    ]


def chords(edge: Edge, y_down: bool, step_rad: float = 0.01) -> FloatArray:
    """The edge as a polyline, arcs finely."""
    if isinstance(edge, Segment):
        return np.array([edge.start, edge.end])
    a0, turn = edge.sweep(y_down)
    t = a0 + turn * np.linspace(0.0, 1.0, max(2, math.ceil(abs(turn) / step_rad)))
    return np.c_[edge.center[0] + edge.radius * np.cos(t), edge.center[1] + edge.radius * np.sin(t)]


def slow_distance(scene: Scene, points: FloatArray) -> FloatArray:
    """Distance of points (n, 2) to the nearest border or wall, by numpy alone.

    Segments by projection; an arc is its circle within its sweep, and its two ends.
    """
    c = scene.bounds.corners()
    straight = [(*c[i], *c[(i + 1) % 4]) for i in range(4)]
    best = np.full(len(points), np.inf)
    for item in all_edges(scene):
        if isinstance(item, tuple):
            straight.append((*item, *item))
            continue
        for edge in item:
            if isinstance(edge, Segment):
                straight.append((*edge.start, *edge.end))
            else:
                best = np.minimum(best, edge_distance(edge, points, scene.y_down))
    x, y = points[:, 0], points[:, 1]
    for some in _portions(np.array(straight), len(points)):
        ax, ay, bx, by = some.T[..., None]
        dx, dy, vx, vy = bx - ax, by - ay, x - ax, y - ay
        square = dx * dx + dy * dy
        t = np.clip((vx * dx + vy * dy) / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
        best = np.minimum(best, np.sqrt(((vx - t * dx) ** 2 + (vy - t * dy) ** 2).min(axis=0)))
    return best


def _portions(rows: FloatArray, points: int) -> list[FloatArray]:
    """The rows in portions that, with so many points each, take a few megabytes."""
    count = max(1, 30_000 // max(1, points))
    return [rows[k : k + count] for k in range(0, len(rows), count)]


def edge_distance(edge: Edge, points: FloatArray, y_down: bool) -> FloatArray:
    ends = np.minimum(np.hypot(*(points - edge.start).T), np.hypot(*(points - edge.end).T))
    if isinstance(edge, Segment):
        a = np.array(edge.start)
        d = np.array(edge.end) - a
        if not d.any():
            return ends
        t = np.clip((points - a) @ d / (d @ d), 0.0, 1.0)
        return np.hypot(*(points - a - t[:, None] * d).T)
    a0, turn = edge.sweep(y_down)
    v = points - np.array(edge.center)
    angle = np.arctan2(v[:, 1], v[:, 0])
    gone = (angle - a0) % math.tau if turn > 0 else (a0 - angle) % math.tau
    return np.where(gone <= abs(turn), np.abs(np.hypot(*v.T) - edge.radius), ends)


def slow_inside(scene: Scene, points: FloatArray) -> np.ndarray:
    """Whether points lie inside an obstacle: even-odd over each object's closed borders."""
    inside = np.zeros(len(points), dtype=bool)
    upwards = np.argsort(points[:, 1], kind="stable")
    x, y = points[upwards].T
    for o in scene.objects:
        lines = [
            np.concatenate([line[:-1], line[1:]], axis=1)
            for r in object_records(o)
            if isinstance(r, PolygonRecord | CircleRecord)
            for line in (chords(edge, scene.y_down) for edge in record_edges(r))
        ]
        ax, ay, bx, by = np.concatenate([np.empty((0, 4)), *lines]).T
        first = np.searchsorted(y, np.minimum(ay, by))  # whose height the chord spans
        count = np.searchsorted(y, np.maximum(ay, by)) - first
        edge = np.repeat(np.arange(len(ax)), count)
        at = np.arange(len(edge)) + np.repeat(first - np.cumsum(count) + count, count)
        ax, ay, bx, by = ax[edge], ay[edge], bx[edge], by[edge]
        right = at[ax + (y[at] - ay) * (bx - ax) / (by - ay) > x[at]]
        inside[upwards] |= np.bincount(right, minlength=len(points)) % 2 == 1
    return inside
