"""The fit of a marker's whole pattern against rendered truth and the Cramer-Rao bound."""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.support.drawn.boards import LIGHT, Patch, marker_patch, pose_bound, render
from vision.calibration.calibration import Calibration
from vision.markers import marker_pattern_kernels
from vision.markers.marker_pattern import pattern_bits
from vision.markers.marker_place_kernels import (
    MOST_BOX_PIXELS,
    collect_pixels,
    marker_pixels,
    place_pattern,
)
from vision.markers.markers import dictionary_by_name

SIZE = (160, 160)
BOOK = dictionary_by_name("DICT_4X4_50")
UNIT = np.array([-0.5 + 0.5j, 0.5 + 0.5j, 0.5 - 0.5j, -0.5 - 0.5j])
Picture = NDArray[np.uint8]


def overhead() -> Calibration:
    """A tilted camera with a lens, 2 m above the floor, 2 mm a pixel."""
    turn = cv2.Rodrigues(np.array([0.06, -0.04, 0.03]))[0] @ np.diag([1.0, -1.0, -1.0])
    pose = np.column_stack([turn, -turn @ np.array([0.16, 0.16, 2.0])])
    matrix = [[1000.0, 0.0, 78.0], [0.0, 1002.0, 82.0], [0.0, 0.0, 1.0]]
    return Calibration.from_camera(SIZE, matrix, [-0.25, 0.08, 0.001, -0.001, 0.0], pose)


CAMERA = overhead()


def marker(
    side_px: float, heading: float, away: tuple[float, float] = (0.0, 0.0), height: float = 0.0
) -> Patch:
    """A marker in the middle of the picture, or ``away`` from there in metres."""
    x, y = CAMERA.arena_from_image([(79.5, 79.5)], height)[0] + away
    side_m = side_px * CAMERA.metres_per_pixel
    return marker_patch(cv2.aruco.DICT_4X4_50, 7, side_m, (float(x), float(y), heading), height)


def corners_of(patch: Patch) -> NDArray[np.float64]:
    """The true corners, without the rim of one cell, in metres."""
    side_m = patch.cell_m * (len(patch.cells) - 2)
    places = complex(patch.x, patch.y) + side_m * UNIT * np.exp(1j * patch.heading_rad)
    return np.column_stack([places.real, places.imag])


def fit_pattern(
    image: Picture,
    corners_m: NDArray[np.float64],
    bits: NDArray[np.float64],
    calibration: Calibration,
    height_m: float = 0.0,
) -> NDArray[np.float64] | None:
    """The corners in metres of the pattern near ``corners_m``, which are good to a pixel."""
    placed, view = np.empty((4, 2)), calibration.plane_view(height_m)
    is_there, _, _ = place_pattern(image, corners_m, bits, view, 0.05, placed)
    return placed if is_there else None


def fitted(image: Picture, patch: Patch, seed: int = 0) -> tuple[float, float] | None:
    """(centre error in pixels, heading error in degrees), begun half a pixel away."""
    away = np.random.default_rng(seed).uniform(-0.5, 0.5, (4, 2)) * CAMERA.metres_per_pixel
    start = corners_of(patch) + away
    found = fit_pattern(image, start, pattern_bits(BOOK, 7), CAMERA, patch.height_m)
    if found is None:
        return None
    points = found[:, 0] + 1j * found[:, 1]
    center = points.mean()
    turn = float(np.angle(np.vdot(UNIT, points - center)))
    off_px = abs(center - complex(patch.x, patch.y)) / CAMERA.metres_per_pixel
    return off_px, math.degrees(math.remainder(turn - patch.heading_rad, math.tau))


@settings(max_examples=15, deadline=None)
@given(
    st.floats(40.0, 80.0),
    st.floats(-math.pi, math.pi),
    st.floats(-4e-3, 4e-3),
    st.sampled_from([0.0, 0.3]),
    st.sampled_from([0.5, 0.8, 1.4]),
)
def test_without_noise_the_pose_is_exact_at_any_blur_and_height(
    side_px: float, heading: float, away: float, height: float, blur: float
) -> None:
    patch = marker(side_px, heading, (away, -away), height)
    error = fitted(render(CAMERA, [patch], blur=blur, samples=8), patch)
    assert error is not None
    assert error[0] < 0.02
    assert abs(error[1]) < 0.05


@pytest.mark.parametrize("side_px", [30.0, 60.0])
def test_at_strong_noise_no_estimate_could_be_much_better(side_px: float) -> None:
    rng = np.random.default_rng(3)
    off, turned, bounds = [], [], []
    for i in range(40):
        patch = marker(side_px, float(rng.uniform(-3, 3)), tuple(rng.uniform(-2e-3, 2e-3, 2)))
        image = render(CAMERA, [patch], noise=20.0, rng=rng)
        error = fitted(image, patch, i)
        assert error is not None
        off.append(error[0])
        turned.append(error[1])
        if i < 8:
            bounds.append(pose_bound(CAMERA, patch, 20.0))
    least_px, least_deg = np.sqrt(np.mean(np.square(bounds), axis=0))
    # The rms of 40 has a spread of a ninth of itself; blur and light are estimated besides.
    assert math.sqrt(np.mean(np.square(off))) < 1.3 * least_px
    assert math.sqrt(np.mean(np.square(turned))) < 1.3 * least_deg


def test_light_that_falls_off_across_the_marker_moves_nothing() -> None:
    patch = marker(50.0, 0.7)
    image = render(CAMERA, [patch], samples=8).astype(np.float64)
    lit = (image * np.linspace(1.0, 0.5, SIZE[0])[None, :]).round().astype(np.uint8)
    error = fitted(lit, patch)
    assert error is not None
    assert error[0] < 0.03
    assert abs(error[1]) < 0.05


def test_a_cable_across_the_marker_moves_little() -> None:
    patch = marker(60.0, 0.4)
    image = render(CAMERA, [patch], noise=3.0, rng=np.random.default_rng(0))
    cv2.line(image, (60, 20), (95, 140), 120, 2, cv2.LINE_AA)
    error = fitted(image, patch)
    assert error is not None
    assert error[0] < 0.1
    assert abs(error[1]) < 0.2


def test_another_pattern_a_blank_picture_and_a_place_outside_give_nothing() -> None:
    patch = marker(50.0, 0.7)
    bits = pattern_bits(BOOK, 23)
    assert fit_pattern(render(CAMERA, [patch]), corners_of(patch), bits, CAMERA) is None
    assert fitted(np.full(SIZE[::-1], 200, np.uint8), patch) is None
    assert fitted(render(CAMERA, []), replace(patch, x=3.0)) is None
    inverted = (LIGHT - render(CAMERA, [patch]).clip(0, int(LIGHT))).astype(np.uint8)
    assert fitted(inverted, patch) is None
    assert fitted(render(CAMERA, [patch])[:, :70].copy(), patch) is None
    assert fit_pattern(inverted, np.full((4, 2), 0.16), bits, CAMERA) is None


def test_a_picture_that_cannot_be_written_is_read_and_left_alone() -> None:
    patch = marker(40.0, -2.0)
    image = render(CAMERA, [patch])
    kept = image.copy()
    image.setflags(write=False)
    assert fitted(image, patch) is not None
    assert np.array_equal(image, kept)


def test_the_bits_are_those_of_the_printed_marker() -> None:
    bits = pattern_bits(BOOK, 7)
    assert bits.shape == (6, 6)
    assert not bits[0].any()
    assert not bits[:, -1].any()
    printed = cv2.aruco.generateImageMarker(BOOK, 7, 60)
    assert np.array_equal(bits, printed[5::10, 5::10] > 127)


def _printed(
    side_px: float, turn: float, rim: float, floor: float, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A marker on paper that reaches ``rim`` cells beyond it, on a floor; corners px and cells."""
    bits = pattern_bits(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50), 7)
    n, fine = len(bits), 6
    width = int(1.6 * side_px) + 24
    middle = 0.5 * width + rng.uniform(-0.5, 0.5, 2)
    row, column = np.mgrid[0 : width * fine, 0 : width * fine]
    x, y = (column + 0.5) / fine - 0.5 - middle[0], (row + 0.5) / fine - 0.5 - middle[1]
    c, s = math.cos(turn), math.sin(turn)
    u, v = (c * x + s * y) / side_px * n + n / 2, (c * y - s * x) / side_px * n + n / 2
    paper = (u > -rim) & (v > -rim) & (u < n + rim) & (v < n + rim)
    light = np.where(paper, 220.0, floor)
    inside = (u >= 0) & (v >= 0) & (u < n) & (v < n)
    light[inside] = np.where(bits[v[inside].astype(int), u[inside].astype(int)] > 0.5, 220.0, 30.0)
    grey = cv2.GaussianBlur(light.reshape(width, fine, width, fine).mean((1, 3)), (0, 0), 0.8)
    grey = np.clip(np.rint(grey + rng.normal(0.0, 2.0, grey.shape)), 0, 255).astype(np.uint8)
    square = side_px * np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    return grey, square @ np.array([[c, s], [-s, c]]) + middle, bits


@pytest.mark.parametrize("side_px", [24, 40, 80, 200])
@pytest.mark.parametrize(("rim", "floor"), [(1.0, 200.0), (0.2, 110.0), (0.0, 110.0), (0.0, 30.0)])
def test_a_marker_cut_tightly_is_within_a_twentieth_of_a_pixel(side_px, rim, floor):
    """What lies outside of the marker is fitted only where it is paper."""
    for seed in range(3):
        rng = np.random.default_rng(seed)
        grey, corners, bits = _printed(side_px, rng.uniform(0.0, 1.5), rim, floor, rng)
        calibration = Calibration.from_scale(1.0, (grey.shape[1], grey.shape[0]))
        truth = calibration.arena_from_image(corners)
        found = fit_pattern(grey, truth + rng.normal(0.0, 0.15, (4, 2)), bits, calibration)
        assert found is not None
        assert np.linalg.norm(found.mean(axis=0) - truth.mean(axis=0)) < 0.05


def test_of_a_large_marker_no_more_pixels_are_used_than_the_bound():
    used = []
    rng = np.random.default_rng(1)
    for side_px in (60, 250, 400):
        grey, corners, bits = _printed(side_px, 0.4, 1.0, 200.0, rng)
        calibration = Calibration.from_scale(1.0, (grey.shape[1], grey.shape[0]))
        truth = calibration.arena_from_image(corners)
        found = fit_pattern(grey, truth, bits, calibration)
        assert found is not None
        assert np.linalg.norm(found.mean(axis=0) - truth.mean(axis=0)) < 0.015
        view, state = calibration.plane_view(), np.zeros(6)
        used.append(len(marker_pixels(grey, truth, state, view, 6, side_px / 6.0)))
    assert max(used) <= MOST_BOX_PIXELS
    assert used[0] > 3000, "a small marker keeps all of its pixels"


@settings(max_examples=100, deadline=None)
@given(st.lists(st.integers(0, 255), min_size=1, max_size=60), st.floats(0.0, 1.0))
def test_quantiles_of_grey_values_are_numpy_s(values: list[int], share: float) -> None:
    counts = np.bincount(values, minlength=256).astype(np.int64)
    expected = np.quantile(np.array(values, dtype=np.float64), share)
    assert marker_pattern_kernels._quantile(counts, share) == pytest.approx(expected, abs=1e-9)


@settings(max_examples=50, deadline=None)
@given(st.integers(1, 13), st.integers(0, 2**32 - 1), st.floats(0.0, 6.0))
def test_equations_are_solved_as_numpy_solves_them(count: int, seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(30, count)) * 10.0 ** rng.uniform(-scale, scale, count)
    matrix, right = rows.T @ rows, rows.T @ rng.normal(size=30)
    found, lower = right.copy(), np.tril(matrix)
    assert marker_pattern_kernels.solve(lower, found)
    assert rows @ found == pytest.approx(rows @ np.linalg.solve(matrix, right), abs=1e-6)


def test_equations_of_an_unknown_that_is_not_seen_are_refused() -> None:
    rows = np.random.default_rng(0).normal(size=(30, 4))
    rows[:, 3] = rows[:, 1]
    for matrix in (rows.T @ rows, np.zeros((3, 3)), np.full((2, 2), np.nan)):
        assert not marker_pattern_kernels.solve(matrix.copy(), np.ones(len(matrix)))


@settings(max_examples=100, deadline=None)
@given(st.floats(-40.0, 40.0))
def test_a_blurred_step_is_the_normal_distribution(t: float) -> None:
    """Within the 1e-7 that its source promises."""
    share, density = marker_pattern_kernels.blurred_step(t)
    assert share == pytest.approx(0.5 * math.erfc(-t / math.sqrt(2.0)), abs=1.1e-7)
    assert density == pytest.approx(math.exp(-0.5 * t * t) / math.sqrt(math.tau), abs=1e-7)


def _lenses() -> list[Calibration]:
    """A plain picture, a wide lens's middle and near its rim, and a fisheye's."""
    brown, fisheye = [-0.3, 0.12, 0.001, -0.001, -0.02], [0.02, -0.01, 0.004, -0.001]
    matrix = [[420.0, 0.0, 319.5], [0.0, 421.0, 239.5], [0.0, 0.0, 1.0]]
    turn = cv2.Rodrigues(np.array([0.2, -0.15, 0.03]))[0] @ np.diag([1.0, -1.0, -1.0])
    pose = np.column_stack([turn, -turn @ np.array([0.3, 0.3, 2.0])])
    size = (640, 480)
    return [
        Calibration.from_scale(0.002, size),
        Calibration.from_camera(size, matrix, np.zeros(5), pose),
        Calibration.from_camera(size, matrix, brown, pose),
        Calibration.from_camera(size, matrix, fisheye, pose, "fisheye"),
    ]


@pytest.mark.parametrize("lens", range(4))
@pytest.mark.parametrize("box", [(300, 220, 347, 260), (20, 20, 160, 90), (2, 300, 9, 302)])
def test_a_pixel_s_place_is_the_calibration_s_whatever_the_lens(lens, box):
    calibration = _lenses()[lens]
    rng = np.random.default_rng(lens)
    grey = rng.integers(0, 256, calibration.size[::-1]).astype(np.uint8)
    everything = np.zeros(6)
    rows = collect_pixels(grey, box, calibration.plane_view(), (0.3, 0.2, 0.05), everything, 6, 0.5)
    x0, y0, x1, y1 = box
    columns, lines = np.meshgrid(np.arange(x0, x1 + 1), np.arange(y0, y1 + 1))
    pixels = np.column_stack([columns.ravel(), lines.ravel()]).astype(float)
    assert len(rows) == len(pixels)
    back = calibration.image_from_arena(rows[:, :2] * 0.05 + np.array([0.3, 0.2]))
    assert np.abs(back - pixels).max() < 1e-4
    assert np.array_equal(rows[:, 2], grey[lines.ravel(), columns.ravel()])
