"""The cure where finished edges do not separate the pixels of a border without grey.

Rules and units
- Cracks, edges and their first cracks as in ``vision.outline.drawn.separation_kernels``.
- A cure replaces the stretch of lost cracks alone, by chords that cross every crack's way; the
  edges on both sides stay what they are. Where little would be left of them the whole border
  becomes such chords, which take no pixel for what it is not.
- A chord is as long as it can be: from its first point the ways ahead are looked through like
  windows, until nothing is left of the cone of sight (J. Sklansky and V. Gonzalez, Fast
  Polygonal Approximation of Digitized Curves, 1980).
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF
from vision.outline.drawn.separation_kernels import GRAVE, OK, find_lost
from vision.outline.fit.outline_kernels import FLATTEST_PX, distance_to_edge, in_sweep
from vision.outline.fit.separating_fit_kernels import HALF
from vision.outline.fitted_borders import ARC_CCW, LINE

WAY = 0.998
"""Share of a crack's way that a chord may cross: no pixel's centre lies on it by a hair."""
CHORD_RESIDUAL_PX = 0.25
"""What a chord is off until its cracks have been measured."""
TIP_LEAST, TIP = 3, 5
"""Cracks lost that are no tip yet; and those around the last two pixels of a tip: where both are
lost, nothing drawn lies beside the last."""
ROUNDS = 4
"""Times that lost stretches alone are mended before a border becomes chords all around."""


@njit(**LEAF)
def straight_ways(qx, qy, hx, hy, lo, hi, x0, y0, x1, y1, found):
    """Chords from (x0, y0) on crack lo's way to (x1, y1) on crack hi's: their number.

    ``found``: the crack at whose middle every chord begins; the first one begins at (x0, y0).
    """
    m = 0
    here = lo
    x = x0
    y = y0
    while here < hi:
        found[m] = here
        m += 1
        best = here + 1
        # towards the cone's sides: the free pixels' and the obstacle's
        free_x = 0.0
        free_y = 0.0
        dark_x = 0.0
        dark_y = 0.0
        for k in range(here + 1, hi + 1):
            tx = (x1 if k == hi else qx[k]) - x
            ty = (y1 if k == hi else qy[k]) - y
            seen = tx * dark_y - ty * dark_x > 0.0 and tx * free_y - ty * free_x < 0.0
            if k > here + 1 and seen:
                best = k
            a = qx[k] + WAY * hx[k] - x
            b = qy[k] + WAY * hy[k] - y
            c = qx[k] - WAY * hx[k] - x
            d = qy[k] - WAY * hy[k] - y
            if a * d - b * c <= 0.0:
                # the border turns back
                break
            if k == here + 1:
                free_x, free_y, dark_x, dark_y = a, b, c, d
                continue
            if a * free_y - b * free_x < 0.0:
                free_x, free_y = a, b
            if c * dark_y - d * dark_x > 0.0:
                dark_x, dark_y = c, d
            if free_x * dark_y - free_y * dark_x <= 0.0:
                break
        here = best
        x = qx[here]
        y = qy[here]
    return m


@njit(**LEAF)
def _weigh_runs(qx, qy, hx, hy, n, state, weights):
    """Per run of lost cracks how many pixels, where it ends: negative where one is grave.

    A tip lost is grave too: all cracks of a pixel that hangs on by a corner, or so many as ``TIP``
    around one that hangs on by a side.

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
    around = 0
    most = 0
    for k in range(n):
        weights[k] = 0
    for t in range(1, n + 1):
        k = start + t if start + t < n else start + t - n
        if state[k] != OK:
            standing += hx[k] != 0.0
            lying += hx[k] == 0.0
            grave = grave or state[k] == GRAVE
            j = k - 1 if k > 0 else n - 1
            apart = abs(qx[k] - hx[k] - qx[j] + hx[j]) + abs(qy[k] - hy[k] - qy[j] + hy[j])
            around = around + 1 if apart < HALF and standing + lying > 1 else 1
            most = max(most, around)
            continue
        pixels = max(standing, lying)
        grave = grave or most >= 4 or (most == 3 and standing + lying >= TIP)
        most = 0
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
                if total > budget:
                    total -= least
                else:
                    weights[k] = 0
    for k in range(n):
        if weights[k] < 0 or weights[k] >= max(least, 1):
            j = k
            while state[j] != OK:
                inside[j] = True
                j = j - 1 if j > 0 else n - 1
            inside[j] = True
            inside[k + 1 if k + 1 < n else 0] = True


@njit(**LEAF)
def _on_way(kind, rows, i, after, x, y, hx, hy, out):
    """Where edge i crosses the way of the crack at (x, y), or else its point nearest to there.

    Returns whether it crosses.
    """
    upright = hx != 0.0
    if kind[i] == LINE:
        dx = rows[after, 0] - rows[i, 0]
        dy = rows[after, 1] - rows[i, 1]
        run = dy if upright else dx
        if abs(run) > 1e-9:
            t = (y - rows[i, 1]) / run if upright else (x - rows[i, 0]) / run
            qx = x if not upright else rows[i, 0] + t * dx
            qy = y if upright else rows[i, 1] + t * dy
            if 0.0 <= t <= 1.0 and abs(qx - x) + abs(qy - y) < WAY * HALF:
                out[0] = qx
                out[1] = qy
                return True
    else:
        off = y - rows[i, 3] if upright else x - rows[i, 2]
        root = math.sqrt(max(rows[i, 4] * rows[i, 4] - off * off, 0.0))
        # the crossing on the crack's side of the centre
        if upright:
            qx = rows[i, 2] + (root if x > rows[i, 2] else -root)
            qy = y
        else:
            qx = x
            qy = rows[i, 3] + (root if y > rows[i, 3] else -root)
        if abs(qx - x) + abs(qy - y) < WAY * HALF:
            out[0] = qx
            out[1] = qy
            return in_sweep(kind, rows, i, after, qx, qy)
    _, out[0], out[1] = distance_to_edge(kind, rows, i, after, x, y)
    return False


@njit(cache=True, nogil=True)
def mend(qx, qy, hx, hy, n, at, kind, rows, count, budget, state, inside, found):
    """Replace what loses more pixels than ``budget`` by chords; returns the new ``count``.

    ``state``, ``inside``, ``found`` (n + 1,) are room to work in. There are never more edges
    than cracks.
    """
    for again in range(ROUNDS + 1):
        lost, grave = find_lost(qx, qy, hx, n, at, kind, rows, count, state)
        if grave == 0 and lost <= min(budget, TIP_LEAST):
            return count
        if again == ROUNDS or 2 * lost >= n:
            break
        total, heaviest = _weigh_runs(qx, qy, hx, hy, n, state, found)
        if total <= budget and found[:n].min() >= 0:
            return count
        _mark_runs(state, n, budget, total, heaviest, found, inside)
        first = 0
        while first < count and inside[at[first]]:
            first += 1
        if first == count:
            break
        count = _replace(qx, qy, hx, hy, n, at, kind, rows, count, first, inside, found)
    return all_chords(qx, qy, hx, hy, n, at, kind, rows, found)


@njit(**LEAF)
def all_chords(qx, qy, hx, hy, n, at, kind, rows, found):
    """Chords all around, from the crack farthest from the middle on."""
    mx = 0.0
    my = 0.0
    for k in range(n):
        mx += qx[k]
        my += qy[k]
    mx /= n
    my /= n
    far = -1.0
    first = 0
    for k in range(n):
        d = (qx[k] - mx) ** 2 + (qy[k] - my) ** 2
        if d > far:
            far = d
            first = k
    x = qx[first]
    y = qy[first]
    count = straight_ways(qx, qy, hx, hy, first, first + n, x, y, x, y, found)
    for t in range(count):
        k = found[t]
        _write(kind, rows, at, t, qx[k], qy[k], k - n if k >= n else k)
    return count


@njit(**LEAF)
def _write(kind, rows, at, i, x, y, k):
    kind[i] = LINE
    rows[i, 0] = x
    rows[i, 1] = y
    rows[i, 2] = 0.0
    rows[i, 3] = 0.0
    rows[i, 4] = 0.0
    rows[i, 5] = CHORD_RESIDUAL_PX
    at[i] = k


@njit(cache=True, nogil=True)
def _replace(qx, qy, hx, hy, n, at, kind, rows, count, first, inside, found):
    """Chords instead of the cracks that are ``inside``; returns the new count.

    Edge ``first`` begins outside.
    """
    kinds = kind[:count].copy()
    old = rows[:count].copy()
    points = at[:count].copy()
    spot = np.empty(2, np.float64)
    ahead = np.empty(2, np.float64)
    begun = 0
    begun_x = 0.0
    begun_y = 0.0
    next_x = 0.0
    next_y = 0.0
    carried = False
    i = 0
    for t in range(count):
        e = (first + t) % count
        after = e + 1 if e + 1 < count else 0
        lo = points[e]
        hi = points[after]
        hi = hi + n if hi <= lo else hi
        turned = lo < points[first]
        from_x = next_x if carried else old[e, 0]
        from_y = next_y if carried else old[e, 1]
        carried = False
        if not inside[lo]:
            _keep(kind, rows, at, i, kinds, old, e, from_x, from_y, lo)
            i += 1
        for k in range(lo, hi):
            here = k - n if k >= n else k
            if not inside[here]:
                continue
            before = here - 1 if here > 0 else n - 1
            next_ = here + 1 if here + 1 < n else 0
            if not inside[before]:
                begun = k + n if turned else k
                begun_x = from_x
                begun_y = from_y
                # the crack at a joint may be crossed by the edge before
                last = e if k > lo else (e - 1 if e > 0 else count - 1)
                behind = after if k > lo else e
                crosses = _on_way(kinds, old, last, behind, qx[k], qy[k], hx[k], hy[k], spot)
                if k > lo or crosses:
                    begun_x = spot[0]
                    begun_y = spot[1]
            if not inside[next_]:
                end = k + n if turned else k
                crosses = _on_way(kinds, old, e, after, qx[k], qy[k], hx[k], hy[k], spot)
                if not crosses and k == hi - 1:
                    # or by the edge after, which then begins here
                    behind = after + 1 if after + 1 < count else 0
                    carried = _on_way(
                        kinds, old, after, behind, qx[k], qy[k], hx[k], hy[k], ahead
                    )  # fmt: skip
                    if carried:
                        spot[0] = ahead[0]
                        spot[1] = ahead[1]
                        next_x = ahead[0]
                        next_y = ahead[1]
                shift = n if begun >= n else 0
                m = straight_ways(
                    qx, qy, hx, hy, begun - shift, end - shift, begun_x, begun_y, spot[0], spot[1],
                    found,
                )  # fmt: skip
                for s in range(m):
                    q = found[s]
                    x = begun_x if s == 0 else qx[q]
                    y = begun_y if s == 0 else qy[q]
                    _write(kind, rows, at, i, x, y, q - n if q >= n else q)
                    i += 1
                if not carried:
                    _keep(kind, rows, at, i, kinds, old, e, spot[0], spot[1], here)
                    i += 1
    if carried:
        rows[0, 0] = next_x
        rows[0, 1] = next_y
    for j in range(i):
        if kind[j] != LINE:
            _straighten(kind, rows, at, n, i, j)
    return i


@njit(**LEAF)
def _keep(kind, rows, at, i, kinds, old, e, x, y, k):
    """What edge e was, from (x, y) on."""
    kind[i] = kinds[e]
    rows[i, 0] = x
    rows[i, 1] = y
    for c in range(2, 6):
        rows[i, c] = old[e, c]
    at[i] = k


@njit(**LEAF)
def _straighten(kind, rows, at, n, count, j):
    """Make a line of what is left of an arc where it is flat, or would turn the long way round."""
    after = j + 1 if j + 1 < count else 0
    hi = at[after]
    hi = hi + n if hi <= at[j] else hi
    ax = rows[j, 0] - rows[j, 2]
    ay = rows[j, 1] - rows[j, 3]
    bx = rows[after, 0] - rows[j, 2]
    by = rows[after, 1] - rows[j, 3]
    turn = math.atan2(ax * by - ay * bx, ax * bx + ay * by)
    turn = -turn if kind[j] == ARC_CCW else turn
    turn = turn + 2.0 * math.pi if turn < 0.0 else turn
    rise = rows[j, 4] * (1.0 - math.cos(min(0.5 * turn, 0.5 * math.pi)))
    if turn * rows[j, 4] > 2.0 * (hi - at[j]) + 4.0 or rise < FLATTEST_PX:
        kind[j] = LINE
        rows[j, 2] = 0.0
        rows[j, 3] = 0.0
        rows[j, 4] = 0.0
