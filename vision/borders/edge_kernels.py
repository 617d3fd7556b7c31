"""Sub-pixel edge points: where the light crosses the half level, crack by crack.

Rules and units
- Pixel coordinates, pixel centres at integers, y down; grey values as floats.
- A crack contributes where the border runs more along it than across it: one point a row or column,
  and the profile meets the edge at 45 degrees or more.
- The profile across the crack is smoothed along itself (Gaussian, sigma 1 px). Interpolation
  through the normal distribution's inverse is then exact to a few thousandths of a pixel.
- The half level is that of both plateaus beside the edge, averaged along the border: neither
  darkness nor uneven light moves the edge.
- In walls or gaps too narrow for a plateau, nothing beyond the middle is read: the light is not
  smoothed, and the given level counts unless the plateau's visible part shows another. -
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from planner.scene import FloatArray
from planner.scene.compile_options import LEAF, OWNING, SUMS
from vision.borders.edge_profile_kernels import (
    DIRECTION_REACH,
    PIXELS_BEHIND,
    PROFILE_PIXELS,
    ROWS,
    TAP0,
    TAP1,
    TAP2,
    Profiles,
    gather,
    locate,
    look_along,
    look_at_mask,
    look_beside,
    out,
)
from vision.shared.typed_numbers import NO, ONE, YES, ZERO

WANDER = 2
"""Pixels beside the crack at which the smoothed crossing may lie."""
CRISP = 0.95
"""Share of the contrast in one step from which an edge is drawn without grey."""
UNREACHED = 1 / 8
"""Distance from half-way between both visible plateaus, as a share of their contrast, up to which
the given level counts at a narrow wall: a fifth of the contrast is unseen."""
STRETCH = 64
"""Cracks to either side over which the plateaus are averaged."""
SAME_GREY = 1e-9
"""Rounding of grey values."""


class PlateauRows(NamedTuple):
    """Rows of one kind of plateau, dark or light; sums run up to every crack."""

    own: FloatArray
    """Every crack's plateau."""
    level: FloatArray
    """Its stretch's mean."""
    total: FloatArray
    """Sum of the plateaus."""
    number: FloatArray
    """Their number."""
    others: FloatArray
    """Number of the other kind: without those there is no level."""


@njit(**OWNING)
def edge_points(grey, mask, level, by_level, xs, ys, directions, starts, points):
    """Sub-pixel points of every border, in order.

    ``grey`` (h, w), obstacles dark; ``mask`` the padded mask; ``level`` the threshold;
    ``by_level``: the mask is exactly the pixels below it; ``points`` (k, 2) has space for one more
    than the cracks. Returns ``(points, point_starts, slope, crispness)``: (k, 2) float64, per
    border its first point, the mean step of the smoothed profile at the edge as a share of the
    contrast, and the share of slanted cracks with a full step.
    """
    borders = starts.shape[0] - 1
    point_starts = np.empty(borders + 1, np.int64)
    longest = 0
    for b in range(borders):
        longest = max(longest, starts[b + 1] - starts[b])
    rows = np.empty((ROWS, longest + 2 * DIRECTION_REACH), np.float64)
    work = Profiles(
        rows[:PROFILE_PIXELS], rows[10], rows[11], rows[12], rows[13], rows[14], rows[15], rows[16],
        rows[17], rows[18], rows[19], rows[20], rows[21], rows[22], rows[23], rows[24],
    )  # fmt: skip
    places = np.empty((2, longest), np.int64)
    sums = np.zeros((4, longest + 1), np.float64)
    totals = np.zeros(4)
    count = ZERO
    for b in range(borders):
        first = starts[b]
        n = starts[b + 1] - first
        x = xs[first : first + n]
        y = ys[first : first + n]
        direction = directions[first : first + n]
        point_starts[b] = count
        locate(grey, x, y, direction, n, work, places)
        if not by_level:
            look_at_mask(mask, grey.shape[1], x, y, direction, n, work.clear)
        gather(grey, mask, x, y, direction, n, work, places)
        look_along(direction, n, work)
        look_beside(level, by_level, n, work)
        find_plateaus(n, work, sums)
        _find_crossings(level, n, work, totals)
        count = _place(grey, level, x, y, direction, n, work, totals, points, count)
    point_starts[borders] = count
    slope = totals[0] / totals[1] if totals[1] > 0 else 0.4
    crispness = totals[2] / totals[3] if totals[3] > 0 else 0.0
    return points[:count], point_starts, slope, crispness


@njit(**SUMS, forceinline=True)
def _find_crossings(level, n, work, totals):
    """Crossings of the half level by the smoothed profile between the crack's own two pixels.

    ``totals``: sum and number of slopes, of full steps and slanted cracks.
    """
    here = work.profile[PIXELS_BEHIND]
    beside = work.profile[PIXELS_BEHIND + 1]
    slopes = 0.0
    crossed = 0.0
    steps = 0.0
    slants = 0.0
    for i in range(n):
        g0 = here[i]
        g1 = beside[i]
        step = g1 - g0
        contrast = work.light_level[i] - work.dark_level[i]
        seen = (work.clear[i] > 0.0) & (contrast > 0.0)
        counts = work.chosen[i] * work.slanted[i] if seen else 0.0
        slants += counts
        steps += counts if step >= CRISP * contrast else 0.0
        share = 1.0 / (contrast if contrast > 0.0 else 1.0)
        half = 0.5 * (work.light_level[i] + work.dark_level[i])
        p0 = _probit((work.near[i] - half) * share)
        p1 = _probit((work.far[i] - half) * share)
        rise = p1 - p0
        between = seen & (work.near[i] < half) & (half <= work.far[i])
        good = between & (rise > 1e-6)
        counts = work.chosen[i] if good else 0.0
        slopes += counts * (work.far[i] - work.near[i]) * share
        crossed += counts
        plain = (g1 > level) & (step > 0.0) & (g0 < level) & (work.clear[i] == 0.0)
        t = (level - g0) / (step if step > 0.0 else 1.0) if plain else 0.5
        t = -p0 / (rise if rise > 1e-6 else 1.0) if good else t
        work.crossing[i] = 0.5 if work.crossing[i] < 0.0 else t
        narrow = work.wall[i] + work.gap[i] > 0.0
        work.astray[i] = 1.0 if seen & (narrow | (not between)) else 0.0
    totals[0] += slopes
    totals[1] += crossed
    totals[2] += steps
    totals[3] += slants


@njit(**SUMS)
def _probit(w):
    """Inverse normal distribution near its middle, up to a factor; w in [-0.5, 0.5]."""
    w = min(max(w, -0.5), 0.5)
    q = w * w
    return w * (1.0 + q * (1.047198 + q * (2.30291 + q * 6.0)))


@njit(**LEAF, forceinline=True)
def _place(grey, level, xs, ys, directions, n, work, totals, points, count):
    for i in range(n):
        nx, ny = out(np.int64(directions[i]))
        t = work.crossing[i]
        if work.astray[i] * work.chosen[i] > 0.0:
            if work.wall[i] + work.gap[i] > 0.0:
                t = _crossing_narrow(level, i, work)
            else:
                t = _crossing_beside(grey, xs[i], ys[i], nx, ny, i, work, totals)
        points[count, 0] = xs[i] + t * nx
        points[count, 1] = ys[i] + t * ny
        count += np.int64(work.chosen[i])
    return count


@njit(**LEAF, forceinline=True)
def _crossing_beside(grey, x, y, nx, ny, i, work, totals):
    """Crossing of the half level by the smoothed profile beside the crack's own two pixels."""
    half = 0.5 * (work.light_level[i] + work.dark_level[i])
    share = 1.0 / (work.light_level[i] - work.dark_level[i])
    k = 0
    s0 = work.near[i]
    s1 = work.far[i]
    while s0 >= half and k > -WANDER:
        k -= 1
        s1 = s0
        s0 = _smoothed(grey, x + k * nx, y + k * ny, nx, ny)
    while s1 < half and k < WANDER:
        k += 1
        s0 = s1
        s1 = _smoothed(grey, x + (k + 1) * nx, y + (k + 1) * ny, nx, ny)
    if s0 < half <= s1:
        p0 = _probit((s0 - half) * share)
        p1 = _probit((s1 - half) * share)
        if p1 - p0 > 1e-6:
            totals[0] += (s1 - s0) * share
            totals[1] += 1.0
            return k - p0 / (p1 - p0)
    return 0.5


@njit(**LEAF, forceinline=True)
def _crossing_narrow(level, i, work):
    """Crossing of the half level by the profile itself, at a wall or a gap three or four wide."""
    dark = work.dark_level[i]
    light = work.light_level[i]
    half = 0.5 * (light + dark)
    # the missing part of a plateau lies beyond the visible one
    lowest = half - (UNREACHED * (light - dark) if work.wall[i] > 0.0 else 0.0)
    highest = half + (UNREACHED * (light - dark) if work.gap[i] > 0.0 else 0.0)
    if lowest <= level <= highest:
        half = level
    k = PIXELS_BEHIND
    while work.profile[k, i] >= half and k > PIXELS_BEHIND - WANDER:
        k -= 1
    while work.profile[k + 1, i] < half and k < PIXELS_BEHIND + WANDER:
        k += 1
    g0 = work.profile[k, i]
    g1 = work.profile[k + 1, i]
    return k - PIXELS_BEHIND + (half - g0) / (g1 - g0) if g0 < half <= g1 else 0.5


@njit(**LEAF)
def _smoothed(grey, x, y, nx, ny):
    """Profile across a crack, smoothed at one pixel; the picture's edge pixels repeat."""
    height, width = grey.shape
    value = 0.0
    for k in range(-2, 3):
        px = min(max(x + k * nx, 0), width - 1)
        py = min(max(y + k * ny, 0), height - 1)
        tap = TAP0 if k == 0 else (TAP1 if abs(k) == 1 else TAP2)
        value += tap * grey[py, px]
    return value


@njit(**SUMS, forceinline=True)
def find_plateaus(n, work, sums):
    """Dark and light for every crack, from pixels within STRETCH of it.

    Near a corner the plateaus are not reached, so the second round leaves out pixels lighter or
    darker than the first round's mean. A crack without any in its stretch keeps its own. ``sums``
    (4, n + 1) is scratch space.
    """
    reach = min(STRETCH, (n - 1) // 2)
    dark = PlateauRows(work.dark, work.dark_level, sums[0], sums[1], sums[3])
    light = PlateauRows(work.light, work.light_level, sums[2], sums[3], sums[1])
    dark.level[:n] = np.inf
    light.level[:n] = -np.inf
    for _ in range(2):
        _add_up(n, work.clear, dark, light)
        for kind in (dark, light):
            _set_level(ZERO, reach, reach + 1, n - reach, YES, n, kind)
            _set_level(reach, n - reach, 2 * reach + 1, ZERO, NO, n, kind)
            _set_level(n - reach, n, ONE, n - 2 * reach, YES, n, kind)


@njit(**LEAF, forceinline=True)
def _add_up(n, clear, dark, light):
    """Cumulative sums along the cracks: dark and light values, and their numbers.

    Values lighter than the known dark level, or darker than the light one, are left out. Sums of
    whole and half grey values are exact, wherever a border begins.
    """
    a = 0.0
    b = 0.0
    c = 0.0
    d = 0.0
    for i in range(n):
        counts = clear[i] if dark.own[i] <= dark.level[i] + SAME_GREY else 0.0
        a += counts * dark.own[i]
        b += counts
        counts = clear[i] if light.own[i] >= light.level[i] - SAME_GREY else 0.0
        c += counts * light.own[i]
        d += counts
        dark.total[i + 1] = a
        dark.number[i + 1] = b
        light.total[i + 1] = c
        light.number[i + 1] = d


@njit(**SUMS)
def _set_level(begin, end, ahead, behind, around, n, kind):
    """Means of the stretches of cracks ``begin`` .. ``end`` - 1, dark or light.

    The first stretch ends before crack ``ahead`` and begins at crack ``behind``; ``around``: past
    the border's end. One kind at a time: a loop that writes two rows is not vectorised.
    """
    cracks = end - begin
    own = kind.own[begin:end]
    level = kind.level[begin:end]
    total, count, others = kind.total, kind.number, kind.others
    total_ahead = total[ahead : ahead + cracks]
    count_ahead = count[ahead : ahead + cracks]
    others_ahead = others[ahead : ahead + cracks]
    total_behind = total[behind : behind + cracks]
    count_behind = count[behind : behind + cracks]
    others_behind = others[behind : behind + cracks]
    whole = 1.0 if around else 0.0
    whole_total = whole * total[n]
    whole_count = whole * count[n]
    whole_others = whole * others[n]
    for i in range(cracks):
        counted = count_ahead[i] - count_behind[i] + whole_count
        known = (counted > 0.0) & (others_ahead[i] - others_behind[i] + whole_others > 0.0)
        mean = (total_ahead[i] - total_behind[i] + whole_total) / max(counted, 1.0)
        level[i] = mean if known else own[i]
