"""The roadmap as a ``networkx.Graph``: what a robot of the radius can use, without spurs.

Rules
- A chain is in the graph where it keeps the radius throughout.
- A dead end is a spur, and left out, where the disc at its end reaches less than ``REACH``
  radii beyond the disc at its junction, or where it only runs into a corner: there the
  clearance falls by more than ``TAPER`` a step. Whatever a spur leads to is reached from its
  junction. The branches into a U, or into a room whose wall is one object, stay.
"""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

import networkx as nx
import numpy as np

from planner.agvd import Chains
from planner.bisectors import Piece, describe
from planner.generators import Borders
from planner.scene import FloatArray

REACH = 1.0
"""What a dead end must reach beyond its junction, in robot radii (lambda in the literature)."""
TAPER = 0.3
"""Sine of half the angle of a corner that counts as one: 35 degrees between its sides."""

if TYPE_CHECKING:
    from planner.roadmap import Roadmap


def make_graph(roadmap: Roadmap) -> nx.Graph[int]:
    """The chains that keep the radius as a graph.

    Two chains between the same nodes, and a chain that returns to its node, are halved by a
    node of their own, since a ``Graph`` holds one edge a pair.
    """
    chains, borders = roadmap.chains, roadmap.borders
    graph: nx.Graph[int] = nx.Graph(radius=roadmap.radius)
    owners: defaultdict[int, set[int]] = defaultdict(set)
    for c in without_spurs(chains, roadmap.radius):
        u, v = (int(n) for n in chains.ends[c])
        part = slice(int(chains.first[c]), int(chains.first[c + 1]))
        mine = _owners(borders, chains, part)
        owners[u] |= mine
        owners[v] |= mine
        if part.stop - part.start == 1:
            _add_node(graph, u, chains.node_xy[u], chains.node_rho[u])
            continue
        for n in (u, v):
            _add_node(graph, n, chains.node_xy[n], chains.node_rho[n])
        points = chains.points[part]
        gap, step = chains.gap[part], chains.step[part]
        pairs, proved = chains.pieces[part], chains.proved[part]
        if u != v and not graph.has_edge(u, v):
            geometry = describe(borders, points, pairs, proved)
            _add_edge(graph, u, v, points, gap, step, mine, geometry)
            continue
        cut = len(points) // 2
        middle = len(chains.node_xy) + int(c)
        if len(points) == 2:
            points = np.array([points[0], points.mean(axis=0), points[1]])
            gap, step = np.repeat(gap[:1], 3), np.repeat(step[:1] / 2.0, 3)
            pairs, proved = pairs[[0, 0, 1]], proved[[0, 0, 1]]
        _add_node(graph, middle, points[cut], gap[cut])
        owners[middle] |= mine
        for a, b, half in ((u, middle, slice(0, cut + 1)), (middle, v, slice(cut, None))):
            geometry = describe(borders, points[half], pairs[half], proved[half])
            _add_edge(graph, a, b, points[half], gap[half], step[half], mine, geometry)
    for n in graph:
        graph.nodes[n]["owners"] = tuple(sorted(owners[n]))
    return graph


def without_spurs(chains: Chains, radius: float) -> list[int]:
    """The chains that keep the radius, less the dead ends that lead nowhere of their own."""
    kept = set(np.flatnonzero(chains.clearance >= radius).tolist())
    around: defaultdict[int, set[int]] = defaultdict(set)
    for c in kept:
        for n in chains.ends[c].tolist():
            around[n].add(c)
    ready = [n for n, cs in around.items() if len(cs) == 1]
    while ready:
        tip = ready.pop()
        if len(around[tip]) != 1:
            continue
        (c,) = around[tip]
        u, v = chains.ends[c].tolist()
        junction = v if tip == u else u
        if u == v or len(around[junction]) == 1:
            continue
        fall = chains.node_rho[junction] - chains.node_rho[tip]
        if chains.length[c] - fall >= REACH * radius and fall <= TAPER * chains.length[c]:
            continue
        kept.discard(c)
        around[tip].discard(c)
        around[junction].discard(c)
        if len(around[junction]) == 1:
            ready.append(junction)
    return sorted(kept)


def _owners(borders: Borders, chains: Chains, part: slice) -> set[int]:
    labels = chains.pieces[part].ravel()
    return {int(o) for o in borders.owner[labels[labels >= 0]]}


def _add_node(graph: nx.Graph[int], n: int, xy: FloatArray, clearance: float) -> None:
    if n not in graph:
        graph.add_node(n, pos=(float(xy[0]), float(xy[1])), clearance=float(clearance))


def _add_edge(
    graph: nx.Graph[int],
    u: int,
    v: int,
    points: FloatArray,
    gap: FloatArray,
    step: FloatArray,
    owners: set[int],
    geometry: tuple[Piece, ...],
) -> None:
    polyline = points.copy()
    polyline.setflags(write=False)
    graph.add_edge(
        u,
        v,
        polyline=polyline,
        geometry=geometry,
        length=float(step[:-1].sum()),
        clearance=float(gap[:-1].min()),
        owners=tuple(sorted(owners)),
    )
