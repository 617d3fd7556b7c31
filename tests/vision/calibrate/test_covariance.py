"""How well a lens is known is what it scatters by: fits of many noisy pictures are the oracle."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.support.drawn.boards import chessboard_patch, render
from tests.vision.calibrate.views import CAMERA, SIZE, views
from vision.calibrate.board import BoardView, refine_corners
from vision.calibrate.covariance import (
    KnownLens,
    information,
    known_lens,
    seen_through,
    supposed_lens,
)
from vision.calibration.calibration import Calibration, CalibrationError

SMALL = (320, 240)
TURNS = [(0.45, 0.0, 0.1), (-0.45, 0.1, 0.5), (0.0, 0.5, -0.4), (0.1, -0.5, 1.0), (0.35, 0.35, 0.0),
         (-0.3, -0.35, 0.7), (0.4, -0.3, -0.6)]  # fmt: skip


def grid(size: tuple[int, int]) -> NDArray[np.float64]:
    x, y = np.meshgrid(np.linspace(0, size[0] - 1, 7), np.linspace(0, size[1] - 1, 5))
    return np.stack([x.ravel(), y.ravel()], axis=1)


def scatter_px(fits: list[KnownLens], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) how far the fits' undistorted pictures differ, each laid on the first by a homography.

    Takes nothing from the code that predicts it: no slopes, no normal matrix.
    """
    focal = fits[0].camera_matrix[0, 0]
    rays = [
        focal * cv2.undistortPoints(
            points.reshape(-1, 1, 2), fit.camera_matrix, fit.distortion,
            criteria=(cv2.TERM_CRITERIA_COUNT, 100, 0.0),
        ).reshape(-1, 2)
        for fit in fits
    ]  # fmt: skip
    middle = np.mean(rays, axis=0)
    laid = [
        cv2.perspectiveTransform(
            ray.reshape(-1, 1, 2), cv2.findHomography(ray, middle, 0)[0]
        ).reshape(-1, 2)
        for ray in rays
    ]
    return np.asarray(np.sqrt(np.var(laid, axis=0, ddof=1).sum(axis=1)))


def seen_from(turn: tuple[float, float, float]) -> Calibration:
    rotation = cv2.Rodrigues(np.array(turn))[0] @ np.diag([1.0, -1.0, -1.0])
    center = -rotation.T @ np.array([0.0, 0.0, 1.7])
    camera = [[300.0, 0.0, 163.0], [0.0, 301.0, 117.0], [0.0, 0.0, 1.0]]
    pose = np.column_stack([rotation, -rotation @ center])
    return Calibration.from_camera(SMALL, camera, [-0.2, 0.05, 0.0, 0.0, 0.0], pose)


@pytest.fixture(scope="module")
def drawn() -> list[tuple[NDArray[np.uint8], BoardView]]:
    """Pictures of a chessboard without noise, and where its corners are."""
    patch = chessboard_patch((8, 6), 0.11, (0.0, 0.0, 0.0))
    x, y = np.meshgrid(np.arange(8) - 3.5, 2.5 - np.arange(6))
    points = 0.11 * np.stack([x.ravel(), y.ravel()], axis=1)
    found = []
    for i, turn in enumerate(TURNS):
        calibration = seen_from(turn)
        corners = calibration.image_from_arena(points)
        image = render(calibration, [patch], samples=3)
        found.append((image, BoardView(f"view {i}", SMALL, corners, points)))
    return found


def noisy(
    drawn: list[tuple[NDArray[np.uint8], BoardView]], seed: int, grey: float = 8.0
) -> list[BoardView]:
    rng = np.random.default_rng(seed)
    found = []
    for image, view in drawn:
        noise = rng.normal(0.0, grey, image.shape)
        picture = np.clip(np.rint(image + noise), 0, 255).astype(np.uint8)
        corners = refine_corners(picture, view.corners_px)
        found.append(BoardView(view.name, SMALL, corners, view.points_m))
    return found


def test_the_spread_predicted_is_that_of_many_noisy_renderings(
    drawn: list[tuple[NDArray[np.uint8], BoardView]],
) -> None:
    fits = [known_lens(noisy(drawn, seed), terms=2) for seed in range(60)]
    predicted = np.median([fit.sigma_px(grid(SMALL)) for fit in fits], axis=0)
    scattered = scatter_px(fits, grid(SMALL))
    # 60 fits know a spread to 9 %; the residuals also hold what refinement is biased by
    ratio = predicted / scattered
    assert 0.75 < np.median(ratio) < 1.35
    assert predicted.max() / scattered.max() == pytest.approx(1.0, abs=0.35)
    focal = np.std([fit.camera_matrix[0, 0] for fit in fits]) / 300.0
    assert np.median([fit.focal_share for fit in fits]) == pytest.approx(focal, rel=0.35)


@pytest.mark.parametrize("count", [6, 14])
@pytest.mark.parametrize("terms", [2, 5])
def test_the_spread_predicted_is_that_of_many_seeds(count: int, terms: int) -> None:
    # a lens that two terms describe, so that noise is all that is left
    clean = views(count, noise_px=0.0, seed=3, lens=np.array([-0.28, 0.09, 0.0, 0.0, 0.0]))
    fits = []
    for seed in range(80):
        rng = np.random.default_rng(seed)
        these = [
            BoardView(v.name, SIZE, v.corners_px + rng.normal(0.0, 0.1, (54, 2)), v.points_m)
            for v in clean
        ]
        fits.append(known_lens(these, terms))
    assert np.mean([fit.noise_px for fit in fits]) == pytest.approx(0.1, rel=0.02)
    predicted = np.median([fit.sigma_px(grid(SIZE)) for fit in fits], axis=0)
    ratio = predicted / scatter_px(fits, grid(SIZE))
    assert 0.85 < np.median(ratio) < 1.18
    assert 0.6 < ratio.min() <= ratio.max() < 1.5
    focal = np.std([fit.camera_matrix[0, 0] for fit in fits]) / 620.0
    assert fits[0].focal_share == pytest.approx(focal, rel=0.3)


def test_what_a_view_would_add_is_what_it_adds() -> None:
    these = views(9, seed=5)
    before, after = known_lens(these[:8]), known_lens(these)
    predicted = before.sigma_px(grid(SIZE), seen_through(before, these[8]))
    assert predicted == pytest.approx(after.sigma_px(grid(SIZE)), rel=0.25)
    assert (predicted <= before.sigma_px(grid(SIZE)) + 1e-12).all()


def test_more_views_are_never_known_less_and_scale_does_not_matter() -> None:
    lens = known_lens(views(10))
    pose = np.zeros(3), np.array([0.0, 0.0, 0.4])
    points = views(1)[0].points_m
    assert np.linalg.eigvalsh(information(lens, points, *pose)).min() > -1e-6
    tenfold = [BoardView(v.name, v.size, v.corners_px, 10.0 * v.points_m) for v in views(10)]
    again = known_lens(tenfold)
    assert again.sigma_px(grid(SIZE)) == pytest.approx(lens.sigma_px(grid(SIZE)), rel=1e-3)


def test_what_is_not_determined_is_unknown() -> None:
    few = known_lens(views(2))
    more = known_lens(views(12))
    assert few.sigma_px(grid(SIZE)).max() > 2.0 * more.sigma_px(grid(SIZE)).max()
    folded = KnownLens(SIZE, CAMERA, np.array([-1.5, 0.0, 0.0, 0.0, 0.0]), np.eye(9), 0.1)
    assert math.isinf(folded.sigma_px(np.array([[0.0, 0.0]]))[0])
    singular = KnownLens(SIZE, CAMERA, np.zeros(5), np.zeros((9, 9)), 0.1)
    assert np.isinf(singular.sigma_px(grid(SIZE))).all()
    assert math.isinf(singular.focal_share)
    assert 0.1 < supposed_lens(SIZE).focal_share < 0.5
    four = np.array([0, 1, 9, 10])
    bare = [BoardView(v.name, SIZE, v.corners_px[four], v.points_m[four]) for v in views(3)]
    with pytest.raises(CalibrationError, match=r"cannot be estimated|too few corners"):
        known_lens(bare)
