"""The compiled loops of ``vision.markers.marker_pattern``: a marker's pixels, and the fit to them.

Raw pixels, centres at integers; ``lens`` as ``vision.calibration.lens_model`` has it.
Pattern coordinates u, v are in cells from the top left corner of the upright marker, v down.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

import planner.scene.compile_options  # noqa: F401 (chooses how kernels are compiled and kept)
from vision.calibration.calibration_kernels import undistort
from vision.calibration.lens_model import LensArrays

UNKNOWNS = 13
"""u = p0 a + p1 b + p2, v = p3 a + p4 b + p5; the blur, pixels; three numbers for the dark,
three for the contrast, each a plane over the marker."""
LEAST_PIXELS = 8 * UNKNOWNS
"""Fewer say too little."""

_EDGE_PX, _BLUR_PX = 1.2, 2.5
"""Beyond the border's edge the rim is looked at so far out, and within it no floor is felt."""
_LEAST_LIGHT = 0.8
"""Of the contrast that a rim of paper shows at least."""
_START_BLUR_PX = 0.8
_LEAST_BLUR_PX = 0.25
_MOST_BLUR_CELLS = 0.45
_MOST_STEPS = 12
_DONE_CELLS, _RESTS_CELLS = 1e-3, 2e-3
"""A step after which none is made, and one that still counts as at rest. With 2e-5 the error of 150
rendered markers of 25 to 100 px is the same, 0.0059 px rms, and takes two steps more."""
_HUBER = 2.5
"""Residuals beyond so many of their own rms weigh less."""
_MIN_CONTRAST = 12.0
_LEAST_PIVOT = 1e-12
"""Of a matrix with a diagonal of ones: what is less is rounding."""
_MAX_MISFIT = 0.3
"""The residuals' rms as a share of the contrast."""


@njit(cache=True, nogil=True, fastmath=False)
def collect_pixels(
    grey: NDArray[np.uint8],
    box: tuple[int, int, int, int],
    lens: LensArrays,
    plane_from_pixel: NDArray[np.float64],
    pattern_from_plane: NDArray[np.float64],
    cells: int,
    rim: float,
    every: int,
) -> NDArray[np.float64]:
    """Rows (n, 3) of a, b, grey value: the pixels of ``box`` that lie on the marker or its rim.

    a, b are the pixel's place in the plane; ``box`` is x0, y0, x1, y1 with the ends included,
    inside ``grey``; ``pattern_from_plane`` (6,) the first guess, ``rim`` a width in cells. Of each
    row one pixel in ``every`` is taken, of the next row the ones beside, so that every edge is
    crossed at all places.
    """
    x0, y0, x1, y1 = box
    rows = np.empty((((x1 - x0) // every + 1) * (y1 - y0 + 1), 3))
    count = 0
    h, p = plane_from_pixel, pattern_from_plane
    for y in range(y0, y1 + 1):
        for x in range(x0 + (y - y0) % every, x1 + 1, every):
            px, py = undistort(float(x), float(y), lens)
            w = h[2, 0] * px + h[2, 1] * py + h[2, 2]
            a = (h[0, 0] * px + h[0, 1] * py + h[0, 2]) / w
            b = (h[1, 0] * px + h[1, 1] * py + h[1, 2]) / w
            u, v = p[0] * a + p[1] * b + p[2], p[3] * a + p[4] * b + p[5]
            if u < -rim or v < -rim or u > cells + rim or v > cells + rim:
                continue
            rows[count, 0] = a
            rows[count, 1] = b
            rows[count, 2] = grey[y, x]
            count += 1
    return rows[:count]


@njit(cache=True, nogil=True, fastmath=False)
def settle_pattern(
    pixels: NDArray[np.float64],
    bits: NDArray[np.float64],
    state: NDArray[np.float64],
    metric: NDArray[np.float64],
    cell_px: float,
) -> bool:
    """Gauss-Newton until nothing moves; whether the pattern is there. Changes ``state``.

    ``pixels`` (n, 3) from `collect_pixels`, ``state`` (13,) with a first guess of the affine map.
    """
    cells = len(bits)
    grey = np.zeros(256, dtype=np.int64)
    for i in range(len(pixels)):
        grey[int(pixels[i, 2])] += 1
    dark, light = _quantile(grey, 0.15), _quantile(grey, 0.85)
    state[6], state[7], state[10] = _START_BLUR_PX, dark, light - dark
    pixels = _on_paper(pixels, state, cells, cell_px)
    if len(pixels) < LEAST_PIXELS:
        return False
    # cells that a pixel crosses, along u and along v
    per_px = max(_length(state[0], state[1], metric), _length(state[3], state[4], metric))
    most_blur_px = max(_MOST_BLUR_CELLS / per_px, _LEAST_BLUR_PX)
    matrix, step = np.empty((UNKNOWNS, UNKNOWNS)), np.empty(UNKNOWNS)
    limit = math.inf
    rms = size = math.inf
    for _ in range(_MOST_STEPS):
        rms = _normal_equations(pixels, bits, state, limit, metric, matrix, step)
        limit = _HUBER * rms
        if not _solve(matrix, step):
            return False
        # A step over more than a cell would land on the next grid line.
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


@njit(cache=True, nogil=True, fastmath=False)
def _on_paper(
    pixels: NDArray[np.float64], state: NDArray[np.float64], cells: int, cell_px: float
) -> NDArray[np.float64]:
    """The pixels, without the rim and the border's edge where the rim is not light.

    A marker may be cut tightly, and the floor beside it is no part of the pattern: then the inner
    cells alone say where it is.
    """
    beyond = _EDGE_PX / cell_px
    inside = np.zeros(256, dtype=np.int64)
    sides = np.zeros((4, 256), dtype=np.int64)
    outmost = np.empty(len(pixels))
    off = np.empty(4)
    for i in range(len(pixels)):
        a, b, grey = pixels[i, 0], pixels[i, 1], int(pixels[i, 2])
        u = state[0] * a + state[1] * b + state[2]
        v = state[3] * a + state[4] * b + state[5]
        off[0], off[1], off[2], off[3] = -u, -v, u - cells, v - cells
        outmost[i] = off.max()
        inside[grey] += outmost[i] < -0.5
        if (off > 0.0).sum() != 1:  # along a side, but not at its corners
            continue
        for side in range(4):
            sides[side, grey] += off[side] > beyond
    dark, paper = _quantile(inside, 0.15), _quantile(inside, 0.95)
    for side in range(4):
        if sides[side].sum() == 0:
            continue
        light = (_quantile(sides[side], 0.5) - dark) / max(paper - dark, 1.0)
        if light < _LEAST_LIGHT:
            return pixels[outmost < -min(_BLUR_PX / cell_px, 0.5)]
    return pixels


@njit(cache=True, nogil=True, fastmath=False)
def _quantile(counts: NDArray[np.int64], share: float) -> float:
    """The quantile of whole grey values by their counts (256,), linear between two values."""
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


@njit(cache=True, nogil=True, fastmath=False)
def _solve(matrix: NDArray[np.float64], right: NDArray[np.float64]) -> bool:
    """Solves a symmetric system in place, by Cholesky's factors, scaled to a diagonal of ones.

    False where the matrix is not positive definite to rounding: some unknown is not seen.
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


@njit(cache=True, nogil=True, fastmath=False)
def _normal_equations(
    pixels: NDArray[np.float64],
    bits: NDArray[np.float64],
    state: NDArray[np.float64],
    limit: float,
    metric: NDArray[np.float64],
    out_matrix: NDArray[np.float64],
    out_right: NDArray[np.float64],
) -> float:
    """One Gauss-Newton step's sums over all pixels, of the matrix its lower half; returns the rms
    of the residuals.

    ``bits`` (n, n) is 1 where a cell is light; residuals beyond ``limit`` weigh less (Huber).
    ``metric`` (2, 2) is J J^T of the plane's a, b by raw pixels: a blur that is round in the
    picture is none in the plane, seen from the side or through a wide lens. The pattern is blurred
    by a Gaussian that is narrow against a cell, so that only the nearest grid line of each
    direction is felt at a pixel.
    """
    out_matrix[:] = 0.0
    out_right[:] = 0.0
    cells = len(bits)
    per_px_u = _length(state[0], state[1], metric)
    per_px_v = _length(state[3], state[4], metric)
    spread_u, spread_v = state[6] * per_px_u, state[6] * per_px_v
    row = np.empty(UNKNOWNS)
    total = weights = 0.0
    for i in range(len(pixels)):
        a, b = pixels[i, 0], pixels[i, 1]
        u = state[0] * a + state[1] * b + state[2]
        v = state[3] * a + state[4] * b + state[5]
        line_u = min(max(math.floor(u + 0.5), 0), cells)
        line_v = min(max(math.floor(v + 0.5), 0), cells)
        du, dv = (u - line_u) / spread_u, (v - line_v) / spread_v
        p, q = _share(du), _share(dv)
        slope_p, slope_q = _slope(du) / spread_u, _slope(dv) / spread_v
        above_left = _cell(bits, line_u - 1, line_v - 1)
        above_right = _cell(bits, line_u, line_v - 1)
        below_left = _cell(bits, line_u - 1, line_v)
        below_right = _cell(bits, line_u, line_v)
        above = above_left + (above_right - above_left) * p
        below = below_left + (below_right - below_left) * p
        light = above + (below - above) * q
        along_u = (above_right - above_left) * (1.0 - q) + (below_right - below_left) * q
        light_u, light_v = along_u * slope_p, (below - above) * slope_q
        x, y = u / cells - 0.5, v / cells - 0.5
        contrast = state[10] + state[11] * x + state[12] * y
        error = pixels[i, 2] - (state[7] + state[8] * x + state[9] * y + contrast * light)
        total += error * error
        weight = 1.0 if abs(error) <= limit else limit / abs(error)
        weights += weight
        row[0], row[1], row[2] = contrast * light_u * a, contrast * light_u * b, contrast * light_u
        row[3], row[4], row[5] = contrast * light_v * a, contrast * light_v * b, contrast * light_v
        row[6] = -contrast * (light_u * du * per_px_u + light_v * dv * per_px_v)
        row[7], row[8], row[9] = 1.0, x, y
        row[10], row[11], row[12] = light, light * x, light * y
        for j in range(UNKNOWNS):
            scaled = weight * row[j]
            if scaled == 0.0:
                continue
            out_right[j] += scaled * error
            for k in range(j + 1):
                out_matrix[j, k] += scaled * row[k]
    return math.sqrt(total / max(len(pixels), 1))


@njit(cache=True, nogil=True, fastmath=False)
def _length(p: float, q: float, metric: NDArray[np.float64]) -> float:
    """How far u = p a + q b goes with one pixel along its own gradient."""
    return math.sqrt(p * p * metric[0, 0] + 2.0 * p * q * metric[0, 1] + q * q * metric[1, 1])


@njit(cache=True, nogil=True, fastmath=False)
def _cell(bits: NDArray[np.float64], column: int, row: int) -> float:
    """A cell's value; the marker's rim is light."""
    if column < 0 or row < 0 or column >= len(bits) or row >= len(bits):
        return 1.0
    return float(bits[row, column])


@njit(cache=True, nogil=True, fastmath=False)
def _share(t: float) -> float:
    """The normal distribution."""
    return 0.5 * math.erfc(-t * 0.7071067811865476)


@njit(cache=True, nogil=True, fastmath=False)
def _slope(t: float) -> float:
    """Its density."""
    return 0.3989422804014327 * math.exp(-0.5 * t * t)
