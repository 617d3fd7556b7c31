"""Scenes on a grid of seven by seven, where everything touches, crosses or lies on one line.

:func:`judge` plans in one of them and measures every path that comes back by distances written
apart from the planner's, in numpy: an end is nearest, or two lines cross.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

import planner
from planner.motion.smooth import smooth_path
from planner.motion.trajectory import default_limits, time_path
from planner.path import Path
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
    Segment,
    SegmentRecord,
)
from tests.support.scenes.planner_scenes import all_edges, edge_distance, scene_of, slow_inside

BOUNDS = Bounds(0.0, 0.0, 8.0, 8.0)
ROUNDING = 1e-9
"""Distances are equal within this share of the bounds' side."""
SLOWEST_S = 1.0
"""A plan that takes more processor time counts as one that hangs."""

Place = tuple[float, float]


def grid_scene(rng: np.random.Generator) -> Scene:
    """Two to six records of every kind with their points on the grid."""
    made: list[Record] = []
    while len(made) < 2 or (len(made) < 6 and rng.random() < 0.7):
        made.append(_record(rng))
    return scene_of(*made, bounds=BOUNDS)


def _place(rng: np.random.Generator) -> Place:
    return float(rng.integers(1, 8)), float(rng.integers(1, 8))


def _record(rng: np.random.Generator) -> Record:
    a, b = _place(rng), _place(rng)
    while b == a:
        b = _place(rng)
    match int(rng.integers(0, 5)):
        case 0:
            return PointRecord(a)
        case 1:
            return SegmentRecord(a, b)
        case 2:
            return CircleRecord(a, float(rng.choice([0.5, 1.0, math.dist(a, b)])))
        case 3:
            places = [a, b]
            while len(places) < 5 and rng.random() < 0.6:
                places.append(_other(rng, places[-1]))
            return ArcRecord(tuple(_edges(rng, places)))
        case _:
            places = [a, b]
            while len(places) < 3 or (len(places) < 7 and rng.random() < 0.6):
                places.append(_other(rng, places[-1]))
            while places[-1] == places[0]:
                places[-1] = _other(rng, places[-2])
            return PolygonRecord(tuple(_edges(rng, [*places, places[0]])))


def _other(rng: np.random.Generator, place: Place) -> Place:
    other = _place(rng)
    while other == place:
        other = _place(rng)
    return other


def _edges(rng: np.random.Generator, places: Sequence[Place]) -> list[Edge]:
    """Straight edges, and half circles now and then."""
    made: list[Edge] = []
    for a, b in pairwise(places):
        if rng.random() < 0.25:
            middle = (0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]))
            made.append(Arc(a, b, middle, 0.5 * math.dist(a, b), ccw=bool(rng.random() < 0.5)))
        else:
            made.append(Segment(a, b))
    return made


def clearance_apart(scene: Scene, line: FloatArray) -> float:
    """The least distance between a polyline (n, 2) and the scene's borders and bounds."""
    corners = BOUNDS.corners()
    walls: list[Edge] = [Segment(a, b) for a, b in pairwise([*corners, corners[0]])]
    a, b = (line[:-1], line[1:]) if len(line) > 1 else (line, line)
    best = math.inf
    for item in [*all_edges(scene), walls]:
        if isinstance(item, tuple):
            best = min(best, float(_to_lines(np.array(item), a, b).min()))
            continue
        for edge in item:
            best = min(best, float(_edge_to_lines(edge, a, b, scene.y_down).min()))
    return best


def _to_lines(p: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """Distances of a place to segments (n, 2) to (n, 2)."""
    d = b - a
    square = (d * d).sum(axis=1)
    ahead = ((p - a) * d).sum(axis=1)
    t = np.clip(ahead / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
    return np.asarray(np.hypot(*(p - a - t[:, None] * d).T))


def _edge_to_lines(edge: Edge, a: FloatArray, b: FloatArray, y_down: bool) -> FloatArray:
    ends = np.minimum(_to_lines(np.array(edge.start), a, b), _to_lines(np.array(edge.end), a, b))
    best = np.minimum.reduce([ends, edge_distance(edge, a, y_down), edge_distance(edge, b, y_down)])
    d = b - a
    if isinstance(edge, Segment):
        return np.where(_cross(np.array(edge.start), np.array(edge.end), a, b), 0.0, best)
    square = (d * d).sum(axis=1)
    square = np.where(square > 0.0, square, 1.0)
    centre = np.array(edge.center)
    middle = ((centre - a) * d).sum(axis=1) / square
    high = ((a + middle[:, None] * d - centre) ** 2).sum(axis=1)
    half = np.sqrt(np.maximum(edge.radius**2 - high, 0.0) / square)
    for t in (middle, middle - half, middle + half):
        at = a + np.clip(t, 0.0, 1.0)[:, None] * d
        best = np.minimum(best, edge_distance(edge, at, y_down))
    return best


def _cross(p: FloatArray, q: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """Whether the segment p q crosses segments a b, by turns that are no rounding."""

    def turn(u: FloatArray, v: FloatArray, w: FloatArray) -> FloatArray:
        t = (v - u)[..., 0] * (w - u)[..., 1] - (v - u)[..., 1] * (w - u)[..., 0]
        return np.where(np.abs(t) > 1e-12, t, 0.0)

    apart = (turn(p, q, a) * turn(p, q, b) < 0.0) & (turn(a, b, p) * turn(a, b, q) < 0.0)
    return np.asarray(apart)


@dataclass(slots=True)
class Tally:
    """What was planned and what was wrong with it, the seeds of each."""

    scenes: int = 0
    plans: int = 0
    paths: int = 0
    slowest_s: float = 0.0
    hangs: list[int] = field(default_factory=list)
    exceptions: list[tuple[int, str]] = field(default_factory=list)
    below: list[int] = field(default_factory=list)
    wrong: list[int] = field(default_factory=list)
    in_solid: list[int] = field(default_factory=list)
    bounded: int = 0

    @property
    def faults(self) -> int:
        """How many scenes had anything wrong, each thing counted."""
        lists = (self.hangs, self.exceptions, self.below, self.wrong, self.in_solid)
        return sum(len(faults) for faults in lists)


def judge(seed: int, tally: Tally, plans: int = 1) -> None:
    """Plan in the scene of a seed, and add what was found to the tally."""
    rng = np.random.default_rng(seed)
    scene = grid_scene(rng)
    radius = float(np.round(10.0 ** rng.uniform(math.log10(0.05), 0.0), 3))
    tally.scenes += 1
    try:
        roadmap = planner.build_roadmap(scene, radius)
        places = rng.integers(1, 64, (40, 2)) / 8.0
        standing = places[roadmap.clearance(places) >= radius]
        # places where the robot cannot stand are asked for, too
        places = standing if len(standing) > 1 and rng.random() < 0.9 else places
        for k in range(plans):
            start, goal = places[2 * k % len(places)], places[(2 * k + 1) % len(places)]
            prefer = float(rng.choice([0.0, 0.5, 0.5, 1.0]))
            begun_s = time.thread_time()
            answer = roadmap.plan(start, goal, prefer=prefer, alternatives=2)
            took_s = time.thread_time() - begun_s
            tally.plans += 1
            tally.slowest_s = max(tally.slowest_s, took_s)
            if took_s > SLOWEST_S:
                tally.hangs.append(seed)
            tally.bounded += bool(answer.remarks)
            if isinstance(answer, Path):
                _judge_path(seed, scene, radius, answer, tally)
                smooth = smooth_path(answer, roadmap.path_clearance, roadmap.clearance)
                if clearance_apart(scene, smooth.points) < radius - ROUNDING * BOUNDS.width:
                    tally.below.append(seed)
                if seed % 16 == 0:
                    time_path(smooth, default_limits(radius), clearance=roadmap.clearance)
    except Exception as error:  # noqa: BLE001 - counted: that there is none is what is judged
        tally.exceptions.append((seed, repr(error)))


def _judge_path(seed: int, scene: Scene, radius: float, answer: Path, tally: Tally) -> None:
    rounding = ROUNDING * BOUNDS.width
    for path in (answer, *answer.alternatives):
        tally.paths += 1
        apart = clearance_apart(scene, path.points)
        if apart < radius - rounding:
            tally.below.append(seed)
        if abs(apart - path.min_clearance) > rounding:
            tally.wrong.append(seed)
    # at three heights within the clearance: on the grid's own, rays graze joints
    ends = answer.points[[0, -1]]
    votes = sum(
        slow_inside(scene, ends + np.array([0.0, part * radius])) for part in (0.1, 0.23, -0.31)
    )
    if np.any(votes >= 2):
        tally.in_solid.append(seed)
