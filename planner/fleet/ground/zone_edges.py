"""Edges of the shared graph that the zones leave to one robot, and the time that they cost.

- On an edge the robot's body must stay out of keep-out zones, measured exactly, and it must not
  drive against a one-way zone. A robot that begins in a keep-out zone may use the edges along its
  own path out.
- Only the choice of paths rests on costs of slow zones and lanes; the order at shared places is
  right whatever the times.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from planner.fleet.ground.clearance_kernels import edge_clearances
from planner.scene import FloatArray
from planner.zones.rules import AGAINST, PIECE, RADIUS_ROUNDING, Rules
from planner.zones.zone_ground import ZoneGround

PLACES_OF_EDGE = 8
"""Places of an edge: chosen, edges are a few radii long."""
MOST_ROUNDED_EDGES = 20
"""Edges inside a one-way zone that may each be driven against by rounding: chosen, so that a
path of them stays within what is allowed for all."""
SAMPLES_AT_ONCE = 10_000
"""Places of edges looked at between two looks at the time: chosen, 0.1 s with a line of 100."""
ON_PATH = 1e-6
"""A place lies on a path within this share of the radius."""


def usable_edges(
    places: FloatArray,
    edges: NDArray[np.int64],
    rules: Rules,
    own_path: FloatArray,
    check: Callable[[], None] = lambda: None,
) -> NDArray[np.bool_]:
    """Mark the edges (m, 2) that a robot may use; ``own_path`` (n, 2) is its path alone.

    ``check`` is called before each piece of work, and may raise an error that ends it.
    """
    usable = np.ones(len(edges), np.bool_)
    begin = (float(own_path[0, 0]), float(own_path[0, 1]))
    for one in rules.of("keep_out"):
        clear = _clearances(one, places, edges) >= rules.radius * (1.0 - RADIUS_ROUNDING)
        if rules.is_held_by(one, begin):
            clear |= _on_path(places, edges, own_path, ON_PATH * rules.radius)
        usable &= clear
    for one in rules.of("one_way"):
        most = AGAINST * rules.radius / MOST_ROUNDED_EDGES
        usable &= _against(one, places, edges, PLACES_OF_EDGE, check) <= most
        # places so far apart may miss a thin zone: edges that touch it are cut as whole paths are
        touch = np.flatnonzero(usable)
        touch = touch[_clearances(one, places, edges[touch]) == 0.0]
        if len(touch):
            longest = float(np.hypot(*np.diff(places[edges[touch]], axis=1)[:, 0].T).max())
            count = math.ceil(longest / (PIECE * rules.radius))
            usable[touch] = _against(one, places, edges[touch], count, check) <= most
    return usable


def cost_factors(places: FloatArray, edges: NDArray[np.int64], rules: Rules) -> FloatArray:
    """Mean cost (m,) of a unit of length along each edge (m, 2)."""
    if not rules.of("slow", "lane") or not len(edges):
        return np.ones(len(edges))
    factors: FloatArray = (
        rules.factors(_samples(places, edges)).reshape(-1, PLACES_OF_EDGE).mean(axis=1)
    )
    return factors


def _samples(
    places: FloatArray, edges: NDArray[np.int64], count: int = PLACES_OF_EDGE
) -> FloatArray:
    share = (np.arange(count) + 0.5) / count
    begin, step = places[edges[:, 0]], places[edges[:, 1]] - places[edges[:, 0]]
    points: FloatArray = (begin[:, None] + share[:, None] * step[:, None]).reshape(-1, 2)
    return points


def _clearances(one: ZoneGround, places: FloatArray, edges: NDArray[np.int64]) -> FloatArray:
    """Least distance (m,) of each edge to a zone, 0 inside."""
    borders = one.ground.borders
    if borders is None:
        return np.full(len(edges), np.inf)
    found: FloatArray = edge_clearances(borders.tree, places, edges)
    found[(one.distances(places) < 0.0)[edges].any(axis=1)] = 0.0
    return found


def _against(
    one: ZoneGround,
    places: FloatArray,
    edges: NDArray[np.int64],
    count: int,
    check: Callable[[], None],
) -> FloatArray:
    """Progress (m,) of each edge against a one-way zone, by ``count`` places of each."""
    at_once = max(1, SAMPLES_AT_ONCE // count)
    progress = np.empty(len(edges))
    for first in range(0, len(edges), at_once):
        check()
        some = slice(first, first + at_once)
        progress[some] = _some_against(one, places, edges[some], count)
    return progress


def _some_against(
    one: ZoneGround, places: FloatArray, edges: NDArray[np.int64], count: int
) -> FloatArray:
    points = _samples(places, edges, count)
    steps = np.repeat((places[edges[:, 1]] - places[edges[:, 0]]) / count, count, axis=0)
    back = np.zeros(len(points))
    inside = np.flatnonzero(one.distances(points) < 0.0)
    if len(inside):
        along = (steps[inside] * one.directions(points[inside])).sum(axis=1)
        back[inside] = np.maximum(-along, 0.0)
    progress: FloatArray = back.reshape(-1, count).sum(axis=1)
    return progress


def _on_path(
    places: FloatArray, edges: NDArray[np.int64], line: FloatArray, near: float
) -> NDArray[np.bool_]:
    on_path: NDArray[np.bool_] = np.asarray((_distances(places, line) <= near)[edges].all(axis=1))
    rows = np.flatnonzero(on_path)
    samples = _distances(_samples(places, edges[rows]), line).reshape(-1, PLACES_OF_EDGE)
    on_path[rows] = (samples <= near).all(axis=1)
    return on_path


def _distances(places: FloatArray, line: FloatArray) -> FloatArray:
    """Distance (n,) of places (n, 2) to a polyline."""
    least = np.full(len(places), np.inf)
    for a, b in pairwise(line):
        step = b - a
        squared = max(float(step @ step), np.finfo(float).tiny)
        share = np.clip((places - a) @ step / squared, 0.0, 1.0)
        least = np.minimum(least, np.hypot(*(places - a - share[:, None] * step).T))
    return least
