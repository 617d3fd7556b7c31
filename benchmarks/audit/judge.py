"""The judge: what an audit must report and what it may, decided without the planner.

Rules
- Distances come from a distance transform (OpenCV) of the map at a quarter of a cell, side s. The
  transform gives the distance d between centres of small cells, so the true distance of a centre to
  the obstacles lies in d - s/sqrt(2) .. d - s/2; any place is within s/sqrt(2) of a centre, and a
  line's least distance within half a step of its samples'. What lies between the bounds may be
  reported or not.
- Everything else looks at all pairs. What is nearer to a limit than rounding, or than half of the
  limit for places that a person would call equal, may be reported or not.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.audit.planted import (
    CELL_M,
    COLUMNS,
    FREE,
    OCCUPIED,
    RADIUS_M,
    ROWS,
    UNKNOWN,
    Case,
    Point,
)
from planner.graph_files.route_graph import RouteEdge

FINER: Final = 4
SIDE_M: Final = CELL_M / FINER
RIM: Final = 16
"""Cells around the map: obstacles, as nothing may leave it."""
NEAR_M: Final = 0.01 * RADIUS_M
"""The distance at which a node is on an edge: what the audit promises."""
HALF_DIAGONAL: Final = SIDE_M / math.sqrt(2.0)
Named = tuple[str, str]


@dataclass
class Verdict:
    """Findings that an audit must have, and those that it may have besides."""

    must: set[Named] = field(default_factory=set)
    may: set[Named] = field(default_factory=set)

    def add(self, kind: str, name: object, sure: bool) -> None:
        (self.must if sure else self.may).add((kind, str(name)))


class Distances:
    """Bounds of the distance to the marked cells (rows, columns), row 0 the top."""

    def __init__(self, marked: NDArray[np.bool_], rim: bool) -> None:
        fine = np.pad(marked, RIM, constant_values=rim).repeat(FINER, 0).repeat(FINER, 1)
        self.fine = fine
        free = (~fine).astype(np.uint8)
        if free.all():
            self.between = np.full(fine.shape, np.inf)
        else:
            transform = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
            self.between = transform.astype(np.float64) * SIDE_M

    def index(self, points: Point) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        column = np.floor(points[:, 0] / SIDE_M).astype(np.int64) + RIM * FINER
        row = (ROWS + RIM) * FINER - 1 - np.floor(points[:, 1] / SIDE_M).astype(np.int64)
        return row, column

    def bounds(self, a: Point, b: Point) -> tuple[float, float]:
        """Lower and upper bound of the least distance of a line a b."""
        points, step = samples(a, b)
        least = float(self.between[self.index(points)].min())
        if least == 0.0:
            return 0.0, 0.0
        # the transform of 32 bits is exact to a millionth
        slack = 1e-5
        return least - 2.0 * HALF_DIAGONAL - 0.5 * step - slack, least - SIDE_M / 2 + HALF_DIAGONAL

    def passes(self, a: Point, b: Point) -> tuple[bool, bool]:
        """True twice if a line surely, and if it perhaps, runs through marked cells."""
        points, _ = samples(a, b)
        at = self.index(points)
        # two samples in marked cells are no grazed corner
        return int(self.fine[at].sum()) >= 2, float(self.between[at].min()) <= 3.0 * SIDE_M


def samples(a: Point, b: Point) -> tuple[Point, float]:
    """Points along a line, and the step between them."""
    length = float(np.hypot(*(b - a)))
    count = max(2, math.ceil(length / (0.5 * SIDE_M)) + 1)
    t = np.linspace(0.0, 1.0, count)[:, None]
    return a + t * (b - a), length / (count - 1)


class Judge:
    """Judge of one map with its zones."""

    def __init__(self, case: Case) -> None:
        self.solid = Distances(case.cells != FREE, True)
        self.seen = Distances(case.cells == OCCUPIED, False)
        self.unseen = Distances(case.cells == UNKNOWN, False)
        self.zones = Distances(case.zones, False)
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
