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


@njit(cache=True, nogil=True)
def _clamped(value, limit):
    if value < 0:
        return 0
    if value >= limit:
        return limit - 1
    return value


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
    height, width = grey.shape
    total = xs.shape[0]
    borders = starts.shape[0] - 1
    out_x = np.array([0, 1, 0, -1])
    out_y = np.array([-1, 0, 1, 0])
    points = np.empty((total, 2), np.float64)
    point_starts = np.empty(borders + 1, np.int64)
    longest = 0
    for b in range(borders):
        longest = max(longest, starts[b + 1] - starts[b])
    sums = np.empty((longest + 1, 3), np.float64)
    again = np.empty((longest + 1, 4), np.float64)
    beside = np.empty((longest, 2), np.float64)
    plateau = np.empty(4, np.float64)
    chosen = np.empty(longest, np.bool_)
    clear = np.empty(longest, np.bool_)
    slanted = np.empty(longest, np.bool_)
    count = 0
    slope_sum = 0.0
    slope_count = 0
    crisp_count = 0
    slanted_count = 0
    for b in range(borders):
        first = starts[b]
        n = starts[b + 1] - first
        point_starts[b] = count
        sums[0] = 0.0
        again[0] = 0.0
        for i in range(n):
            x = xs[first + i]
            y = ys[first + i]
            direction = directions[first + i]
            nx = out_x[direction]
            ny = out_y[direction]
            ahead = i + REACH
            while ahead >= n:
                ahead -= n
            behind = i - REACH
            while behind < 0:
                behind += n
            da = directions[first + ahead]
            db = directions[first + behind]
            dx = xs[first + ahead] - xs[first + behind] + 0.5 * (out_x[da] - out_x[db])
            dy = ys[first + ahead] - ys[first + behind] + 0.5 * (out_y[da] - out_y[db])
            across = abs(dx * nx + dy * ny)
            along = abs(dx * ny) + abs(dy * nx)
            chosen[i] = across <= along
            slanted[i] = across > 0.5
            # three obstacle pixels on one side and three free ones on the other
            good = True
            for k in range(1, 3):
                px = x - k * nx
                py = y - k * ny
                if px < 0 or py < 0 or px >= width or py >= height or mask[py + 1, px + 1] & 1 == 0:
                    good = False
                    break
            if good:
                for k in range(1, 4):
                    px = x + k * nx
                    py = y + k * ny
                    if px < 0 or py < 0 or px >= width or py >= height:
                        good = k > 1
                        break
                    if mask[py + 1, px + 1] & 1:
                        good = False
                        break
            clear[i] = good
            d = 0.0
            lt = 0.0
            if good:
                d = 0.5 * (
                    grey[_clamped(y - 2 * ny, height), _clamped(x - 2 * nx, width)]
                    + np.float64(grey[_clamped(y - 3 * ny, height), _clamped(x - 3 * nx, width)])
                )
                if d > level:
                    d = grey[y - 2 * ny, x - 2 * nx]
                lt = 0.5 * (
                    grey[_clamped(y + 3 * ny, height), _clamped(x + 3 * nx, width)]
                    + np.float64(grey[_clamped(y + 4 * ny, height), _clamped(x + 4 * nx, width)])
                )
                if lt < level:
                    lt = grey[_clamped(y + 3 * ny, height), _clamped(x + 3 * nx, width)]
            beside[i, 0] = d
            beside[i, 1] = lt
            sums[i + 1, 0] = sums[i, 0] + d
            sums[i + 1, 1] = sums[i, 1] + lt
            sums[i + 1, 2] = sums[i, 2] + (1.0 if good else 0.0)
        # near a corner the plateaus are not reached: average once more what is not grey
        for i in range(n):
            again[i + 1] = again[i]
            if not clear[i]:
                continue
            _around(sums, n, i, 3, plateau)
            if beside[i, 0] <= plateau[0] / plateau[2] + 1e-9:
                again[i + 1, 0] += beside[i, 0]
                again[i + 1, 2] += 1.0
            if beside[i, 1] >= plateau[1] / plateau[2] - 1e-9:
                again[i + 1, 1] += beside[i, 1]
                again[i + 1, 3] += 1.0
        for i in range(n):
            if not chosen[i]:
                continue
            x = xs[first + i]
            y = ys[first + i]
            nx = out_x[directions[first + i]]
            ny = out_y[directions[first + i]]
            px = x + nx
            py = y + ny
            t = 0.5
            if px < 0 or py < 0 or px >= width or py >= height:
                t = 0.5
            elif not clear[i]:
                g0 = np.float64(grey[y, x])
                g1 = np.float64(grey[py, px])
                if g1 > level and g1 > g0 and g0 < level:
                    t = (level - g0) / (g1 - g0)
            else:
                _around(again, n, i, 4, plateau)
                if plateau[2] > 0.0 and plateau[3] > 0.0:
                    d = plateau[0] / plateau[2]
                    lt = plateau[1] / plateau[3]
                else:
                    d = beside[i, 0]
                    lt = beside[i, 1]
                contrast = lt - d
                half = 0.5 * (lt + d)
                if contrast > 0.0:
                    if slanted[i]:
                        slanted_count += 1
                        if np.float64(grey[py, px]) - np.float64(grey[y, x]) >= CRISP * contrast:
                            crisp_count += 1
                    k = 0
                    s0 = _smoothed(grey, x, y, nx, ny, 0, width, height)
                    s1 = _smoothed(grey, x, y, nx, ny, 1, width, height)
                    while s0 >= half and k > -WANDER:
                        k -= 1
                        s1 = s0
                        s0 = _smoothed(grey, x, y, nx, ny, k, width, height)
                    while s1 < half and k < WANDER:
                        k += 1
                        s0 = s1
                        s1 = _smoothed(grey, x, y, nx, ny, k + 1, width, height)
                    if s0 < half <= s1:
                        p0 = _probit((s0 - half) / contrast)
                        p1 = _probit((s1 - half) / contrast)
                        if p1 - p0 > 1e-6:
                            t = k - p0 / (p1 - p0)
                            slope_sum += (s1 - s0) / contrast
                            slope_count += 1
            points[count, 0] = x + t * nx
            points[count, 1] = y + t * ny
            count += 1
    point_starts[borders] = count
    slope = slope_sum / slope_count if slope_count > 0 else 0.4
    crispness = crisp_count / slanted_count if slanted_count > 0 else 0.0
    return points[:count].copy(), point_starts, slope, crispness


@njit(cache=True, nogil=True)
def _around(sums, n, i, columns, out):
    """The sums over the cracks within STRETCH of crack i of a closed border."""
    lo = i - STRETCH
    hi = i + STRETCH
    for c in range(columns):
        if n <= 2 * STRETCH:
            out[c] = sums[n, c]
            continue
        out[c] = sums[min(hi, n), c] - sums[max(lo, 0), c]
        if lo < 0:
            out[c] += sums[n, c] - sums[n + lo, c]
        if hi > n:
            out[c] += sums[hi - n, c]


@njit(cache=True, nogil=True)
def _smoothed(grey, x, y, nx, ny, k, width, height):
    """The profile across the crack at k pixels from its obstacle pixel, smoothed."""
    x += k * nx
    y += k * ny
    value = TAP0 * grey[_clamped(y, height), _clamped(x, width)]
    value += TAP1 * (
        np.float64(grey[_clamped(y - ny, height), _clamped(x - nx, width)])
        + np.float64(grey[_clamped(y + ny, height), _clamped(x + nx, width)])
    )
    value += TAP2 * (
        np.float64(grey[_clamped(y - 2 * ny, height), _clamped(x - 2 * nx, width)])
        + np.float64(grey[_clamped(y + 2 * ny, height), _clamped(x + 2 * nx, width)])
    )
    return value
