"""Agreement of a placed pattern with its pixels: cells, sides, and corners' error.

Coordinates and arrays are those of `marker_pattern_kernels`.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import OWNING
from vision.markers.marker_pattern_kernels import (
    EDGE_PX,
    UNKNOWNS,
    blurred_step,
    normal_equations,
    pixel_length,
    solve,
)

NOT_READ = 0.0
"""Score of cells that do not read, or without a fitted pattern."""
LEAST_READ = 0.65
"""Least score of each cell: 1 as printed, 0.5 halfway, 0 wrong (``test_following.py``)."""

_CORE = 0.3
"""Share of a cell, to each side of its middle, that is read: the rest may be blurred."""
_SIDE_PX = 1.2
"""Distance from a side at which its edge shows."""
_SIDE_ENDS = 0.3
"""Cells left out at each end of a side, where a corner may be covered."""
_LEAST_SHIFT_PX = 0.06
"""Least distance of a side from the pattern's where something covers it: chosen, without a cover
none is off by 0.05."""
_SHIFT_ERRORS = 0.5
"""The same in standard errors of the corners: derived, a side that is off draws the pattern to
itself, whose corners are then off by up to six times the rest."""
_LEAST_MISFIT = 0.03
"""Least share of the contrast by which pixels differ from the pattern: chosen, by markers without
noise (``test_covered_side.py``)."""
_ALIKE = 1.5
"""Factor on errors of independent pixels, as a cover differs everywhere. Chosen
(``test_covered_side.py``)."""


@njit(**OWNING)
def corners_of(state, cells, center, unit_m, out_m):
    """Corners (4, 2) of a placed pattern in the plane; NaN without a size."""
    determinant = state[0] * state[4] - state[1] * state[3]
    for i in range(4):
        out_m[i, 0] = out_m[i, 1] = math.nan
        if determinant != 0.0:
            u = (cells if i == 1 or i == 2 else 0.0) - state[2]
            v = (cells if i >= 2 else 0.0) - state[5]
            out_m[i, 0] = center[0] + unit_m * (state[4] * u - state[1] * v) / determinant
            out_m[i, 1] = center[1] + unit_m * (state[0] * v - state[3] * u) / determinant


@njit(**OWNING)
def sides_agree(pixels, bits, state, metric, error_px):
    """True if each side's edge is where the fitted pattern has it, within the errors.

    A cover over a whole side has as straight an edge, but the inner cells hold the pattern. One
    least-squares step moves each side alone.
    """
    cells = len(bits)
    per_px_u = pixel_length(state[0], state[1], metric)
    per_px_v = pixel_length(state[3], state[4], metric)
    near_u, near_v = _SIDE_PX * per_px_u, _SIDE_PX * per_px_v
    moments, weights = np.zeros(4), np.zeros(4)
    for i in range(len(pixels)):
        a, b = pixels[i, 0], pixels[i, 1]
        u = state[0] * a + state[1] * b + state[2]
        v = state[3] * a + state[4] * b + state[5]
        off_u, off_v = max(-u, u - cells), max(-v, v - cells)
        if abs(off_u) < near_u and off_v < -_SIDE_ENDS:
            side, outwards_px = (0 if 2.0 * u < cells else 1), off_u / per_px_u
        elif abs(off_v) < near_v and off_u < -_SIDE_ENDS:
            side, outwards_px = (2 if 2.0 * v < cells else 3), off_v / per_px_v
        else:
            continue
        x, y = u / cells - 0.5, v / cells - 0.5
        dark = state[7] + state[8] * x + state[9] * y
        contrast = state[10] + state[11] * x + state[12] * y
        light, slope = blurred_step(outwards_px / state[6])
        slope *= contrast / state[6]
        moments[side] += slope * (pixels[i, 2] - dark - contrast * light)
        weights[side] += slope * slope
    most_px = max(_LEAST_SHIFT_PX, _SHIFT_ERRORS * error_px)
    return bool((np.abs(moments) <= most_px * weights).all())


@njit(**OWNING)
def corner_error_px(pixels, bits, state, metric, cell_px):
    """Standard error of a fitted pattern's worst corner, by regression, pixels."""
    cells = len(bits)
    matrix, row = np.empty((UNKNOWNS, UNKNOWNS)), np.empty(UNKNOWNS)
    rms = normal_equations(pixels, bits, state, math.inf, metric, matrix, row)
    scatter = _ALIKE * max(rms, _LEAST_MISFIT * state[10])
    corners = np.empty((4, 2))
    corners_of(state, cells, (0.0, 0.0), 1.0, corners)
    worst = 0.0
    for i in range(4):
        variance = 0.0
        for first in range(0, 6, 3):  # u, then v
            row[:] = 0.0
            row[first], row[first + 1], row[first + 2] = corners[i, 0], corners[i, 1], 1.0
            moved = row.copy()
            if not solve(matrix.copy(), moved):
                return math.inf
            for k in range(first, first + 3):
                variance += row[k] * moved[k]
        worst = max(worst, scatter * math.sqrt(variance))
    return worst * cell_px


@njit(**OWNING)
def worst_cells(pixels, bits, state, cell_px):
    """Score of the worst cell within the border, and of the worst of all cells and the light rim.

    1 if a cell is as light, or as dark, as fitted, 0.5 halfway, 0 if it is the other or has no
    pixel.
    """
    cells = len(bits)
    light = np.zeros((cells + 2, cells + 2))
    counts = np.zeros((cells + 2, cells + 2))
    beyond = EDGE_PX / cell_px
    for i in range(len(pixels)):
        a, b = pixels[i, 0], pixels[i, 1]
        u = state[0] * a + state[1] * b + state[2]
        v = state[3] * a + state[4] * b + state[5]
        column, row = math.floor(u), math.floor(v)
        across, along = abs(u - column - 0.5) <= _CORE, abs(v - row - 0.5) <= _CORE
        if column < 0 or column >= cells:
            across = max(-u, u - cells) > beyond
        if row < 0 or row >= cells:
            along = max(-v, v - cells) > beyond
        if not (across and along and abs(u - 0.5 * cells) < 0.5 * cells + 1.0):
            continue
        if not abs(v - 0.5 * cells) < 0.5 * cells + 1.0:
            continue
        x, y = u / cells - 0.5, v / cells - 0.5
        dark = state[7] + state[8] * x + state[9] * y
        contrast = state[10] + state[11] * x + state[12] * y
        light[row + 1, column + 1] += (pixels[i, 2] - dark) / contrast if contrast > 0.0 else 0.5
        counts[row + 1, column + 1] += 1.0
    code = worst = 1.0
    for row in range(cells + 2):
        for column in range(cells + 2):
            outside = (row == 0 or row == cells + 1) + (column == 0 or column == cells + 1)
            if outside == 2:
                continue
            share = NOT_READ
            if counts[row, column] > 0.0:
                share = light[row, column] / counts[row, column]
                is_light = outside == 1 or bits[row - 1, column - 1] > 0.5
                share = max(share if is_light else 1.0 - share, NOT_READ)
            worst = min(worst, share)
            if 2 <= row < cells and 2 <= column < cells:
                code = min(code, share)
    return code, worst
