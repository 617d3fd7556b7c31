"""Sub-pixel edge points: where the light crosses the half level, crack by crack.

Rules and units
- Pixel coordinates, pixel centres at integers, y down; grey values as floats.
- A crack contributes where the border runs more along it than across it, so that one point a
  row or column is left and the profile across the crack meets the edge at 45 degrees or more.
- The profile across the crack is smoothed along itself (Gaussian, sigma 1 px): next to the
  best that can be done at a noisy edge, and it makes the step so wide that an interpolation
  through the normal distribution's inverse is exact to a few thousandths of a pixel.
- The half level is taken from both plateaus beside the edge, averaged over a stretch of the
  border, so that objects of different darkness and uneven light do not move the edge.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

REACH = 3
"""Cracks to either side that tell the border's direction."""
STRETCH = 64
"""Cracks to either side over which the plateaus are averaged."""
TAP0, TAP1, TAP2 = 0.40261995, 0.24420134, 0.05448868
"""A Gaussian of sigma 1 on five pixels."""
WANDER = 2
"""How many pixels beside the crack the smoothed crossing may lie."""
CRISP = 0.95
"""Share of the contrast in one step from which an edge counts as drawn without grey."""
BEHIND, SAMPLES, ONE = np.int64(4), 10, np.int64(1)
"""Where in a profile the obstacle pixel lies, its samples, and the step between them; typed, so
that kernels are compiled for numbers and not once more for these."""
CHOSEN, SLANTED, CLEAR, INSIDE, OUTSIDE = 1, 2, 4, 8, 16
"""A crack gives a point; the border runs aslant; both plateaus are there; the profile lies in
the picture; the free pixel does not."""
BLOCK = 16
"""Cracks that share their plateaus."""
OUT_X = np.array([0, 1, 0, -1])
OUT_Y = np.array([-1, 0, 1, 0])
"""From a crack's obstacle pixel to its free one, by the walk's direction."""


@njit(cache=True, nogil=True)
def _probit(w):
    """The inverse normal distribution near its middle, but for a factor; w in [-0.5, 0.5]."""
    if w > 0.5:
        w = 0.5
    elif w < -0.5:
        w = -0.5
    q = w * w
    return w * (1.0 + q * (1.047198 + q * (2.30291 + q * 6.0)))


@njit(cache=True, nogil=True)
def edge_points(grey, mask, level, xs, ys, directions, starts):
    """Sub-pixel points of every border, in order.

    ``grey`` (h, w), obstacles dark; ``mask`` the padded mask; ``level`` the threshold.
    Returns ``(points, point_starts, slope, crispness)``: (k, 2) float64, per border the index
    of its first point, the mean step of the smoothed profile at the edge as a share of the
    contrast, and the share of slanted cracks with a full step.
    """
    borders = starts.shape[0] - 1
    points = np.empty((xs.shape[0], 2), np.float64)
    point_starts = np.empty(borders + 1, np.int64)
    longest = 0
    for b in range(borders):
        longest = max(longest, starts[b + 1] - starts[b])
    dark = np.empty(longest, np.float64)
    light = np.empty(longest, np.float64)
    flags = np.empty(longest, np.int8)
    blocks = longest // BLOCK + 1
    sums = np.empty((blocks, 4), np.float64)
    plateaus = np.empty((blocks, 2), np.float64)
    profile = np.empty(SAMPLES, grey.dtype)
    totals = np.zeros(4)
    count = np.int64(0)
    for b in range(borders):
        first = starts[b]
        n = starts[b + 1] - first
        point_starts[b] = count
        _look_beside(grey, mask, level, xs, ys, directions, first, n, profile, flags, dark, light)
        _find_plateaus(flags, dark, light, n, sums, plateaus)
        count = _locate(
            grey, xs, ys, directions, first, n, level, profile, flags, dark, light, plateaus,
            totals, points, count,
        )  # fmt: skip
    point_starts[borders] = count
    slope = totals[0] / totals[1] if totals[1] > 0 else 0.4
    crispness = totals[2] / totals[3] if totals[3] > 0 else 0.0
    return points[:count], point_starts, slope, crispness


@njit(cache=True, nogil=True)
def _look_beside(grey, mask, level, xs, ys, directions, first, n, profile, flags, dark, light):
    """How every crack lies, and the grey values of the plateaus beside those that are clear."""
    height, width = grey.shape
    stride = mask.shape[1]
    flat_mask = mask.reshape(-1)
    flat_grey = grey.reshape(-1)
    for i in range(n):
        x = np.int64(xs[first + i])
        y = np.int64(ys[first + i])
        direction = directions[first + i]
        nx = OUT_X[direction]
        ny = OUT_Y[direction]
        ahead = i + REACH
        while ahead >= n:
            ahead -= n
        behind = i - REACH
        while behind < 0:
            behind += n
        da = directions[first + ahead]
        db = directions[first + behind]
        # twice the way between the cracks' middles
        dx = 2 * (np.int64(xs[first + ahead]) - xs[first + behind]) + OUT_X[da] - OUT_X[db]
        dy = 2 * (np.int64(ys[first + ahead]) - ys[first + behind]) + OUT_Y[da] - OUT_Y[db]
        across = abs(dx * nx + dy * ny)
        along = abs(dx * ny) + abs(dy * nx)
        flag = CHOSEN if across <= along else 0
        if across > 1:
            flag |= SLANTED
        if 4 <= x < width - 5 and 4 <= y < height - 5:
            flag |= INSIDE
            step = ny * stride + nx
            at = (y + 1) * stride + x + 1
            if (
                flat_mask[at - step] & flat_mask[at - 2 * step]
                & ~(flat_mask[at + 2 * step] | flat_mask[at + 3 * step]) & 1
            ) != 0:  # fmt: skip
                flag |= CLEAR
                step = ny * width + nx
                at = y * width + x
                dark[i] = _dark(flat_grey, at, step, level)
                light[i] = _light(flat_grey, at, step, level)
        else:
            if not (0 <= x + nx < width and 0 <= y + ny < height):
                flag |= OUTSIDE
            if _is_clear(mask, x, y, nx, ny, width, height):
                flag |= CLEAR
                _take_profile(grey, x, y, nx, ny, profile)
                dark[i] = _dark(profile, BEHIND, ONE, level)
                light[i] = _light(profile, BEHIND, ONE, level)
        flags[i] = flag


@njit(cache=True, nogil=True)
def _take_profile(grey, x, y, nx, ny, profile):
    """The grey values across a crack; beyond the picture its last pixel goes on."""
    height, width = grey.shape
    for k in range(SAMPLES):
        px = min(max(x + (k - BEHIND) * nx, 0), width - 1)
        py = min(max(y + (k - BEHIND) * ny, 0), height - 1)
        profile[k] = grey[py, px]


@njit(cache=True, nogil=True)
def _is_clear(mask, x, y, nx, ny, width, height):
    """Three obstacle pixels on one side and three free ones on the other, near the margin."""
    for k in range(1, 3):
        px = x - k * nx
        py = y - k * ny
        if px < 0 or py < 0 or px >= width or py >= height or mask[py + 1, px + 1] & 1 == 0:
            return False
    for k in range(1, 4):
        px = x + k * nx
        py = y + k * ny
        if px < 0 or py < 0 or px >= width or py >= height:
            return k > 1
        if mask[py + 1, px + 1] & 1:
            return False
    return True


@njit(cache=True, nogil=True)
def _dark(values, at, step, level):
    """The obstacle's own grey beside a clear crack: of two pixels, or one where that is light.

    ``values[at]`` is the crack's obstacle pixel, ``step`` leads to the free one.
    """
    near = np.float64(values[at - 2 * step])
    mean = 0.5 * (near + values[at - 3 * step])
    return near if mean > level else mean


@njit(cache=True, nogil=True)
def _light(values, at, step, level):
    """The free ground's grey beside a clear crack."""
    near = np.float64(values[at + 3 * step])
    mean = 0.5 * (near + values[at + 4 * step])
    return near if mean < level else mean


@njit(cache=True, nogil=True)
def _find_plateaus(flags, dark, light, n, sums, plateaus):
    """Dark and light for every block of cracks, from what lies within STRETCH of it.

    Near a corner the plateaus are not reached, so that the second round leaves out what is
    lighter or darker than the first round's mean. -1 where nothing is clear.
    """
    blocks = (n + BLOCK - 1) // BLOCK
    for again in range(2):
        for j in range(blocks):
            d = 0.0
            darks = 0.0
            lt = 0.0
            lights = 0.0
            darkest = plateaus[j, 0] + 1e-9 if again else 1e9
            lightest = plateaus[j, 1] - 1e-9 if again else -1e9
            for i in range(j * BLOCK, min(j * BLOCK + BLOCK, n)):
                if flags[i] & CLEAR:
                    if dark[i] <= darkest:
                        d += dark[i]
                        darks += 1.0
                    if light[i] >= lightest:
                        lt += light[i]
                        lights += 1.0
            sums[j, 0] = d
            sums[j, 1] = darks
            sums[j, 2] = lt
            sums[j, 3] = lights
        reach = STRETCH // BLOCK
        for j in range(blocks):
            d = 0.0
            darks = 0.0
            lt = 0.0
            lights = 0.0
            first = j - reach
            last = j + reach
            if 2 * reach + 1 >= blocks:
                first = 0
                last = blocks - 1
            for k in range(first, last + 1):
                m = k
                if k < 0:
                    m = k + blocks
                elif k >= blocks:
                    m = k - blocks
                d += sums[m, 0]
                darks += sums[m, 1]
                lt += sums[m, 2]
                lights += sums[m, 3]
            plateaus[j, 0] = d / darks if darks > 0.0 and lights > 0.0 else -1.0
            plateaus[j, 1] = lt / lights if darks > 0.0 and lights > 0.0 else -1.0


@njit(cache=True, nogil=True)
def _locate(
    grey, xs, ys, directions, first, n, level, profile, flags, dark, light, plateaus,
    totals, points, count,
):  # fmt: skip
    """Where the light crosses the half level at every chosen crack; returns the next count.

    ``totals``: the sum and number of slopes, full steps and slanted cracks.
    """
    width = grey.shape[1]
    flat_grey = grey.reshape(-1)
    for i in range(n):
        flag = flags[i]
        if not flag & CHOSEN:
            continue
        x = np.int64(xs[first + i])
        y = np.int64(ys[first + i])
        nx = OUT_X[directions[first + i]]
        ny = OUT_Y[directions[first + i]]
        t = 0.5
        if flag & OUTSIDE:
            t = 0.5
        elif not flag & CLEAR:
            g0 = np.float64(grey[y, x])
            g1 = np.float64(grey[y + ny, x + nx])
            if g1 > level and g1 > g0 and g0 < level:
                t = (level - g0) / (g1 - g0)
        else:
            d = plateaus[i // BLOCK, 0]
            lt = plateaus[i // BLOCK, 1]
            if lt < 0.0:
                d = dark[i]
                lt = light[i]
            if flag & INSIDE:
                at = y * width + x
                t = _crossing(flat_grey, at, ny * width + nx, d, lt, flag & SLANTED, totals)
            else:
                _take_profile(grey, x, y, nx, ny, profile)
                t = _crossing(profile, BEHIND, ONE, d, lt, flag & SLANTED, totals)
        points[count, 0] = x + t * nx
        points[count, 1] = y + t * ny
        count += 1
    return count


@njit(cache=True, nogil=True)
def _crossing(values, at, step, dark, light, slanted, totals):
    """Where the smoothed profile crosses the half level, in pixels from the obstacle pixel."""
    contrast = light - dark
    if contrast <= 0.0:
        return 0.5
    half = 0.5 * (light + dark)
    share = 1.0 / contrast
    if slanted:
        totals[3] += 1.0
        if np.float64(values[at + step]) - values[at] >= CRISP * contrast:
            totals[2] += 1.0
    k = 0
    s0 = _smoothed(values, at, step)
    s1 = _smoothed(values, at + step, step)
    while s0 >= half and k > -WANDER:
        k -= 1
        s1 = s0
        s0 = _smoothed(values, at + k * step, step)
    while s1 < half and k < WANDER:
        k += 1
        s0 = s1
        s1 = _smoothed(values, at + (k + 1) * step, step)
    if s0 < half <= s1:
        p0 = _probit((s0 - half) * share)
        p1 = _probit((s1 - half) * share)
        if p1 - p0 > 1e-6:
            totals[0] += (s1 - s0) * share
            totals[1] += 1.0
            return k - p0 / (p1 - p0)
    return 0.5


@njit(cache=True, nogil=True)
def _smoothed(values, at, step):
    """The profile across the crack, smoothed."""
    value = TAP0 * values[at]
    value += TAP1 * (np.float64(values[at - step]) + values[at + step])
    value += TAP2 * (np.float64(values[at - 2 * step]) + values[at + 2 * step])
    return value
