"""Fit of a marker's known pattern to its pixels (``vision.markers.marker_pattern``).

Pattern coordinates u, v are in cells from the upright marker's top left corner, v down.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import OWNING

UNKNOWNS = 13
"""u = p0 a + p1 b + p2, v = p3 a + p4 b + p5; the blur, pixels; dark and contrast, each a plane of
three."""
LEAST_PIXELS = 8 * UNKNOWNS
"""Fewer say too little."""

EDGE_PX, _BLUR_PX = 1.2, 2.5
"""Distance outside the border's edge at which the rim is read, and inside at which it no longer
shows."""
_LEAST_LIGHT = 0.8
"""Least share of the contrast of a paper rim."""
_START_BLUR_PX = 0.8
_LEAST_BLUR_PX = 0.25
_MOST_BLUR_CELLS = 0.45
_MOST_STEPS = 12
_DONE_CELLS, _RESTS_CELLS = 1e-3, 2e-3
"""Step that ends the fit, and one that still counts as at rest. With 2e-5 the error of 150 rendered
markers of 25 to 100 px is the same, 0.0059 px rms."""
_HUBER = 2.5
"""Residuals beyond this multiple of their rms weigh less."""
_MIN_CONTRAST = 12.0
_LEAST_PIVOT = 1e-12
"""Least pivot of a matrix with a diagonal of ones: less is rounding."""
_MAX_MISFIT = 0.3
"""The residuals' rms as a share of the contrast."""
_BLOCK = 64
"""Pixels summed at a time."""


@njit(**OWNING)
def settle_pattern(pixels, bits, state, metric):
    """Run Gauss-Newton on ``state`` until it rests; True if the pattern is there.

    ``pixels`` (n, 3) from `marker_pixels`, ``state`` (13,) with a first guess of the affine map.
    """
    if len(pixels) < LEAST_PIXELS:
        return False
    grey = np.zeros(256, dtype=np.int64)
    for i in range(len(pixels)):
        grey[int(pixels[i, 2])] += 1
    dark, light = _quantile(grey, 0.15), _quantile(grey, 0.85)
    state[6:] = 0.0
    state[6], state[7], state[10] = _START_BLUR_PX, dark, light - dark
    per_px = max(pixel_length(state[0], state[1], metric), pixel_length(state[3], state[4], metric))
    most_blur_px = max(_MOST_BLUR_CELLS / per_px, _LEAST_BLUR_PX)
    matrix, step = np.empty((UNKNOWNS, UNKNOWNS)), np.empty(UNKNOWNS)
    limit = math.inf
    rms = size = math.inf
    for _ in range(_MOST_STEPS):
        rms = normal_equations(pixels, bits, state, limit, metric, matrix, step)
        limit = _HUBER * rms
        if not solve(matrix, step):
            return False
        # a step over more than a cell would land on the next grid line
        size = 0.0
        for j in range(6):
            size = max(size, abs(step[j]))
        shrink = min(1.0, 0.5 / max(size, 1e-12))
        for j in range(UNKNOWNS):
            state[j] += step[j] * shrink
        state[6] = min(max(state[6], _LEAST_BLUR_PX), most_blur_px)
        if size < _DONE_CELLS:
            break
    contrast = state[10]
    return bool(size <= _RESTS_CELLS and contrast > _MIN_CONTRAST and rms < _MAX_MISFIT * contrast)


@njit(**OWNING)
def has_light_rim(pixels, state, cells, cell_px):
    """True if the rim is paper along each side.

    A marker may be cut tightly.
    """
    beyond = EDGE_PX / cell_px
    inside = np.zeros(256, dtype=np.int64)
    sides = np.zeros((4, 256), dtype=np.int64)
    for i in range(len(pixels)):
        a, b, grey = pixels[i, 0], pixels[i, 1], int(pixels[i, 2])
        u = state[0] * a + state[1] * b + state[2]
        v = state[3] * a + state[4] * b + state[5]
        off_u, off_v = max(-u, u - cells), max(-v, v - cells)
        outmost = max(off_u, off_v)
        if outmost < -0.5:
            inside[grey] += 1
        elif outmost > beyond and min(off_u, off_v) <= 0.0:
            side = (0 if u < 0.0 else 1) if off_u > off_v else (2 if v < 0.0 else 3)
            sides[side, grey] += 1
    dark, paper = _quantile(inside, 0.15), _quantile(inside, 0.95)
    for side in range(4):
        if sides[side].sum() == 0:
            continue
        light = (_quantile(sides[side], 0.5) - dark) / max(paper - dark, 1.0)
        if light < _LEAST_LIGHT:
            return False
    return True


@njit(**OWNING)
def inner_pixels(pixels, state, cells, cell_px):
    """Pixels affected by neither the rim nor the border's edge."""
    inmost = min(_BLUR_PX / cell_px, 0.5)
    is_inner = np.empty(len(pixels), dtype=np.bool_)
    for i in range(len(pixels)):
        a, b = pixels[i, 0], pixels[i, 1]
        u = state[0] * a + state[1] * b + state[2]
        v = state[3] * a + state[4] * b + state[5]
        is_inner[i] = max(-u, u - cells, -v, v - cells) < -inmost
    return pixels[is_inner]


@njit(**OWNING)
def _quantile(counts, share):
    place = share * (counts.sum() - 1)
    first = math.floor(place)
    below = above = -1
    passed = 0
    for value in range(256):
        passed += counts[value]
        if below < 0 and passed > first:
            below = value
        if passed > first + 1:
            above = value
            break
    if below < 0:
        return 0.0
    above = below if above < 0 else above
    return float(below + (place - first) * (above - below))


@njit(**OWNING)
def solve(matrix, right):
    """Solve a symmetric system in place by Cholesky's factors, scaled to a diagonal of ones.

    False if not positive definite to rounding.
    """
    count = len(right)
    scale = np.empty(count)
    for j in range(count):
        if not matrix[j, j] > 0.0:
            return False
        scale[j] = 1.0 / math.sqrt(matrix[j, j])
    for j in range(count):
        for k in range(j + 1):
            total = matrix[j, k] * scale[j] * scale[k]
            for m in range(k):
                total -= matrix[j, m] * matrix[k, m]
            if k < j:
                matrix[j, k] = total / matrix[k, k]
            elif total > _LEAST_PIVOT:
                matrix[j, j] = math.sqrt(total)
            else:
                return False
    for j in range(count):
        total = right[j] * scale[j]
        for m in range(j):
            total -= matrix[j, m] * right[m]
        right[j] = total / matrix[j, j]
    for j in range(count - 1, -1, -1):
        total = right[j]
        for m in range(j + 1, count):
            total -= matrix[m, j] * right[m]
        right[j] = total / matrix[j, j]
    for j in range(count):
        right[j] *= scale[j]
    return True


@njit(**OWNING)
def normal_equations(pixels, bits, state, limit, metric, out_matrix, out_right):
    """Sum one Gauss-Newton step over all pixels, the matrix's lower half only; return the residual
    rms.

    ``bits`` (n, n) is 1 for light; residuals beyond ``limit`` weigh less (Huber). ``metric`` (2, 2)
    is J J^T of the plane's a, b by raw pixels: a blur round in the picture is not round in the
    plane. The blur is narrow compared with a cell, so only the nearest grid lines matter. Pixels
    among alike cells depend only on light and dark and are summed apart.
    """
    out_matrix[:] = 0.0
    out_right[:] = 0.0
    cells = len(bits)
    per_px_u = pixel_length(state[0], state[1], metric)
    per_px_v = pixel_length(state[3], state[4], metric)
    spread_u, spread_v = state[6] * per_px_u, state[6] * per_px_v
    rows, weighted = np.empty((UNKNOWNS + 2, _BLOCK)), np.empty(_BLOCK)
    flat = np.zeros((2, 9))
    count = 0
    total = 0.0
    for i in range(len(pixels)):
        a, b = pixels[i, 0], pixels[i, 1]
        u = state[0] * a + state[1] * b + state[2]
        v = state[3] * a + state[4] * b + state[5]
        line_u = min(max(math.floor(u + 0.5), 0), cells)
        line_v = min(max(math.floor(v + 0.5), 0), cells)
        above_left = _cell(bits, line_u - 1, line_v - 1)
        above_right = _cell(bits, line_u, line_v - 1)
        below_left = _cell(bits, line_u - 1, line_v)
        below_right = _cell(bits, line_u, line_v)
        x, y = u / cells - 0.5, v / cells - 0.5
        contrast = state[10] + state[11] * x + state[12] * y
        dark = state[7] + state[8] * x + state[9] * y
        if above_left == above_right == below_left == below_right:
            error = pixels[i, 2] - dark - contrast * above_left
            weight = 1.0 if abs(error) <= limit else limit / abs(error)
            total += error * error
            _add_flat(flat, int(above_left), weight, x, y, error)
            continue
        du, dv = (u - line_u) / spread_u, (v - line_v) / spread_v
        p, slope_p = blurred_step(du)
        q, slope_q = blurred_step(dv)
        above = above_left + (above_right - above_left) * p
        below = below_left + (below_right - below_left) * p
        light = above + (below - above) * q
        along_u = (above_right - above_left) * (1.0 - q) + (below_right - below_left) * q
        light_u = contrast * along_u * slope_p / spread_u
        light_v = contrast * (below - above) * slope_q / spread_v
        error = pixels[i, 2] - dark - contrast * light
        total += error * error
        weight = 1.0 if abs(error) <= limit else limit / abs(error)
        rows[0, count], rows[1, count], rows[2, count] = light_u * a, light_u * b, light_u
        rows[3, count], rows[4, count], rows[5, count] = light_v * a, light_v * b, light_v
        rows[6, count] = -(light_u * du * per_px_u + light_v * dv * per_px_v)
        rows[7, count], rows[8, count], rows[9, count] = 1.0, x, y
        rows[10, count], rows[11, count], rows[12, count] = light, light * x, light * y
        rows[UNKNOWNS, count], rows[UNKNOWNS + 1, count] = error, weight
        count += 1
        if count == _BLOCK:
            _add_products(rows, weighted, count, out_matrix, out_right)
            count = 0
    _add_products(rows, weighted, count, out_matrix, out_right)
    _add_alike(flat, out_matrix, out_right)
    return math.sqrt(total / max(len(pixels), 1))


@njit(**{**OWNING, "fastmath": {"reassoc", "contract"}})
def _add_products(rows, weighted, count, out_matrix, out_right):
    """Sum the products of ``count`` pixels' derivatives with each other and with the errors.

    The last two rows are errors and weights; ``weighted`` is scratch space.
    """
    for j in range(UNKNOWNS):
        total = 0.0
        for i in range(count):
            weighted[i] = rows[UNKNOWNS + 1, i] * rows[j, i]
            total += weighted[i] * rows[UNKNOWNS, i]
        out_right[j] += total
        for k in range(j + 1):
            total = 0.0
            for i in range(count):
                total += weighted[i] * rows[k, i]
            out_matrix[j, k] += total


@njit(**OWNING)
def _add_flat(sums, light, weight, x, y, error):
    """Add a pixel in the dark (row 0) or the light (row 1), away from edges."""
    sums[light, 0] += weight
    sums[light, 1] += weight * x
    sums[light, 2] += weight * y
    sums[light, 3] += weight * x * x
    sums[light, 4] += weight * x * y
    sums[light, 5] += weight * y * y
    sums[light, 6] += weight * error
    sums[light, 7] += weight * error * x
    sums[light, 8] += weight * error * y


@njit(**OWNING)
def _add_alike(flat, out_matrix, out_right):
    """Add the sums of dark (row 0) and light pixels (row 1), which feel the contrast."""
    for light in range(2):
        sums = flat[light]
        for rows in range(7, 8 + 3 * light, 3):
            for columns in range(7, rows + 1, 3):
                m = out_matrix
                m[rows, columns] += sums[0]
                m[rows + 1, columns] += sums[1]
                m[rows + 2, columns] += sums[2]
                m[rows + 1, columns + 1] += sums[3]
                m[rows + 2, columns + 1] += sums[4]
                m[rows + 2, columns + 2] += sums[5]
                if rows > columns:
                    m[rows, columns + 1] += sums[1]
                    m[rows, columns + 2] += sums[2]
                    m[rows + 1, columns + 2] += sums[4]
            for k in range(3):
                out_right[rows + k] += sums[6 + k]


@njit(**OWNING)
def pixel_length(p, q, metric):
    """Change of u = p a + q b over one pixel along its gradient."""
    return math.sqrt(p * p * metric[0, 0] + 2.0 * p * q * metric[0, 1] + q * q * metric[1, 1])


@njit(**OWNING)
def _cell(bits, column, row):
    if column < 0 or row < 0 or column >= len(bits) or row >= len(bits):
        return 1.0
    return float(bits[row, column])


@njit(**OWNING)
def blurred_step(t):
    """Normal distribution and its density, within 1e-7.

    Abramowitz and Stegun, Handbook of mathematical functions (1964), 26.2.17.
    """
    away = abs(t)
    if away > 6.0:
        return (1.0 if t > 0.0 else 0.0), 0.0
    density = 0.3989422804014327 * math.exp(-0.5 * t * t)
    k = 1.0 / (1.0 + 0.2316419 * away)
    series = -1.821255978 + k * 1.330274429
    series = 0.319381530 + k * (-0.356563782 + k * (1.781477937 + k * series))
    tail = density * k * series
    return (1.0 - tail if t > 0.0 else tail), density
