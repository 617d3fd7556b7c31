"""The graph that several robots share: roadmap chains, each robot's own path, places beside.

The roadmap's chains for the smallest robot include niches and dead ends; robots pass each other on
a lattice of places beside. Lines are cut into places at most a radius of the smallest robot apart;
straight edges join near places, and their clearances are exact.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from planner.fleet.ground.clearance_kernels import edge_clearances, near_pairs
from planner.roadmap.roadmap import Roadmap
from planner.scene import FloatArray

LINE_STEP = 1.0
"""Spacing on a line, in radii of the smallest robot: half of what two need to be apart, so that
one gives way by little more than it must."""
LATTICE = 2.2
"""Spacing of the lattice, in radii of the largest robot: two fit side by side."""
LATTICE_REACH = 2.0
"""Lattice spacings within which places are joined: straight lines in 12 directions and more."""
LATTICE_MOST = 2500
"""Places of the lattice; in larger arenas those nearest to the robots' own paths."""
ASKED_MOST = 400
"""Places of the paths, evenly spread, whose surroundings are searched."""
ONE_PLACE = 1e-6
"""Places are one within this share of the smallest radius."""


@dataclass(frozen=True, slots=True)
class GroundPlaces:
    """Places (n, 2), edges (m, 2) in both directions, the clearance of each (m,).

    ``starts``, ``goals`` and ``junctions`` of the roadmap's chains are node numbers.
    """

    places: FloatArray
    edges: NDArray[np.int64]
    clearance: FloatArray
    starts: list[int]
    goals: list[int]
    junctions: list[int]


def lay_places(
    roadmap: Roadmap,
    paths: Sequence[FloatArray],
    radii: Sequence[float],
    check: Callable[[], None] = lambda: None,
    chains: Sequence[Roadmap] = (),
) -> GroundPlaces:
    """Build the shared graph; ``paths`` are polylines from each robot's start to its goal.

    ``chains`` are the roadmaps whose chains count, by default this one: those on which keep-out
    zones are obstacles. ``check`` is called before each piece of work, and may raise
    an error that ends it.
    """
    smallest, largest = min(radii), max(radii)
    graphs = [one.graph for one in chains or (roadmap,)]
    lines = [data["polyline"] for one in graphs for _, _, data in one.edges(data=True)]
    gather = _Gather(ONE_PLACE * smallest)
    fine = [_cut(path, LINE_STEP * smallest) for path in paths]
    ends = [gather.line(path) for path in fine]
    for line in lines:
        check()
        keep = float(roadmap.path_clearance(line).distance)
        gather.line(_cut(_straightened(roadmap, line, keep, smallest), LINE_STEP * smallest))
    spacing = LATTICE * largest
    check()
    gather.add_beside(_lattice(roadmap, fine, smallest, spacing), 0.5 * spacing, check)
    ends_of_chains = [one.nodes[n]["pos"] for one in graphs for n, k in one.degree if k > 2]
    junctions = sorted({gather.number(x, y) for x, y in ends_of_chains})
    places = np.array(gather.places)
    joined = near_pairs(places, LATTICE_REACH * spacing)
    check()
    pairs = np.unique(
        np.concatenate([np.array(gather.pairs, np.int64).reshape(-1, 2), joined]), axis=0
    )
    check()
    pairs, clearance = _wide(roadmap, places, pairs, smallest)
    check()
    edges = np.concatenate([pairs, pairs[:, ::-1]])
    return GroundPlaces(
        places, np.ascontiguousarray(edges), np.concatenate([clearance, clearance]),
        [a for a, _ in ends], [b for _, b in ends], junctions,
    )  # fmt: skip


def with_paths(
    roadmap: Roadmap, base: GroundPlaces, paths: Sequence[FloatArray], radii: Sequence[float]
) -> GroundPlaces:
    """Add a few more polylines, cut and joined to near places: far faster than a new graph.

    ``starts`` and ``goals`` are the ends of these polylines.
    """
    smallest, spacing = min(radii), LATTICE * max(radii)
    gather = _Gather(ONE_PLACE * smallest)
    ends = [gather.line(_cut(path, LINE_STEP * smallest)) for path in paths]
    own, first = np.array(gather.places), len(base.places)
    places = np.concatenate([base.places, own])
    pairs = [np.array(gather.pairs, np.int64).reshape(-1, 2) + first]
    for i, (x, y) in enumerate(own.tolist()):
        away = np.hypot(places[: first + i, 0] - x, places[: first + i, 1] - y)
        near = np.flatnonzero(away <= LATTICE_REACH * spacing)
        pairs.append(np.column_stack([near, np.full(len(near), first + i)]))
    joined, clearance = _wide(roadmap, places, np.unique(np.concatenate(pairs), axis=0), smallest)
    return GroundPlaces(
        places, np.concatenate([base.edges, joined, joined[:, ::-1]]),
        np.concatenate([base.clearance, clearance, clearance]),
        [first + a for a, _ in ends], [first + b for _, b in ends], base.junctions,
    )  # fmt: skip


def _wide(
    roadmap: Roadmap, places: FloatArray, pairs: NDArray[np.int64], radius: float
) -> tuple[NDArray[np.int64], FloatArray]:
    """Pairs with edges as wide as the radius, and their clearance."""
    clearance = edge_clearances(roadmap.borders.tree, places, pairs)
    used, where = np.unique(pairs, return_inverse=True)
    inside = roadmap.clearance(places[used])[where.reshape(pairs.shape)]
    clearance = np.minimum(clearance, inside.min(axis=1, initial=np.inf))
    wide = clearance >= radius - ONE_PLACE * radius
    return pairs[wide], clearance[wide]


class _Gather:
    def __init__(self, same: float) -> None:
        self.same = same
        self.places: list[tuple[float, float]] = []
        self.pairs: list[tuple[int, int]] = []
        self._numbers: dict[tuple[int, int], int] = {}

    def number(self, x: float, y: float) -> int:
        key = round(x / self.same), round(y / self.same)
        if key not in self._numbers:
            self._numbers[key] = len(self.places)
            self.places.append((x, y))
        return self._numbers[key]

    def line(self, points: FloatArray) -> tuple[int, int]:
        """Add a polyline; return the numbers of its ends."""
        numbers = [self.number(x, y) for x, y in points.tolist()]
        for a, b in pairwise(numbers):
            if a != b:
                self.pairs.append((min(a, b), max(a, b)))
        return numbers[0], numbers[-1]

    def add_beside(self, points: FloatArray, apart: float, check: Callable[[], None]) -> None:
        """Add the points that are not near to an existing place."""
        known = np.array(self.places)
        for x, y in points.tolist():
            check()
            if np.hypot(known[:, 0] - x, known[:, 1] - y).min() >= apart:
                self.number(x, y)


def _cut(line: FloatArray, step: float) -> FloatArray:
    points = [line[:1]]
    for a, b in pairwise(line):
        parts = max(math.ceil(math.dist(a, b) / step), 1)
        share = np.arange(1, parts + 1)[:, None] / parts
        points.append(a + share * (b - a))
        points[-1][-1] = b
    return np.concatenate(points)


def _straightened(roadmap: Roadmap, line: FloatArray, keep: float, step: float) -> FloatArray:
    """Drop points of a polyline where chords are as wide and at most a step long."""
    kept, last = [0], len(line) - 1
    while kept[-1] < last:
        end = kept[-1] + 1
        while end < last and math.dist(line[kept[-1]], line[end + 1]) <= step:
            chord = line[[kept[-1], end + 1]]
            if roadmap.path_clearance(chord).distance < keep:
                break
            end += 1
        kept.append(end)
    return np.asarray(line[kept])


def _lattice(
    roadmap: Roadmap, paths: Sequence[FloatArray], smallest: float, spacing: float
) -> FloatArray:
    """Places in rows, alternate rows shifted by half, as wide as the smallest robot needs."""
    b = roadmap.scene.bounds  # type: ignore[attr-defined]
    ys = np.arange(b.y_min + smallest, b.y_max - smallest, math.sqrt(0.75) * spacing)
    xs = np.arange(b.x_min + smallest, b.x_max - smallest, spacing)
    if not len(xs) or not len(ys):
        return np.empty((0, 2))
    x, y = np.meshgrid(xs, ys)
    x = x + 0.5 * spacing * (np.arange(len(ys)) % 2)[:, None]
    points = np.column_stack([x.ravel(), y.ravel()])
    if len(points) > LATTICE_MOST:
        points = points[np.sort(_nearest(points, np.concatenate(paths)))]
    return points[roadmap.clearance(points) >= smallest]


def _nearest(points: FloatArray, to: FloatArray) -> NDArray[np.int64]:
    distance = np.full(len(points), np.inf)
    for x, y in to[:: -(-len(to) // ASKED_MOST)].tolist():
        np.minimum(distance, np.hypot(points[:, 0] - x, points[:, 1] - y), out=distance)
    return np.argsort(distance, kind="stable")[:LATTICE_MOST].astype(np.int64)
