"""One robot's earliest arrival among moving discs: safe-interval path planning.

Rules and units
- A graph in compressed rows: the edges of node n are ``starts[n]`` to ``starts[n + 1]``, each with
  its end ``to`` and this robot's time ``lasts``; places (n, 2).
- Others are rows of ``moves`` (m, 7): x, y, vx, vy, begin, lasts, gap; velocity zero while at rest.
  The gap is the least distance of both centres.
- A state is a node and one of its safe intervals, when no other comes too near. The earlier of two
  arrivals within one interval can do all that the later can, so the first found is the best
  (Phillips and Likhachev, "SIPP: Safe interval path planning for dynamic environments", ICRA 2011).
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from heapq import heappop, heappush
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from planner.fleet.motions.motion_kernels import forbidden_delays, near_times
from planner.scene.compile_options import LEAF, OWNING

HORIZON = 1e9
"""Time that stands for ever."""
FORBIDDEN_SLACK = 1e-9
"""By which what is forbidden is wider, for the last bits."""
X, Y, VX, VY, BEGIN, LASTS, GAP = range(7)
KERNEL: dict[str, Any] = {**OWNING, "error_model": "numpy"}


class MotionGraph(NamedTuple):
    """A robot's graph: places, edges in compressed rows, and times to the goal."""

    places: np.ndarray
    starts: np.ndarray
    to: np.ndarray
    lasts: np.ndarray


class Others(NamedTuple):
    """Moves of the others, the box of each, and space for intervals in time."""

    moves: np.ndarray
    boxes: np.ndarray
    found: np.ndarray


class States(NamedTuple):
    """Per state: interval, arrival, departure from its parent, node, done."""

    begin: np.ndarray
    end: np.ndarray
    arrival: np.ndarray
    left: np.ndarray
    parent: np.ndarray
    node: np.ndarray
    done: np.ndarray


@njit(**LEAF)
def _boxes(moves, boxes):
    """Box of each move, grown by its gap: x0, y0, x1, y1."""
    for m in range(moves.shape[0]):
        reach = moves[m, LASTS] if moves[m, VX] != 0.0 or moves[m, VY] != 0.0 else 0.0
        ex, ey = moves[m, X] + reach * moves[m, VX], moves[m, Y] + reach * moves[m, VY]
        boxes[m, 0] = min(moves[m, X], ex) - moves[m, GAP]
        boxes[m, 1] = min(moves[m, Y], ey) - moves[m, GAP]
        boxes[m, 2] = max(moves[m, X], ex) + moves[m, GAP]
        boxes[m, 3] = max(moves[m, Y], ey) + moves[m, GAP]


@njit(**LEAF)
def _insert(found, count, begin, end):
    """Insert an interval, a little wider, by begin, merged with any it meets; the new count."""
    begin, end = begin - FORBIDDEN_SLACK, end + FORBIDDEN_SLACK
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
    """Times when others come too near to a place: sorted disjoint intervals; their number."""
    count = 0
    for m in range(moves.shape[0]):
        box = boxes[m]
        if box[0] < x < box[2] and box[1] < y < box[3]:
            begin, end = near_times(
                moves[m, X] - x, moves[m, Y] - y, moves[m, VX], moves[m, VY], moves[m, LASTS],
                moves[m, GAP],
            )  # fmt: skip
            if begin < end:
                count = _insert(found, count, moves[m, BEGIN] + begin, moves[m, BEGIN] + end)
    return count


@njit(**LEAF)
def forbidden_departures(x, y, vx, vy, lasts, moves, boxes, found):
    """Times when this motion must not begin: sorted disjoint intervals; their number."""
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
                count = _insert(found, count, moves[m, BEGIN] + begin, moves[m, BEGIN] + end)
    return count


@njit(**LEAF)
def _earliest(found, count, least, most):
    """Earliest time from ``least`` to ``most`` that is not forbidden; HORIZON if none."""
    at = least
    for k in range(count):
        if found[k, 0] < at < found[k, 1]:
            at = found[k, 1]
    return at if at <= most else HORIZON


@njit(**KERNEL)
def times_to(goal, count, edges, lasts):
    """Least time from each of ``count`` nodes to the goal alone, HORIZON if unreachable.

    ``edges`` (m, 2) from and to, ``lasts`` (m,).
    """
    first = np.zeros(count + 1, np.int64)
    for e in range(edges.shape[0]):
        first[edges[e, 1] + 1] += 1
    for n in range(count):
        first[n + 1] += first[n]
    into = np.empty(edges.shape[0], np.int64)
    free = first[:-1].copy()
    for e in range(edges.shape[0]):
        into[free[edges[e, 1]]] = e
        free[edges[e, 1]] += 1
    best = np.full(count, HORIZON)
    best[goal] = 0.0
    heap = [(0.0, np.int64(goal))]
    while len(heap) > 0:
        at, there = heappop(heap)
        if at > best[there]:
            continue
        for k in range(first[there], first[there + 1]):
            e = into[k]
            before = np.int64(edges[e, 0])
            if at + lasts[e] < best[before]:
                best[before] = at + lasts[e]
                heappush(heap, (at + lasts[e], before))
    return best


@njit(**KERNEL)
def _with_capacity(states, needed):
    """Make space for ``needed`` states, doubling the arrays if they must move."""
    if needed <= states.arrival.size:
        return states
    more = max(needed, states.arrival.size)
    return States(
        np.append(states.begin, np.empty(more)),
        np.append(states.end, np.empty(more)),
        np.append(states.arrival, np.empty(more)),
        np.append(states.left, np.empty(more)),
        np.append(states.parent, np.empty(more, np.int64)),
        np.append(states.node, np.empty(more, np.int64)),
        np.append(states.done, np.zeros(more, np.bool_)),
    )


@njit(**KERNEL)
def _open_node(node, x, y, others, span, states):
    """Make the node's states, its safe intervals; ``span`` (n + 1, 2) is first state and number.

    The last row of ``span`` counts all states. Returns the states, which may have moved.
    """
    used = span[-1, 0]
    count = unsafe_times(x, y, others.moves, others.boxes, others.found)
    states = _with_capacity(states, used + count + 1)
    span[node, 0] = used
    since = 0.0
    for k in range(count + 1):
        until = others.found[k, 0] if k < count else HORIZON
        if until >= since:
            states.begin[used], states.end[used] = since, until
            states.arrival[used], states.node[used], states.done[used] = HORIZON, node, False
            used += 1
        if k < count:
            since = max(since, others.found[k, 1])
    span[node, 1] = used - span[node, 0]
    span[-1, 0] = used
    return states


@njit(**LEAF)
def _is_useful(now, lasts, first, count, states):
    """True if an edge can improve any state at its end."""
    arrival = states.arrival[now] + lasts
    for j in range(first, first + count):
        if (
            not states.done[j]
            and arrival < states.arrival[j]
            and states.end[j] >= arrival
            and states.begin[j] <= states.end[now] + lasts
        ):
            return True
    return False


@njit(**KERNEL)
def _go_along(now, edge, graph, others, span, states, heap, ahead):
    """Improve the states at the end of an edge; ``ahead`` (time to go, latest arrival)."""
    here, there, lasts = states.node[now], graph.to[edge], graph.lasts[edge]
    first, count = span[there, 0], span[there, 1]
    if not _is_useful(now, lasts, first, count, states):
        return
    x, y = graph.places[here, 0], graph.places[here, 1]
    vx, vy = 0.0, 0.0
    if lasts > 0.0:
        vx = (graph.places[there, 0] - x) / lasts
        vy = (graph.places[there, 1] - y) / lasts
    forbidden = forbidden_departures(
        x, y, vx, vy, lasts, others.moves, others.boxes, others.found
    )  # fmt: skip
    for j in range(first, first + count):
        if states.done[j]:
            continue
        at = _earliest(
            others.found, forbidden, max(states.arrival[now], states.begin[j] - lasts),
            min(states.end[now], states.end[j] - lasts),
        )  # fmt: skip
        arrival = at + lasts
        if arrival < states.arrival[j] and arrival + ahead[0] <= ahead[1]:
            states.arrival[j], states.parent[j], states.left[j] = arrival, now, at
            # among equally good states the one nearer to the goal first
            heappush(heap, (arrival + ahead[0], ahead[0], j))


@njit(**KERNEL)
def _next_state(heap, states):
    """Mark the best open state done and return it; -1 if there is none."""
    while len(heap) > 0:
        _, _, j = heappop(heap)
        if not states.done[j]:
            states.done[j] = True
            return j
    return np.int64(-1)


@njit(**KERNEL)
def _trace(last, states):
    """Way that ends in a state: nodes, arrivals, departures."""
    length, j = 0, last
    while j >= 0:
        length += 1
        j = states.parent[j]
    way, arrivals, departures = np.empty(length, np.int64), np.empty(length), np.empty(length - 1)
    j = last
    for k in range(length - 1, -1, -1):
        way[k], arrivals[k] = states.node[j], states.arrival[j]
        if k > 0:
            departures[k - 1] = states.left[j]
        j = states.parent[j]
    return way, arrivals, departures


@njit(**KERNEL)
def find_way(graph, to_goal, start, goal, moves, latest):
    """The way with the earliest arrival at the goal, to stay there for ever.

    It begins at time zero. ``to_goal`` (n,) is the time to the goal alone, ``latest`` the latest
    useful arrival. Returns (nodes (k,), arrivals (k,), departures (k - 1,)), empty if there is no
    such way; the robot rests at a node until its departure. Each node has at most one state more
    than the moves, and each is done once.
    """
    nodes = graph.places.shape[0]
    boxes = np.empty((moves.shape[0], 4))
    _boxes(moves, boxes)
    others = Others(moves, boxes, np.empty((moves.shape[0] + 1, 2)))
    span = np.zeros((nodes + 1, 2), np.int64)
    capacity = nodes + 64
    states = States(
        np.empty(capacity), np.empty(capacity), np.empty(capacity), np.empty(capacity),
        np.empty(capacity, np.int64), np.empty(capacity, np.int64), np.zeros(capacity, np.bool_),
    )  # fmt: skip
    states = _open_node(start, graph.places[start, 0], graph.places[start, 1], others, span, states)
    heap = [(0.0, 0.0, np.int64(0))]
    heap.clear()
    if span[start, 1] > 0 and states.begin[0] <= 0.0 and to_goal[start] <= latest:
        states.arrival[0], states.parent[0], states.left[0] = 0.0, -1, 0.0
        heappush(heap, (to_goal[start], to_goal[start], np.int64(0)))
    while True:
        now = _next_state(heap, states)
        if now < 0:
            return np.empty(0, np.int64), np.empty(0), np.empty(0)
        here = states.node[now]
        if here == goal and states.end[now] >= HORIZON:
            return _trace(now, states)
        for e in range(graph.starts[here], graph.starts[here + 1]):
            there = graph.to[e]
            if to_goal[there] >= HORIZON:
                continue
            if span[there, 1] == 0:
                states = _open_node(
                    there, graph.places[there, 0], graph.places[there, 1], others, span, states
                )
            _go_along(now, e, graph, others, span, states, heap, (to_goal[there], latest))


@njit(**KERNEL)
def moves_along(places, way, arrivals, departures, radius):
    """Rows of ``moves`` of a robot on its way, with its radius in place of the gap."""
    length = way.shape[0]
    rows = np.empty((2 * length, 7))
    used = 0
    for k in range(length):
        x, y = places[way[k], 0], places[way[k], 1]
        until = departures[k] if k < length - 1 else HORIZON
        if until > arrivals[k]:
            _put(rows[used], x, y, 0.0, 0.0, arrivals[k], until - arrivals[k])
            used += 1
        if k < length - 1 and arrivals[k + 1] > until:
            lasts = arrivals[k + 1] - until
            vx, vy = (places[way[k + 1], 0] - x) / lasts, (places[way[k + 1], 1] - y) / lasts
            _put(rows[used], x, y, vx, vy, until, lasts)
            used += 1
    rows[:, GAP] = radius
    return rows[:used].copy()


@njit(**LEAF)
def _put(row, x, y, vx, vy, begin, lasts):
    row[X], row[Y], row[VX], row[VY] = x, y, vx, vy
    row[BEGIN], row[LASTS] = begin, lasts


@njit(**KERNEL)
def do_touch(rows, others, gap):
    """True if two robots' moves (m, 7), each sorted by time, ever come nearer than the gap."""
    i, j = 0, 0
    while i < rows.shape[0] and j < others.shape[0]:
        a, b = rows[i], others[j]
        begin = max(a[BEGIN], b[BEGIN])
        end = min(a[BEGIN] + a[LASTS], b[BEGIN] + b[LASTS])
        if end > begin:
            s, t = begin - a[BEGIN], begin - b[BEGIN]
            near, far = near_times(
                a[X] + s * a[VX] - b[X] - t * b[VX], a[Y] + s * a[VY] - b[Y] - t * b[VY],
                a[VX] - b[VX], a[VY] - b[VY], end - begin, gap,
            )  # fmt: skip
            if far - near > FORBIDDEN_SLACK:
                return True
        if a[BEGIN] + a[LASTS] <= b[BEGIN] + b[LASTS]:
            i += 1
        else:
            j += 1
    return False
