"""Precision of the lens from pictures of a board, in pixels of the picture.

Rules and units
- Parameters are fx, fy, cx, cy and the first distortion terms in OpenCV's order (k1, k2, p1, p2,
  k3). Their covariance is the inverse of the normal matrix without the boards' poses (Schur's
  complement), times the residuals' variance.
- A picture point's figure is the spread of its undistorted position, in pixels, without the part
  that a homography undoes, as the arena's does: focal length and centre count only where they bend
  lines. The focal length has its own spread.
- Errors alike in all views are invisible here; residuals of left-out views show them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibrate.board import BoardView, in_space
from vision.calibration.calibration import CalibrationError, FloatArray

MOST_TERMS = 5
TERM_FLAGS = {
    0: cv2.CALIB_FIX_K1 | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST,
    1: cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST,
    2: cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST,
    4: cv2.CALIB_FIX_K3,
    5: 0,
}
"""Number of terms (none; k1; k1 k2; k1 k2 p1 p2; all five) and OpenCV's flags."""
_ROUNDS = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 30, 1e-9)
_UNDISTORT_ROUNDS = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 50, 1e-10)
_FOLDED_PX = 0.05
"""Largest error of undistorting a point; beyond it the lens model folds, and the spread is
unknown."""
_LEAST_NOISE_PX = 0.01
"""Least noise of corners; keeps drawings without noise from being certain."""
_PRIOR_FOCAL, _PRIOR_CENTRE, _PRIOR_TERMS = 0.3, 0.05, (0.3, 0.3, 0.01, 0.01, 0.3)
"""Spreads of an unknown lens: focal length and centre as shares of the picture's width, and the
distortion's terms."""


@dataclass(frozen=True, slots=True, eq=False)
class KnownLens:
    """A lens and the precision of its parameters.

    ``size`` px; ``camera_matrix`` (3, 3); ``distortion`` (5,); ``normal`` (4 + terms, 4 + terms),
    the inverse of the parameters' covariance at 1 px of corner noise; ``noise_px`` of each corner
    coordinate.
    """

    size: tuple[int, int]
    camera_matrix: FloatArray
    distortion: FloatArray
    normal: FloatArray
    noise_px: float
    model: str = "brown"

    def sigma_px(self, points_px: FloatArray, more: FloatArray | None = None) -> FloatArray:
        """(n,) spread, rms length in pixels, at picture points (n, 2); inf where unknown.

        ``more`` is added to ``normal`` (see ``information``).
        """
        normal = self.normal if more is None else self.normal + more
        slopes, known = self._slopes(points_px)
        try:
            covariance = np.linalg.inv(normal) * self.noise_px**2
        except np.linalg.LinAlgError:
            return np.full(len(points_px), np.inf)
        variances = np.einsum("nij,jk,nik->n", slopes, covariance, slopes)
        good = known & (variances >= 0.0) & np.isfinite(variances)
        return np.where(good, np.sqrt(np.where(good, variances, 0.0)), np.inf)

    @property
    def focal_share(self) -> float:
        """Relative spread of the focal length; inf if unknown."""
        try:
            covariance = np.linalg.inv(self.normal)
        except np.linalg.LinAlgError:
            return float("inf")
        spread = float(covariance[0, 0]) * self.noise_px**2
        return float(np.sqrt(spread) / self.camera_matrix[0, 0]) if spread >= 0.0 else float("inf")

    def _slopes(self, points_px: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """(n, 2, 4 + terms) slopes of undistorted points by parameters; (n,) True if known."""
        points = np.asarray(points_px, dtype=np.float64).reshape(-1, 1, 2)
        found = cv2.undistortPoints(
            points, self.camera_matrix, self.distortion, criteria=_UNDISTORT_ROUNDS
        )
        rays = np.asarray(found, dtype=np.float64).reshape(-1, 2)
        space = np.column_stack([rays, np.ones(len(rays))])
        zero = np.zeros(3)
        seen, slopes = cv2.projectPoints(space, zero, zero, self.camera_matrix, self.distortion)
        known = np.linalg.norm(seen.reshape(-1, 2) - points.reshape(-1, 2), axis=1) < _FOLDED_PX
        slopes = slopes.reshape(len(rays), 2, -1)
        by_ray = slopes[:, :, 3:5]
        count = self.normal.shape[0]
        turned = np.linalg.pinv(by_ray) @ slopes[:, :, 6 : 6 + count]
        focal = np.array([self.camera_matrix[0, 0], self.camera_matrix[1, 1]])
        moved = -focal[None, :, None] * turned
        return _without_homography(rays, focal, moved, known), known


def _without_homography(
    rays: FloatArray, focal: FloatArray, moved: FloatArray, known: NDArray[np.bool_]
) -> FloatArray:
    """Rest of movements (n, 2, m) after the small homography that undoes most of them."""
    if np.count_nonzero(known) < 4:
        return moved
    x, y = rays.T
    one, none = np.ones_like(x), np.zeros_like(x)
    right = np.stack([one, x, y, none, none, none, x * x, x * y], axis=1) * focal[0]
    down = np.stack([none, none, none, one, x, y, x * y, y * y], axis=1) * focal[1]
    small = np.stack([right, down], axis=1)
    of_known, by_known = small[known].reshape(-1, 8), moved[known].reshape(-1, moved.shape[2])
    undone = np.linalg.lstsq(of_known, by_known, rcond=None)[0]
    return np.asarray(moved - small @ undone)


def supposed_lens(size: tuple[int, int]) -> KnownLens:
    """Assumed lens of an unknown camera: a focal length near its width."""
    width = float(max(size))
    camera = np.array(
        [
            [0.9 * width, 0.0, (size[0] - 1) / 2],
            [0.0, 0.9 * width, (size[1] - 1) / 2],
            [0.0, 0.0, 1.0],
        ]
    )
    return KnownLens(size, camera, np.zeros(5), prior_normal(size, 0.2), 0.2)


def prior_normal(size: tuple[int, int], noise_px: float) -> FloatArray:
    """Normal matrix of an unknown lens."""
    width = float(max(size))
    spreads = [_PRIOR_FOCAL * width] * 2 + [_PRIOR_CENTRE * width] * 2 + list(_PRIOR_TERMS)
    return np.diag((noise_px / np.array(spreads)) ** 2)


def known_lens(views: Sequence[BoardView], terms: int = MOST_TERMS) -> KnownLens:
    """Fit lens and precision to views of one size.

    Raises ``CalibrationError`` if they determine none.
    """
    boards = [in_space(view.points_m) for view in views]
    try:
        _, matrix, distortion, turns, shifts = cv2.calibrateCamera(
            [board.astype(np.float32) for board in boards],
            [view.corners_px.astype(np.float32) for view in views],
            views[0].size,
            np.eye(3),
            np.zeros(5),
            flags=TERM_FLAGS[terms],
            criteria=_ROUNDS,
        )
    except cv2.error as error:
        raise CalibrationError("the lens cannot be estimated from these pictures") from error
    found = np.asarray(matrix, dtype=np.float64)
    bends = np.asarray(distortion, dtype=np.float64).reshape(-1)[:5]
    if not (np.isfinite(found).all() and np.isfinite(bends).all()):
        raise CalibrationError("the lens cannot be estimated from these pictures")
    normal = np.zeros((4 + terms, 4 + terms))
    squares, values = 0.0, 0
    for view, board, turn, shift in zip(views, boards, turns, shifts, strict=True):
        seen, slopes = cv2.projectPoints(board, turn, shift, found, bends)
        normal += _reduced(slopes, terms)
        squares += float(np.sum((seen.reshape(-1, 2) - view.corners_px) ** 2))
        values += 2 * len(board)
    free = values - 6 * len(views) - 4 - terms
    if free <= 0:
        raise CalibrationError("the pictures show too few corners to determine the lens")
    noise_px = max(_LEAST_NOISE_PX, float(np.sqrt(squares / free)))
    return KnownLens(views[0].size, found, bends, normal, noise_px)


def seen_through(lens: KnownLens, view: BoardView) -> FloatArray:
    """Addition of a view to ``normal``, through any lens; 0 without a pose."""
    found, turn, shift = cv2.solvePnP(
        in_space(view.points_m), view.corners_px.copy(), lens.camera_matrix, lens.distortion
    )
    if not found:
        return np.zeros_like(lens.normal)
    pose = (np.asarray(one, dtype=np.float64).ravel() for one in (turn, shift))
    return information(lens, view.points_m, *pose)


def information(
    lens: KnownLens, points_m: FloatArray, turn: FloatArray, shift: FloatArray
) -> FloatArray:
    """Addition to ``normal`` of board points (n, 2) in a pose, camera from board."""
    board = in_space(points_m)
    _, slopes = cv2.projectPoints(board, turn, shift, lens.camera_matrix, lens.distortion)
    return _reduced(slopes, lens.normal.shape[0] - 4)


def _reduced(slopes: NDArray[Any], terms: int) -> FloatArray:
    """Part of a view in the lens's normal matrix, its pose being free."""
    by_pose, by_lens = slopes[:, :6], slopes[:, 6 : 10 + terms]
    # scaled alike, so that the small matrix is invertible
    scale = np.linalg.norm(by_pose, axis=0)
    by_pose = by_pose / np.where(scale > 0.0, scale, 1.0)
    held = np.linalg.lstsq(by_pose, by_lens, rcond=None)[0]
    rest = by_lens - by_pose @ held
    return np.asarray(rest.T @ rest, dtype=np.float64)
