"""The compiled loops of ``vision.markers.marker_pattern``: a marker's pixels and its normal
equations.

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
def normal_equations(
    pixels: NDArray[np.float64],
    bits: NDArray[np.float64],
    state: NDArray[np.float64],
    limit: float,
    metric: NDArray[np.float64],
    out_matrix: NDArray[np.float64],
    out_right: NDArray[np.float64],
) -> float:
    """One Gauss-Newton step's sums over all pixels; returns the rms of the residuals.

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
    for j in range(UNKNOWNS):
        for k in range(j):
            out_matrix[k, j] = out_matrix[j, k]
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
