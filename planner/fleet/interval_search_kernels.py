"""One robot's earliest arrival among moving discs: safe-interval path planning.

Rules and units
- A graph in compressed rows: the edges of node n are ``starts[n]`` to ``starts[n + 1]``, each with
  its end ``to`` and the time ``lasts`` that this robot takes; places (n, 2).
- Others are rows of ``moves`` (m, 7): x, y, vx, vy, begin, lasts, gap; where they stand, with
  velocity zero. The gap is the least distance of both centres.
- A state is a node and one of its safe intervals, the times at which nobody comes too near. Of
  two arrivals within one interval the earlier can do all that the later can, so that the first
  one found is the best (Phillips and Likhachev, "SIPP: Safe interval path planning for
  dynamic environments", ICRA 2011).
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np
from numba import njit

from planner.fleet.motion_kernels import forbidden_delays, near_times
from planner.scene.compile_options import LEAF

HORIZON = 1e9
"""Time that stands for ever."""
SLACK = 1e-9
"""By which what is forbidden is wider, for the last bits."""
X, Y, VX, VY, BEGIN, LASTS, GAP = range(7)
KERNEL = {"cache": True, "nogil": True, "error_model": "numpy"}


class Graph(NamedTuple):
    """Where one robot can go: places, edges in compressed rows, and times to the goal."""

    places: np.ndarray
    starts: np.ndarray
    to: np.ndarray
    lasts: np.ndarray


@njit(**LEAF)
def _boxes(moves, boxes):
    """The box of each move, grown by its gap: x0, y0, x1, y1."""
    for m in range(moves.shape[0]):
        reach = moves[m, LASTS] if moves[m, VX] != 0.0 or moves[m, VY] != 0.0 else 0.0
        ex, ey = moves[m, X] + reach * moves[m, VX], moves[m, Y] + reach * moves[m, VY]
        boxes[m, 0] = min(moves[m, X], ex) - moves[m, GAP]
        boxes[m, 1] = min(moves[m, Y], ey) - moves[m, GAP]
        boxes[m, 2] = max(moves[m, X], ex) + moves[m, GAP]
        boxes[m, 3] = max(moves[m, Y], ey) + moves[m, GAP]


@njit(**LEAF)
def _insert(found, count, begin, end):
    """Put an interval in its place by begin, joined with those that it meets; the new count."""
    k = count
    while k > 0 and found[k - 1, 0] > begin:
        k -= 1
    if k > 0 and found[k - 1, 1] >= begin:
        k -= 1
        found[k, 1] = max(found[k, 1], end)
    else:
        for j in range(count, k, -1):
            found[j, 0], found[j, 1] = found[j - 1, 0], found[j - 1, 1]
        found[k, 0], found[k, 1] = begin, end
        count += 1
    last = k + 1
    while last < count and found[last, 0] <= found[k, 1]:
        found[k, 1] = max(found[k, 1], found[last, 1])
        last += 1
    shift = last - k - 1
    if shift > 0:
        for j in range(last, count):
            found[j - shift, 0], found[j - shift, 1] = found[j, 0], found[j, 1]
    return count - shift


@njit(**LEAF)
def unsafe_times(x, y, moves, boxes, found):
    """When somebody comes too near to a place: sorted disjoint intervals; how many."""
    count = 0
    for m in range(moves.shape[0]):
        box = boxes[m]
        if box[0] < x < box[2] and box[1] < y < box[3]:
            begin, end = near_times(
                moves[m, X] - x, moves[m, Y] - y, moves[m, VX], moves[m, VY], moves[m, LASTS],
                moves[m, GAP],
            )  # fmt: skip
            if begin < end:
                at = moves[m, BEGIN]
                count = _insert(found, count, at + begin - SLACK, at + end + SLACK)
    return count


@njit(**LEAF)
def forbidden_departures(x, y, vx, vy, lasts, moves, boxes, found):
    """When this motion must not begin: sorted disjoint intervals; how many."""
    ex, ey = x + lasts * vx, y + lasts * vy
    x0, x1 = min(x, ex), max(x, ex)
    y0, y1 = min(y, ey), max(y, ey)
    count = 0
    for m in range(moves.shape[0]):
        box = boxes[m]
        if box[0] < x1 and box[2] > x0 and box[1] < y1 and box[3] > y0:
            begin, end = forbidden_delays(
                x - moves[m, X], y - moves[m, Y], (vx, vy, lasts),
                (moves[m, VX], moves[m, VY], moves[m, LASTS]), moves[m, GAP],
            )  # fmt: skip
            if begin < end:
                at = moves[m, BEGIN]
                count = _insert(found, count, at + begin - SLACK, at + end + SLACK)
    return count


@njit(**LEAF)
def _earliest(found, count, least, most):
    """The earliest time from ``least`` to ``most`` that is not forbidden; HORIZON if none."""
    at = least
    for k in range(count):
        if found[k, 0] < at < found[k, 1]:
            at = found[k, 1]
    return at if at <= most else HORIZON


@njit(**KERNEL)
def find_way(graph, to_goal, begin, goal, moves, most):
    """The way with the earliest arrival at the goal, to stay there for ever.

    ``begin`` (node, time), ``to_goal`` (n,) the time to the goal alone, ``most`` the number of
    states to look at. Returns (nodes (k,), arrivals (k,), departures (k - 1,)), empty where
    there is none; an edge is left at its departure, and till then the robot stands.
    """
    nodes = graph.places.shape[0]
    boxes = np.empty((moves.shape[0], 4))
    _boxes(moves, boxes)
    found = np.empty((moves.shape[0] + 1, 2))
    # safe intervals of each node, made when it is first reached
    first = np.full(nodes, -1, np.int64)
    number = np.zeros(nodes, np.int64)
    safe_begin, safe_end = np.empty(4 * nodes + 64), np.empty(4 * nodes + 64)
    arrival, parent = np.empty(safe_begin.size), np.empty(safe_begin.size, np.int64)
    left, node_of = np.empty(safe_begin.size), np.empty(safe_begin.size, np.int64)
    done = np.zeros(safe_begin.size, np.bool_)
    used = 0
    heap = [(0.0, 0.0, np.int64(-1))]
    heap.clear()
    start, start_s = np.int64(begin[0]), begin[1]
    looked = 0
    now, here = np.int64(-1), start
    while True:
        if now < 0:
            edges_from, edges_to = 0, 1
        else:
            edges_from, edges_to = graph.starts[here], graph.starts[here + 1]
        for e in range(edges_from, edges_to):
            there = start if now < 0 else np.int64(graph.to[e])
            if to_goal[there] >= HORIZON:
                continue
            if first[there] < 0:
                count = unsafe_times(
                    graph.places[there, 0], graph.places[there, 1], moves, boxes, found
                )
                while used + count + 1 > arrival.size:
                    safe_begin = np.append(safe_begin, np.empty(safe_begin.size))
                    safe_end = np.append(safe_end, np.empty(safe_end.size))
                    arrival = np.append(arrival, np.empty(arrival.size))
                    left = np.append(left, np.empty(left.size))
                    parent = np.append(parent, np.empty(parent.size, np.int64))
                    node_of = np.append(node_of, np.empty(node_of.size, np.int64))
                    done = np.append(done, np.zeros(done.size, np.bool_))
                first[there] = used
                since = 0.0
                for k in range(count + 1):
                    until = found[k, 0] if k < count else HORIZON
                    if until >= since:
                        safe_begin[used], safe_end[used] = since, until
                        arrival[used], node_of[used] = HORIZON, there
                        used += 1
                    if k < count:
                        since = max(since, found[k, 1])
                number[there] = used - first[there]
            if now < 0:
                for j in range(first[there], first[there] + number[there]):
                    if safe_begin[j] <= start_s <= safe_end[j]:
                        arrival[j], parent[j], left[j] = start_s, -1, start_s
                        heappush(heap, (start_s + to_goal[there], -start_s, j))
                continue
            lasts = graph.lasts[e]
            x, y = graph.places[here, 0], graph.places[here, 1]
            vx = (graph.places[there, 0] - x) / lasts
            vy = (graph.places[there, 1] - y) / lasts
            useful = False
            for j in range(first[there], first[there] + number[there]):
                if (
                    not done[j]
                    and arrival[now] + lasts < arrival[j]
                    and safe_end[j] >= arrival[now] + lasts
                    and safe_begin[j] <= safe_end[now] + lasts
                ):
                    useful = True
            if not useful:
                continue
            count = forbidden_departures(x, y, vx, vy, lasts, moves, boxes, found)
            for j in range(first[there], first[there] + number[there]):
                if done[j]:
                    continue
                at = _earliest(
                    found, count, max(arrival[now], safe_begin[j] - lasts),
                    min(safe_end[now], safe_end[j] - lasts),
                )  # fmt: skip
                if at + lasts < arrival[j]:
                    arrival[j], parent[j], left[j] = at + lasts, now, at
                    heappush(heap, (at + lasts + to_goal[there], -at - lasts, j))
        now = np.int64(-1)
        while len(heap) > 0:
            _, _, j = heappop(heap)
            if not done[j]:
                now = j
                break
        looked += 1
        if now < 0 or looked > most:
            return np.empty(0, np.int64), np.empty(0), np.empty(0)
        done[now] = True
        here = node_of[now]
        if here == goal and safe_end[now] >= HORIZON:
            break
    length = 0
    j = now
    while j >= 0:
        length += 1
        j = parent[j]
    way, arrivals, departures = np.empty(length, np.int64), np.empty(length), np.empty(length - 1)
    j = now
    for k in range(length - 1, -1, -1):
        way[k], arrivals[k] = node_of[j], arrival[j]
        if k > 0:
            departures[k - 1] = left[j]
        j = parent[j]
    return way, arrivals, departures
