"""Residuals of views of a board under a lens estimated without them.

Rules and units
- A view's pull on the lens would hide its error; only its pose is fitted.
- Views are left out in at most ``FOLDS`` parts (cross-validation).
- Residuals are raw pixels.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, TypeAlias

import cv2
import numpy as np

from vision.calibrate.board import BoardView, in_space
from vision.calibrate.fisheye import pose_errors
from vision.calibration.calibration import FloatArray

FOLDS = 10


class SeenThrough(Protocol):
    """Part of a lens that a view needs."""

    @property
    def camera_matrix(self) -> FloatArray:
        """(3, 3)."""

    @property
    def distortion(self) -> FloatArray:
        """OpenCV's terms."""

    @property
    def model(self) -> str:
        """``brown`` or ``fisheye``."""


Estimate: TypeAlias = Callable[[Sequence[BoardView]], SeenThrough]
"""The lens from some views; raises ``CalibrationError`` where they do not determine one."""


def residuals_px(view: BoardView, lens: SeenThrough) -> FloatArray:
    """(n, 2) corners of the board's best pose under the lens, minus those found; inf without
    one."""
    if lens.model == "fisheye":
        camera = lens.camera_matrix[[0, 1, 0, 1], [0, 1, 2, 2]]
        errors = pose_errors(view, camera, lens.distortion)
        return np.full_like(view.corners_px, np.inf) if errors is None else errors
    board = in_space(view.points_m)
    corners = np.ascontiguousarray(view.corners_px, dtype=np.float64)
    try:
        found, turn, shift = cv2.solvePnP(board, corners, lens.camera_matrix, lens.distortion)
    except cv2.error:
        found = False
    if not found:
        return np.full_like(corners, np.inf)
    seen, _ = cv2.projectPoints(board, turn, shift, lens.camera_matrix, lens.distortion)
    return np.asarray(seen.reshape(-1, 2) - corners, dtype=np.float64)


def rms_px(residuals: FloatArray) -> float:
    """Rms length of residuals (n, 2)."""
    return float(np.sqrt(np.mean(np.sum(residuals * residuals, axis=1))))


def left_out_px(views: Sequence[BoardView], estimate: Estimate) -> FloatArray:
    """(n,) rms of each view under the lens of views without it."""
    found = np.empty(len(views))
    folds = min(FOLDS, len(views))
    for fold in range(folds):
        others = [view for i, view in enumerate(views) if i % folds != fold]
        lens = estimate(others)
        for i in range(fold, len(views), folds):
            found[i] = rms_px(residuals_px(views[i], lens))
    return found
