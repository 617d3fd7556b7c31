"""Whether two calibrations are of one floor, measured by the outlines that both cameras see."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.vision.joined.floor_truth import BOUNDS, Points, camera, disc, picture, polygon
from vision.calibration.calibration import Calibration
from vision.joined.floor_plan import FloorPlan
from vision.joined.outline_agreement import FARTHEST_M, edge_points_m, outlines_apart_m

LEFT = camera(0.62, 0.62, tilt_deg=(1.2, -0.8), turn_deg=0.7)
RIGHT = camera(1.40, 0.58, tilt_deg=(-0.6, 1.1), turn_deg=-1.3)
SHAPES = [polygon([(0.9, 0.4), (1.1, 0.45), (1.05, 0.65), (0.92, 0.6)]), disc(1.0, 0.85, 0.06)]


def moved(calibration: Calibration, x_m: float, y_m: float) -> Calibration:
    """The calibration of somebody who took another point for the floor's origin."""
    shift = np.array([[1.0, 0.0, x_m], [0.0, 1.0, y_m], [0.0, 0.0, 1.0]])
    homography = shift @ calibration.arena_from_pixel
    return replace(calibration, arena_from_pixel=homography / homography[2, 2])


def apart_m(
    right: Calibration, shapes: list[Points], of_right: list[Points] | None = None
) -> float | None:
    plan = FloorPlan.of((LEFT, right), BOUNDS)
    seen = (picture(LEFT, shapes, seed=1), picture(RIGHT, of_right or shapes, seed=2))
    edges = [edge_points_m(one, plan, i) for i, one in enumerate(seen)]
    return outlines_apart_m(plan, 0, 1, *edges)


def test_calibrations_of_one_floor_agree_within_a_pixel() -> None:
    found = apart_m(RIGHT, SHAPES)
    assert found is not None
    assert found < 0.3 * LEFT.metres_per_pixel


@pytest.mark.parametrize("off_m", [0.01, 0.03, 0.08])
def test_how_far_they_disagree_is_measured(off_m: float) -> None:
    found = apart_m(moved(RIGHT, off_m, -off_m), SHAPES)
    assert found is not None
    # across an edge less of the shift is seen than along it: on an average 2 / pi
    assert 0.4 * off_m < found < 1.5 * off_m


def test_an_empty_overlap_says_nothing() -> None:
    assert apart_m(RIGHT, [disc(0.3, 0.6, 0.1)], [disc(1.8, 0.6, 0.1)]) is None


def test_what_only_one_of_them_sees_is_as_far_apart_as_can_be() -> None:
    assert apart_m(RIGHT, SHAPES, [disc(1.8, 0.6, 0.1)]) == FARTHEST_M


def test_a_shadow_that_one_sees_does_not_count() -> None:
    found = apart_m(RIGHT, [*SHAPES, disc(1.05, 0.2, 0.03)], SHAPES)
    assert found is not None
    assert found < LEFT.metres_per_pixel
