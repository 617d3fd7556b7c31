"""Ground truth of the simulated arena: the true places of the obstacles.

Only the simulator and the report use it. Distances come straight from the records, without the
planner's kernels, so the report judges the planner independently. Units: metres, y up.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from navigation.config import Config
from planner.formats.scene_io import load_scene, read_scene_text
from planner.scene import (
    Arc,
    Bounds,
    CircleRecord,
    FloatArray,
    PointRecord,
    PolygonRecord,
    Record,
    Scene,
    SceneError,
    Segment,
    object_records,
    record_edges,
)

BoolArray: TypeAlias = NDArray[np.bool_]

TRACK_TOLERANCE_M = 1e-7
"""Accuracy of the least clearance of `track_clearance`."""


@dataclass(frozen=True, slots=True)
class SimulatedArena:
    """The true scene, in metres, and distances to it.

    Raises ``SceneError`` for a scene in other units.
    """

    scene: Scene

    def __post_init__(self) -> None:
        if self.scene.units != "m":
            raise SceneError(
                f"the simulated arena is in {self.scene.units}: must be in m "
                "(the scene text's '#@ units m')"
            )

    def clearances(self, points_m: ArrayLike) -> FloatArray:
        """Distance (n,) of points (n, 2) to the nearest border or wall.

        Negative inside an obstacle and outside the bounds. Exact but for rounding; O(points x
        edges).
        """
        points = np.asarray(points_m, dtype=np.float64).reshape(-1, 2)
        distance = _distance_to_walls(points, self.scene.bounds)
        solid = np.zeros(len(points), dtype=np.bool_)
        for thing in self.scene.objects:
            inside = np.zeros(len(points), dtype=np.bool_)
            for record in object_records(thing):
                distance = np.minimum(distance, _distance_to(record, points))
                inside ^= _inside(record, points)
            solid |= inside
        return np.where(solid | ~_within(points, self.scene.bounds), -distance, distance)

    def track_clearance(self, track_m: ArrayLike) -> tuple[float, tuple[float, float]]:
        """Return the least clearance of a polyline (n >= 1, 2) and its place.

        Covers places between the points, to ``TRACK_TOLERANCE_M``: the clearance changes by at most
        the distance travelled, so pieces that cannot hold the least one are dropped and others
        halved.
        """
        track = np.asarray(track_m, dtype=np.float64).reshape(-1, 2)
        if len(track) == 0:
            raise ValueError("a track needs at least one point")
        at_points = self.clearances(track)
        best, where = float(at_points.min()), track[int(at_points.argmin())]
        a, b, at_a, at_b = track[:-1], track[1:], at_points[:-1], at_points[1:]
        while True:
            lowest = (at_a + at_b - np.hypot(*(b - a).T)) / 2
            open_ = lowest < best - TRACK_TOLERANCE_M
            if not open_.any():
                return best, (float(where[0]), float(where[1]))
            a, b, at_a, at_b = a[open_], b[open_], at_a[open_], at_b[open_]
            middle = (a + b) / 2
            at_middle = self.clearances(middle)
            if float(at_middle.min()) < best:
                best, where = float(at_middle.min()), middle[int(at_middle.argmin())]
            a, b = np.concatenate([a, middle]), np.concatenate([middle, b])
            at_a, at_b = np.concatenate([at_a, at_middle]), np.concatenate([at_middle, at_b])


def load_arena(config: Config) -> SimulatedArena:
    """Load a configuration's simulated arena, inside the configured bounds.

    Raises ``SceneError`` if the file is no scene in metres, no arena is configured, or the robot's
    start is not free.
    """
    simulation = config.simulation
    if simulation is None:
        raise SceneError("the configuration has no section 'simulation'")
    if simulation.arena is not None:
        scene = load_scene(simulation.arena)
    else:
        scene = read_scene_text(simulation.arena_text or "", "simulation.arena_text")
    arena = SimulatedArena(scene.with_bounds(Bounds(*config.arena.bounds_m)))
    start = simulation.start
    if start is None:  # several robots, each with a start of its own
        return arena
    clearance = float(arena.clearances(np.array([[start.x_m, start.y_m]]))[0])
    if clearance < config.robot.radius_m:
        raise SceneError(
            f"simulation.start ({start.x_m:g}, {start.y_m:g}) has a clearance of "
            f"{clearance:.3f} m: must be >= {config.robot.radius_m:g}, the robot's radius"
        )
    return arena


def _within(points: FloatArray, bounds: Bounds) -> BoolArray:
    x, y = points.T
    inside: BoolArray = (
        (x >= bounds.x_min) & (x <= bounds.x_max) & (y >= bounds.y_min) & (y <= bounds.y_max)
    )
    return inside


def _distance_to_walls(points: FloatArray, bounds: Bounds) -> FloatArray:
    c = bounds.corners()
    sides = tuple(Segment(c[i], c[(i + 1) % 4]) for i in range(4))
    return _distance_to(PolygonRecord(sides), points)


def _distance_to(record: Record, points: FloatArray) -> FloatArray:
    match record:
        case PointRecord(at):
            return np.asarray(np.hypot(points[:, 0] - at[0], points[:, 1] - at[1]))
        case CircleRecord(center, radius):
            to_center = np.hypot(points[:, 0] - center[0], points[:, 1] - center[1])
            return np.abs(to_center - radius)
        case _:
            measures: dict[type, Callable[..., FloatArray]] = {
                Segment: _to_segment,
                Arc: _to_arc,
            }
            each = [measures[type(edge)](edge, points) for edge in record_edges(record)]
            return np.asarray(np.min(each, axis=0))


def _to_segment(edge: Segment, points: FloatArray) -> FloatArray:
    a, b = np.array(edge.start), np.array(edge.end)
    along = b - a
    length2 = float(along @ along)
    share = np.clip((points - a) @ along / length2, 0.0, 1.0) if length2 > 0.0 else 0.0
    off = points - (a + np.multiply.outer(share, along))
    return np.asarray(np.hypot(off[:, 0], off[:, 1]))


def _to_arc(edge: Arc, points: FloatArray) -> FloatArray:
    """Distance to the circle if the foot lies on the arc, else to the nearer end."""
    start_rad, sweep_rad = edge.sweep(y_down=False)
    off = points - np.array(edge.center)
    turned = np.arctan2(off[:, 1], off[:, 0]) - start_rad
    gone = np.mod(turned if sweep_rad > 0 else -turned, math.tau)
    to_circle = np.abs(np.hypot(off[:, 0], off[:, 1]) - edge.radius)
    to_ends = np.minimum(
        np.hypot(points[:, 0] - edge.start[0], points[:, 1] - edge.start[1]),
        np.hypot(points[:, 0] - edge.end[0], points[:, 1] - edge.end[1]),
    )
    return np.where(gone <= abs(sweep_rad), to_circle, to_ends)


def _inside(record: Record, points: FloatArray) -> BoolArray:
    """True for points inside a record's closed border; open records have no inside."""
    match record:
        case CircleRecord(center, radius):
            return np.asarray(np.hypot(points[:, 0] - center[0], points[:, 1] - center[1]) < radius)
        case PolygonRecord(edges):
            inside = _inside_chords(np.array([edge.start for edge in edges]), points)
            for edge in edges:
                if isinstance(edge, Arc):
                    inside ^= _between_chord_and_arc(edge, points)
            return inside
        case _:
            return np.zeros(len(points), dtype=np.bool_)


def _inside_chords(corners: FloatArray, points: FloatArray) -> BoolArray:
    """Even-odd rule for the polygon through the edges' ends."""
    inside = np.zeros(len(points), dtype=np.bool_)
    x, y = points.T
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if y0 != y1:
            crosses = (y0 > y) != (y1 > y)
            inside ^= crosses & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
    return inside


def _between_chord_and_arc(edge: Arc, points: FloatArray) -> BoolArray:
    """True for points in the circular segment between the arc and its chord."""
    off = points - np.array(edge.center)
    in_disc: BoolArray = np.hypot(off[:, 0], off[:, 1]) < edge.radius
    start_rad, sweep_rad = edge.sweep(y_down=False)
    if abs(sweep_rad) >= math.tau:
        return in_disc
    middle_rad = start_rad + sweep_rad / 2
    towards = np.array([math.cos(middle_rad), math.sin(middle_rad)])
    chord = edge.radius * math.cos(sweep_rad / 2)
    beyond_chord: BoolArray = off @ towards > chord
    return in_disc & beyond_chord
