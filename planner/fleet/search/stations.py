"""Places for robots that are clear of each other, and the paths between them.

No two stations are nearer than two of the largest robots need, and a path between two comes that
near to no third. They are packed as tightly as possible from a few seeds.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush

import numpy as np
from numpy.typing import NDArray

from planner.scene import FloatArray

STATIONS_MOST = 200
"""In larger arenas those on the robots' own routes first, then those around them."""
TOUCH = 1e-9
"""Distances are enough within this share."""

Pair = tuple[int, int]


@dataclass(frozen=True, slots=True)
class StationGraph:
    """Nodes of the shared graph (k,), paths between two, and each one's neighbours."""

    nodes: list[int]
    ways: dict[Pair, list[int]]
    near: list[list[int]]


def choose_stations(
    places: FloatArray,
    edges: NDArray[np.int64],
    seeds: Iterable[int],
    routes: Sequence[int],
    gap: float,
) -> StationGraph:
    """Choose stations on a graph (m, 2) of two-way edges, including the seeds if possible.

    After them come nodes of ``routes``, then any with an edge.
    """
    chosen = _pack(places, edges, seeds, routes, gap * (1.0 - TOUCH))
    ways = _ways(places, edges, chosen, gap * (1.0 - TOUCH))
    near: list[list[int]] = [[] for _ in chosen]
    for a, b in sorted(ways):
        near[a].append(b)
    return StationGraph(chosen, ways, near)


def _pack(
    places: FloatArray,
    edges: NDArray[np.int64],
    seeds: Iterable[int],
    routes: Sequence[int],
    gap: float,
) -> list[int]:
    nearest = np.full(len(places), np.inf)
    chosen: list[int] = []

    def take(node: int) -> None:
        chosen.append(node)
        away = places - places[node]
        np.minimum(nearest, np.hypot(away[:, 0], away[:, 1]), out=nearest)

    for node in seeds:
        if nearest[node] >= gap:
            take(node)
    for group in (np.unique(np.asarray(routes, np.int64)), np.unique(edges)):
        while len(chosen) < STATIONS_MOST and len(group):
            group = group[nearest[group] >= gap]
            if len(group):
                # the one that leaves least space unused
                take(int(group[np.argmin(nearest[group])]))
    return chosen


def _ways(
    places: FloatArray, edges: NDArray[np.int64], chosen: Sequence[int], gap: float
) -> dict[Pair, list[int]]:
    alone: dict[int, list[Pair]] = defaultdict(list)
    shared: dict[Pair, list[Pair]] = defaultdict(list)
    touched: dict[int, set[int]] = defaultdict(set)
    near = _stations_near(places, edges, places[list(chosen)], gap)
    for (a, b), stations in zip(edges.tolist(), near, strict=True):
        if len(stations) == 1:
            alone[stations[0]].append((a, b))
            touched[a].add(stations[0])
            touched[b].add(stations[0])
        elif len(stations) == 2:
            shared[stations[0], stations[1]].append((a, b))
    pairs = set(shared)
    for owners in touched.values():
        pairs |= {(s, t) for s in owners for t in owners if s < t}
    ways = {}
    for s, t in sorted(pairs):
        way = _shortest(places, [*alone[s], *alone[t], *shared[s, t]], chosen[s], chosen[t])
        if way:
            ways[s, t], ways[t, s] = way, way[::-1]
    return ways


def _stations_near(
    places: FloatArray, edges: NDArray[np.int64], stations: FloatArray, gap: float
) -> list[list[int]]:
    begin = places[edges[:, 0]]
    step = places[edges[:, 1]] - begin
    length = np.maximum((step**2).sum(axis=1), np.finfo(float).tiny)
    found: list[list[int]] = [[] for _ in edges]
    for s, (x, y) in enumerate(stations.tolist()):
        away = np.array([x, y]) - begin
        share = np.clip((away * step).sum(axis=1) / length, 0.0, 1.0)
        away -= share[:, None] * step
        for e in np.flatnonzero(np.hypot(away[:, 0], away[:, 1]) < gap).tolist():
            found[e].append(s)
    return found


def _shortest(places: FloatArray, edges: Sequence[Pair], begin: int, end: int) -> list[int]:
    after: dict[int, list[tuple[int, float]]] = defaultdict(list)
    for a, b in edges:
        after[a].append((b, float(np.hypot(*(places[b] - places[a])))))
    heap = [(0.0, begin, -1)]
    parent: dict[int, int] = {}
    while heap:
        far, node, before = heappop(heap)
        if node in parent:
            continue
        parent[node] = before
        if node == end:
            way = [end]
            while parent[way[-1]] >= 0:
                way.append(parent[way[-1]])
            return way[::-1]
        for then, length in after[node]:
            if then not in parent:
                heappush(heap, (far + length, then, node))
    return []
