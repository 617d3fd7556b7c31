"""Merging of edges without grey: one line or arc replaces a run if no more pixels are lost.

Rules and units
- ``cracks``, and ``finished``, edges ``0 .. count - 1`` with their first cracks: see
  ``vision.outline.outline_types``.
- From every edge, one arc or line (``vision.outline.bilevel.merged_edge_kernels``) replaces the
  longest possible run.
- An edge may lose no pixel around it that was not lost before
  (``vision.outline.bilevel.separation_kernels``).
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from numba import njit

from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import successor
from vision.outline.bilevel.merged_edge_kernels import line_between, may_be_arc, put_arc, put_line
from vision.outline.bilevel.separation_kernels import (
    NEIGHBOURS,
    find_lost,
    find_lost_beside,
)
from vision.outline.fitted_borders import FEWEST_LINES, LINE
from vision.outline.partition_kernels import FAILURES
from vision.shared.typed_numbers import NO, YES, ZERO

MOST_MERGED = 64
"""Most edges that become one: indifferent, a bound on the work."""
CRACK_STATE, FRESH_STATE = 1, 2
"""Rows of the scratch indices: defined."""
MERGING_ROUNDS = 8
"""Most rounds: indifferent, a bound on the work."""
AFFECTED = NEIGHBOURS + 1
"""Edges on either side whose pixels an edge may change: derived, those that may pass a point beside
it, and one whose end it moves."""
JUDGED_BESIDE = AFFECTED + NEIGHBOURS + 1
"""Edges on either side needed to judge those: derived."""
ROUNDED_LINE = 1.0 / 12.0
"""Mean square deviation of a straight line rounded to pixels: derived."""
ARC_LINES = 2
"""Price of an arc in lines: defined, see ``vision.outline.fit.edge_prices``."""


@njit(**LEAF, inline="always")
def merge_edges(cracks, finished, count, one_circle, trial, circle, scratch):
    """Merge runs of edges that lose no further pixel; return the new ``count``.

    ``one_circle``: its arcs belong to one circle and stay. ``trial``, as large as ``finished``,
    ``circle`` (3,) and ``scratch`` are scratch space.
    """
    state = scratch.indices[CRACK_STATE]
    find_lost(cracks, finished, count, state)
    now = scratch.flags[0]
    then = scratch.flags[1]
    for k in range(cracks.n):
        then[k] = True
    for _ in range(MERGING_ROUNDS):
        for k in range(cracks.n):
            now[k] = then[k]
            then[k] = False
        before = count
        for arc in (NO, YES):
            e = count if arc and one_circle else 0
            while e < count:
                k = finished.at[e]
                run = 0
                if now[k] or then[k]:
                    run = _best_run(cracks, finished, count, e, arc, trial, circle, scratch)
                if run > 1:
                    at = _put(cracks, finished, count, e, run, arc, trial, circle, scratch)
                    number = _window(count, run)
                    count = _take_over(trial, number, at, finished, count, e, run)
                    at = min(e, count - 1)
                    _judge_around(cracks, finished, count, at, state)
                    for step in range(-AFFECTED, 1):
                        then[finished.at[(at + step + count) % count]] = True
                e += 1
        if count == before:
            break
    return count


@njit(**LEAF, inline="always")
def _best_run(cracks, finished, count, e, arc, trial, circle, scratch):
    """Most edges from e on that one line or arc may replace; 0 if none."""
    if not arc:
        return _longest_line(cracks, finished, count, e, trial, circle, scratch)
    best = 0
    failed = 0
    for run in range(2, min(MOST_MERGED, count - 1) + 1):
        if not _is_dearer(finished, count, e, run):
            continue
        at = _put(cracks, finished, count, e, run, arc, trial, circle, scratch)
        if at >= 0 and _loses_no_more(cracks, trial, _window(count, run), at, scratch):
            best = run
            continue
        failed += 1
        if failed == FAILURES:
            break
    return best


@njit(**LEAF)
def _longest_line(cracks, finished, count, e, trial, circle, scratch):
    """Most lines from e on that one line may replace; 0 if none.

    If no line separates a run's pixels, none does for a longer run.
    """
    if finished.kind[e] != LINE:
        return 0
    most = 1
    while most < min(MOST_MERGED, count - 1) and finished.kind[(e + most) % count] == LINE:
        lo, hi = _stretch(cracks, finished, count, e, most + 1)
        gap, _, _, _, _ = line_between(cracks, lo, hi)
        if gap < 0.0:
            break
        most += 1
    for run in range(most, 1, -1):
        at = _put(cracks, finished, count, e, run, NO, trial, circle, scratch)
        number = _window(count, run)
        if (
            at >= 0
            and _is_as_near(cracks, finished, count, e, run, trial, number, at)
            and _loses_no_more(cracks, trial, number, at, scratch)
        ):
            return run
    return 0


@njit(**LEAF)
def _stretch(cracks, finished, count, e, run):
    lo = finished.at[e]
    hi = finished.at[(e + run) % count]
    return lo, hi + cracks.n if hi <= lo else hi


@njit(**LEAF)
def _is_as_near(cracks, finished, count, e, run, trial, number, at):
    """True if a run's line is as near to its cracks as the edges were, within rounding.

    Rounding counts for all but the longest edge: a side must not turn for a corner.
    """
    before = 0.0
    total = 0
    longest = 0
    for t in range(run):
        points, squares = _squares(cracks, finished, count, (e + t) % count)
        before += squares
        total += points
        longest = max(longest, points)
    _, after = _squares(cracks, trial, number, at)
    return after <= before + ROUNDED_LINE * (total - longest + 1)


@njit(**LEAF)
def _squares(cracks, edges, count, i):
    """Number of an edge's cracks, and the sum of their squared distances to its line."""
    after = successor(i, count)
    lo = edges.at[i]
    hi = edges.at[after]
    hi = hi + cracks.n if hi <= lo else hi
    x0 = edges.rows[i, 0]
    y0 = edges.rows[i, 1]
    dx = edges.rows[after, 0] - x0
    dy = edges.rows[after, 1] - y0
    total = 0.0
    for k in range(lo, hi):
        off = (cracks.x[k] - x0) * dy - (cracks.y[k] - y0) * dx
        total += off * off
    square = dx * dx + dy * dy
    return hi - lo, total / square if square > 0.0 else 0.0


@njit(**LEAF)
def _is_dearer(finished, count, e, run):
    lines = 0
    for t in range(run):
        lines += 1 if finished.kind[(e + t) % count] == LINE else ARC_LINES
    return lines > ARC_LINES


@njit(**LEAF)
def _window(count, run):
    """Number of edges in a trial: one for a run, and those that matter on either side."""
    return min(count - run + 1, 2 * JUDGED_BESIDE + 1)


@njit(**LEAF)
def _around(count, at):
    """First of the edges whose pixels an edge may change, and their number."""
    if count <= 2 * AFFECTED + 1:
        return 0, count
    return (at - AFFECTED + count) % count, 2 * AFFECTED + 1


@njit(**LEAF)
def _judge_around(cracks, finished, count, at, state):
    first, number = _around(count, at)
    lost = 0
    grave = 0
    for t in range(number):
        some, worse = find_lost_beside(cracks, finished, count, (first + t) % count, state)
        lost += some
        grave += worse
    return lost, grave


@njit(**LEAF)
def _loses_no_more(cracks, trial, count, at, scratch):
    state = scratch.indices[CRACK_STATE]
    fresh = scratch.indices[FRESH_STATE]
    lost, _ = _judge_around(cracks, trial, count, at, fresh)
    if lost == 0:
        return True
    first, number = _around(count, at)
    n = cracks.n
    lo = trial.at[first]
    hi = trial.at[(first + number) % count]
    hi = hi + n if hi <= lo else hi
    for k in range(lo, hi):
        here = k - n if k >= n else k
        if fresh[here] * state[here] < fresh[here] * fresh[here]:
            return False
    return True


@njit(**LEAF)
def _put(cracks, finished, count, e, run, arc, trial, circle, scratch):
    """Write one edge for a run, and those around it, into ``trial``: its place there, or -1."""
    lo, hi = _stretch(cracks, finished, count, e, run)
    if hi - lo < 2 or (arc and not may_be_arc(cracks, lo, hi)):
        return -1
    number = _window(count, run)
    at = min(JUDGED_BESIDE, number - 1)
    for t in range(number):
        i = (e + t - at + (run - 1 if t > at else 0) + count) % count
        for c in range(6):
            trial.rows[t, c] = finished.rows[i, c]
        trial.kind[t] = finished.kind[i]
        trial.at[t] = finished.at[i]
    if arc:
        return at if put_arc(cracks, trial, number, at, lo, hi, circle, scratch) else -1
    trial.kind[at] = LINE
    for c in range(2, 5):
        trial.rows[at, c] = 0.0
    # two lines enclose nothing
    if count - run + 1 < FEWEST_LINES and trial.kind[successor(at, number)] == LINE:
        return -1
    return at if put_line(cracks, trial, number, at, lo, hi) else -1


@njit(**LEAF)
def _take_over(trial, number, at, finished, count, e, run):
    """Replace a run from edge e on by edge ``at`` of a trial; return the number of edges."""
    fewer = count - run + 1
    passed = max(e + run - count, 0)
    place = e - passed
    if passed > 0:
        _move(finished, passed, ZERO, place)
    else:
        _move(finished, e + run, e + 1, fewer - e - 1)
    after = successor(place, fewer)
    for c in range(6):
        finished.rows[place, c] = trial.rows[at, c]
    finished.kind[place] = trial.kind[at]
    finished.at[place] = trial.at[at]
    beside = successor(at, number)
    finished.rows[after, 0] = trial.rows[beside, 0]
    finished.rows[after, 1] = trial.rows[beside, 1]
    return fewer


@njit(**LEAF)
def _move(finished, from_, to, number):
    for t in range(number):
        for c in range(6):
            finished.rows[to + t, c] = finished.rows[from_ + t, c]
        finished.kind[to + t] = finished.kind[from_ + t]
        finished.at[to + t] = finished.at[from_ + t]
