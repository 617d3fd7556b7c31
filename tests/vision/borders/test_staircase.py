"""Drawings without grey, blurred afterwards: their border is still the pixels' staircase."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.vision.grey_shapes import FAMILIES, drawn
from benchmarks.vision.rounds import stepped_disc
from planner.scene import CircleRecord, object_records
from vision import extract
from vision.binarise.binarise import binarise
from vision.borders.contours import follow_borders, locate_edges
from vision.borders.staircase_kernels import follow_staircase
from vision.outline.fitting import staircase_share, tolerance_of


def is_one_circle(picture: np.ndarray) -> bool:
    records = [r for one in extract(picture).objects for r in object_records(one)]
    return len(records) == 1 and isinstance(records[0], CircleRecord)


def share_in(picture: np.ndarray) -> float:
    binary = binarise(picture)
    edges = locate_edges(binary, follow_borders(binary.mask))
    tolerance = tolerance_of(edges, binary.noise, binary.contrast)
    return staircase_share(edges, tolerance.sigma_px)


@pytest.mark.parametrize("blur", [0.7, 0.85, 1.0, 1.2])
@pytest.mark.parametrize("noise", [0.0, 2.0, 4.0, 8.0])
def test_a_disc_without_antialiasing_is_a_circle_after_a_blur(blur: float, noise: float) -> None:
    """Before, its steps were traced: 20 to 80 edges without noise, 4 to 10 with it."""
    missed = []
    for radius in (*range(7, 60, 4), 66, 100, 141, 200):
        rng = np.random.default_rng([radius, int(noise)])
        if not is_one_circle(stepped_disc(radius, blur, noise, rng)):
            missed.append(radius)
    # what is smaller has too few steps to tell; in noise, a little more has
    assert max(missed, default=0) < (20 if noise <= 4.0 else 30)
    assert len(missed) <= 2


@pytest.mark.parametrize(("blur", "radius"), [(1.5, 80), (1.5, 200), (2.0, 150), (2.0, 200)])
@pytest.mark.parametrize("noise", [0.0, 2.0, 4.0])
def test_so_is_a_large_one_after_a_wider_blur(blur: float, radius: int, noise: float) -> None:
    for seed in range(3):
        rng = np.random.default_rng([radius, seed])
        assert is_one_circle(stepped_disc(radius, blur, noise, rng)), f"seed {seed}"


def test_no_staircase_is_seen_in_shapes_with_grey() -> None:
    """Corners, arcs, blobs, in all blurs and noises of the benchmark: all stays as it is."""
    for name, family in FAMILIES.items():
        for look in family.looks:
            for i in range(4):
                assert share_in(drawn(name, look, i)[1]) == 0.0, f"{name} {look} {i}"


@pytest.mark.parametrize("radius", [20, 30, 45, 70, 110, 180])
@pytest.mark.parametrize("blur", [0.5, 1.0, 2.0])
def test_no_staircase_is_seen_in_antialiased_discs(radius: int, blur: float) -> None:
    """Whether their tops are at a pixel's middle, its edge or between."""
    rng = np.random.default_rng(radius)
    size = 2 * radius + 40
    for part in range(5):
        picture = np.full((size, size), 220, np.uint8)
        middle = round(8 * size) + 4 * part
        cv2.circle(picture, (middle, middle), 16 * radius + 4 * part, 30, -1, cv2.LINE_AA, 4)
        grey = cv2.GaussianBlur(picture.astype(float), (0, 0), blur)
        noisy = np.clip(np.rint(grey + rng.normal(0.0, 3.0, grey.shape)), 0, 255)
        assert share_in(noisy.astype(np.uint8)) == 0.0, f"part {part}"


def closed(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A border of one course along x, closed far away from it by points that follow no axis."""
    back = np.array([[x[-1] + 40.25, y[-1] + 90.5], [x[0] - 40.25, y[0] + 90.5]])
    points = np.concatenate([np.stack([x, y], axis=1), back])
    return points, np.array([0, len(points)])


@given(
    st.floats(0.03, 0.9),
    st.floats(-2.0, 2.0),
    st.floats(-2e-3, 2e-3),
    st.booleans(),
    st.integers(0, 1 << 16),
)
def test_a_course_is_a_staircase_or_it_is_not(
    rise: float, at: float, bend: float, mirrored: bool, seed: int
) -> None:
    """Points on a line or a bow have nothing in common with it, rounded ones all."""
    x = np.arange(120.0)
    y = at + (-rise if mirrored else rise) * x + bend * (x - 60.0) ** 2
    noise = np.random.default_rng(seed).normal(0.0, 0.03, x.size)
    common, whole = follow_staircase(*closed(x, y + noise), 0.3)
    stepped, steps = follow_staircase(*closed(x, np.floor(y) + 0.5 + noise), 0.3)
    turned = closed(x, y + noise)[0][:, ::-1].copy()
    other = follow_staircase(turned, np.array([0, len(turned)]), 0.3)
    if whole > 1.0:
        assert abs(common) <= 0.25 * whole
    if min(steps, whole) > 1.0 and abs(rise) < 0.45:
        assert stepped >= 0.5 * steps
    assert other == pytest.approx((common, whole))


def test_a_border_along_an_axis_says_nothing() -> None:
    """A straight side has no phase but one, which may be the staircase's own."""
    x = np.arange(200.0)
    for at in (0.0, 0.25, 0.5):
        noise = np.random.default_rng(7).normal(0.0, 0.05, x.size)
        assert follow_staircase(*closed(x, at + noise), 0.7) == (0.0, 0.0)
    assert math.isclose(sum(follow_staircase(*closed(x, 0.004 * x), 0.7)), 0.0)
