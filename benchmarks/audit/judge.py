"""The judge: what an audit must report and what it may, decided without the planner.

Rules
- Distances have the bounds of ``distances.py``. What lies between them may be reported or not.
- Everything else looks at all pairs. What is nearer to a limit than rounding, or than half of the
  limit for places that a person would call equal, may be reported or not.
"""

from __future__ import annotations

import math
from collections import Counter
from typing import Final

import numpy as np

from benchmarks.audit.distances import Distances, Verdict
from benchmarks.audit.planted import (
    CELL_M,
    COLUMNS,
    FREE,
    LIMITS,
    OCCUPIED,
    RADIUS_M,
    ROWS,
    UNKNOWN,
    Case,
    Point,
)
from benchmarks.audit.turns import judge_turns
from planner.graph_files.route_graph import RouteEdge

NEAR_M: Final = 0.01 * RADIUS_M
"""The distance at which a node is on an edge: what the audit promises."""


class Judge:
    """Judge of one map with its zones."""

    def __init__(self, case: Case) -> None:
        self.solid = Distances(case.cells != FREE, True)
        self.seen = Distances(case.cells == OCCUPIED, False)
        self.unseen = Distances(case.cells == UNKNOWN, False)
        self.zones = Distances(case.zones, False)
        self.limits = {limit: Distances(case.limits == limit, False) for limit in LIMITS}
        self.cells = case.cells

    def is_sound(self, a: Point, b: Point) -> bool:
        """True if a line surely keeps the radius and is out of all zones."""
        return min(self.solid.bounds(a, b)[0], self.zones.bounds(a, b)[0]) > 1.05 * RADIUS_M

    def judge(self, case: Case) -> Verdict:
        """Judge a graph."""
        verdict = Verdict()
        place = {}
        for node in case.nodes:
            place.setdefault(node.id, np.array((node.x, node.y)))
        edges = [e for e in case.edges if e.start in place and e.end in place]
        for node in case.nodes:
            self._node(verdict, node.id, place[node.id])
        for edge in edges:
            self._edge(verdict, edge, place[edge.start], place[edge.end])
        _ids(verdict, case)
        lines = [(place[e.start], place[e.end]) for e in edges]
        _doubles(verdict, case, edges)
        _nearby(verdict, case, edges, lines)
        _reach(verdict, case, edges)
        judge_turns(verdict, edges, lines, self.solid, self.zones)
        return verdict

    def _node(self, verdict: Verdict, name: object, at: Point) -> None:
        low, high = self.solid.bounds(at, at)
        x, y = at.tolist()
        if not (0.0 <= x <= COLUMNS * CELL_M and 0.0 <= y <= ROWS * CELL_M):
            verdict.add("node_off_map", name, True)
        else:
            kind = self.cells[ROWS - 1 - math.floor(y / CELL_M), math.floor(x / CELL_M)]
            if kind != FREE:
                word = "node_in_obstacle" if kind == OCCUPIED else "node_in_unknown"
                verdict.add(word, name, True)
            elif low < RADIUS_M:
                verdict.add("node_near_obstacle", name, high < RADIUS_M)
        low, high = self.zones.bounds(at, at)
        if self.zones.fine[self.zones.index(at[None])].any():
            verdict.add("node_in_keepout", name, True)
        elif low < RADIUS_M:
            verdict.add("node_near_keepout", name, high < RADIUS_M)

    def _edge(self, verdict: Verdict, edge: RouteEdge, a: Point, b: Point) -> None:
        name = edge.id
        length = float(np.hypot(*(b - a)))
        if length == 0.0:  # its node is judged
            verdict.add("edge_without_length", name, True)
            return
        for one, near in ((self.solid, "edge_near_obstacle"), (self.zones, "edge_near_keepout")):
            low, high = one.bounds(a, b)
            if low < RADIUS_M:
                # an edge that touches may be said to be near, if it is inside for hardly anything
                verdict.add(near, name, low > 0.0 and high < RADIUS_M)
        for one, kind in (
            (self.seen, "edge_in_obstacle"),
            (self.unseen, "edge_in_unknown"),
            (self.zones, "edge_in_keepout"),
        ):
            sure, perhaps = one.passes(a, b)
            if sure or perhaps:
                verdict.add(kind, name, sure)
        for limit, area in self.limits.items():
            if edge.speed_percent is not None and edge.speed_percent > limit:
                sure, perhaps = area.passes(a, b)
                if sure or perhaps:
                    verdict.add("edge_too_fast", name, sure)
        out = [
            not (0.0 <= p[0] <= COLUMNS * CELL_M and 0.0 <= p[1] <= ROWS * CELL_M) for p in (a, b)
        ]
        if any(out):
            verdict.add("edge_off_map", name, True)
        if length < 1e-8:
            verdict.add("edge_without_length", name, False)
        if edge.length is not None and abs(edge.length - length) > 1e-3 * length:
            kind = "length_too_short" if edge.length < length else "length_too_long"
            verdict.add(kind, name, abs(edge.length - length) > 2e-3 * length + 0.02 * RADIUS_M)


def _ids(verdict: Verdict, case: Case) -> None:
    for number, times in Counter(edge.id for edge in case.edges).items():
        if times > 1:
            verdict.add("edge_id_taken", number, True)
    ids = {node.id for node in case.nodes}
    for edge in case.edges:
        if not {edge.start, edge.end} <= ids:
            verdict.add("edge_without_node", edge.id, True)


def _doubles(verdict: Verdict, case: Case, edges: list[RouteEdge]) -> None:
    for i, edge in enumerate(edges):
        if any((one.start, one.end) == (edge.start, edge.end) for one in edges[:i]):
            verdict.add("edge_doubled", edge.id, True)
    for i, node in enumerate(case.nodes):
        for other in case.nodes[:i]:
            if (node.x, node.y) == (other.x, other.y):
                verdict.add("node_doubled", node.id, True)
                verdict.add("node_doubled", other.id, False)


def _nearby(
    verdict: Verdict, case: Case, edges: list[RouteEdge], lines: list[tuple[Point, Point]]
) -> None:
    first: dict[tuple[float, ...], int] = {}
    for k, (a, b) in enumerate(lines):
        ends = sorted((tuple(a.tolist()), tuple(b.tolist())))
        first.setdefault((*ends[0], *ends[1]), k)
    kept = sorted(first.values())
    for k in kept:
        a, b = lines[k]
        for node in case.nodes:
            p = np.array((node.x, node.y))
            gap = _to_segment(p, a, b)
            own = min(float(np.hypot(*(p - a))), float(np.hypot(*(p - b))))
            if gap < 1.5 * NEAR_M and own > 0.5 * NEAR_M:
                sure = gap < 0.5 * NEAR_M and own > 1.5 * NEAR_M
                verdict.add("edge_passes_node", edges[k].id, sure)
    for i, k in enumerate(kept):
        for m in kept[i + 1 :]:
            crossing = _crossing(*lines[k], *lines[m])
            if crossing is None:
                continue
            apart = min(float(np.hypot(*(crossing - end))) for end in (*lines[k], *lines[m]))
            if apart > 0.5 * NEAR_M:
                verdict.add("edges_cross", edges[k].id, apart > 1.5 * NEAR_M)


def _to_segment(p: Point, a: Point, b: Point) -> float:
    d = b - a
    t = float(np.clip((p - a) @ d / max(float(d @ d), 1e-18), 0.0, 1.0))
    return float(np.hypot(*(p - a - t * d)))


def _crossing(a: Point, b: Point, c: Point, d: Point) -> Point | None:
    """Place where two segments cross, None if they do not."""
    matrix = np.array([b - a, c - d]).T
    det = float(np.linalg.det(matrix))
    if abs(det) < 1e-9:
        return None
    t, s = np.linalg.solve(matrix, c - a)
    return a + t * (b - a) if 0.0 < t < 1.0 and 0.0 < s < 1.0 else None


def _reach(verdict: Verdict, case: Case, edges: list[RouteEdge]) -> None:
    """Reachability by the closure of the matrix of edges."""
    index: dict[object, int] = {}
    for node in case.nodes:
        index.setdefault(node.id, len(index))
    n = len(index)
    step = np.eye(n, dtype=np.int64)
    for edge in edges:
        step[index[edge.start], index[edge.end]] = 1
    degree = step.sum(axis=0) + step.sum(axis=1) - 2
    for edge in edges:
        if edge.start == edge.end:
            degree[index[edge.start]] += 1
    reach = step
    for _ in range(max(1, math.ceil(math.log2(n)))):
        reach = ((reach @ reach) > 0).astype(np.int64)
    both = (reach & reach.T).astype(bool)
    joined = [k for k in range(n) if degree[k] > 0]
    names = list(index)
    for k in set(range(n)) - set(joined):
        verdict.add("node_alone", names[k], True)
    if not joined:
        return
    root = max(joined, key=lambda k: (int(both[k].sum()), -int(np.flatnonzero(both[k])[0])))
    if any(not both[root, k] for k in joined):
        verdict.add("graph_in_parts", "", True)
    for k in joined:
        if both[root, k]:
            continue
        leaves = any(edge.start == names[k] for edge in edges)
        if not leaves:
            verdict.add("node_dead_end", names[k], True)
        if not reach[root, k]:
            verdict.add("node_unreachable", names[k], True)
        elif leaves:
            verdict.add("node_without_return", names[k], True)
