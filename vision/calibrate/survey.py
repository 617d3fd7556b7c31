"""The arena's homography from surveyed points or from a board on the floor.

Rules and units
- A surveyed point is a raw pixel (centres at integers) and its place in metres, y up. Four are
  enough; six or more can show a wrong one.
- The start is the least median of squares over minimal sets (Rousseeuw 1984), then least squares of
  the agreeing points. Others are left out and named.
- A point's residual comes from the fit without it: its own pull would hide its error.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibrate.board import BoardView
from vision.calibrate.lens import Lens
from vision.calibration.calibration import (
    Calibration,
    CalibrationError,
    FloatArray,
    camera_center,
    nominal_camera_matrix,
)
from vision.calibration.calibration_file import read_text

MIN_POINTS = 4
CHECKED_POINTS = 6
"""Least number of points at which a wrong one can be distinguished."""

_OUTLIER_SPREADS = 4.5
_LEAST_SPREAD_PX = 0.5
_MOST_SETS = 1500
_LEAST_AREA = 1e-3
_RIM_PX = 1.0
"""Distance outside the picture at which a point on its rim may be read."""


@dataclass(frozen=True, slots=True, eq=False)
class Survey:
    """``pixels`` (n, 2) raw and ``places_m`` (n, 2); ``names`` (n) for messages."""

    pixels: FloatArray
    places_m: FloatArray
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class ArenaFit:
    """A calibration, each point's residual (n, 2) m by the fit without it, and if it was used."""

    calibration: Calibration
    residuals_m: FloatArray
    used: tuple[bool, ...]


def read_survey(path: str | Path) -> Survey:
    """Read lines ``px,py,x_m,y_m``; ``#`` begins a comment, one heading is allowed.

    Raises ``CalibrationError`` with the wrong line.
    """
    text = read_text(path)
    rows: list[tuple[float, ...]] = []
    names: list[str] = []
    heading_seen = False
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split("#", 1)[0].replace(",", " ").replace(";", " ").split()
        if not words:
            continue
        try:
            row = tuple(float(word) for word in words)
        except ValueError:
            if not rows and not heading_seen and not any(c.isdigit() for c in words[0]):
                heading_seen = True
                continue
            raise CalibrationError(f"{path}:{number}: must be px,py,x_m,y_m") from None
        if len(row) != 4 or not all(math.isfinite(v) for v in row):
            raise CalibrationError(f"{path}:{number}: must be four finite numbers, px,py,x_m,y_m")
        rows.append(row)
        names.append(f"line {number}")
    table = np.array(rows, dtype=np.float64).reshape(-1, 4)
    return Survey(table[:, :2], table[:, 2:], tuple(names))


def board_survey(
    view: BoardView, origin_m: tuple[float, float] = (0.0, 0.0), heading_rad: float = 0.0
) -> Survey:
    """A board on the floor as a survey: first corner at ``origin_m``, rows by ``heading_rad``."""
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    places = view.points_m @ np.array([[c, s], [-s, c]]) + np.array(origin_m)
    names = tuple(f"corner {i}" for i in range(len(places)))
    return Survey(view.corners_px, places, names)


def fit_arena(
    survey: Survey,
    size: tuple[int, int],
    lens: Lens | None = None,
    camera_height_m: float | None = None,
) -> ArenaFit:
    """Fit the calibration to a survey; ``size`` is the picture's (width, height).

    Without a lens the camera's place stays unknown, unless ``camera_height_m`` gives its height
    above the picture's middle. With a lens, a given height corrects the place. Raises
    ``CalibrationError`` for fewer than four points, points in a line, or a mirror.
    """
    _check(survey)
    if lens is not None and lens.size != size:
        raise CalibrationError(
            f"the lens was calibrated with {lens.size[0]}x{lens.size[1]} pixels, the arena's "
            f"picture has {size[0]}x{size[1]}"
        )
    _refuse_outside(survey, size)
    camera = lens.camera_matrix if lens is not None else nominal_camera_matrix(size)
    distortion = lens.distortion if lens is not None else np.zeros(5)
    model = lens.model if lens is not None else "brown"
    plane = Calibration(size, camera, distortion, _ANY_FLOOR, lens_model=model)
    ideal = plane.undistort_points(survey.pixels)
    _refuse_folded(survey, ideal)
    homography, used = robust_homography(ideal, survey.places_m)
    _refuse_mirrored(homography, ideal[used])
    residuals = _left_out_residuals(ideal, survey.places_m, used)
    remarks = list(lens.remarks) if lens is not None else []
    remarks += _say_left_out(survey, residuals, used)
    rms_m = float(np.sqrt(np.mean(np.sum(residuals[used] ** 2, axis=1))))
    n = int(np.count_nonzero(used))
    if n < 5:
        rms_m = 0.0
        remarks.append("four surveyed points fit any error: survey six or more to see it")
    elif n < CHECKED_POINTS:
        remarks.append("five surveyed points cannot show which is wrong: survey six or more")
    calibration = Calibration(
        size,
        camera,
        distortion,
        homography,
        _center(camera, homography, lens, size, camera_height_m),
        lens.rms_px if lens is not None else None,
        None if n < 5 else rms_m,
        tuple(remarks),
        lens_model=model,
    )
    return ArenaFit(calibration, residuals, tuple(bool(u) for u in used))


_ANY_FLOOR = np.diag([1.0, -1.0, 1.0])
"""A floor for a calibration that needs its lens only."""


def _center(
    camera: FloatArray,
    homography: FloatArray,
    lens: Lens | None,
    size: tuple[int, int],
    height_m: float | None,
) -> tuple[float, float, float] | None:
    if height_m is not None and not (math.isfinite(height_m) and height_m > 0.0):
        raise CalibrationError(f"camera height = {height_m} m: must be > 0")
    if lens is not None:
        x, y, z = camera_center(camera, homography)
        return x, y, z if height_m is None else height_m
    if height_m is None:
        return None
    middle = homography @ np.array([(size[0] - 1) / 2.0, (size[1] - 1) / 2.0, 1.0])
    return float(middle[0] / middle[2]), float(middle[1] / middle[2]), height_m


def _check(survey: Survey) -> None:
    n = len(survey.pixels)
    if n < MIN_POINTS:
        raise CalibrationError(f"{n} surveyed points: must be at least {MIN_POINTS}")
    for what, points in (("pixels", survey.pixels), ("places", survey.places_m)):
        if not np.isfinite(points).all():
            raise CalibrationError(f"the surveyed {what} must be finite")
        spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        if not spread[1] > 1e-3 * spread[0]:
            raise CalibrationError(f"the surveyed {what} lie in one line")


def _refuse_outside(survey: Survey, size: tuple[int, int]) -> None:
    width, height = size
    for name, (x, y) in zip(survey.names, survey.pixels, strict=True):
        if not (-_RIM_PX <= x <= width - 1 + _RIM_PX and -_RIM_PX <= y <= height - 1 + _RIM_PX):
            raise CalibrationError(
                f"{name}: the pixel ({x:g}, {y:g}) must lie in the picture of {width}x{height}"
            )


def _refuse_folded(survey: Survey, ideal: FloatArray) -> None:
    for name, (x, y), there in zip(survey.names, survey.pixels, ideal, strict=True):
        if not np.isfinite(there).all():
            raise CalibrationError(f"{name}: the lens shows no ray at the pixel ({x:g}, {y:g})")


def _homography(pixels: FloatArray, places: FloatArray) -> FloatArray | None:
    """Least squares of the arena error, metres; None if undetermined."""
    found, _ = cv2.findHomography(pixels, places, 0)
    if found is None or not np.isfinite(found).all():
        return None
    matrix = np.asarray(found, dtype=np.float64)
    return matrix if abs(float(np.linalg.det(matrix))) > 0.0 else None


def _errors(homography: FloatArray, pixels: FloatArray, places: FloatArray) -> FloatArray:
    moved = pixels @ homography[:, :2].T + homography[:, 2]
    return np.asarray(moved[:, :2] / moved[:, 2:] - places)


def robust_homography(
    pixels: FloatArray, places: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Homography from undistorted pixels (n, 2) to places (n, 2), and the agreeing points.

    Fewer than ``CHECKED_POINTS`` all count. Raises ``CalibrationError`` if they determine none or
    contradict one another.
    """
    n = len(pixels)
    everything = np.ones(n, dtype=np.bool_)
    plain = _homography(pixels, places)
    if plain is None:
        raise CalibrationError("the surveyed points determine no plane")
    if n < CHECKED_POINTS:
        return plain, everything
    scale = math.sqrt(abs(float(np.linalg.det(np.cov(places.T)) / np.linalg.det(np.cov(pixels.T)))))
    floor_m = _LEAST_SPREAD_PX * math.sqrt(scale)
    best, best_median = plain, math.inf
    sets = np.array(_minimal_sets(n))
    for chosen in sets[_well_spread(pixels[sets]) & _well_spread(places[sets])]:
        candidate = _homography(pixels[chosen], places[chosen])
        if candidate is None:
            continue
        distances = np.linalg.norm(_errors(candidate, pixels, places), axis=1)
        # the set fits by construction; take the others' median
        median = float(np.sort(distances)[4 + (n - 4) // 2 - (n == 4)])
        if median < best_median:
            best, best_median = candidate, median
    used = everything
    for _ in range(5):
        distances = np.linalg.norm(_errors(best, pixels, places), axis=1)
        spread = max(1.4826 * float(np.median(distances)), floor_m)
        agreeing = distances <= _OUTLIER_SPREADS * spread
        if np.count_nonzero(agreeing) < MIN_POINTS + 1:
            raise CalibrationError("the surveyed points contradict one another")
        refined = _homography(pixels[agreeing], places[agreeing])
        if refined is None:
            raise CalibrationError("the surveyed points that agree determine no plane")
        best = refined
        if np.array_equal(agreeing, used):
            break
        used = agreeing
    return best, used


def _refuse_mirrored(homography: FloatArray, pixels: FloatArray) -> None:
    """Refuse mirrored or crossed points, which no camera above the arena can see.

    Pixels have y down and the arena y up: the Jacobian's determinant, det H / w^3, is negative
    everywhere.
    """
    w = pixels @ homography[2, :2] + homography[2, 2]
    senses = np.sign(np.linalg.det(homography) * w)
    if np.all(senses > 0.0):
        raise CalibrationError(
            "the surveyed points are mirrored: seen from above, x must point right where y points "
            "up; one axis has the wrong sign, x and y are exchanged, or the points were given in "
            "the opposite order"
        )
    if not np.all(senses < 0.0):
        raise CalibrationError(
            "the surveyed points are crossed: pixels and places of two of them are exchanged"
        )


def _minimal_sets(n: int) -> list[tuple[int, ...]]:
    """All sets of four, or a fixed sample of many."""
    if math.comb(n, 4) <= _MOST_SETS:
        return list(itertools.combinations(range(n), 4))
    rng = np.random.default_rng(0)
    return [tuple(rng.choice(n, 4, replace=False).tolist()) for _ in range(_MOST_SETS)]


def _well_spread(sets: FloatArray) -> NDArray[np.bool_]:
    """(m,) True for sets of four points (m, 4, 2) without three nearly in line."""
    extent = np.ptp(sets, axis=1).max(axis=1)
    spread = np.ones(len(sets), dtype=np.bool_)
    for a, b, c in itertools.combinations(range(4), 3):
        u, v = sets[:, b] - sets[:, a], sets[:, c] - sets[:, a]
        area = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
        spread &= area >= _LEAST_AREA * extent * extent
    return spread


def _left_out_residuals(
    pixels: FloatArray, places: FloatArray, used: NDArray[np.bool_]
) -> FloatArray:
    residuals = np.empty_like(places)
    for i in range(len(pixels)):
        others = used.copy()
        others[i] = False
        enough = np.count_nonzero(others) >= MIN_POINTS
        fit = _homography(pixels[others], places[others]) if enough else None
        if fit is None:
            fit = _homography(pixels[used], places[used])
        if fit is None:
            raise CalibrationError("the surveyed points determine no plane")
        residuals[i] = _errors(fit, pixels[i : i + 1], places[i : i + 1])[0]
    return residuals


def _say_left_out(survey: Survey, residuals: FloatArray, used: NDArray[np.bool_]) -> list[str]:
    usual_mm = 1000.0 * float(np.median(np.linalg.norm(residuals[used], axis=1)))
    return [
        f"{survey.names[i]}: left out, {1000.0 * float(np.linalg.norm(residuals[i])):.1f} mm off "
        f"where {usual_mm:.1f} mm is usual"
        for i in np.flatnonzero(~used)
    ]
