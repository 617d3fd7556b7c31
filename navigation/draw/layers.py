"""The layers of a picture, bottom up."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from navigation.draw.driven import DrawnRobot, driven_shapes, plan_shapes
from navigation.draw.numbers import costs, obstacle_labels
from navigation.draw.outlines import chain_points, object_lines, ring_points
from navigation.draw.robot_marks import lines_of, name_beside, nose
from navigation.draw.shapes import (
    BOTTLENECK,
    FLOOR,
    FRAME,
    GOAL,
    OBSTACLE,
    OBSTACLE_EDGE,
    OTHER_PATH,
    OTHER_ROBOT,
    OTHER_ROBOT_INK,
    PAGE,
    PATH,
    RAMP_STEPS,
    START,
    TRACK,
    Area,
    Colour,
    DiscShape,
    Layer,
    Screen,
    Shape,
    Strokes,
    ramp_colour,
)
from navigation.draw.zones import zone_names, zone_shapes
from planner.path import NoPath, Path, Trajectory
from planner.scene import (
    Bounds,
    CircleRecord,
    FloatArray,
    PointRecord,
    PolygonRecord,
    Scene,
)
from planner.zones.zone import Zone

if TYPE_CHECKING:
    from planner.roadmap.curves import Curves
    from planner.roadmap.roadmap import Roadmap

FLATNESS_PX = 0.2
"""Largest error of the roadmap's drawn curves."""
COLOUR_STEP_PX = 5.0
"""Distance along an edge at which the colour follows the clearance."""

CROP_BELOW = 0.5
"""Largest share of the scene that a picture of a part shows."""


@dataclass(frozen=True, slots=True)
class OtherRobot:
    """Another robot at the end of its track (n, 3) of x, y, heading_rad; NaN breaks the line."""

    name: str
    radius: float
    track: FloatArray


@dataclass(frozen=True, slots=True)
class Content:
    """Contents of one picture; None or empty is not drawn."""

    scene: Scene
    roadmap: Roadmap | None
    curves: Curves | None
    path: Path | NoPath | None
    trajectory: Trajectory | None
    track: FloatArray | None
    earlier: tuple[FloatArray, ...]
    others: tuple[OtherRobot, ...]
    driven: tuple[DrawnRobot, ...]
    stations: tuple[tuple[float, ...], ...]
    title: str
    zones: tuple[Zone, ...] = ()

    @property
    def found(self) -> Path | None:
        """The path, if any."""
        return self.path if isinstance(self.path, Path) else None

    @property
    def robot_radius(self) -> float | None:
        """The robot's radius, from the path or else the roadmap."""
        if self.found:
            return self.found.robot_radius
        return self.roadmap.radius if self.roadmap else None

    def clearance_span(self) -> tuple[float, float] | None:
        """Ends of the colour ramp: least and largest clearance on the roadmap."""
        if self.curves is None:
            return None
        low = self.curves.narrowest
        return low, max(float(self.curves.clearances.max()), low)

    def window(self) -> Bounds:
        """Part of the scene to show: all of it, or a small reachable part with a rim."""
        whole = self.scene.bounds
        if self.roadmap is None or self.curves is None:
            return whole
        places = np.array([s[:2] for s in self.stations if whole.contains((s[0], s[1]))])
        points = np.concatenate([self.curves.points, places.reshape(-1, 2)])
        low, high = points.min(axis=0), points.max(axis=0)
        rim = 2.0 * self.roadmap.radius + 0.08 * float((high - low).max())
        part = Bounds(
            max(whole.x_min, float(low[0]) - rim),
            max(whole.y_min, float(low[1]) - rim),
            min(whole.x_max, float(high[0]) + rim),
            min(whole.y_max, float(high[1]) + rim),
        )
        small = part.width * part.height < CROP_BELOW * whole.width * whole.height
        return part if small else whole

    def bottleneck(self) -> tuple[float, float, float] | None:
        """Place (x, y) and width of the bottleneck of the path, or of the widest route."""
        if self.found:
            return (*self.found.min_clearance_at, 2.0 * self.found.min_clearance)
        if isinstance(self.path, NoPath) and self.path.bottleneck:
            gap = self.path.bottleneck
            return gap.x, gap.y, gap.width
        return None


def layers(content: Content, screen: Screen) -> tuple[Layer, ...]:
    """Layers inside the plot, bottom up."""
    return (
        Layer("floor", (Area((screen.frame,), FLOOR),)),
        Layer("corridor", tuple(_corridor(content, screen))),
        Layer("obstacles", tuple(_obstacles(content.scene, screen))),
        Layer("zones", tuple(zone_shapes(content.zones, screen))),
        Layer("bounds", (_frame(screen),)),
        Layer("roadmap", tuple(_roadmap(content, screen))),
        Layer("other robots", tuple(_others(content, screen))),
        Layer("alternatives", tuple(_alternatives(content, screen))),
        Layer("earlier plans", tuple(_earlier(content, screen))),
        Layer("path", (*_path(content, screen), *plan_shapes(content.driven, screen))),
        Layer("driven track", tuple(_track(content, screen))),
        Layer("driven robots", tuple(driven_shapes(content.driven, screen))),
        Layer("waypoints", tuple(_waypoints(content, screen))),
        Layer("bottleneck", tuple(_bottleneck(content, screen))),
        Layer("zone names", tuple(zone_names(content.zones, screen, content.scene.units))),
        Layer("numbers", tuple(_numbers(content, screen))),
        Layer("stations", tuple(_stations(content, screen))),
    )


def _obstacles(scene: Scene, screen: Screen) -> Iterator[Shape]:
    for obj in scene.objects:
        rings = [screen.points(ring) for ring in ring_points(obj, scene.y_down)]
        if rings:
            yield Area(tuple(rings), OBSTACLE, stroke=OBSTACLE_EDGE)
        for record in obj.records:
            if isinstance(record, PointRecord):
                ((x, y),) = screen.points([record.at]).tolist()
                yield DiscShape(x, y, 2.0, fill=OBSTACLE)
            elif not isinstance(record, PolygonRecord | CircleRecord):
                line = screen.points(chain_points(record, scene.y_down))
                yield Strokes((line,), OBSTACLE, 2.0)


def screen_borders(scene: Scene, screen: Screen) -> list[list[FloatArray]]:
    """Each object's borders (n, 2), or its points, in screen pixels."""
    return [
        [screen.points(line) for line in object_lines(obj, scene.y_down)] for obj in scene.objects
    ]


def _numbers(content: Content, screen: Screen) -> Iterator[Shape]:
    borders = screen_borders(content.scene, screen)
    yield from obstacle_labels(borders, [str(k) for k in range(len(borders))], screen, PAGE)
    if content.found:
        yield from costs(content.found, content.scene.units, screen)


def _frame(screen: Screen) -> Strokes:
    return Strokes((np.vstack([screen.frame, screen.frame[:1]]),), FRAME, 1.5)


def _corridor(content: Content, screen: Screen) -> Iterator[Shape]:
    if content.found and len(content.found.points) > 1:
        line = screen.points(content.found.points)
        width = 2.0 * content.found.robot_radius * screen.scale
        yield Strokes((line,), PATH, width, opacity=0.14)


def _roadmap(content: Content, screen: Screen) -> Iterator[Shape]:
    span = content.clearance_span()
    if content.roadmap is None or content.curves is None or span is None:
        return
    from planner.roadmap.curves import followed

    curves = followed(content.roadmap, content.curves, FLATNESS_PX / screen.scale)
    points, clearances, last = _densely(curves, COLOUR_STEP_PX / screen.scale)
    places = screen.points(points)
    width = span[1] - span[0]
    part = (clearances - span[0]) / width if width > 0.0 else np.ones(len(clearances))
    steps = np.clip(np.rint(part * (RAMP_STEPS - 1)), 0, RAMP_STEPS - 1).astype(int)
    # a link has its first point's colour; each stretch of one colour is one line
    changes = (steps[1:] != steps[:-1]) | last[:-1]
    cuts = [0, *(np.flatnonzero(changes) + 1).tolist(), len(points)]
    by_step: dict[int, list[FloatArray]] = {}
    for a, b in pairwise(cuts):
        end = b if last[b - 1] else b + 1
        if end - a > 1:
            by_step.setdefault(int(steps[a]), []).append(places[a:end])
    for step in sorted(by_step, reverse=True):
        yield Strokes(tuple(by_step[step]), ramp_colour(step), 1.8)


def _densely(curves: Curves, step: float) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Points at most ``step`` apart, their clearances, and a mask of each line's last point."""
    last = np.zeros(len(curves.points), dtype=np.bool_)
    last[curves.first[1:] - 1] = True
    ahead = np.minimum(np.arange(len(last)) + 1, len(last) - 1)
    along = curves.points[ahead] - curves.points
    count = np.maximum(np.ceil(np.hypot(*along.T) / step).astype(int), 1)
    count[last] = 1
    row = np.repeat(np.arange(len(last)), count)
    share = (np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)) / count[row]
    points = curves.points[row] + share[:, None] * along[row]
    rho = curves.clearances
    return points, rho[row] + share * (rho[ahead] - rho)[row], last[row]


def _alternatives(content: Content, screen: Screen) -> Iterator[Shape]:
    if content.found:
        for other in content.found.alternatives:
            yield Strokes((screen.points(other.points),), OTHER_PATH, 2.5, dash=(8.0, 5.0))


def _earlier(content: Content, screen: Screen) -> Iterator[Shape]:
    lines = tuple(screen.points(line) for line in content.earlier if len(line) > 1)
    if lines:
        yield Strokes(lines, PAGE, 6.5)
        yield Strokes(lines, OTHER_PATH, 3.5)


def _others(content: Content, screen: Screen) -> Iterator[Shape]:
    seen = [other for other in content.others if len(other.track)]
    drawn = screen.points(content.found.points) if content.found else np.empty((0, 2))
    for other in seen:
        lines = tuple(screen.points(line[:, :2]) for line in lines_of(other.track))
        if lines:
            yield Strokes(lines, OTHER_ROBOT, 2.0)
        x, y = screen.points(other.track[-1:, :2])[0].tolist()
        size = other.radius * screen.scale
        yield DiscShape(x, y, size, fill=OTHER_ROBOT, opacity=0.22)
        yield DiscShape(x, y, size, stroke=OTHER_ROBOT, width=2.0)
        yield nose(x, y, size, float(other.track[-1, 2]), OTHER_ROBOT, screen)
        yield name_beside(other.name, x, y, size, OTHER_ROBOT_INK, screen, drawn)


def _path(content: Content, screen: Screen) -> Iterator[Shape]:
    if content.found and len(content.found.points) > 1:
        line = (screen.points(content.found.points),)
        yield Strokes(line, PAGE, 6.5)
        yield Strokes(line, PATH, 3.5)


def _track(content: Content, screen: Screen) -> Iterator[Shape]:
    if lines := lines_of(content.track):
        yield Strokes(tuple(screen.points(line) for line in lines), TRACK, 2.0)


def _waypoints(content: Content, screen: Screen) -> Iterator[Shape]:
    if content.trajectory:
        places = screen.points([(w.x, w.y) for w in content.trajectory.waypoints])
        for x, y in places.tolist():
            yield DiscShape(x, y, 2.6, fill=PAGE, stroke=PATH, width=1.3)


def _bottleneck(content: Content, screen: Screen) -> Iterator[Shape]:
    gap = content.bottleneck()
    if gap is None:
        return
    ((x, y),) = screen.points([gap[:2]]).tolist()
    radius = 0.5 * gap[2] * screen.scale
    yield DiscShape(x, y, max(radius, 3.0), stroke=BOTTLENECK, width=2.0)
    yield DiscShape(x, y, 2.4, fill=BOTTLENECK)


def _stations(content: Content, screen: Screen) -> Iterator[Shape]:
    last = len(content.stations) - 1
    radius = content.robot_radius
    size = 7.0 if radius is None else max(7.0, radius * screen.scale)
    drawn = screen.points(content.found.points) if content.found else np.empty((0, 2))
    for number, station in enumerate(content.stations):
        name, colour = _station_name(number, last)
        ((x, y),) = screen.points([station[:2]]).tolist()
        yield DiscShape(x, y, size, fill=colour, opacity=0.22)
        yield DiscShape(x, y, size, stroke=colour, width=2.0)
        yield DiscShape(x, y, 3.5, fill=colour)
        if len(station) == 3:
            yield nose(x, y, size, station[2], colour, screen)
        yield name_beside(name, x, y, size, colour, screen, drawn)


def _station_name(number: int, last: int) -> tuple[str, Colour]:
    if number == 0:
        return "start", START
    return ("goal", GOAL) if number == last else (str(number), GOAL)
