"""Calibration of a moved camera by floor markers alone; the lens stays.

Rules and units
- Raw pixels, metres, y up. A marker with a known heading gives its four corners, any other its
  centre, where its diagonals cross.
- Four points show a contradiction; with six or more, contradicting markers are named and left out.
- The pose minimises distances in undistorted pixels (Levenberg and Marquardt). A fit worse than
  ``MOST_RMS_PX`` is refused.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibrate.survey import MIN_POINTS, robust_homography
from vision.calibration.calibration import (
    Calibration,
    CalibrationError,
    FloatArray,
    nominal_camera_matrix,
    plane_pose,
)
from vision.markers.reading import crossing

MOST_RMS_PX = 2.0
"""Largest rms of a fit: the default of ``safety.camera_moved_px``, at which the robot holds."""
LEAST_MARKERS = 3
"""With two markers that disagree, the moved one is unknown."""
_STEPS = 100


@dataclass(frozen=True, slots=True)
class Anchor:
    """A floor marker: centre and side in metres, and its right side's direction, if known."""

    id: int
    place_m: tuple[float, float]
    size_m: float
    heading_rad: float | None = None

    def corners_m(self) -> FloatArray:
        """Corners (4, 2), clockwise from the upright marker's top left; without a heading the
        centre."""
        middle = np.array(self.place_m)
        if self.heading_rad is None:
            return middle[None]
        c, s = math.cos(self.heading_rad), math.sin(self.heading_rad)
        right, up = np.array([c, s]), np.array([-s, c])
        signs = ((-1, 1), (1, 1), (1, -1), (-1, -1))
        return np.array([middle + 0.5 * self.size_m * (i * right + j * up) for i, j in signs])


@dataclass(frozen=True, slots=True)
class Residual:
    """A marker's rms distance in the new calibration, and if it was used."""

    id: int
    rms_px: float
    used: bool


@dataclass(frozen=True, slots=True, eq=False)
class Reanchored:
    """The new calibration, each marker's residual, and the picture's shift.

    ``moved_px`` is the used markers' median distance from their places by the old calibration;
    ``missing`` lists unseen anchors.
    """

    calibration: Calibration
    residuals: tuple[Residual, ...]
    rms_px: float
    moved_px: float
    missing: tuple[int, ...]


def reanchor(
    calibration: Calibration, anchors: Sequence[Anchor], seen: Sequence[Mapping[int, FloatArray]]
) -> Reanchored:
    """Calibrate a camera that was moved since ``calibration`` was made.

    ``seen``: each picture's marker corners (4, 2) px by id; a marker counts with its median over
    pictures. Raises ``CalibrationError`` for a calibration without a lens, fewer than
    ``LEAST_MARKERS`` markers, or contradictory ones.
    """
    if np.array_equal(calibration.camera_matrix, nominal_camera_matrix(calibration.size)):
        raise CalibrationError(
            "the calibration has no lens, its focal length is supposed: calibrate with pictures of "
            "a board first, or place the camera by clearway calibrate --points"
        )
    corners = {
        one.id: np.median([picture[one.id] for picture in seen if one.id in picture], axis=0)
        for one in anchors
        if any(one.id in picture for picture in seen)
    }
    known = [one for one in anchors if one.id in corners]
    missing = tuple(one.id for one in anchors if one.id not in corners)
    _refuse_too_few(known, missing)
    places = np.concatenate([one.corners_m() for one in known])
    pixels = np.concatenate(
        [
            corners[one.id] if one.heading_rad is not None else [crossing(corners[one.id])]
            for one in known
        ]
    )
    owner = np.repeat([one.id for one in known], [len(one.corners_m()) for one in known])
    ideal = calibration.undistort_points(pixels)
    homography, agrees = robust_homography(ideal, places)
    # a marker is used as a whole or not at all
    used_ids = {one.id for one in known if agrees[owner == one.id].all()}
    used = np.isin(owner, sorted(used_ids))
    if len(used_ids) < LEAST_MARKERS:
        raise _contradiction(sorted(set(corners) - used_ids))
    pose = _refined(
        _pose_of(calibration.camera_matrix, homography), calibration, ideal, places, used
    )
    errors = np.hypot(*(_projected(pose, calibration, places) - ideal).T)
    rms_px = float(np.sqrt(np.mean(errors[used] ** 2)))
    residuals = tuple(
        Residual(one.id, float(np.sqrt(np.mean(errors[owner == one.id] ** 2))), one.id in used_ids)
        for one in known
    )
    if rms_px > MOST_RMS_PX:
        worst = sorted(residuals, key=lambda r: -r.rms_px)[0]
        raise CalibrationError(
            f"the floor markers fit no place of the camera: {rms_px:.1f} px rms, must be at most "
            f"{MOST_RMS_PX:g}; the worst is {worst.id} with {worst.rms_px:.1f} px: one was moved, "
            "or a place in arena.floor_markers is wrong"
        )
    away = np.hypot(*(calibration.image_from_arena(places) - pixels).T)
    return Reanchored(
        _placed(calibration, pose, rms_px, residuals),
        residuals,
        rms_px,
        float(np.median(away[used])),
        missing,
    )


def _refuse_too_few(known: Sequence[Anchor], missing: Sequence[int]) -> None:
    points = sum(len(one.corners_m()) for one in known)
    unseen = f"; not seen: {', '.join(map(str, missing))}" if missing else ""
    if len(known) < LEAST_MARKERS:
        raise CalibrationError(
            f"{len(known)} floor markers with a place are seen: must be at least "
            f"{LEAST_MARKERS}{unseen}"
        )
    if points < MIN_POINTS:
        raise CalibrationError(
            f"{len(known)} floor markers without a heading are seen: must be at least "
            f"{MIN_POINTS}, or give heading_deg{unseen}"
        )


def _contradiction(ids: Sequence[int]) -> CalibrationError:
    return CalibrationError(
        f"the floor markers contradict one another: {', '.join(map(str, ids))} would have to be "
        f"left out, and fewer than {LEAST_MARKERS} would remain"
    )


def _pose_of(camera: FloatArray, homography: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotation vector and shift, camera from arena, from a homography to the floor."""
    rotation, shift = plane_pose(np.linalg.solve(camera, np.linalg.inv(homography)))
    return np.asarray(cv2.Rodrigues(rotation)[0], dtype=np.float64), shift.reshape(3, 1)


def _refined(
    start: tuple[FloatArray, FloatArray],
    calibration: Calibration,
    ideal: FloatArray,
    places: FloatArray,
    used: NDArray[np.bool_],
) -> tuple[FloatArray, FloatArray]:
    solid = np.column_stack([places[used], np.zeros(int(used.sum()))])
    until = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, _STEPS, 1e-12)
    turn, shift = cv2.solvePnPRefineLM(
        solid,
        np.ascontiguousarray(ideal[used]),
        np.array(calibration.camera_matrix),
        np.zeros(4),
        start[0].copy(),
        start[1].copy(),
        until,
    )
    return np.asarray(turn, dtype=np.float64), np.asarray(shift, dtype=np.float64)


def _pixel_from_arena(pose: tuple[FloatArray, FloatArray], calibration: Calibration) -> FloatArray:
    rotation = np.asarray(cv2.Rodrigues(pose[0])[0], dtype=np.float64)
    columns = np.column_stack([rotation[:, 0], rotation[:, 1], pose[1].reshape(3)])
    return np.asarray(calibration.camera_matrix @ columns)


def _projected(
    pose: tuple[FloatArray, FloatArray], calibration: Calibration, places: FloatArray
) -> FloatArray:
    homogeneous = np.column_stack([places, np.ones(len(places))])
    seen = homogeneous @ _pixel_from_arena(pose, calibration).T
    return np.asarray(seen[:, :2] / seen[:, 2:])


def _placed(
    calibration: Calibration,
    pose: tuple[FloatArray, FloatArray],
    rms_px: float,
    residuals: Sequence[Residual],
) -> Calibration:
    rotation = np.asarray(cv2.Rodrigues(pose[0])[0], dtype=np.float64)
    center = -rotation.T @ pose[1].reshape(3)
    homography = np.linalg.inv(_pixel_from_arena(pose, calibration))
    used = sum(one.used for one in residuals)
    remarks = [f"anchored again by {used} floor markers"]
    remarks += [
        f"floor marker {one.id}: left out, {one.rms_px:.1f} px off"
        for one in residuals
        if not one.used
    ]
    placed = replace(
        calibration,
        arena_from_pixel=homography / homography[2, 2],
        camera_center_m=(float(center[0]), float(center[1]), float(center[2])),
        remarks=tuple(remarks),
    )
    return replace(placed, arena_rms_m=rms_px * placed.metres_per_pixel)
