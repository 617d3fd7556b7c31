"""A fisheye's camera matrix and terms from views of a board, by least squares.

Rules and units
- OpenCV's model (``vision.calibration.lens_model``), on angles, so that corners behind the camera's
  plane count too.
- Levenberg and Marquardt's method, with slopes from differences, starts from the best of several
  equidistant lenses.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibrate.board import BoardView
from vision.calibration.calibration import CalibrationError, FloatArray, plane_pose

_FOCAL_SHARES = (0.24, 0.33, 0.46, 0.65, 1.0)
"""First focal lengths, in picture widths: 240 to 57 degrees across."""
_MOST_START_RAD = 1.35
"""Farthest angle of corners in a first pose: their tangents outweigh all else."""
_START_STEPS, _MOST_STEPS = 5, 60
_DONE = 1e-7
"""Relative reduction of the sum of squares below which the fit is done."""
_STEP = 1e-6
_MOST_DAMPING = 1e12


class FisheyeFit(NamedTuple):
    """``camera`` (4,) fx, fy, cx, cy; ``terms`` (4,); ``poses`` (v, 6) turn and shift of boards;
    ``errors`` (n, 2) px of all corners; ``focal_spread_px`` standard deviation of fx.
    """

    camera: FloatArray
    terms: FloatArray
    poses: FloatArray
    errors: FloatArray
    focal_spread_px: float


@dataclass(frozen=True, slots=True)
class _Corners:
    """All views' corners: ``space`` (n, 3) on the board, ``pixels`` (n, 2), ``view`` (n,)."""

    space: FloatArray
    pixels: FloatArray
    view: NDArray[np.int64]
    count: int

    @classmethod
    def of(cls, views: Sequence[BoardView]) -> _Corners:
        flat = np.concatenate([v.points_m for v in views])
        return cls(
            np.column_stack([flat, np.zeros(len(flat))]),
            np.concatenate([v.corners_px for v in views]),
            np.repeat(np.arange(len(views)), [len(v.points_m) for v in views]),
            len(views),
        )


def fit_fisheye(
    views: Sequence[BoardView], terms: int, start: FloatArray | None = None
) -> FisheyeFit:
    """Fit the first ``terms`` of the lens's four terms; the others are 0.

    ``start`` (4,) is a camera near it, if known. Raises ``CalibrationError`` if no first lens fits.
    """
    corners = _Corners.of(views)
    width, height = views[0].size
    best: tuple[float, FloatArray, FloatArray] | None = None
    middle = ((width - 1) / 2.0, (height - 1) / 2.0)
    starts = [np.array([f * width, f * width, *middle]) for f in _FOCAL_SHARES]
    for lens in starts if start is None else [start]:
        poses = _first_poses(views, lens)
        if poses is None:
            continue
        lens, poses, errors, _ = _least_squares(corners, lens, poses, _START_STEPS)
        cost = float((errors**2).sum())
        if best is None or cost < best[0]:
            best = cost, lens, poses
    if best is None:
        raise CalibrationError("the lens cannot be estimated from these pictures as a fisheye")
    lens = np.concatenate([best[1], np.zeros(terms)])
    lens, poses, errors, spread_px = _least_squares(corners, lens, best[2], _MOST_STEPS)
    return FisheyeFit(lens[:4], np.pad(lens[4:], (0, 4 - terms)), poses, errors, spread_px)


def pose_errors(view: BoardView, camera: FloatArray, terms: FloatArray) -> FloatArray | None:
    """Errors (n, 2) px of a view's corners, only its pose fitted; None without a pose."""
    lens = np.concatenate([camera, terms])
    poses = _first_poses([view], lens)
    if poses is None:
        return None
    return _least_squares(_Corners.of([view]), lens, poses, _MOST_STEPS, known=True)[2]


def _first_poses(views: Sequence[BoardView], lens: FloatArray) -> FloatArray | None:
    """Poses (v, 6) from each board's homography to the rays; None if one fails."""
    found = []
    for view in views:
        seen = (view.corners_px - lens[2:4]) / lens[:2]
        radius = np.hypot(seen[:, 0], seen[:, 1])
        angle = np.minimum(_angle_at(radius, lens[4:]), 0.5 * math.pi)
        near = angle < _MOST_START_RAD
        if np.count_nonzero(near) < 6:
            return None
        rays = seen * (np.tan(angle) / np.maximum(radius, 1e-12))[:, None]
        homography, _ = cv2.findHomography(view.points_m[near], rays[near], 0)
        if homography is None or not np.isfinite(homography).all():
            return None
        rotation, shift = plane_pose(np.asarray(homography))
        found.append(np.concatenate([cv2.Rodrigues(rotation)[0].ravel(), shift]))
    return np.array(found)


def _angle_at(radius: FloatArray, terms: FloatArray) -> FloatArray:
    """Angle theta where theta_d is ``radius``, from a table; good enough to start."""
    angle = np.linspace(0.0, 0.5 * math.pi, 2000)
    seen = np.maximum.accumulate(_theta_d(angle, terms))
    return np.asarray(np.interp(radius, seen, angle, right=math.inf))


def _theta_d(angle: FloatArray, terms: FloatArray) -> FloatArray:
    squares = angle * angle
    even = np.ones_like(angle)
    power = np.ones_like(angle)
    for term in terms:
        power = power * squares
        even = even + term * power
    return np.asarray(angle * even)


def _errors(corners: _Corners, lens: FloatArray, poses: FloatArray) -> FloatArray:
    """Projected minus found corners (n, 2), pixels."""
    turns = np.array([cv2.Rodrigues(pose[:3])[0] for pose in poses])
    space = np.einsum("nij,nj->ni", turns[corners.view], corners.space) + poses[corners.view, 3:]
    across = np.hypot(space[:, 0], space[:, 1])
    radius = _theta_d(np.arctan2(across, space[:, 2]), lens[4:])
    seen = space[:, :2] * (radius / np.maximum(across, 1e-12))[:, None]
    return np.asarray(seen * lens[:2] + lens[2:4] - corners.pixels)


def _slopes(
    corners: _Corners, lens: FloatArray, poses: FloatArray, *, known: bool
) -> NDArray[np.float64]:
    """Derivatives of the errors (2 n, lens and 6 v); the lens's are 0 if ``known``."""
    whole = np.zeros((2 * len(corners.pixels), len(lens) + 6 * corners.count))
    for j in range(0 if known else len(lens)):
        step = np.zeros(len(lens))
        step[j] = _STEP * max(1.0, abs(lens[j]))
        there, here = _errors(corners, lens + step, poses), _errors(corners, lens - step, poses)
        whole[:, j] = (there - here).ravel() / (2.0 * step[j])
    rows = np.arange(2 * len(corners.pixels)).reshape(-1, 2)
    for j in range(6):
        step = np.zeros(6)
        step[j] = _STEP
        there, here = _errors(corners, lens, poses + step), _errors(corners, lens, poses - step)
        columns = len(lens) + 6 * corners.view + j
        whole[rows, columns[:, None]] = (there - here) / (2.0 * _STEP)
    return whole


def _least_squares(
    corners: _Corners, lens: FloatArray, poses: FloatArray, most_steps: int, *, known: bool = False
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    errors = _errors(corners, lens, poses)
    cost, damping = float((errors**2).sum()), 1e-3
    normal = np.eye(len(lens))
    for _ in range(most_steps):
        slopes = _slopes(corners, lens, poses, known=known)
        normal = slopes.T @ slopes
        right = slopes.T @ errors.ravel()
        # known parameters have no slope and stay
        scale = np.maximum(np.diag(normal), 1e-12)
        before = cost
        while damping < _MOST_DAMPING:
            step = np.linalg.solve(normal + np.diag(damping * scale), -right)
            new_lens, new_poses = lens + step[: len(lens)], poses + step[len(lens) :].reshape(-1, 6)
            tried = _errors(corners, new_lens, new_poses)
            tried_cost = float((tried**2).sum())
            if math.isfinite(tried_cost) and tried_cost < cost:
                lens, poses, errors, cost = new_lens, new_poses, tried, tried_cost
                damping = max(0.1 * damping, 1e-9)
                break
            damping *= 10.0
        if before - cost <= _DONE * before:
            break
    if known:
        return lens, poses, errors, 0.0
    free = max(errors.size - len(normal), 1)
    spread = np.linalg.pinv(normal)[0, 0] * cost / free
    return lens, poses, errors, math.sqrt(max(float(spread), 0.0))
