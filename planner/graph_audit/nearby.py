"""Edges that cross without a node, and nodes that lie on edges that do not lead to them.

- Edges along the same line, in either direction, count once, under the first one's name.
- Two straight pieces cross if each one's ends surely lie on both sides of the other. Crossings
  within ``NEAR_EDGE`` radii of their nodes do not count.
- A sweep finds the pairs: O(n log n) and the pairs.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner.graph_audit.edge_lines import EdgeLines, vec_of
from planner.graph_audit.findings import FindingList
from planner.scene import FloatArray, IntArray, Vec

NEAR_EDGE = 0.01
"""A node this near to an edge, in robot radii, is on it: people draw no better."""
PAIRS_AT_ONCE = 2_000_000
"""Pairs looked at in one step: some 200 MB."""
CROSSING_SLACK = 1e-15
"""Error bound of a turn's determinant over its products (Shewchuk 1997: 3.3e-16)."""


@dataclass(frozen=True, slots=True)
class _Pieces:
    """Straight pieces (p, 4), the edge (p,) of each, and the edge's two nodes (p, 2)."""

    xy: FloatArray
    edge: IntArray
    ends: IntArray


def find_nearby(lines: EdgeLines, radius: float, findings: FindingList) -> None:
    """Add findings on crossings and on nodes that edges pass."""
    rows, edge = lines.pieces()
    some = np.isin(edge, lines.once())
    pieces = _Pieces(rows[some], edge[some], lines.ends[edge[some]])
    near = NEAR_EDGE * radius
    names = [one.name for one in lines.edges]
    for e, node, gap in _passed(pieces, lines.places, near):
        at = vec_of(lines.places[node])
        other = lines.node_names[node]
        findings.add("edge_passes_node", "edge", names[e], at, gap, other=other)
    for e, f, at in _crossings(pieces, lines.places, near):
        findings.add("edges_cross", "edge", names[e], at, other=names[f])


def _pairs(
    low: FloatArray, high: FloatArray, other_low: FloatArray, other_high: FloatArray
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Yield overlapping pairs of intervals of two lists."""
    order = np.argsort(other_low, kind="stable")
    begins = other_low[order]
    # candidates begin before an interval ends, and by the longest one before it begins
    longest = float((other_high - other_low).max(initial=0.0))
    first = np.searchsorted(begins, low - longest, side="left")
    last = np.searchsorted(begins, high, side="right")
    counts = last - first
    total = np.concatenate([[0], np.cumsum(counts)])
    begin = 0
    while begin < len(low):
        end = int(np.searchsorted(total, total[begin] + PAIRS_AT_ONCE, side="right")) - 1
        end = min(max(end, begin + 1), len(low))
        rows = np.repeat(np.arange(begin, end), counts[begin:end])
        within = np.arange(len(rows)) - np.repeat(
            total[begin:end] - total[begin], counts[begin:end]
        )
        yield rows, order[first[rows] + within]
        begin = end


def _boxes(xy: FloatArray) -> tuple[FloatArray, FloatArray]:
    return np.minimum(xy[:, :2], xy[:, 2:]), np.maximum(xy[:, :2], xy[:, 2:])


def _passed(pieces: _Pieces, places: FloatArray, near: float) -> Iterator[tuple[int, int, float]]:
    """Yield edge, node and distance where an edge passes a node that is not its own."""
    low, high = _boxes(pieces.xy)
    best: dict[tuple[int, int], float] = {}
    for row, node in _pairs(low[:, 0] - near, high[:, 0] + near, places[:, 0], places[:, 0]):
        y = places[node, 1]
        close = (y >= low[row, 1] - near) & (y <= high[row, 1] + near)
        row, node = row[close], node[close]
        gap = _distance(places[node], pieces.xy[row])
        ends = places[pieces.ends[row]]
        own = np.hypot(*(ends - places[node][:, None]).transpose(2, 0, 1)).min(
            axis=1, initial=np.inf
        )
        for k in np.flatnonzero((gap <= near) & (own > near)).tolist():
            key = int(pieces.edge[row[k]]), int(node[k])
            best[key] = min(best.get(key, np.inf), float(gap[k]))
    for (edge, one), least in sorted(best.items()):
        yield edge, one, least


def _distance(points: FloatArray, xy: FloatArray) -> FloatArray:
    along = xy[:, 2:] - xy[:, :2]
    off = points - xy[:, :2]
    square = (along * along).sum(axis=1)
    part = np.clip((off * along).sum(axis=1) / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
    distance: FloatArray = np.hypot(*(off - part[:, None] * along).T)
    return distance


def _crossings(pieces: _Pieces, places: FloatArray, near: float) -> Iterator[tuple[int, int, Vec]]:
    """Yield two edges and a place where they cross, once for each two."""
    low, high = _boxes(pieces.xy)
    done: set[tuple[int, int]] = set()
    axis = _narrower(low, high)
    for i, j in _pairs(low[:, axis], high[:, axis], low[:, axis], high[:, axis]):
        other = 1 - axis
        meet = (pieces.edge[i] < pieces.edge[j]) & (low[i, axis] <= high[j, axis])
        meet &= (low[j, axis] <= high[i, axis]) & (low[i, other] <= high[j, other])
        meet &= low[j, other] <= high[i, other]
        i, j = i[meet], j[meet]
        crossed, at = _cross(pieces.xy[i], pieces.xy[j])
        i, j, at = i[crossed], j[crossed], at[crossed]
        ends = places[np.hstack([pieces.ends[i], pieces.ends[j]])]
        apart = np.hypot(*(ends - at[:, None]).transpose(2, 0, 1)).min(axis=1, initial=np.inf)
        for k in np.flatnonzero(apart > near).tolist():
            pair = int(pieces.edge[i[k]]), int(pieces.edge[j[k]])
            if pair not in done:
                done.add(pair)
                yield *pair, vec_of(at[k])


def _narrower(low: FloatArray, high: FloatArray) -> int:
    """Axis along which the pieces are shorter, as a share of all of them together."""
    if not len(low):
        return 0
    low_end, high_end = low.min(axis=0), high.max(axis=0)
    share = (high - low).sum(axis=0) / np.where(high_end > low_end, high_end - low_end, 1.0)
    return int(np.argmin(share))


def _cross(p: FloatArray, q: FloatArray) -> tuple[NDArray[np.bool_], FloatArray]:
    """Mark the pairs of pieces (n, 4) that surely cross, and give the places (n, 2)."""
    a, b, c, d = p[:, :2], p[:, 2:], q[:, :2], q[:, 2:]
    to_c, to_d = _turn(b - a, c - a), _turn(b - a, d - a)
    to_a, to_b = _turn(d - c, a - c), _turn(d - c, b - c)
    crossed = (np.sign(to_c) * np.sign(to_d) < 0.0) & (np.sign(to_a) * np.sign(to_b) < 0.0)
    part = to_a / np.where(crossed, to_a - to_b, 1.0)
    return crossed, a + part[:, None] * (b - a)


def _turn(u: FloatArray, v: FloatArray) -> FloatArray:
    """Determinants of u and v (n, 2), 0 where rounding decides the sign."""
    left, right = u[:, 0] * v[:, 1], u[:, 1] * v[:, 0]
    turn = left - right
    turn[np.abs(turn) <= CROSSING_SLACK * (np.abs(left) + np.abs(right))] = 0.0
    return turn
