"""The test for edge points that follow the pixels' staircase in spite of grey.

Rules and units
- Pixels, centres at integers. A drawing without grey keeps its pixels' steps in spite of later blur
  where they are longer: its border lies up to half a pixel off the drawing.
- A parabola through a stretch of points a column (or a row) apart predicts the middle one. A border
  drawn between pixels stays on it; one rounded to pixels follows the rounded parabola, blurred.
  Squares decide.
- Noise favours neither: a stretch that rises by a pixel meets every phase of the staircase alike. A
  stretch that rises less is not evaluated.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF, OWNING, SUMS
from planner.scene.primitive_kernels import successor

NARROWEST, WIDEST = 4, 16
"""Points on either side of a parabola's middle, at least and at most: chosen, by
``tests/vision/borders/test_staircase.py``, over discs of 20 to 200 px."""
COURSE, WIDER = 28.0, 0.75
"""Points of a course with the narrowest stretches: derived, the octants of a circle of 20 px. In
wider courses stretches grow by this power of the radius: derived, a parabola then leaves the circle
by the same w^4 / (8 r^3)."""
NARROW = 4.5
"""Points on either side at such a course, without a least: chosen, by the same test."""
TAILS = 2.5
"""Standard deviations at which blur is cut off: chosen, 1 % lies beyond."""
RISE_PX = 1.0
"""Least rise of a stretch: derived, a step."""
BESIDE_CORNER_PX = 0.6
"""Deviation from which a point is beside a corner: chosen, rounding makes half a pixel, noise a
little."""

ENOUGH = 4.0
"""Square pixels of the staircase that suffice: chosen, a hundred times the variance of points in
noise of 0.2 px; this takes 3 % of a picture's time, all borders a tenth to a fifth."""


@njit(**OWNING)
def follow_staircase(points, starts, blur):
    """Share of the pixels' staircase in the points (k, 2) of borders, from ``starts`` on.

    ``blur``: spread of light at an edge, pixels. Returns the sum of the points' deviation from
    their parabola times the staircase's, and the sum of the latter's squares, square pixels. Their
    quotient is 0 for drawings with grey, and 1 without. O(points) at most; it ends once enough are
    compared.
    """
    longest = 0
    for b in range(starts.shape[0] - 1):
        longest = max(longest, starts[b + 1] - starts[b])
    work = np.empty((4, longest + 1))
    reach = math.ceil(TAILS * blur)
    taps = np.empty(2 * reach + 1)
    total = 0.0
    for k in range(-reach, reach + 1):
        taps[k + reach] = math.exp(-0.5 * (k / blur) ** 2)
        total += taps[k + reach]
    taps /= total
    shared = 0.0
    squares = 0.0
    for b in range(starts.shape[0] - 1):
        border = points[starts[b] : starts[b + 1]]
        n = border.shape[0]
        for axis in range(2):
            begin = _first_break(border, axis)
            k = 0
            while k < n and squares < ENOUGH:
                first = begin + k if begin + k < n else begin + k - n
                count = _course(border, axis, first, n - k)
                if count > 2 * (NARROWEST + reach):
                    here = first
                    for i in range(count):
                        work[0, i] = border[here, 1 - axis]
                        here = successor(here, n)
                    more, most = _compare(work, count, taps, reach)
                    shared += more
                    squares += most
                k += max(count - 1, 1)
    return shared, squares


@njit(**LEAF)
def _first_break(border, axis):
    """Point where no course continues: its neighbours are not a pixel away on opposite sides."""
    n = border.shape[0]
    if n == 0:
        return 0
    step = border[0, axis] - border[n - 1, axis]
    for k in range(n):
        before = step
        step = border[successor(k, n), axis] - border[k, axis]
        if abs(before) != 1.0 or step != before:
            return k
    return 0


@njit(**LEAF)
def _course(border, axis, begin, most):
    """Number of points from ``begin`` on that follow each other a pixel apart; at most one more."""
    n = border.shape[0]
    here = successor(begin, n)
    step = border[here, axis] - border[begin, axis]
    if abs(step) != 1.0:
        return 1
    count = 2
    while count <= most:
        after = successor(here, n)
        if border[after, axis] - border[here, axis] != step:
            break
        here = after
        count += 1
    return count


@njit(**SUMS)
def _compare(work, count, taps, reach):
    course = work[0]
    smooth = work[1]
    rounded = work[2]
    blurred = work[3]
    width = int(NARROW * (count / COURSE) ** WIDER)
    width = min(max(width, NARROWEST), WIDEST)
    size = 2 * width + 1
    # value in the middle of a fitted parabola: weights a - b j^2
    second = width * (width + 1.0) * size / 3.0
    fourth = second * (3.0 * width * width + 3.0 * width - 1.0) / 5.0
    scale = 1.0 / (size * fourth - second * second)
    a = fourth * scale
    b = second * scale
    inner = count - 2 * width
    smooth[:inner] = 0.0
    for j in range(size):
        weight = a - b * (j - width) ** 2
        ahead = course[j:]
        for i in range(inner):
            smooth[i] += weight * ahead[i]
    for i in range(inner):
        rounded[i] = math.floor(smooth[i]) + 0.5
    end = inner - 2 * reach
    blurred[:end] = 0.0
    for j in range(2 * reach + 1):
        ahead = rounded[j:]
        for i in range(end):
            blurred[i] += taps[j] * ahead[i]
    first = course[reach:]
    middle = course[reach + width :]
    last = course[reach + 2 * width :]
    parabola = smooth[reach:]
    shared = 0.0
    squares = 0.0
    for i in range(end):
        rise = abs(first[i] - last[i])
        rise = max(rise, abs(first[i] - middle[i]), abs(last[i] - middle[i]))
        away = middle[i] - parabola[i]
        stair = blurred[i] - parabola[i]
        tells = 1.0 if (rise >= RISE_PX) & (abs(away) < BESIDE_CORNER_PX) else 0.0
        shared += tells * away * stair
        squares += tells * stair * stair
    return shared, squares
