"""Fewer edges without grey: a run of edges becomes one line or one arc that loses no more pixels.

Rules and units
- ``cracks``, and ``finished``, edges ``0 .. count - 1`` with their first cracks: see
  ``vision.outline.outline_types``.
- A local search: from every edge on the longest run is sought that one arc may stand for where
  that costs less, or one line for a run of lines (``vision.outline.drawn.merged_edge_kernels``);
  what is beside an edge that was put in is looked at again.
- An edge is judged by the pixels that the outline then loses around it, drawn again
  (``vision.outline.drawn.separation_kernels``): none that it did not lose before.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from numba import njit

from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import successor
from vision.outline.drawn.merged_edge_kernels import put_arc, put_line
from vision.outline.drawn.separation_kernels import (
    NEIGHBOURS,
    find_lost,
    find_lost_beside,
)
from vision.outline.fitted_borders import FEWEST_LINES, LINE
from vision.outline.partition_kernels import FAILURES
from vision.shared.typed_numbers import NO, YES

LONGEST = 64
"""Edges that become one at most: indifferent, a bound on the work."""
ROUNDS = 8
"""Times that edges are looked at: indifferent, a bound on the work."""
AFFECTED = NEIGHBOURS + 1
"""Edges on either side whose pixels an edge may change: derived, those that may pass a point beside
it, and one whose end it moves."""
ROUNDED = 1.0 / 12.0
"""What rounding to pixels leaves of a straight line, in the mean square: derived."""
ARC_LINES = 2
"""Lines that an arc costs as much as: defined, see ``vision.outline.fit.edge_prices``."""


@njit(**LEAF)
def merge_edges(cracks, finished, count, trial, circle, room):
    """Merge runs of edges where no pixel is lost by it; returns the new ``count``.

    ``trial``, as long as ``finished``, ``circle`` (3,) and ``room`` are memory to work in.
    """
    state = room.indices[1]
    find_lost(cracks, finished, count, state)
    # by their first cracks: edges to begin at now, and in the next round
    now = room.flags[0]
    then = room.flags[1]
    for k in range(cracks.n):
        then[k] = True
    for _ in range(ROUNDS):
        for k in range(cracks.n):
            now[k] = then[k]
            then[k] = False
        before = count
        for arc in (NO, YES):
            e = 0
            while e < count:
                k = finished.at[e]
                run = 0
                if now[k] or then[k]:
                    run = _best_run(cracks, finished, count, e, arc, trial, circle, room)
                if run > 1:
                    _put(cracks, finished, count, e, run, arc, trial, circle, room)
                    at = _place_of(count, e, run)
                    count = _take_over(trial, finished, count - run + 1)
                    _judge_around(cracks, finished, count, at, state)
                    for step in range(-AFFECTED, 1):
                        then[finished.at[(at + step + count) % count]] = True
                e += 1
        if count == before:
            break
    return count


@njit(**LEAF)
def _best_run(cracks, finished, count, e, arc, trial, circle, room):
    """The most edges from e on that one line or arc may stand for; 0 where there are none."""
    best = 0
    failed = 0
    if not arc and finished.kind[e] != LINE:
        return best
    for run in range(2, min(LONGEST, count - 1) + 1):
        if not arc and finished.kind[(e + run - 1) % count] != LINE:
            break
        if arc and not _is_dearer(finished, count, e, run):
            continue
        good = _put(cracks, finished, count, e, run, arc, trial, circle, room)
        good = good and (arc or _is_as_near(cracks, finished, count, e, run, trial))
        if good and _loses_no_more(cracks, trial, count - run + 1, _place_of(count, e, run), room):
            best = run
            continue
        failed += 1
        if failed == FAILURES:
            break
    return best


@njit(**LEAF)
def _is_as_near(cracks, finished, count, e, run, trial):
    """Whether the line for a run is as near to its cracks as the edges were, but for rounding.

    That of all but the longest edge: a side must not turn for a corner's pixel.
    """
    before = 0.0
    total = 0
    longest = 0
    for t in range(run):
        number, squares = _squares(cracks, finished, count, (e + t) % count)
        before += squares
        total += number
        longest = max(longest, number)
    at = _place_of(count, e, run)
    _, after = _squares(cracks, trial, count - run + 1, at)
    return after <= before + ROUNDED * (total - longest + 1)


@njit(**LEAF)
def _squares(cracks, edges, count, i):
    """How many cracks an edge has, and the sum of their squared distances to its line."""
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
    """Whether a run of edges costs more than an arc."""
    lines = 0
    for t in range(run):
        lines += 1 if finished.kind[(e + t) % count] == LINE else ARC_LINES
    return lines > ARC_LINES


@njit(**LEAF)
def _place_of(count, e, run):
    """Which edge is the one for a run from e on: one that passes the last edge comes first."""
    return e if e + run <= count else 0


@njit(**LEAF)
def _around(count, at):
    """The first of the edges whose pixels an edge may change, and their number."""
    if count <= 2 * AFFECTED + 1:
        return 0, count
    return (at - AFFECTED + count) % count, 2 * AFFECTED + 1


@njit(**LEAF)
def _judge_around(cracks, finished, count, at, state):
    """``state`` of the cracks around edge ``at``: those lost, and how many of them gravely."""
    first, number = _around(count, at)
    lost = 0
    grave = 0
    for t in range(number):
        some, worse = find_lost_beside(cracks, finished, count, (first + t) % count, state)
        lost += some
        grave += worse
    return lost, grave


@njit(**LEAF)
def _loses_no_more(cracks, trial, count, at, room):
    """Whether around edge ``at`` of a trial nothing is lost, or gravely, that was not before."""
    state = room.indices[1]
    fresh = room.indices[2]
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
        if fresh[here] > state[here]:
            return False
    return True


@njit(**LEAF)
def _put(cracks, finished, count, e, run, arc, trial, circle, room):
    """Write the outline with one edge for a run into ``trial``: whether there is such an edge."""
    lo = finished.at[e]
    behind = (e + run) % count
    hi = finished.at[behind]
    hi = hi + cracks.n if hi <= lo else hi
    if hi - lo < 2:
        return False
    fewer = count - run + 1
    at = _place_of(count, e, run)
    after = successor(at, fewer)
    for t in range(fewer):
        i = (e + (t - at if t <= at else t - at + run - 1)) % count
        for c in range(6):
            trial.rows[t, c] = finished.rows[i, c]
        trial.kind[t] = finished.kind[i]
        trial.at[t] = finished.at[i]
    if arc:
        return put_arc(cracks, trial, fewer, at, lo, hi, circle, room)
    trial.kind[at] = LINE
    for c in range(2, 5):
        trial.rows[at, c] = 0.0
    # two lines enclose nothing
    if fewer < FEWEST_LINES and trial.kind[after] == LINE:
        return False
    return put_line(cracks, trial, fewer, at, lo, hi)


@njit(**LEAF)
def _take_over(trial, finished, count):
    """Let the trial be the outline: its number of edges."""
    for i in range(count):
        for c in range(6):
            finished.rows[i, c] = trial.rows[i, c]
        finished.kind[i] = trial.kind[i]
        finished.at[i] = trial.at[i]
    return count
