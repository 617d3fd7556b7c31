"""The roadmap as a ``networkx.Graph`` of edges that a robot of the radius can use, without spurs.

- A dead end is a spur if the disc at its end reaches less than ``DEAD_END_REACH`` radii beyond the
  disc at its junction, or if it only runs into a corner, where the clearance falls by more than
  ``TAPER`` a step. Branches into a U, or into a room whose wall is one object, stay.
- Chains that meet two by two are one edge. As a ``Graph`` holds one edge per pair of nodes and no
  loop, one of two edges between the same nodes is halved by an extra node, and a loop is cut in
  three.
- An edge's polyline is as wide as the edge but for ``NARROWER``, never less than the radius but for
  ``TIGHT_BEND``.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from planner.borders import clear_kernels
from planner.borders.box_tree_kernels import polyline_clearance
from planner.borders.generators import BoolArray, Borders
from planner.diagram import bisector_kernels
from planner.diagram.agvd import Chains
from planner.diagram.bisectors import describe
from planner.roadmap.clip import Clipped
from planner.scene import FloatArray, IntArray

DEAD_END_REACH = 1.0
"""Least reach of a dead end beyond its junction, in robot radii (lambda in the literature)."""
TAPER = 0.3
"""Sine of half the angle of a corner: 35 degrees between its sides."""
NARROWER = 1e-4
"""Share of an edge's clearance by which its polyline may come nearer to the borders."""
TIGHT_BEND = 1e-7
"""Share of the radius lost by the chords of a bend exactly as wide as the robot."""
EQUAL_DEAD_ENDS = 1e-5
"""Dead ends whose lengths differ by less, as a share of the scene, are equally long."""
CHORD_BULGE = 0.05
"""Largest gap between the bisectors and the polyline's chords, in spacings."""
EQUIDISTANT = 1e-9
"""A node is equidistant to what is as near within this share of the scene's extent."""

if TYPE_CHECKING:
    import networkx as nx


@dataclass(frozen=True, slots=True)
class Strand:
    """Chains that form one edge from node ``u`` to node ``v``: (chain, walked forwards)."""

    u: int
    v: int
    chains: tuple[tuple[int, bool], ...]


@dataclass(frozen=True, slots=True)
class StrandPoints:
    """A strand's points (n, 2) and clearances (n,), with the links to the next points.

    ``pairs`` (n, 2), ``gap``, ``step`` and ``proved`` (n,) as in
    :class:`planner.diagram.agvd.Chains`.
    """

    points: FloatArray
    rho: FloatArray
    pairs: IntArray
    gap: FloatArray
    step: FloatArray
    proved: BoolArray

    def part(self, first: int, last: int) -> StrandPoints:
        """Part between two points, both included."""
        s = slice(first, last + 1)
        return StrandPoints(
            self.points[s], self.rho[s], self.pairs[s], self.gap[s], self.step[s], self.proved[s]
        )


def make_graph(
    chains: Chains, kept: Sequence[int], borders: Borders, radius: float, spacing: float
) -> nx.Graph[int]:
    """Graph of the ``kept`` chains, all of which keep the radius."""
    import networkx as nx  # late: it takes 0.2 s, and a plan does not need it

    graph: nx.Graph[int] = nx.Graph(radius=radius)
    owners: defaultdict[int, set[int]] = defaultdict(set)
    bulge = CHORD_BULGE * spacing
    new = len(chains.node_xy)
    for strand in lay_strands(chains, kept):
        u, v = strand.u, strand.v
        run = _run(chains, strand)
        owners[u] |= _owners(borders, run.pairs[:1])
        owners[v] |= _owners(borders, run.pairs[-2:-1])
        for n in (u, v):
            _add_node(graph, n, chains.node_xy[n], max(chains.node_rho[n], radius))
        if len(run.points) == 1:
            continue
        parts = 3 if u == v else 2 if graph.has_edge(u, v) else 1
        run = _divisible(borders, run, parts)
        last = len(run.points) - 1
        cuts = [round(last * i / parts) for i in range(parts + 1)]
        nodes = [u, *range(new, new + parts - 1), v]
        new += parts - 1
        for i in range(1, parts):
            _add_node(graph, nodes[i], run.points[cuts[i]], max(run.rho[cuts[i]], radius))
            owners[nodes[i]] |= _owners(borders, run.pairs[cuts[i] - 1 : cuts[i] + 1])
        for i in range(parts):
            part = _followed(borders, run.part(cuts[i], cuts[i + 1]), radius, bulge)
            _add_edge(graph, borders, nodes[i], nodes[i + 1], part, radius)
    for n, data in graph.nodes(data=True):
        reach = data["clearance"] + EQUIDISTANT * borders.extent
        x, y = data["pos"]
        around = clear_kernels.within(borders.tree, x, y, reach)
        data["owners"] = tuple(sorted(owners[n] | set(borders.owner[around].tolist())))
    return graph


def count_graph(chains: Chains, kept: Sequence[int]) -> tuple[int, int]:
    """Numbers of nodes and edges of the graph, without making it."""
    nodes: set[int] = set()
    pairs: set[tuple[int, int]] = set()
    extra_nodes, edges = 0, 0
    for strand in lay_strands(chains, kept):
        nodes |= {strand.u, strand.v}
        c = strand.chains[0][0]
        if chains.first[c + 1] - chains.first[c] == 1:
            continue
        pair = min(strand.u, strand.v), max(strand.u, strand.v)
        parts = 3 if strand.u == strand.v else 2 if pair in pairs else 1
        pairs.add(pair)
        extra_nodes += parts - 1
        edges += parts
    return len(nodes) + extra_nodes, edges


def lay_strands(chains: Chains, kept: Sequence[int]) -> list[Strand]:
    """The edges: maximal rows of ``kept`` chains, joined where only two meet."""
    ends = chains.ends.tolist()
    around = _met(ends, kept)
    joints = {n for n, met in around.items() if len(met) == 2 and met[0][0] != met[1][0]}
    done: set[int] = set()
    strands = []
    # closed rows without a junction begin anywhere, and so come last
    for c, end in sorted(
        ((c, end) for c in kept for end in range(2)), key=lambda ce: ends[ce[0]][ce[1]] in joints
    ):
        if c in done:
            continue
        first = ends[c][end]
        row = []
        while True:
            done.add(c)
            row.append((c, end == 0))
            here = ends[c][1 - end]
            if here not in joints or here == first:
                break
            one, other = around[here]
            c, end = other if one[0] == c else one
        strands.append(Strand(first, here, tuple(row)))
    return strands


def without_spurs(clipped: Clipped, radius: float) -> list[int]:
    """The wide chains without spurs."""
    chains = clipped.chains
    kept = set(np.flatnonzero(clipped.wide).tolist())
    if not kept:
        return []
    ends, length = chains.ends.tolist(), chains.length.tolist()
    rho = chains.node_rho.tolist()
    around: defaultdict[int, set[int]] = defaultdict(set)
    for c in kept:
        for n in ends[c]:
            around[n].add(c)
    # the shortest first, of equal ones the lowest: the chains' order does not matter
    step, place = _rounded_places(chains, radius)
    ready = [
        (round(length[c] / step), place[n], n)
        for n, cs in around.items()
        if len(cs) == 1
        for c in cs
    ]
    heapify(ready)
    while ready:
        _, _, tip = heappop(ready)
        if len(around[tip]) != 1:
            continue
        (c,) = around[tip]
        u, v = ends[c]
        junction = v if tip == u else u
        if u == v or len(around[junction]) == 1:
            continue
        fall = rho[junction] - rho[tip]
        if length[c] - fall >= DEAD_END_REACH * radius and fall <= TAPER * length[c]:
            continue
        kept.discard(c)
        around[tip].discard(c)
        around[junction].discard(c)
        if len(around[junction]) == 1:
            (other,) = around[junction]
            heappush(ready, (round(length[other] / step), place[junction], junction))
    return sorted(kept)


def without_short_branches(
    chains: Chains, kept: Sequence[int], radius: float, least: float
) -> tuple[list[int], tuple[float, ...]]:
    """Leave out dead ends below ``least``, the shortest first; return the rest, and their lengths.

    O(k log k) for k tips, but for the lengths walked again.
    """
    if not kept:
        return [], ()
    ends, length = chains.ends.tolist(), chains.length.tolist()
    around = _met(ends, kept)
    step, place = _rounded_places(chains, radius)

    def branch(tip: int) -> tuple[list[int], float, int]:
        """Chains from a tip to the next junction, their length, and that junction."""
        row, coming = [], around[tip][0]
        while True:
            c, end = coming
            row.append(c)
            here = ends[c][1 - end]
            if len(around[here]) != 2:
                return row, sum(length[c] for c in row), here
            one, other = around[here]
            coming = other if one == (c, 1 - end) else one

    ready = []
    for tip, met in around.items():
        if len(met) == 1:
            ready.append((round(branch(tip)[1] / step), place[tip], tip))
    heapify(ready)
    left_out: list[float] = []
    gone: set[int] = set()
    while ready:
        key, _, tip = heappop(ready)
        row, total, junction = branch(tip)
        if total >= least or len(around[junction]) == 1:
            continue
        if round(total / step) > key:  # what met it at its junction is gone
            heappush(ready, (round(total / step), place[tip], tip))
            continue
        gone.update(row)
        left_out.append(total)
        around[junction] = [met for met in around[junction] if met[0] != row[-1]]
    return [c for c in kept if c not in gone], tuple(left_out)


def _met(ends: list[list[int]], kept: Sequence[int]) -> defaultdict[int, list[tuple[int, int]]]:
    """Chains that meet at each node, with the end that lies there; a loop meets itself."""
    around: defaultdict[int, list[tuple[int, int]]] = defaultdict(list)
    for c in kept:
        for end in range(2):
            around[ends[c][end]].append((c, end))
    return around


def _rounded_places(chains: Chains, radius: float) -> tuple[float, list[list[float]]]:
    """Length below which two are alike, and the nodes' places in it."""
    step = EQUAL_DEAD_ENDS * max(float(np.ptp(chains.node_xy, axis=0).max()), radius)
    return step, np.rint(chains.node_xy / step).tolist()


def _run(chains: Chains, strand: Strand) -> StrandPoints:
    runs = []
    for c, forwards in strand.chains:
        s = slice(int(chains.first[c]), int(chains.first[c + 1]))
        points, rho, proved = chains.points[s], chains.rho[s], chains.proved[s]
        pairs, gap, step = chains.pieces[s], chains.gap[s], chains.step[s]
        if not forwards:
            points, rho, pairs = points[::-1], rho[::-1], _turned(pairs)[:, ::-1]
            gap, step, proved = _turned(gap), _turned(step), _turned(proved)
        runs.append((points, rho, pairs, gap, step, proved))
    columns = [[*(a[:-1] for a in arrays[:-1]), arrays[-1]] for arrays in zip(*runs, strict=True)]
    return StrandPoints(*(np.concatenate(column) for column in columns))


def _turned(of_links: NDArray[Any]) -> NDArray[Any]:
    """Reverse an array of links; the last row stays last."""
    return np.concatenate([of_links[:-1][::-1], of_links[-1:]])


def _followed(borders: Borders, run: StrandPoints, radius: float, bulge: float) -> StrandPoints:
    keep = max(radius * (1.0 - TIGHT_BEND), float(run.gap[:-1].min()) * (1.0 - NARROWER))
    pairs = np.where(run.proved[:, None], run.pairs, -1)
    points, _ = bisector_kernels.follow(
        borders.tree, run.points, pairs, keep, bulge, borders.equal, np.inf
    )
    if len(points) == len(run.points):
        return run
    link = np.zeros(len(points), np.int32)
    at = 0
    for i in range(1, len(run.points)):
        at += 1
        while (points[at] != run.points[i]).any():
            link[at] = i - 1
            at += 1
        link[at] = i
    return _with_points(borders, run, points, link)


def _divisible(borders: Borders, run: StrandPoints, parts: int) -> StrandPoints:
    links = len(run.points) - 1
    if links >= parts:
        return run
    points, link = [], []
    for i in range(links):
        a, step = run.points[i], run.points[i + 1] - run.points[i]
        for share in np.linspace(0.0, 1.0, parts, endpoint=False):
            place = a + share * step
            if run.proved[i] and share > 0.0:
                left, right = run.pairs[i].tolist()
                x, y, _ = bisector_kernels.slide_between(
                    borders.kind, borders.data, left, right, place[0], place[1],
                    borders.equal,
                )  # fmt: skip
                place = np.array([x, y])
            points.append(place)
            link.append(i)
    return _with_points(
        borders, run, np.array([*points, run.points[-1]]), np.array([*link, links], np.int32)
    )


def _with_points(
    borders: Borders, run: StrandPoints, points: FloatArray, link: IntArray
) -> StrandPoints:
    """Return the run through more points, each in or at the start of a ``link`` (m,).

    A part of a proved link is as wide as its narrower end; others are measured.
    """
    rho = borders.distances(np.ascontiguousarray(points))[0]
    proved = run.proved[link]
    gap, step = np.full(len(points), np.inf), np.zeros(len(points))
    step[:-1] = np.hypot(*np.diff(points, axis=0).T)
    for i in range(len(points) - 1):
        gap[i] = min(rho[i], rho[i + 1])
        if not proved[i]:
            gap[i] = polyline_clearance(borders.tree, points[i : i + 2])[0]
    return StrandPoints(points, rho, run.pairs[link], gap, step, proved)


def _owners(borders: Borders, pairs: IntArray) -> set[int]:
    labels = pairs.ravel()
    return set(borders.owner[labels[labels >= 0]].tolist())


def _add_node(graph: nx.Graph[int], n: int, xy: FloatArray, clearance: float) -> None:
    if n not in graph:
        graph.add_node(n, pos=(float(xy[0]), float(xy[1])), clearance=float(clearance))


def _add_edge(
    graph: nx.Graph[int], borders: Borders, u: int, v: int, run: StrandPoints, radius: float
) -> None:
    """Add a wide run, narrower than ``radius`` only by rounding."""
    polyline = np.array(run.points)
    polyline.setflags(write=False)
    graph.add_edge(
        u,
        v,
        polyline=polyline,
        geometry=describe(borders, run.points, run.pairs, run.proved),
        length=float(run.step[:-1].sum()),
        clearance=max(float(run.gap[:-1].min()), radius),
        owners=tuple(sorted(_owners(borders, run.pairs[:-1]))),
    )
