"""Chords where finished edges do not separate the pixels of a border without grey.

Rules and units
- ``cracks``, and ``finished``, edges ``0 .. count - 1`` with their first cracks: see
  ``vision.outline.outline_types``.
- A crack's way is the line between its two pixels. Chords that cross all ways replace a stretch of
  lost cracks or, if little else remains, the whole border; they misclassify no pixel.
- A chord extends until the cone of sight from its first point, through the ways ahead as windows,
  is empty (J. Sklansky and V. Gonzalez, Fast Polygonal Approximation of Digitized Curves, 1980).
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import TAU, predecessor, successor
from vision.outline.bilevel.lost_run_kernels import mark_runs, weigh_runs
from vision.outline.bilevel.separation_kernels import find_lost
from vision.outline.fit.outline_kernels import FLATTEST_PX, distance_to_edge, in_sweep, write_line
from vision.outline.fit.separating_fit_kernels import HALF
from vision.outline.fitted_borders import ARC_CCW, LINE
from vision.shared.typed_numbers import ZERO

WAY = 0.998
"""Share of a crack's way that a chord may cross: chosen, no pixel's centre lies on it."""
TIP_LEAST = 3
"""Lost cracks that are no tip yet: derived, those of one pixel that hangs on by a side."""
CHORD_ROUNDS = 4
"""Times that lost stretches are replaced before the whole border: chosen, a bound on the work."""


@njit(**LEAF)
def chords_between(cracks, lo, hi, x0, y0, x1, y1, found):
    """Find chords from (x0, y0) on crack lo's way to (x1, y1) on crack hi's; return their number.

    ``found``: the crack at whose middle each chord begins, except the first, which begins at (x0,
    y0).
    """
    m = 0
    here = lo
    x = x0
    y = y0
    while here < hi:
        found[m] = here
        m += 1
        best = here + 1
        free_x = 0.0
        free_y = 0.0
        dark_x = 0.0
        dark_y = 0.0
        for k in range(here + 1, hi + 1):
            tx = (x1 if k == hi else cracks.x[k]) - x
            ty = (y1 if k == hi else cracks.y[k]) - y
            seen = tx * dark_y - ty * dark_x > 0.0 and tx * free_y - ty * free_x < 0.0
            if k > here + 1 and seen:
                best = k
            a = cracks.x[k] + WAY * cracks.free_x[k] - x
            b = cracks.y[k] + WAY * cracks.free_y[k] - y
            c = cracks.x[k] - WAY * cracks.free_x[k] - x
            d = cracks.y[k] - WAY * cracks.free_y[k] - y
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
        x = cracks.x[here]
        y = cracks.y[here]
    return m


@njit(**LEAF)
def _on_way(cracks, k, finished, i, count, out):
    """Find where edge i crosses the way of crack k, or comes nearest to its middle; True if it
    crosses."""
    after = successor(i, count)
    x = cracks.x[k]
    y = cracks.y[k]
    upright = cracks.free_x[k] != 0.0
    if finished.kind[i] == LINE:
        dx = finished.rows[after, 0] - finished.rows[i, 0]
        dy = finished.rows[after, 1] - finished.rows[i, 1]
        run = dy if upright else dx
        if abs(run) > 1e-9:
            t = (y - finished.rows[i, 1]) / run if upright else (x - finished.rows[i, 0]) / run
            qx = x if not upright else finished.rows[i, 0] + t * dx
            qy = y if upright else finished.rows[i, 1] + t * dy
            if 0.0 <= t <= 1.0 and abs(qx - x) + abs(qy - y) < WAY * HALF:
                out[0] = qx
                out[1] = qy
                return True
    else:
        off = y - finished.rows[i, 3] if upright else x - finished.rows[i, 2]
        root = math.sqrt(max(finished.rows[i, 4] * finished.rows[i, 4] - off * off, 0.0))
        if upright:
            qx = finished.rows[i, 2] + (root if x > finished.rows[i, 2] else -root)
            qy = y
        else:
            qx = x
            qy = finished.rows[i, 3] + (root if y > finished.rows[i, 3] else -root)
        if abs(qx - x) + abs(qy - y) < WAY * HALF:
            out[0] = qx
            out[1] = qy
            return in_sweep(finished.kind, finished.rows, i, after, qx, qy)
    _, out[0], out[1] = distance_to_edge(finished.kind, finished.rows, i, after, x, y)
    return False


@njit(**LEAF, inline="always")
def separate_by_chords(cracks, finished, count, budget, state, inside, found, old, ends):
    """Replace edges that lose more pixels than ``budget`` by chords; return the new ``count``.

    ``state``, ``inside``, ``found`` (n + 1,), ``old``, as large as ``finished``, and ``ends`` (2,
    2) are scratch space.
    """
    n = cracks.n
    for again in range(CHORD_ROUNDS + 1):
        lost, grave = find_lost(cracks, finished, count, state)
        if grave == 0 and lost <= min(budget, TIP_LEAST):
            return count
        if again == CHORD_ROUNDS or 2 * lost >= n:
            break
        total, heaviest = weigh_runs(cracks, state, found)
        if total <= budget and not _any_grave(found, n):
            return count
        mark_runs(state, n, budget, total, heaviest, found, inside)
        first = 0
        while first < count and inside[finished.at[first]]:
            first += 1
        if first == count:
            break
        count = _replace(cracks, finished, count, first, inside, found, old, ends)
    return all_chords(cracks, finished, found)


@njit(**LEAF)
def _any_grave(weights, n):
    for k in range(n):  # noqa: SIM110 (numba knows no generators)
        if weights[k] < 0:
            return True
    return False


@njit(**LEAF)
def all_chords(cracks, finished, found):
    """Write chords all around, from the crack farthest from the middle on; return their number."""
    n = cracks.n
    mx = 0.0
    my = 0.0
    for k in range(n):
        mx += cracks.x[k]
        my += cracks.y[k]
    mx /= n
    my /= n
    far = -1.0
    first = ZERO
    for k in range(n):
        d = (cracks.x[k] - mx) ** 2 + (cracks.y[k] - my) ** 2
        if d > far:
            far = d
            first = k
    x = cracks.x[first]
    y = cracks.y[first]
    count = chords_between(cracks, first, first + n, x, y, x, y, found)
    for t in range(count):
        k = found[t]
        write_line(finished, t, cracks.x[k], cracks.y[k], k - n if k >= n else k)
    return count


@njit(**LEAF)
def _replace(cracks, finished, count, first, inside, found, old, ends):
    """Replace the cracks ``inside`` by chords; return the new count.

    Edge ``first`` begins outside.
    """
    n = cracks.n
    for e in range(count):
        _keep(old, e, finished, e, finished.rows[e, 0], finished.rows[e, 1], finished.at[e])
    start = ends[0]
    end = ends[1]
    begun = 0
    carried = False
    i = ZERO
    for t in range(count):
        e = (first + t) % count
        lo = old.at[e]
        hi = old.at[successor(e, count)]
        hi = hi + n if hi <= lo else hi
        turned = n if lo < old.at[first] else 0
        from_x = end[0] if carried else old.rows[e, 0]
        from_y = end[1] if carried else old.rows[e, 1]
        carried = False
        if not inside[lo]:
            _keep(finished, i, old, e, from_x, from_y, lo)
            i += 1
        for k in range(lo, hi):
            here = k - n if k >= n else k
            if not inside[here]:
                continue
            if not inside[predecessor(here, n)]:
                begun = k + turned
                if not _begin_stretch(cracks, old, count, e, k, start):
                    start[0] = from_x
                    start[1] = from_y
            if not inside[successor(here, n)]:
                carried = _end_stretch(cracks, old, count, e, k, end)
                i = _write_stretch(cracks, finished, i, begun, k + turned, start, end, found)
                if not carried:
                    _keep(finished, i, old, e, end[0], end[1], here)
                    i += 1
    if carried:
        finished.rows[0, 0] = end[0]
        finished.rows[0, 1] = end[1]
    for j in range(i):
        if finished.kind[j] != LINE:
            _straighten(finished, n, i, j)
    return i


@njit(**LEAF)
def _begin_stretch(cracks, old, count, e, k, start):
    """Begin chords on the way of crack k of edge e; False at the edge's own beginning."""
    if k > old.at[e]:
        _on_way(cracks, k, old, e, count, start)
        return True
    # the edge before may cross the crack at a joint
    return _on_way(cracks, k, old, predecessor(e, count), count, start)


@njit(**LEAF)
def _end_stretch(cracks, old, count, e, k, end):
    """End chords on the way of crack k of edge e; True if the next edge begins there."""
    if _on_way(cracks, k, old, e, count, end):
        return False
    after = successor(e, count)
    lo = old.at[e]
    hi = old.at[after]
    hi = hi + cracks.n if hi <= lo else hi
    if k < hi - 1:
        return False
    x = end[0]
    y = end[1]
    if _on_way(cracks, k, old, after, count, end):
        return True
    end[0] = x
    end[1] = y
    return False


@njit(**LEAF)
def _write_stretch(cracks, finished, i, begun, ended, start, end, found):
    """Write the chords from ``start`` on crack ``begun`` to ``end``; return the next edge."""
    n = cracks.n
    shift = n if begun >= n else 0
    m = chords_between(
        cracks, begun - shift, ended - shift, start[0], start[1], end[0], end[1], found
    )
    for s in range(m):
        q = found[s]
        x = start[0] if s == 0 else cracks.x[q]
        y = start[1] if s == 0 else cracks.y[q]
        write_line(finished, i + s, x, y, q - n if q >= n else q)
    return i + m


@njit(**LEAF)
def _keep(finished, i, old, e, x, y, k):
    finished.kind[i] = old.kind[e]
    finished.rows[i, 0] = x
    finished.rows[i, 1] = y
    for c in range(2, 6):
        finished.rows[i, c] = old.rows[e, c]
    finished.at[i] = k


@njit(**LEAF)
def _straighten(finished, n, count, j):
    """Make the rest of an arc a line if it is flat, or would turn the long way round."""
    after = successor(j, count)
    hi = finished.at[after]
    hi = hi + n if hi <= finished.at[j] else hi
    ax = finished.rows[j, 0] - finished.rows[j, 2]
    ay = finished.rows[j, 1] - finished.rows[j, 3]
    bx = finished.rows[after, 0] - finished.rows[j, 2]
    by = finished.rows[after, 1] - finished.rows[j, 3]
    turn = math.atan2(ax * by - ay * bx, ax * bx + ay * by)
    turn = -turn if finished.kind[j] == ARC_CCW else turn
    turn = turn + TAU if turn < 0.0 else turn
    rise = finished.rows[j, 4] * (1.0 - math.cos(min(0.5 * turn, 0.5 * math.pi)))
    if turn * finished.rows[j, 4] > 2.0 * (hi - finished.at[j]) + 4.0 or rise < FLATTEST_PX:
        write_line(finished, j, finished.rows[j, 0], finished.rows[j, 1], finished.at[j])
