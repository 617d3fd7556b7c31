"""Whether finished edges separate the pixels of a border without grey, and the cure where not.

Rules and units
- A crack lies between the centres of an obstacle pixel and a free one, half a pixel away each.
  Edges drawn again give both back exactly where they cross the way from one centre to the other
  an odd number of times: no estimate.
- ``qx``, ``qy``: the middles of one border's n cracks, twice over, in the picture's pixels;
  ``upright`` (n,): whether the crack is, so that its pixels lie side by side.
- Edges ``begin .. count - 1`` of ``kind`` and ``data`` (see ``vision.fitting_kernels``), whose
  first cracks' indices are in ``at``, ascending around the border.
- A cure replaces the stretch of lost cracks alone, by chords from middle to middle; the edges on
  both sides stay what they are.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from vision.cover_kernels import ARC_CCW, FLATTEST_PX, LINE, chords
from vision.kernel_options import LEAF
from vision.shape_kernels import HUGE

HALF = 0.5
AHEAD, SAME_PX = 12, 1e-6
"""The crack of an edge point is looked for among so many; one so near is it."""
NEAR_JOINT_PX = 2.0
"""So near to a joint more than its own edge may pass a point."""
NEIGHBOURS = 2
"""Edges on either side that may pass a point."""
JUT_PX, AROUND, TOUCH_PX = 1.2, 8, 0.51
"""A corner farther from its border may hold a pixel that is none of the object's; it is compared
with so many cracks on either side. A free pixel touches the obstacle across a crack's middle."""
GRAVE_PX = 0.75
"""A lost point so far from its edges is mended whatever its border may lose: its pixel lies more
than one from what is drawn."""
BESIDE_PX = 0.4
"""A crack farther from its edge may be its neighbour's."""
OK, LOST, GRAVE = 0, 1, 2
"""What becomes of a point."""


@njit(**LEAF)
def middles(xs, ys, directions, qx, qy, upright):
    """Fill ``qx``, ``qy`` and ``upright`` from a border's cracks; returns their number."""
    n = xs.shape[0]
    for k in range(n):
        d = np.int64(directions[k])
        upright[k] = d & 1 == 1
        qx[k] = xs[k] + HALF * ((d & 1) * (2 - d))
        qy[k] = ys[k] + HALF * ((1 - (d & 1)) * (d - 1))
        qx[n + k] = qx[k]
        qy[n + k] = qy[k]
    qx[2 * n] = qx[0]
    qy[2 * n] = qy[0]
    return n


@njit(**LEAF)
def find_cracks(px, py, points, ox, oy, qx, qy, n, cracks):
    """``cracks`` (points,): which crack every edge point was measured across, ascending."""
    c = -1
    for k in range(points):
        x = px[k] + ox
        y = py[k] + oy
        nearest = HUGE
        where = c + 1
        last = min(c + AHEAD, n - points + k)
        for j in range(c + 1, last + 1):
            d = abs(qx[j] - x) + abs(qy[j] - y)
            if d < nearest:
                nearest = d
                where = j
            if d < SAME_PX:
                break
        c = where
        cracks[k] = c


@njit(**LEAF)
def _in_sweep(kind, data, i, x0, y0, x1, y1, x, y):
    """Whether a point of arc i's circle lies on the arc from (x0, y0) to (x1, y1)."""
    cx = data[i, 2]
    cy = data[i, 3]
    ax = x0 - cx
    ay = y0 - cy
    bx = x1 - cx
    by = y1 - cy
    if kind[i] == ARC_CCW:
        ax, ay, bx, by = bx, by, ax, ay
    dx = x - cx
    dy = y - cy
    after_a = ax * dy - ay * dx >= 0.0
    before_b = dx * by - dy * bx >= 0.0
    return (after_a and before_b) if ax * by - ay * bx >= 0.0 else (after_a or before_b)


@njit(**LEAF)
def _crossings(kind, data, i, after, x, y, upright):
    """How often edge i crosses the way between the two pixels of the crack at (x, y)."""
    x0 = data[i, 0]
    y0 = data[i, 1]
    x1 = data[after, 0]
    y1 = data[after, 1]
    if kind[i] == LINE:
        if upright:
            if (y0 <= y) == (y1 <= y):
                return 0
            there = x0 + (y - y0) * (x1 - x0) / (y1 - y0)
            return 1 if abs(there - x) < HALF else 0
        if (x0 <= x) == (x1 <= x):
            return 0
        there = y0 + (x - x0) * (y1 - y0) / (x1 - x0)
        return 1 if abs(there - y) < HALF else 0
    cx = data[i, 2]
    cy = data[i, 3]
    r = data[i, 4]
    off = y - cy if upright else x - cx
    square = r * r - off * off
    if square <= 0.0:
        return 0
    root = math.sqrt(square)
    found = 0
    for side in range(2):
        reach = root if side == 0 else -root
        qx = cx + reach if upright else x
        qy = y if upright else cy + reach
        if abs(qx - x) < HALF and abs(qy - y) < HALF:
            found += _in_sweep(kind, data, i, x0, y0, x1, y1, qx, qy)
    return found


@njit(**LEAF)
def _distance(kind, data, i, after, x, y):
    """From (x, y) to edge i."""
    x0 = data[i, 0]
    y0 = data[i, 1]
    x1 = data[after, 0]
    y1 = data[after, 1]
    if kind[i] != LINE:
        if _in_sweep(kind, data, i, x0, y0, x1, y1, x, y):
            return abs(math.sqrt((x - data[i, 2]) ** 2 + (y - data[i, 3]) ** 2) - data[i, 4])
        return math.sqrt(min((x - x0) ** 2 + (y - y0) ** 2, (x - x1) ** 2 + (y - y1) ** 2))
    dx = x1 - x0
    dy = y1 - y0
    square = dx * dx + dy * dy
    t = 0.0
    if square > 0.0:
        t = min(max(((x - x0) * dx + (y - y0) * dy) / square, 0.0), 1.0)
    return math.sqrt((x - x0 - t * dx) ** 2 + (y - y0 - t * dy) ** 2)


@njit(**LEAF)
def _judge(kind, data, begin, count, i, x, y, upright):
    """What becomes of the crack at (x, y), whose stretch edge i is: OK, LOST or GRAVE."""
    after = i + 1 if i + 1 < count else begin
    own = _crossings(kind, data, i, after, x, y, upright)
    near = NEAR_JOINT_PX * NEAR_JOINT_PX
    beside = (x - data[i, 0]) ** 2 + (y - data[i, 1]) ** 2 < near
    beside = beside or (x - data[after, 0]) ** 2 + (y - data[after, 1]) ** 2 < near
    if own == 1 and not beside:
        return OK
    edges = count - begin
    reach = min(NEIGHBOURS, (edges - 1) // 2)
    first = -reach
    last = reach if edges > 2 * NEIGHBOURS else edges - 1 - reach
    for step in range(first, last + 1):
        if step != 0:
            j = begin + (i - begin + step + edges) % edges
            own += _crossings(kind, data, j, j + 1 if j + 1 < count else begin, x, y, upright)
    if own % 2 == 1:
        return OK
    for step in range(first, last + 1):
        j = begin + (i - begin + step + edges) % edges
        if _distance(kind, data, j, j + 1 if j + 1 < count else begin, x, y) <= GRAVE_PX:
            return LOST
    return GRAVE


@njit(**LEAF)
def _juts_out(qx, qy, n, k, x, y, ax, ay, bx, by):
    """Whether a corner at (x, y), before crack k, holds a pixel that touches no obstacle.

    (ax, ay) and (bx, by) are where its edges come from and go to.
    """
    nearest = HUGE
    for step in range(-AROUND, AROUND + 1):
        j = (k + step + n) % n
        nearest = min(nearest, (qx[j] - x) ** 2 + (qy[j] - y) ** 2)
    if nearest < JUT_PX * JUT_PX:
        return False
    reach = math.sqrt(nearest)
    # a pixel lies in the corner where it lies on the inner side of both edges
    turn = (x - ax) * (by - y) - (y - ay) * (bx - x)
    side = 1.0 if turn > 0.0 else -1.0
    for py in range(math.ceil(y - reach), math.floor(y + reach) + 1):
        for px in range(math.ceil(x - reach), math.floor(x + reach) + 1):
            if (px - x) ** 2 + (py - y) ** 2 >= nearest:
                continue
            if side * ((x - ax) * (py - ay) - (y - ay) * (px - ax)) < 0.0:
                continue
            if side * ((bx - x) * (py - y) - (by - y) * (px - x)) < 0.0:
                continue
            touches = False
            for step in range(-AROUND, AROUND + 1):
                j = (k + step + n) % n
                touches = touches or (qx[j] - px) ** 2 + (qy[j] - py) ** 2 < TOUCH_PX * TOUCH_PX
            if not touches:
                return True
    return False


@njit(**LEAF)
def _find_lost(qx, qy, upright, n, at, kind, data, begin, count, state):
    """``state`` (n,) of every crack; pixels lost at most, and how many cracks gravely."""
    lost = 0
    grave = 0
    for i in range(begin, count):
        after = i + 1 if i + 1 < count else begin
        lo = at[i]
        hi = at[after]
        hi = hi + n if hi <= lo else hi
        x0 = data[i, 0]
        y0 = data[i, 1]
        dx = data[after, 0] - x0
        dy = data[after, 1] - y0
        # a crack well within a line is told by the line alone
        square = dx * dx + dy * dy if kind[i] == LINE else 0.0
        margin = NEAR_JOINT_PX * math.sqrt(square)
        across_upright = HALF * abs(dy)
        across_level = HALF * abs(dx)
        for k in range(lo, hi):
            here = k - n if k >= n else k
            x = qx[k] - x0
            y = qy[k] - y0
            along = x * dx + y * dy
            limit = across_upright if upright[here] else across_level
            if (margin < along) & (along < square - margin) & (abs(x * dy - y * dx) < limit):
                state[here] = OK
                continue
            found = _judge(kind, data, begin, count, i, qx[k], qy[k], upright[here])
            state[here] = found
            lost += found != OK
            grave += found == GRAVE
    for i in range(begin, count):
        after = i + 1 if i + 1 < count else begin
        before = i - 1 if i > begin else count - 1
        if kind[i] == LINE and kind[before] == LINE and _juts_out(
            qx, qy, n, at[i], data[i, 0], data[i, 1], data[before, 0], data[before, 1],
            data[after, 0], data[after, 1],
        ):  # fmt: skip
            state[at[i]] = GRAVE
            grave += 1
    return lost, grave


@njit(**LEAF)
def _weigh_runs(upright, n, state, weights):
    """Per run of lost cracks how many pixels, where it ends: negative where one is grave.

    A pixel is lost at one upright and one level crack where the border runs aslant. Returns
    the pixels of all runs, and of the heaviest one that is not grave.
    """
    start = 0
    while state[start] != OK:
        start += 1
    total = 0
    heaviest = 0
    standing = 0
    lying = 0
    grave = False
    for k in range(n):
        weights[k] = 0
    for t in range(1, n + 1):
        k = start + t if start + t < n else start + t - n
        if state[k] != OK:
            standing += upright[k]
            lying += not upright[k]
            grave = grave or state[k] == GRAVE
            continue
        pixels = max(standing, lying)
        if pixels > 0:
            weights[k - 1 if k > 0 else n - 1] = -pixels if grave else pixels
            total += pixels
            heaviest = max(heaviest, 0 if grave else pixels)
        standing = 0
        lying = 0
        grave = False
    return total, heaviest


@njit(**LEAF)
def _mark_runs(state, n, budget, total, heaviest, weights, inside):
    """Mark in ``inside`` the runs of lost cracks that have to go, and one crack beyond each.

    Those with a grave one, then the heaviest until the border loses no more than it may.
    """
    for k in range(n):
        inside[k] = False
        total += min(weights[k], 0)
    least = heaviest + 1
    while total > budget and least > 1:
        least -= 1
        for k in range(n):
            if weights[k] == least:
                total -= least
    for k in range(n):
        if weights[k] < 0 or weights[k] >= max(least, 1):
            j = k
            while state[j] != OK:
                inside[j] = True
                j = j - 1 if j > 0 else n - 1
            inside[j] = True
            inside[k + 1 if k + 1 < n else 0] = True


@njit(**LEAF)
def _on_edge(kind, data, i, after, x, y, out):
    """Where edge i passes the crack at (x, y): on the way between its pixels, or nearest."""
    x0 = data[i, 0]
    y0 = data[i, 1]
    if kind[i] != LINE:
        dx = x - data[i, 2]
        dy = y - data[i, 3]
        share = data[i, 4] / max(math.sqrt(dx * dx + dy * dy), 1e-9)
        out[0] = data[i, 2] + dx * share
        out[1] = data[i, 3] + dy * share
        return
    dx = data[after, 0] - x0
    dy = data[after, 1] - y0
    square = dx * dx + dy * dy
    t = 0.0
    if square > 0.0:
        t = min(max(((x - x0) * dx + (y - y0) * dy) / square, 0.0), 1.0)
    out[0] = x0 + t * dx
    out[1] = y0 + t * dy


@njit(cache=True, nogil=True)
def mend(
    qx, qy, upright, n, at, kind, data, begin, count, budget, rounds, chord, residual, state,
    inside, is_seed, found,
):  # fmt: skip
    """Replace what loses more pixels than ``budget`` by chords; returns the new ``count``.

    ``residual``: the deviation that a chord is written with. ``state``, ``inside``, ``is_seed``,
    ``found`` (n + 1,) are room to work in. There are never more edges than cracks.
    """
    total = heaviest = 0
    for again in range(rounds + 1):
        lost, grave = _find_lost(qx, qy, upright, n, at, kind, data, begin, count, state)
        if lost <= budget and grave == 0:
            break
        if 2 * lost < n:
            total, heaviest = _weigh_runs(upright, n, state, found)
            if total <= budget and grave == 0:
                break
        if again < rounds and 2 * lost < n:
            _mark_runs(state, n, budget, total, heaviest, found, inside)
            first = begin
            while first < count and inside[at[first]]:
                first += 1
            if first < count:
                count = _replace(
                    qx, qy, upright, n, at, kind, data, begin, count, first, chord, residual,
                    inside, is_seed, found,
                )  # fmt: skip
                continue
        # little would be left: chords all around
        edges = chords(qx, qy, 0, n, chord, is_seed, found)
        for t in range(edges):
            i = begin + t
            _write(kind, data, at, i, qx[found[t]], qy[found[t]], found[t], residual)
        count = begin + edges
        break
    return count


@njit(**LEAF)
def _write(kind, data, at, i, x, y, k, residual):
    kind[i] = LINE
    data[i, 0] = x
    data[i, 1] = y
    data[i, 2] = 0.0
    data[i, 3] = 0.0
    data[i, 4] = 0.0
    data[i, 5] = residual
    at[i] = k


@njit(cache=True, nogil=True)
def _replace(
    qx, qy, upright, n, at, kind, data, begin, count, first, chord, residual, inside, is_seed,
    found,
):  # fmt: skip
    """Chords instead of the points that are ``inside``; returns the new count."""
    edges = count - begin
    kinds = kind[begin:count].copy()
    rows = data[begin:count].copy()
    points = at[begin:count].copy()
    spot = np.empty(2, np.float64)
    begun = 0
    i = begin
    for t in range(edges):
        e = (first - begin + t) % edges
        after = e + 1 if e + 1 < edges else 0
        lo = points[e]
        hi = points[after]
        hi = hi + n if hi <= lo else hi
        turned = lo < points[first - begin]
        if not inside[lo]:
            _keep(kind, data, at, i, kinds, rows, e, rows[e, 0], rows[e, 1], lo)
            i += 1
        for k in range(lo, hi):
            here = k - n if k >= n else k
            if not inside[here]:
                continue
            before = here - 1 if here > 0 else n - 1
            next_ = here + 1 if here + 1 < n else 0
            if not inside[before]:
                begun = k + n if turned else k
                spot[0] = rows[e, 0]
                spot[1] = rows[e, 1]
                if k > lo:
                    _on_edge(kinds, rows, e, after, qx[k], qy[k], spot)
                _write(kind, data, at, i, spot[0], spot[1], here, residual)
                i += 1
            if not inside[next_]:
                end = k + n if turned else k
                m = chords(qx, qy, begun, end, chord, is_seed, found)
                for s in range(1, m):
                    q = found[s]
                    x = qx[q]
                    y = qy[q]
                    _write(kind, data, at, i, x, y, q - n if q >= n else q, residual)
                    i += 1
                _on_edge(kinds, rows, e, after, qx[k], qy[k], spot)
                _keep(kind, data, at, i, kinds, rows, e, spot[0], spot[1], here)
                i += 1
    for j in range(begin, i):
        if kind[j] != LINE:
            _straighten(kind, data, at, n, begin, i, j)
    return i


@njit(**LEAF)
def _keep(kind, data, at, i, kinds, rows, e, x, y, k):
    """What edge e was, from (x, y) on."""
    kind[i] = kinds[e]
    data[i, 0] = x
    data[i, 1] = y
    for c in range(2, 6):
        data[i, c] = rows[e, c]
    at[i] = k


@njit(**LEAF)
def _straighten(kind, data, at, n, begin, count, j):
    """Make a line of what is left of an arc where it is flat, or would turn the long way round."""
    after = j + 1 if j + 1 < count else begin
    hi = at[after]
    hi = hi + n if hi <= at[j] else hi
    ax = data[j, 0] - data[j, 2]
    ay = data[j, 1] - data[j, 3]
    bx = data[after, 0] - data[j, 2]
    by = data[after, 1] - data[j, 3]
    turn = math.atan2(ax * by - ay * bx, ax * bx + ay * by)
    turn = -turn if kind[j] == ARC_CCW else turn
    turn = turn + 2.0 * math.pi if turn < 0.0 else turn
    rise = data[j, 4] * (1.0 - math.cos(min(0.5 * turn, 0.5 * math.pi)))
    if turn * data[j, 4] > 2.0 * (hi - at[j]) + 4.0 or rise < FLATTEST_PX:
        kind[j] = LINE
        data[j, 2] = 0.0
        data[j, 3] = 0.0
        data[j, 4] = 0.0


@njit(**LEAF)
def measure_residuals(qx, qy, upright, n, at, kind, data, begin, count):
    """Write every edge's rms distance from the cracks of its stretch, all of them.

    A crack at a corner may be the neighbour's.
    """
    for i in range(begin, count):
        after = i + 1 if i + 1 < count else begin
        lo = at[i]
        hi = at[after]
        hi = hi + n if hi <= lo else hi
        before = i - 1 if i > begin else count - 1
        behind = after + 1 if after + 1 < count else begin
        total = 0.0
        for k in range(lo, hi):
            d = _distance(kind, data, i, after, qx[k], qy[k])
            if d > BESIDE_PX:
                d = min(d, _distance(kind, data, before, i, qx[k], qy[k]))
                d = min(d, _distance(kind, data, after, behind, qx[k], qy[k]))
            total += d * d
        data[i, 5] = math.sqrt(total / (hi - lo))
