"""Poses and outlines in ray-traced pictures, to hundredths of a pixel, through every lens."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.camera.lenses import cameras, outlines, poses, rms, undistorted

pytestmark = pytest.mark.slow

BY_NAME = {camera.name: camera for camera in cameras()}


@pytest.mark.parametrize("name", ["pinhole", "fisheye, four terms"])
def test_markers_are_placed_to_a_twentieth_of_a_pixel(name: str) -> None:
    found, lost = poses(BY_NAME[name], seed=5, pictures=2)
    flat = found[:, 0] < 60.0
    assert np.count_nonzero(flat) >= 5
    # what is seen flatter than that is not always read
    assert lost <= 12 - np.count_nonzero(flat)
    assert rms(found[:, 1]) < 0.02
    assert found[:, 1].max() < 0.05


@pytest.mark.parametrize("name", ["pinhole", "fisheye, four terms"])
def test_outlines_lie_within_a_twentieth_of_a_pixel(name: str) -> None:
    found, split = outlines(BY_NAME[name], seed=6, pictures=2)
    flat = found[found[:, 0] < 60.0]
    assert len(flat) >= 5
    assert flat[:, 1].max() < 0.05
    assert split <= len(found) - len(flat)


@pytest.mark.parametrize("name", sorted(BY_NAME))
def test_undistorted_points_are_opencv_s_all_over_the_picture(name: str) -> None:
    assert undistorted(BY_NAME[name], 3000) < 1e-6
