"""What blur does to corners: points where blur puts them cost nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.drawn.outlines import blank_outline
from vision.outline.corners.blurred_corner_kernels import (
    ALONG_X,
    CORNER_FIELDS,
    STEEPNESS,
    TURN,
    _explain,
    change_cost,
    find_corners,
    sum_costs,
)
from vision.outline.outline_types import BorderPoints, Costs, EdgeChange, Outline

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


def square_outline(blur: float, clockwise: bool) -> tuple[BorderPoints, Outline]:
    """A rounded square's border, and the sharp square as its outline."""
    points, joints = rounded_square(blur, clockwise)
    x, y = (np.append(np.tile(points[:, c], 2), points[0, c]) for c in (0, 1))
    outline = blank_outline(4)
    outline.breaks[:] = np.arange(4) * 2 * HALF + HALF
    outline.is_arc[:] = False
    outline.joints[:] = joints
    outline.shape[:, :2] = joints
    outline.shape[:, 2:4] = (np.roll(joints, -1, axis=0) - joints) / SIDE
    return BorderPoints(x, y, len(points)), outline


@pytest.mark.parametrize("blur", [0.6, 1.0, 1.7])
@pytest.mark.parametrize("clockwise", [True, False])
def test_points_where_blur_puts_them_cost_nothing(blur: float, clockwise: bool) -> None:
    border, outline = square_outline(blur, clockwise)
    n = border.n
    corners = np.zeros((4, CORNER_FIELDS))
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


@pytest.mark.parametrize("clockwise", [True, False])
@pytest.mark.parametrize("believed", [0.3, 1.0, 2.0])
def test_an_edit_costs_what_the_outline_costs_with_it(clockwise: bool, believed: float) -> None:
    """The search over edits and the outline have one cost, whatever blur is believed.

    Three sides of a square as a change: a side, and the halves of those beside it.
    """
    border, outline = square_outline(1.0, clockwise)
    corners = np.zeros((4, CORNER_FIELDS))
    find_corners(border, outline, 4, corners)
    sums = np.zeros(2 * border.n + 1)
    costs = Costs(False, 0.01, 0.05, 1e9, 0.3)
    sum_costs(border, outline, 4, corners, believed, costs, sums)
    first, behind = outline.breaks[1], outline.breaks[2]
    change = EdgeChange(
        np.zeros((3, 8)), np.zeros((2, 8)), corners[1:3].copy(), np.zeros(8),
        np.zeros(4, np.int64), np.array([first - HALF, first, behind, behind + HALF]),
        np.zeros(border.n),
    )  # fmt: skip
    change.rows[:, :5] = outline.shape[:3]
    change.joints[:, :2] = outline.joints[1:3]
    cost = change_cost(border, change, False, 0.0, believed, costs, 1e9)
    assert cost == pytest.approx(sums[behind + HALF] - sums[first - HALF], abs=1e-6)
    assert cost > 0.0 or believed == 1.0


def test_no_entry_beyond_the_table_is_read_where_tangents_are_no_unit_vectors() -> None:
    corner = np.zeros(CORNER_FIELDS)
    corner[ALONG_X], corner[STEEPNESS] = 3.0, 1.0
    deviations = np.zeros(1)
    border = BorderPoints(np.array([3.9]), np.zeros(1), 1)  # 374 entries from its beginning
    _explain.py_func(border, 0, 1, 0, np.zeros(2), corner, 1.0, deviations)
    assert abs(deviations[0]) < 1e-4
