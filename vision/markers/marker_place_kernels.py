"""From a picture and a quadrilateral to a marker's place and reading score.

Raw pixels, centres at integers; ``view`` is the arena's plane at the marker's height, in metres.
Corners in the order top left, top right, bottom right, bottom left of the upright marker; a
marker's ``bits`` (n, n), with the dark border, are 1 for light.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import OWNING
from vision.calibration.calibration_kernels import placed_at, seen_at
from vision.markers.marker_agreement_kernels import (
    LEAST_READ,
    NOT_READ,
    corner_error_px,
    corners_of,
    sides_agree,
    worst_cells,
)
from vision.markers.marker_kernels import AT_EDGE, FITTED, FOLDED, NO_FLOOR, UNREAD, fit_quad
from vision.markers.marker_pattern_kernels import (
    UNKNOWNS,
    has_light_rim,
    inner_pixels,
    settle_pattern,
)

NO_SIDES = math.inf
"""Standard error of corners that are a guess."""

_RIM_PX = 3.0
_RIM_CELLS = 0.75
"""Distance around the marker in which pixels are used: the rim is light for a cell at least."""
MOST_BOX_PIXELS = 12_000
"""Most pixels in the box around a marker; more are thinned out. From 200 px on the centre stays
within 0.01 px (``test_marker_pattern.py``)."""
_MAX_MOVE_PX = 1.5
"""Largest distance of the whole pattern's corners from where its sides meet: chosen."""
_MAX_MOVE_CELLS = 0.5
"""Largest move of the inner pattern's middle: derived, beyond half a cell the next cell's edges are
nearer."""
_STRETCH_PX = 24
"""Stretch of a row or column in which a pixel's place is a cubic's: within 1e-4 px of a wide lens's
(``test_marker_pattern.py``)."""


@njit(**OWNING)
def follow_marker(grey, marker, bits, view, out_m, out_px):
    """Reading score, 0 for unread, of a marker expected at x, y, heading, side in metres.

    Also its worst corner's standard error, pixels. Its corners are as in `see_marker`.
    """
    x, y, heading, side = marker
    c, s = 0.5 * side * math.cos(heading), 0.5 * side * math.sin(heading)
    guess = np.empty((4, 2))
    guess[0, 0], guess[0, 1] = seen_at(x - c - s, y - s + c, view)
    guess[1, 0], guess[1, 1] = seen_at(x + c - s, y + s + c, view)
    guess[2, 0], guess[2, 1] = seen_at(x + c + s, y + s - c, view)
    guess[3, 0], guess[3, 1] = seen_at(x - c + s, y - s - c, view)
    sides_m = np.empty((4, 2))
    became, _, error_px = _sides_on_floor(grey, guess, len(bits), view, sides_m)
    if became != FITTED:
        return NOT_READ, error_px
    is_there, read, error_px = place_pattern(grey, sides_m, bits, view, error_px, out_m)
    if not is_there:
        return NOT_READ, error_px
    _seen_corners(out_m, view, out_px)
    return read, error_px


@njit(**OWNING)
def see_marker(grey, guess_px, bits, view, out_m, out_px):
    """Find the corners of a marker near ``guess_px`` (4, 2), which is good to a few pixels.

    The pattern at the sides or, if hidden, near the guess gives ``out_m`` (4, 2) in the plane, and
    ``out_px`` (4, 2). Returns the outcome, the sides' roughness and the worst corner's standard
    error in pixels.
    """
    near_m = np.empty((4, 2))
    became, roughness_px, error_px = _sides_on_floor(grey, guess_px, len(bits), view, near_m)
    if became in (AT_EDGE, FOLDED, NO_FLOOR):
        return became, roughness_px, error_px
    if became != FITTED:
        error_px = NO_SIDES
        for i in range(4):
            near_m[i, 0], near_m[i, 1] = placed_at(guess_px[i, 0], guess_px[i, 1], view)
        if not np.isfinite(near_m).all():
            return NO_FLOOR, roughness_px, error_px
    is_there, _, error_px = place_pattern(grey, near_m, bits, view, error_px, out_m)
    if not is_there:
        return (UNREAD if became == FITTED else became), roughness_px, error_px
    _seen_corners(out_m, view, out_px)
    return FITTED, roughness_px, error_px


@njit(**OWNING)
def _sides_on_floor(grey, guess_px, cells, view, out_m):
    """Intersect a marker's sides in the plane, into ``out_m`` (4, 2); the rest as `fit_quad`."""
    ideal = np.empty((4, 2))
    became, roughness_px, error_px = fit_quad(grey, guess_px, cells, view.lens, ideal)
    if became != FITTED:
        return became, roughness_px, error_px
    h = view.from_pixel
    for i in range(4):
        x, y = ideal[i, 0], ideal[i, 1]
        w = h[2, 0] * x + h[2, 1] * y + h[2, 2]
        if not w * view.front > 0.0:
            return NO_FLOOR, roughness_px, error_px
        out_m[i, 0] = (h[0, 0] * x + h[0, 1] * y + h[0, 2]) / w
        out_m[i, 1] = (h[1, 0] * x + h[1, 1] * y + h[1, 2]) / w
    return FITTED, roughness_px, error_px


@njit(**OWNING)
def _seen_corners(corners_m, view, out_px):
    for i in range(4):
        out_px[i, 0], out_px[i, 1] = seen_at(corners_m[i, 0], corners_m[i, 1], view)


@njit(**OWNING)
def place_pattern(grey, corners_m, bits, view, sides_error_px, out_m):
    """Write the corners of the pattern near ``corners_m`` (4, 2) to ``out_m``.

    ``sides_error_px`` is the worst corner's standard error, or `NO_SIDES`. If sides disagree with
    the inner cells, these alone give place and error. Returns True if the pattern is there, its
    cells' score, and the worst corner's standard error, pixels.
    """
    cells = len(bits)
    center, unit_m = _middle(corners_m)
    if not unit_m > 0.0:
        return False, NOT_READ, sides_error_px
    state, metric, seen_px = np.zeros(UNKNOWNS), np.empty((2, 2)), np.empty((4, 2))
    _affine(corners_m, center, unit_m, cells, state)
    _seen_corners(corners_m, view, seen_px)
    cell_px = 0.0
    for i in range(4):
        before = (i + 3) % 4
        dx, dy = seen_px[i, 0] - seen_px[before, 0], seen_px[i, 1] - seen_px[before, 1]
        cell_px += 0.25 * math.sqrt(dx * dx + dy * dy) / cells
    if not _metric(seen_px, unit_m, view, metric):
        return False, NOT_READ, sides_error_px
    pixels = marker_pixels(grey, corners_m, state, view, cells, cell_px)
    guess, placed_px = state.copy(), np.empty((4, 2))
    has_sides = sides_error_px != NO_SIDES and has_light_rim(pixels, state, cells, cell_px)
    if has_sides and settle_pattern(pixels, bits, state, metric):
        corners_of(state, cells, center, unit_m, out_m)
        _seen_corners(out_m, view, placed_px)
        is_near = np.abs(placed_px - seen_px).max() <= _MAX_MOVE_PX
        if is_near and sides_agree(pixels, bits, state, metric, sides_error_px):
            return True, worst_cells(pixels, bits, state, cell_px)[1], sides_error_px
    return _place_inner(pixels, bits, guess, metric, cell_px, (center, unit_m), out_m)


@njit(**OWNING, inline="always")
def _place_inner(pixels, bits, state, metric, cell_px, unit, out_m):
    """Corners of the pattern whose cells lie near ``state``; the rest as `place_pattern`.

    ``unit`` is the marker's middle and size in metres.
    """
    cells = len(bits)
    center, unit_m = unit
    inner = inner_pixels(pixels, state, cells, cell_px)
    if not settle_pattern(inner, bits, state, metric):
        return False, NOT_READ, NO_SIDES
    corners_of(state, cells, center, unit_m, out_m)
    (x, y), placed_unit_m = _middle(out_m)
    moved_cells = math.hypot(x - center[0], y - center[1]) * cells / (math.sqrt(2.0) * unit_m)
    code, read = worst_cells(pixels, bits, state, cell_px)
    is_there = placed_unit_m > 0.0 and code >= LEAST_READ and moved_cells <= _MAX_MOVE_CELLS
    return is_there, read, corner_error_px(inner, bits, state, metric, cell_px)


@njit(**OWNING)
def _middle(corners_m):
    x = y = unit_m = 0.0
    for i in range(4):
        x, y = x + 0.25 * corners_m[i, 0], y + 0.25 * corners_m[i, 1]
    for i in range(4):
        dx, dy = corners_m[i, 0] - x, corners_m[i, 1] - y
        unit_m += 0.25 * math.sqrt(dx * dx + dy * dy)
    return (x, y), unit_m


@njit(**OWNING)
def _affine(corners_m, center, unit_m, cells, out_state):
    """Affine map from the corners, in units around their centre, to the pattern's.

    Least squares; the centre is the corners' mean.
    """
    aa = ab = bb = 0.0
    au = av = bu = bv = 0.0
    for i in range(4):
        a, b = (corners_m[i, 0] - center[0]) / unit_m, (corners_m[i, 1] - center[1]) / unit_m
        u = 0.5 * cells if i == 1 or i == 2 else -0.5 * cells
        v = 0.5 * cells if i >= 2 else -0.5 * cells
        aa, ab, bb = aa + a * a, ab + a * b, bb + b * b
        au, av, bu, bv = au + a * u, av + a * v, bu + b * u, bv + b * v
    determinant = aa * bb - ab * ab
    if not determinant > 0.0:
        return
    out_state[0], out_state[1] = (
        (bb * au - ab * bu) / determinant,
        (aa * bu - ab * au) / determinant,
    )
    out_state[3], out_state[4] = (
        (bb * av - ab * bv) / determinant,
        (aa * bv - ab * av) / determinant,
    )
    out_state[2] = out_state[5] = 0.5 * cells


@njit(**OWNING)
def _metric(seen_px, unit_m, view, out):
    """J J^T (2, 2) of the plane, in units of the marker's size, by raw pixels at its middle."""
    x = y = 0.0
    for i in range(4):
        x, y = x + 0.25 * seen_px[i, 0], y + 0.25 * seen_px[i, 1]
    ax, ay = placed_at(x + 0.5, y, view)
    bx, by = placed_at(x - 0.5, y, view)
    cx, cy = placed_at(x, y + 0.5, view)
    dx, dy = placed_at(x, y - 0.5, view)
    j00, j10 = (ax - bx) / unit_m, (ay - by) / unit_m
    j01, j11 = (cx - dx) / unit_m, (cy - dy) / unit_m
    out[0, 0], out[1, 1] = j00 * j00 + j01 * j01, j10 * j10 + j11 * j11
    out[0, 1] = out[1, 0] = j00 * j10 + j01 * j11
    return bool(np.isfinite(out[0, 0]) and np.isfinite(out[1, 1]))


@njit(**OWNING)
def marker_pixels(grey, corners_m, state, view, cells, cell_px):
    """Rows (n, 3) of a, b, grey value: the pixels on the marker and its rim.

    a, b are a pixel's place in the plane, in units of the marker's size around its centre;
    ``state`` begins with the affine map from there to the pattern. No rows if part of the marker is
    out of the picture.
    """
    center, unit_m = _middle(corners_m)
    rim = min(_RIM_PX / cell_px, _RIM_CELLS)
    wider = 1.0 + 2.0 * rim / cells
    height, width = grey.shape
    low_x = low_y = math.inf
    high_x = high_y = -math.inf
    for i in range(4):
        x, y = seen_at(corners_m[i, 0], corners_m[i, 1], view)
        if not (x >= 0.0 and y >= 0.0 and x <= width - 1 and y <= height - 1):
            return np.empty((0, 3))
        x, y = seen_at(
            center[0] + wider * (corners_m[i, 0] - center[0]),
            center[1] + wider * (corners_m[i, 1] - center[1]),
            view,
        )
        if not (math.isfinite(x) and math.isfinite(y)):
            return np.empty((0, 3))
        low_x, high_x = min(low_x, x), max(high_x, x)
        low_y, high_y = min(low_y, y), max(high_y, y)
    x0, y0 = max(0, math.floor(low_x) - 1), max(0, math.floor(low_y) - 1)
    x1, y1 = min(width - 1, math.ceil(high_x) + 1), min(height - 1, math.ceil(high_y) + 1)
    place = center[0], center[1], unit_m
    return collect_pixels(grey, (x0, y0, x1, y1), view, place, state[:6], cells, rim)


@njit(**OWNING, inline="always")
def collect_pixels(grey, box, view, place, pattern_from_plane, cells, rim):
    """Rows as of `marker_pixels` within ``box``.

    ``box`` is x0, y0, x1, y1 with the ends included, inside ``grey``; ``place`` the centre's x, y
    and the unit; ``pattern_from_plane`` (6,) the first guess, ``rim`` a width in cells. Every nth
    pixel of a row is taken, shifted by one in the next row. No rows if part of the box shows no
    floor.
    """
    x0, y0, x1, y1 = box
    every = (x1 - x0 + 1) * (y1 - y0 + 1) // MOST_BOX_PIXELS + 1
    rows = np.empty((((x1 - x0) // every + 1) * (y1 - y0 + 1), 3))
    count = 0
    p = pattern_from_plane
    step_x, first_x, weights_x = _cubics(x1 - x0 + 1)
    step_y, first_y, weights_y = _cubics(y1 - y0 + 1)
    grid = np.empty((first_y[-1] + 4, first_x[-1] + 4, 2))
    for j in range(grid.shape[0]):
        for i in range(grid.shape[1]):
            a, b = placed_at(x0 + step_x * i, y0 + step_y * j, view)
            if not (math.isfinite(a) and math.isfinite(b)):
                return rows[:0]
            grid[j, i, 0], grid[j, i, 1] = (a - place[0]) / place[2], (b - place[1]) / place[2]
    nodes = np.empty((grid.shape[1], 2))
    for y in range(y0, y1 + 1):
        n, w = first_y[y - y0], weights_y[y - y0]
        for i in range(len(nodes)):
            for k in range(2):
                nodes[i, k] = w[0] * grid[n, i, k] + w[1] * grid[n + 1, i, k]
                nodes[i, k] += w[2] * grid[n + 2, i, k] + w[3] * grid[n + 3, i, k]
        for x in range(x0 + (y - y0) % every, x1 + 1, every):
            n, i = first_x[x - x0], x - x0
            a = weights_x[i, 0] * nodes[n, 0] + weights_x[i, 1] * nodes[n + 1, 0]
            a += weights_x[i, 2] * nodes[n + 2, 0] + weights_x[i, 3] * nodes[n + 3, 0]
            b = weights_x[i, 0] * nodes[n, 1] + weights_x[i, 1] * nodes[n + 1, 1]
            b += weights_x[i, 2] * nodes[n + 2, 1] + weights_x[i, 3] * nodes[n + 3, 1]
            u, v = p[0] * a + p[1] * b + p[2], p[3] * a + p[4] * b + p[5]
            if u < -rim or v < -rim or u > cells + rim or v > cells + rim:
                continue
            rows[count, 0] = a
            rows[count, 1] = b
            rows[count, 2] = grey[y, x]
            count += 1
    return rows[:count]


@njit(**OWNING)
def _cubics(count):
    """Interpolate a function of ``count`` pixels in a row from a few values.

    Returns the nodes' distance in pixels, and for each pixel the first of its four nodes and their
    weights (4,): Lagrange's cubics.
    """
    stretches = (count - 1) // _STRETCH_PX + 1
    step = max(count - 1, 1) / (3.0 * stretches)
    first, weights = np.empty(count, np.int64), np.empty((count, 4))
    for i in range(count):
        t = i / step
        first[i] = 3 * min(int(t) // 3, stretches - 1)
        t -= first[i]
        near, far = t * (t - 3.0) / 2.0, (t - 1.0) * (t - 2.0) / 6.0
        weights[i, 0], weights[i, 1] = far * (3.0 - t), near * (t - 2.0)
        weights[i, 2], weights[i, 3] = near * (1.0 - t), far * t
    return step, first, weights
