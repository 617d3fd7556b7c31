"""The shortest way that keeps a distance: a search over tangents and arcs, on flat arrays.

Rules and units
- A disc is an arc of :mod:`planner.search.tangent_search`: centre, radius, and the exposed
  directions of its border, ``cone`` = first angle and width. Disc 0 is the start and disc 1 the
  goal, of radius 0.
- A side is +1 for a way counter-clockwise round a disc (angles grow), -1 for clockwise.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from planner.borders.box_tree_kernels import segment_clearance
from planner.scene.compile_options import BORROWING, OWNING
from planner.scene.primitive_kernels import (
    ARC,
    SEGMENT,
    TAU,
    grown,
    has_ends,
    is_round,
    put_rows,
)
from planner.search.chain_graph_kernels import pop, push

ANGLE = 1e-7
"""Angles nearer than this are equal."""
STEP_RAD = 0.2
"""An arc is proved free in chords around it of at most this angle."""
SHORTEST_RAD = STEP_RAD / 64.0
"""Shortest chord that has to be free for the arc to continue."""
START, GOAL = 0, 1
FOUND, NONE_SHORTER, OUT_OF_BUDGET = 0, 1, 2
CHECK, QUEUE_ENTRY = 60, 10
"""Cost of a clearance query and of an entry in the queue, in tangents tried."""


@njit(**BORROWING)
def turn_towards(a, b, side):
    """Angle from a to b towards ``side``, in [0, 2 pi), rounding counted as 0."""
    t = (side * (b - a)) % TAU
    return 0.0 if t > TAU - ANGLE else t


@njit(**BORROWING)
def _ends(kind, data, i, out):
    """Both ends of a segment or arc, each with the direction from it along the piece."""
    if kind[i] == SEGMENT:
        a = math.atan2(data[i, 3] - data[i, 1], data[i, 2] - data[i, 0])
        out[0, 0], out[0, 1], out[0, 2] = data[i, 0], data[i, 1], a
        out[1, 0], out[1, 1], out[1, 2] = data[i, 2], data[i, 3], a + math.pi
        return
    for end in range(2):
        a = data[i, 3] + end * data[i, 4]
        out[end, 0] = data[i, 0] + data[i, 2] * math.cos(a)
        out[end, 1] = data[i, 1] + data[i, 2] * math.sin(a)
        out[end, 2] = a + (0.5 - end) * math.pi


@njit(**OWNING)
def discs_around(kind, data, keep, joint, start, goal, longest):
    """Discs (n, 5) that a way shorter than ``longest`` from start to goal can touch.

    Columns: centre x, y, radius, cone's first angle and width. Ends of pieces within ``joint`` are
    one corner, exposed at a right angle or more to each of its pieces, where none is nearer.
    """
    k = len(kind)
    out = np.empty((2 + 3 * k, 5))
    out[START, 0], out[START, 1], out[GOAL, 0], out[GOAL, 1] = start[0], start[1], goal[0], goal[1]
    out[:2, 2:4] = 0.0
    out[:2, 4] = TAU
    n = 2
    ends = np.empty((2 * k, 3))
    two = np.empty((2, 3))
    m = 0
    for i in range(k):
        if has_ends(kind[i]):
            _ends(kind, data, i, two)
            put_rows(ends, m, two)
            m += 2
        if kind[i] == SEGMENT:
            continue
        out[n, 0], out[n, 1], out[n, 2], out[n, 3], out[n, 4] = (
            data[i, 0],
            data[i, 1],
            keep,
            0.0,
            TAU,
        )
        if is_round(kind[i]):
            out[n, 2] = data[i, 2] + keep
        if kind[i] == ARC:
            out[n, 3], out[n, 4] = data[i, 3], min(data[i, 4], TAU)
        n += 1
    key = np.empty(m, np.int64)
    for j in range(m):
        key[j] = (math.floor(ends[j, 0] / joint) << 32) ^ (
            math.floor(ends[j, 1] / joint) & 0xFFFFFFFF
        )
    order = np.argsort(key)
    j = 0
    while j < m:
        first = order[j]
        low, width = ends[first, 2] + 0.5 * math.pi, math.pi
        j += 1
        while j < m and key[order[j]] == key[first]:
            shift = math.pi - (math.pi - (ends[order[j], 2] + 0.5 * math.pi - low)) % TAU
            begin, end = max(0.0, shift), min(width, shift + math.pi)
            low, width = low + begin, end - begin
            j += 1
        if width <= ANGLE:
            continue
        out[n, 0], out[n, 1], out[n, 2] = ends[first, 0], ends[first, 1], keep
        out[n, 3], out[n, 4] = low, width
        n += 1
    kept = 2
    for i in range(2, n):
        x, y = out[i, 0], out[i, 1]
        to = math.hypot(x - start[0], y - start[1]) + math.hypot(x - goal[0], y - goal[1])
        if to - 2.0 * out[i, 2] < longest:
            put_rows(out, kept, out[i])
            kept += 1
    return out[:kept]


@njit(**BORROWING)
def _exposed(discs, i, a):
    if discs[i, 4] >= TAU:
        return True
    t = (a - discs[i, 3]) % TAU
    return t <= discs[i, 4] + ANGLE or t >= TAU - ANGLE


@njit(**BORROWING)
def _tangent(discs, i, si, j, sj, out):
    """Write the tangent from disc i on side si to disc j on side sj; False if there is none.

    ``out``: length, leaving angle at disc i, meeting angle at disc j.
    """
    vx, vy = discs[j, 0] - discs[i, 0], discs[j, 1] - discs[i, 1]
    d = math.sqrt(vx * vx + vy * vy)
    bend = si * discs[i, 2] - sj * discs[j, 2]
    if d <= 0.0 or abs(bend) > d * (1.0 + 1e-9):
        return False
    s = min(1.0, max(-1.0, bend / d))
    c = math.sqrt(1.0 - s * s)
    if c < 1e-4 and si == sj:
        # one disc touches the other from within: an arc and its own end
        c = 0.0
    wx, wy = (s * vx + c * vy) / d, (s * vy - c * vx) / d
    out[0] = c * d
    out[1] = math.atan2(si * wy, si * wx)
    out[2] = math.atan2(sj * wy, sj * wx)
    return True


@njit(**BORROWING)
def _reach(tree, discs, i, side, a, most, floor):
    """Angle up to ``most`` that the way can follow round disc i from direction a."""
    cx, cy, r = discs[i, 0], discs[i, 1], discs[i, 2]
    if discs[i, 4] < TAU:
        last = discs[i, 3] + (discs[i, 4] if side > 0 else 0.0)
        most = min(most, turn_towards(a, last, side))
    gone, step = 0.0, STEP_RAD
    while gone < most:
        step = min(step, most - gone)
        b, e = a + side * gone, a + side * (gone + step)
        out = r / math.cos(0.5 * step)
        mx, my = cx + out * math.cos(0.5 * (b + e)), cy + out * math.sin(0.5 * (b + e))
        _, _, w1 = segment_clearance(
            tree,
            cx + r * math.cos(b), cy + r * math.sin(b), mx, my, floor
        )  # fmt: skip
        w2 = -1
        if w1 < 0:
            _, _, w2 = segment_clearance(
                tree,
                mx, my, cx + r * math.cos(e), cy + r * math.sin(e), floor
            )  # fmt: skip
        if w1 < 0 and w2 < 0:
            gone += step
            step = min(STEP_RAD, 2.0 * step)
        elif step > SHORTEST_RAD:
            step *= 0.5
        else:
            break
    return gone


class TangentQueue(NamedTuple):
    """Tangents, the cheapest first.

    ``item`` (i, 8), ``made`` of them set: cost at the tangent's end; disc, side and angle met;
    disc, side and angle left; the item before. ``keys`` and ``items`` (i,) are the heap, ``size``
    of them used.
    """

    item: NDArray[np.float64]
    keys: NDArray[np.float64]
    items: NDArray[np.int32]
    made: int
    size: int


@njit(**BORROWING, forceinline=True)
def _is_worse(place, p, r, side, a, cost):
    """True if place p, or a next one, reaches this direction of a disc of radius r more cheaply.

    A ``place`` (m, 4) is the angle, the turn round the disc from there, the cost, and the next
    place round the same disc and side, or -1.
    """
    while p >= 0:
        turn = turn_towards(place[p, 0], a, side)
        if turn <= place[p, 1] and place[p, 2] + r * turn <= cost * (1.0 + 1e-12):
            return True
        p = int(place[p, 3])
    return False


@njit(**OWNING, inline="always")
def _queued(queue, discs, t, reach, longest):
    """Queue the tangents that leave the arc of ``reach`` after item t.

    Only if the way through their ends straight to the goal is shorter than ``longest``.
    """
    item, keys, items, made, size = queue
    gx, gy = discs[GOAL, 0], discs[GOAL, 1]
    cost, j, side, a = item[t, 0], int(item[t, 1]), int(item[t, 2]), item[t, 3]
    r = discs[j, 2]
    t3 = np.empty(3)
    for m in range(1, len(discs)):
        if m == j:
            continue
        for sm in (1, -1):
            if (m == GOAL and sm < 0) or not _tangent(discs, j, side, m, sm, t3):
                continue
            turn = 0.0 if j == START else turn_towards(a, t3[1], side)
            if turn > reach + ANGLE or not _exposed(discs, m, t3[2]):
                continue
            far = cost + r * turn + t3[0]
            ex = discs[m, 0] + discs[m, 2] * math.cos(t3[2])
            ey = discs[m, 1] + discs[m, 2] * math.sin(t3[2])
            key = far + math.hypot(gx - ex, gy - ey)
            if key >= longest:
                continue
            if made == len(item):
                item = grown(item, 2 * made)
                keys, items = grown(keys, 2 * made), grown(items, 2 * made)
            item[made, 0], item[made, 1], item[made, 2], item[made, 3] = far, m, sm, t3[2]
            item[made, 4], item[made, 5], item[made, 6], item[made, 7] = j, side, t3[1], t
            push(keys, items, size, key, np.int32(made))
            made += 1
            size += 1
    return TangentQueue(item, keys, items, made, size)


@njit(**OWNING)
def _tangents_to(item, last):
    """Tangents (n, 6) that lead to an item, in order."""
    count, t = 0, last
    while t > 0:
        count += 1
        t = int(item[t, 7])
    way = np.empty((count, 6))
    t = last
    for c in range(count - 1, -1, -1):
        way[c, 0], way[c, 1], way[c, 2] = item[t, 4], item[t, 5], item[t, 6]
        way[c, 3], way[c, 4], way[c, 5] = item[t, 1], item[t, 2], item[t, 3]
        t = int(item[t, 7])
    return way


@njit(**BORROWING, forceinline=True)
def _first_nearer(tree, discs, item, t, floor):
    """A primitive nearer than ``floor`` to the tangent of item t, or -1."""
    i, b = int(item[t, 4]), item[t, 6]
    j, a = int(item[t, 1]), item[t, 3]
    x, y = discs[j, 0] + discs[j, 2] * math.cos(a), discs[j, 1] + discs[j, 2] * math.sin(a)
    ox, oy = discs[i, 0] + discs[i, 2] * math.cos(b), discs[i, 1] + discs[i, 2] * math.sin(b)
    _, _, hit = segment_clearance(tree, ox, oy, x, y, floor)
    return hit


@njit(**OWNING)
def shortest(tree, discs, floor, longest, budget):
    """The shortest way from disc 0 to disc 1 among ways shorter than ``longest``.

    A* over tangents (the tangent graph of Liu and Arimoto 1992), made and proved against all
    borders when taken from the queue, with clearance ``floor``. Returns the outcome (FOUND,
    NONE_SHORTER if no way is shorter, OUT_OF_BUDGET after the work of ``budget`` tangents), the
    length, the tangents in order (n, 6): disc, side and angle left, disc, side and angle met, and
    the work done.
    """
    n, capacity = len(discs), 1024
    queue = TangentQueue(
        np.empty((capacity, 8)), np.empty(capacity), np.empty(capacity, np.int32), 1, 1
    )
    queue.item[0] = 0.0
    queue.item[0, 1], queue.item[0, 2], queue.item[0, 7] = START, 1.0, -1.0
    gx, gy = discs[GOAL, 0], discs[GOAL, 1]
    queue.keys[0], queue.items[0] = math.hypot(gx - discs[START, 0], gy - discs[START, 1]), 0
    # see _is_worse; the first place round each disc and side
    place, places = np.empty((256, 4)), 0
    around = np.full(2 * n, -1, np.int32)
    outcome, last, length, work = NONE_SHORTER, -1, np.inf, 0
    while queue.size > 0:
        if work > budget:
            outcome = OUT_OF_BUDGET
            break
        key, t = pop(queue.keys, queue.items, queue.size)
        queue = TangentQueue(queue.item, queue.keys, queue.items, queue.made, queue.size - 1)
        if key >= longest:
            break
        item = queue.item
        cost, j, side, a = item[t, 0], int(item[t, 1]), int(item[t, 2]), item[t, 3]
        r = discs[j, 2]
        slot = 2 * j + (1 if side > 0 else 0)
        if _is_worse(place, around[slot], r, side, a, cost):
            continue
        if t > 0:
            work += CHECK
            if _first_nearer(tree, discs, item, t, floor) >= 0:
                continue
        if j == GOAL:
            outcome, last, length = FOUND, t, cost
            break
        reach = 0.0
        if j == START:
            reach = TAU
        elif r > 0.0:
            # round the disc only while the way can remain shorter than ``longest``
            reach = _reach(tree, discs, j, side, a, min(TAU, (longest - cost) / r), floor)
            work += CHECK * int(2.0 + 2.0 * reach / STEP_RAD)
        if places == len(place):
            place = grown(place, 2 * places)
        place[places, 0], place[places, 1], place[places, 2] = a, reach, cost
        place[places, 3] = around[slot]
        around[slot] = places
        places += 1
        made = queue.made
        queue = _queued(queue, discs, t, reach, longest)
        work += 2 * n + QUEUE_ENTRY * (queue.made - made)
    return outcome, length, _tangents_to(queue.item, last), work
