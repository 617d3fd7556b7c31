"""The roadmap as a ``networkx.Graph``: what a robot of the radius can use, without spurs."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

import networkx as nx
import numpy as np

from planner.agvd import Chains
from planner.generators import Borders
from planner.scene import FloatArray

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
    for c in np.flatnonzero(chains.clearance >= roadmap.radius):
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
        if u != v and not graph.has_edge(u, v):
            _add_edge(graph, u, v, points, gap, step, mine)
            continue
        cut = len(points) // 2
        middle = len(chains.node_xy) + int(c)
        if len(points) == 2:
            points = np.array([points[0], points.mean(axis=0), points[1]])
            gap, step = np.repeat(gap[:1], 3), np.repeat(step[:1] / 2.0, 3)
        _add_node(graph, middle, points[cut], gap[cut])
        owners[middle] |= mine
        _add_edge(graph, u, middle, points[: cut + 1], gap[: cut + 1], step[: cut + 1], mine)
        _add_edge(graph, middle, v, points[cut:], gap[cut:], step[cut:], mine)
    for n in graph:
        graph.nodes[n]["owners"] = tuple(sorted(owners[n]))
    return graph


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
) -> None:
    polyline = points.copy()
    polyline.setflags(write=False)
    graph.add_edge(
        u,
        v,
        polyline=polyline,
        length=float(step[:-1].sum()),
        clearance=float(gap[:-1].min()),
        owners=tuple(sorted(owners)),
    )
