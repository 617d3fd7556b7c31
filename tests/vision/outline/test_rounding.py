"""What blur does to corners: points where blur puts them cost nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.drawn.outlines import blank_outline
from vision.outline.corners.blurred_corner_kernels import (
    ALONG_X,
    CORNER_ROOM,
    STEEPNESS,
    TURN,
    _explain,
    find_corners,
    sum_costs,
)
from vision.outline.outline_types import BorderPoints, Costs

SIDE = 40.0
HALF = 20
"""Points on either side of a corner."""


def rounded_square(blur: float, clockwise: bool) -> tuple[np.ndarray, np.ndarray]:
    """A square's border as blur leaves it, from half-way before each corner to half-way behind."""
    corners = np.array([(0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE)])
    if not clockwise:
        corners = corners[::-1]
    # across the middle between a corner's sides, which rise at 45 degrees
    s = (np.arange(2 * HALF) + 0.5 - HALF) * math.sqrt(0.5)
    t = np.abs(s) / blur
    tail = np.array([0.5 * math.erfc(v / math.sqrt(2.0)) for v in t])
    density = np.exp(-0.5 * t * t) / math.sqrt(2.0 * math.pi)
    height = np.abs(s) + 2.0 * blur * (density - t * tail)
    points = []
    for e, corner in enumerate(corners):
        ahead = (corners[(e + 1) % 4] - corner) / SIDE
        back = (corners[e - 1] - corner) / SIDE
        across, inwards = (ahead - back) * math.sqrt(0.5), (ahead + back) * math.sqrt(0.5)
        points.append(corner + s[:, None] * across + height[:, None] * inwards)
    return np.concatenate(points), corners


@pytest.mark.parametrize("blur", [0.6, 1.0, 1.7])
@pytest.mark.parametrize("clockwise", [True, False])
def test_points_where_blur_puts_them_cost_nothing(blur: float, clockwise: bool) -> None:
    points, joints = rounded_square(blur, clockwise)
    n = len(points)
    x, y = (np.append(np.tile(points[:, c], 2), points[0, c]) for c in (0, 1))
    border = BorderPoints(x, y, n)
    outline = blank_outline(4)
    outline.breaks[:] = np.arange(4) * 2 * HALF + HALF
    outline.is_arc[:] = False
    outline.joints[:] = joints
    outline.shape[:, :2] = joints
    outline.shape[:, 2:4] = (np.roll(joints, -1, axis=0) - joints) / SIDE
    corners = np.zeros((4, CORNER_ROOM))
    find_corners(border, outline, 4, corners)
    assert np.allclose(corners[:, TURN], math.pi / 2.0 if clockwise else -math.pi / 2.0)
    sums = np.zeros(2 * n + 1)
    costs = Costs(False, 1e-3 * blur, 0.01, 1e9, 0.0)
    sum_costs(border, outline, 4, corners, blur, costs, sums)
    assert sums[-1] == 0.0
    # and sharp corners would not do
    sum_costs(border, outline, 4, corners, 1e-3, costs, sums)
    assert sums[-1] > 100.0
    assert np.isclose(sums[-1], 2.0 * sums[n])


def test_no_entry_beyond_the_table_is_read_where_tangents_are_no_unit_vectors() -> None:
    corner = np.zeros(CORNER_ROOM)
    corner[ALONG_X], corner[STEEPNESS] = 3.0, 1.0
    deviations = np.zeros(1)
    border = BorderPoints(np.array([3.9]), np.zeros(1), 1)  # 374 entries from its beginning
    _explain.py_func(border, 0, 1, 0, np.zeros(2), corner, 1.0, deviations)
    assert abs(deviations[0]) < 1e-4
