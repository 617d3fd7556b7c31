"""Which pixels a finished outline takes for what they are not, row by row.

Rules and units
- Pixels, centres at integers, y down. An outline covers a pixel where half of the row through
  its centre or more lies inside, as a drawing of it would.
- A border's own pixels are known from its cracks: between two vertical cracks of a row. Both
  are lists of whole numbers, where a run begins and behind its last pixel; where their merged
  list alternates, the two differ. O(border).
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

LINE, ARC_CCW = 0, 2
"""Kinds of an edge, as in ``vision.cover_kernels``."""
SOUTH, NORTH = 1, 3
HALF_TURN, QUARTER = math.pi, 0.5 * math.pi


@njit(cache=True, nogil=True)
def _cross_line(x0, y0, x1, y1, rows, xs, count):
    """Where a line crosses the rows' centres: appended to ``rows`` and ``xs``; the new count."""
    if y0 > y1:
        x0, y0, x1, y1 = x1, y1, x0, y0
    first = math.ceil(y0)
    last = math.ceil(y1)
    if first >= last:
        return count
    slope = (x1 - x0) / (y1 - y0)
    for y in range(first, last):
        rows[count] = y
        xs[count] = x0 + (y - y0) * slope
        count += 1
    return count


@njit(cache=True, nogil=True)
def _cross_round(cx, cy, r, y0, y1, side, rows, xs, count):
    """The same for a part of a circle that rises or falls throughout; side: -1 left, 1 right."""
    low = min(y0, y1)
    high = max(y0, y1)
    for y in range(math.ceil(low), math.ceil(high)):
        rows[count] = y
        xs[count] = cx + side * math.sqrt(max(r * r - (y - cy) * (y - cy), 0.0))
        count += 1
    return count


@njit(cache=True, nogil=True)
def _cross_arc(x0, y0, x1, y1, cx, cy, r, ccw, rows, xs, count):
    """The same for an arc, cut where it turns from rising to falling."""
    begin = math.atan2(y0 - cy, x0 - cx)
    end = math.atan2(y1 - cy, x1 - cx)
    if ccw:
        begin, end = end, begin
        x0, y0, x1, y1 = x1, y1, x0, y0
    sweep = (end - begin) % (2.0 * HALF_TURN)
    here = begin
    y = y0
    # the next quarter turn at which the circle is highest or lowest
    turn = (math.floor((begin - QUARTER) / HALF_TURN) + 1.0) * HALF_TURN + QUARTER
    while turn < begin + sweep:
        top = cy + r * (1.0 if math.sin(turn) > 0.0 else -1.0)
        side = 1.0 if math.cos(0.5 * (here + turn)) > 0.0 else -1.0
        count = _cross_round(cx, cy, r, y, top, side, rows, xs, count)
        here = turn
        y = top
        turn += HALF_TURN
    side = 1.0 if math.cos(0.5 * (here + begin + sweep)) > 0.0 else -1.0
    return _cross_round(cx, cy, r, y, y1, side, rows, xs, count)


@njit(cache=True, nogil=True)
def _outline(kinds, data, first, last, is_circle, rows, xs):
    """Every crossing of an outline with a row's centre; their number."""
    if is_circle:
        cx = data[first, 2]
        cy = data[first, 3]
        r = data[first, 4]
        count = _cross_round(cx, cy, r, cy - r, cy + r, -1.0, rows, xs, 0)
        return _cross_round(cx, cy, r, cy - r, cy + r, 1.0, rows, xs, count)
    count = 0
    for e in range(first, last):
        after = e + 1 if e + 1 < last else first
        x0 = data[e, 0]
        y0 = data[e, 1]
        x1 = data[after, 0]
        y1 = data[after, 1]
        if kinds[e] == LINE:
            count = _cross_line(x0, y0, x1, y1, rows, xs, count)
        else:
            count = _cross_arc(
                x0, y0, x1, y1, data[e, 2], data[e, 3], data[e, 4], kinds[e] == ARC_CCW, rows, xs,
                count,
            )  # fmt: skip
    return count


@njit(cache=True, nogil=True)
def _room(kinds, data, first, last, is_circle):
    """No fewer crossings than an outline has."""
    if is_circle:
        return 4 * int(data[first, 4]) + 8
    total = 0
    for e in range(first, last):
        after = e + 1 if e + 1 < last else first
        if kinds[e] == LINE:
            total += int(abs(data[after, 1] - data[e, 1])) + 2
        else:
            # as long as the arc is, and a little: a large circle may give but a small part
            begin = math.atan2(data[e, 1] - data[e, 3], data[e, 0] - data[e, 2])
            end = math.atan2(data[after, 1] - data[e, 3], data[after, 0] - data[e, 2])
            sweep = (begin - end if kinds[e] == ARC_CCW else end - begin) % (2.0 * HALF_TURN)
            total += int(sweep * data[e, 4]) + 8
    return total


@njit(cache=True, nogil=True)
def _sort_rows(rows, values, count, top, height, starts, ordered):
    """``values`` row by row, ascending in each: ``ordered``, from ``starts`` (height + 1,)."""
    for i in range(height + 1):
        starts[i] = 0
    for i in range(count):
        starts[rows[i] - top + 1] += 1
    for i in range(height):
        starts[i + 1] += starts[i]
    for i in range(count):
        row = rows[i] - top
        at = starts[row]
        starts[row] += 1
        ordered[at] = values[i]
    for i in range(height, 0, -1):
        starts[i] = starts[i - 1]
    starts[0] = 0
    for row in range(height):
        for i in range(starts[row] + 1, starts[row + 1]):
            value = ordered[i]
            j = i - 1
            while j >= starts[row] and ordered[j] > value:
                ordered[j + 1] = ordered[j]
                j -= 1
            ordered[j + 1] = value


@njit(cache=True, nogil=True)
def _to_pixels(starts, height, crossings, limits):
    """Turn crossings into where covered runs begin and end; a run may vanish (begin == end)."""
    for row in range(height):
        for i in range(starts[row], starts[row + 1] - 1, 2):
            left = crossings[i]
            right = crossings[i + 1]
            begin = math.ceil(left)
            end = math.floor(right) + 1
            narrow = right - left < 1.0 and begin < end
            if narrow and min(right, begin + 0.5) - max(left, begin - 0.5) < 0.5:
                end = begin
            limits[i] = begin
            limits[i + 1] = max(end, begin)


@njit(cache=True, nogil=True)
def _holds(starts, limits, row, height, x):
    """Whether pixel x of a row lies in one of its runs."""
    if row < 0 or row >= height:
        return False
    inside = False
    for i in range(starts[row], starts[row + 1]):
        if limits[i] > x:
            break
        inside = not inside
    return inside


@njit(cache=True, nogil=True)
def find_misfits(kinds, data, first, last, is_circle, xs, ys, directions, begin, end):
    """The pixels on which an outline and its border differ: rows (n, 4).

    Edges first .. last - 1 and cracks begin .. end - 1. A row is x, y, whether the border has the
    pixel, and whether none of its four neighbours is in the other one too: then the two are
    farther than a pixel apart there.
    """
    room = max(_room(kinds, data, first, last, is_circle), end - begin) + 1
    rows = np.empty(room, np.int64)
    crossings = np.empty(room, np.float64)
    count = _outline(kinds, data, first, last, is_circle, rows, crossings)
    top = np.int64(ys[begin])
    bottom = top
    for i in range(begin, end):
        top = min(top, np.int64(ys[i]))
        bottom = max(bottom, np.int64(ys[i]))
    for i in range(count):
        top = min(top, rows[i])
        bottom = max(bottom, rows[i])
    height = bottom - top + 1
    starts = np.empty(height + 1, np.int64)
    ordered = np.empty(room, np.float64)
    _sort_rows(rows, crossings, count, top, height, starts, ordered)
    limits = np.empty(room, np.int64)
    _to_pixels(starts, height, ordered, limits)
    cracks = 0
    values = np.empty(room, np.int64)
    for i in range(begin, end):
        if directions[i] == SOUTH or directions[i] == NORTH:
            rows[cracks] = ys[i]
            values[cracks] = xs[i] + (1 if directions[i] == SOUTH else 0)
            cracks += 1
    own_starts = np.empty(height + 1, np.int64)
    own = np.empty(room, np.int64)
    _sort_rows(rows, values, cracks, top, height, own_starts, own)
    found = np.empty((16, 4), np.int64)
    n = 0
    for row in range(height):
        i = starts[row]
        j = own_starts[row]
        here = 0
        differ = False
        while i < starts[row + 1] or j < own_starts[row + 1]:
            ours = j >= own_starts[row + 1] or (i < starts[row + 1] and limits[i] < own[j])
            at = limits[i] if ours else own[j]
            if ours:
                i += 1
            else:
                j += 1
            if differ:
                for x in range(here, at):
                    if n == len(found):
                        more = np.empty((2 * n, 4), np.int64)
                        more[:n] = found
                        found = more
                    lacks = _holds(own_starts, own, row, height, x)
                    found[n, 0] = x
                    found[n, 1] = row + top
                    found[n, 2] = lacks
                    if lacks:
                        near = (
                            _holds(starts, limits, row, height, x - 1)
                            or _holds(starts, limits, row, height, x + 1)
                            or _holds(starts, limits, row - 1, height, x)
                            or _holds(starts, limits, row + 1, height, x)
                        )
                    else:
                        near = (
                            _holds(own_starts, own, row, height, x - 1)
                            or _holds(own_starts, own, row, height, x + 1)
                            or _holds(own_starts, own, row - 1, height, x)
                            or _holds(own_starts, own, row + 1, height, x)
                        )
                    found[n, 3] = not near
                    n += 1
            here = at
            differ = not differ
    return found[:n]


@njit(cache=True, nogil=True)
def audit(border_kind, edge_starts, kinds, data, xs, ys, directions, starts):
    """Pixels that each border's outline gets wrong, and how many of them lie far off: (b, 2)."""
    borders = border_kind.shape[0]
    wrong = np.zeros((borders, 2), np.int64)
    for b in range(borders):
        first = edge_starts[b]
        last = edge_starts[b + 1]
        if first == last:
            continue
        found = find_misfits(
            kinds, data, first, last, border_kind[b] == 1, xs, ys, directions, starts[b],
            starts[b + 1],
        )  # fmt: skip
        wrong[b, 0] = len(found)
        for i in range(len(found)):
            wrong[b, 1] += found[i, 3]
    return wrong
