"""The lens from pictures of a board: camera matrix and distortion terms, of either model.

Rules
- Brown's model is fitted by Zhang's method in OpenCV, the fisheye's by
  ``vision.calibrate.fisheye``. The Bayesian information criterion sets the number of terms.
- Foreign pictures (`suspects`) are named and left out; more than a third is an error, and so is an
  undetermined focal length (all pictures from straight above).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibrate.board import BoardView, in_space
from vision.calibrate.covariance import TERM_FLAGS
from vision.calibrate.fisheye import fit_fisheye
from vision.calibrate.left_out import Estimate, left_out_px
from vision.calibrate.suspects import bad_px, compared_with, refuse_too_many, suspects
from vision.calibration.calibration import CalibrationError, FloatArray

MIN_VIEWS = 3
_WEAK_FOCAL = 0.01
_UNKNOWN_FOCAL = 0.1
_LEAST_TURN_DEG = 8.0
_GOOD_TURN_DEG = 20.0
"""Largest angle between two boards' planes: parallel planes do not determine the focal length
(Zhang 2000, 3.2), and the fit's spread does not show it."""
_KEPT_FITS = 256
"""The search for foreign pictures, the number of terms and the residual on ones left out ask for
some 100 fits, a third of them again."""
TERMS = {"brown": tuple(TERM_FLAGS), "fisheye": (0, 1, 2, 4)}
"""Numbers of terms for each model."""


@dataclass(frozen=True, slots=True, eq=False)
class Lens:
    """``camera_matrix`` (3, 3), ``distortion`` (5,), fisheye's (4,), and rms over all corners.

    ``terms`` is the number of distortion terms; ``used`` the pictures' names and rms;
    ``left_out_rms_px`` the residual on left-out views, None with too few; ``left_out_px`` both
    models' if compared.
    """

    size: tuple[int, int]
    camera_matrix: FloatArray
    distortion: FloatArray
    rms_px: float
    terms: int
    used: tuple[tuple[str, float], ...]
    remarks: tuple[str, ...]
    model: str = "brown"
    left_out_px: tuple[tuple[str, float], ...] = ()
    left_out_rms_px: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class LensFit:
    """One fit: ``view_px`` (v,) rms of each view, ``focal_spread`` relative, ``turn_deg`` the
    largest angle between two boards.
    """

    rms_px: float
    camera_matrix: FloatArray
    distortion: FloatArray
    focal_spread: float
    view_px: FloatArray
    turn_deg: float
    model: str = "brown"


def estimate_lens(
    views: Sequence[BoardView], terms: int | None = None, model: str = "brown"
) -> Lens:
    """Estimate the lens from at least three views of a board.

    ``terms``: 0, 1, 2, 4 or, for Brown's ``model``, 5 distortion terms; None chooses. Raises
    ``CalibrationError`` for too few pictures or if they do not determine the lens.
    """
    if model not in TERMS:
        raise CalibrationError(f"lens model {model!r}: must be {' or '.join(TERMS)}")
    if terms is not None and terms not in TERMS[model]:
        *few, last = map(str, TERMS[model])
        said = f"must be {', '.join(few)} or {last}" + ("" if model == "brown" else " (fisheye)")
        raise CalibrationError(f"distortion terms = {terms}: {said}")
    good, remarks = _same_size(views)
    if len(good) < MIN_VIEWS:
        raise CalibrationError(
            f"{len(good)} usable pictures of the board: must be at least {MIN_VIEWS}"
        )
    start: FloatArray | None = None
    if model == "fisheye":
        good, start = _without_bad_views(good, remarks)
    else:
        foreign = suspects(good, estimate_for(good))
        refuse_too_many(good, foreign)
        remarks += [f"{good[one.index].name}: left out, {one.reason}" for one in foreign]
        left_out = {one.index for one in foreign}
        good = [view for i, view in enumerate(good) if i not in left_out]
    chosen = terms if terms is not None else _best_terms(good, model, start)
    fit = fit_lens(good, chosen, model, start)
    if fit.focal_spread > _UNKNOWN_FOCAL or fit.turn_deg < _LEAST_TURN_DEG:
        raise CalibrationError(
            "the pictures do not determine the focal length: take some with the board tilted "
            "by 20 to 40 degrees, in different directions"
        )
    if fit.focal_spread > _WEAK_FOCAL or fit.turn_deg < _GOOD_TURN_DEG:
        remarks.append(
            f"the board's pictures differ in tilt by {fit.turn_deg:.0f} degrees only, the focal "
            f"length is known to {100 * fit.focal_spread:.1f} %: add pictures with it tilted"
        )
    used = tuple((v.name, float(e)) for v, e in zip(good, fit.view_px, strict=True))
    return Lens(
        good[0].size,
        fit.camera_matrix,
        fit.distortion,
        fit.rms_px,
        chosen,
        used,
        tuple(remarks),
        model,
        left_out_rms_px=_left_out_rms_px(good, chosen, model, start),
    )


def estimate_for(views: Sequence[BoardView]) -> Estimate:
    """Estimate of Brown's lens that compares these views.

    It has the terms that all views ask for, two at least. Raises ``CalibrationError`` if they
    determine no lens.
    """
    return partial(fit_lens, terms=max(2, _best_terms(views, "brown", None)))


def _without_bad_views(
    views: list[BoardView], remarks: list[str]
) -> tuple[list[BoardView], FloatArray]:
    """Drop a fisheye's badly fitting views, the worst first; return a camera matrix near it too.

    ``remarks`` names them; more than a third is refused.
    """
    good = list(views)
    fit = fit_lens(good, 2, "fisheye")
    start = fit.camera_matrix
    while len(good) > MIN_VIEWS:
        worst = int(np.argmax(fit.view_px))
        if fit.view_px[worst] <= bad_px(float(np.median(fit.view_px))):
            break
        del good[worst]
        fit = fit_lens(good, 2, "fisheye", start)
    left_out = [i for i, view in enumerate(views) if not any(view is one for one in good)]
    foreign = compared_with(views, left_out, fit, float(np.median(fit.view_px)))
    refuse_too_many(views, foreign)
    remarks += [f"{views[one.index].name}: left out, {one.reason}" for one in foreign]
    return good, start


def _left_out_rms_px(
    views: Sequence[BoardView], terms: int, model: str, start: FloatArray | None
) -> float | None:
    """Rms of views under the others' lens; None if the others determine none."""
    if len(views) <= MIN_VIEWS:
        return None
    try:
        found = left_out_px(views, partial(fit_lens, terms=terms, model=model, start=start))
    except CalibrationError:
        return None
    return float(np.sqrt(np.mean(found * found)))


def _same_size(views: Sequence[BoardView]) -> tuple[list[BoardView], list[str]]:
    sizes = [v.size for v in views]
    common = max(sizes, key=sizes.count) if sizes else (0, 0)
    remarks = [
        f"{v.name}: left out, {v.size[0]}x{v.size[1]} pixels where the others have "
        f"{common[0]}x{common[1]}"
        for v in views
        if v.size != common
    ]
    return [v for v in views if v.size == common], remarks


def _best_terms(views: Sequence[BoardView], model: str, start: FloatArray | None) -> int:
    values = 2 * sum(len(v.corners_px) for v in views)

    def criterion(terms: int) -> float:
        rms_px = max(fit_lens(views, terms, model, start).rms_px, 1e-6)
        return values * math.log(rms_px * rms_px) + terms * math.log(values)

    return min(TERMS[model], key=criterion)


def fit_lens(
    views: Sequence[BoardView],
    terms: int,
    model: str = "brown",
    start: FloatArray | None = None,
) -> LensFit:
    """Fit ``terms`` terms to all views once; ``CalibrationError`` if that fails.

    ``start``: a camera matrix (3, 3) near the fisheye's, which saves a search.
    """
    if model == "fisheye":
        return _fit_fisheye(views, terms, start)
    return _fit_brown(tuple(views), terms)


def _fit_fisheye(views: Sequence[BoardView], terms: int, start: FloatArray | None) -> LensFit:
    near = None if start is None else start[[0, 1, 0, 1], [0, 1, 2, 2]]
    found = fit_fisheye(views, terms, near)
    fx, fy, cx, cy = found.camera.tolist()
    squares = (found.errors**2).sum(axis=1)
    if not (fx > 0.0 and fy > 0.0 and np.isfinite(squares).all()):
        raise CalibrationError("the lens cannot be estimated from these pictures as a fisheye")
    starts = np.cumsum([0, *(len(v.corners_px) for v in views[:-1])])
    counts = np.diff([*starts, len(squares)])
    return LensFit(
        float(np.sqrt(squares.mean())),
        np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]),
        found.terms,
        found.focal_spread_px / fx,
        np.sqrt(np.add.reduceat(squares, starts) / counts),
        _largest_turn_deg([cv2.Rodrigues(pose[:3])[0] for pose in found.poses]),
        "fisheye",
    )


@lru_cache(_KEPT_FITS)
def _fit_brown(views: tuple[BoardView, ...], terms: int) -> LensFit:
    boards = [in_space(v.points_m) for v in views]
    try:
        rms, matrix, lens, turns, _, spreads, _, view_px = cv2.calibrateCameraExtended(
            [b.astype(np.float32) for b in boards],
            [v.corners_px.astype(np.float32) for v in views],
            views[0].size,
            np.eye(3),
            np.zeros(5),
            flags=TERM_FLAGS[terms],
        )
    except cv2.error as error:
        raise CalibrationError("the lens cannot be estimated from these pictures") from error
    camera = np.asarray(matrix, dtype=np.float64)
    if not (np.isfinite(camera).all() and math.isfinite(rms)):
        raise CalibrationError("the lens cannot be estimated from these pictures")
    distortion = np.asarray(lens, dtype=np.float64).reshape(-1)[:5]
    each_px = np.asarray(view_px, dtype=np.float64).reshape(-1)
    for kept in (camera, distortion, each_px):
        kept.setflags(write=False)
    return LensFit(
        float(rms),
        camera,
        distortion,
        float(np.ravel(spreads)[0] / camera[0, 0]),
        each_px,
        _largest_turn_deg([cv2.Rodrigues(np.asarray(t, dtype=np.float64))[0] for t in turns]),
    )


def _largest_turn_deg(rotations: Sequence[NDArray[Any]]) -> float:
    normals = np.array([np.asarray(r)[:, 2] for r in rotations])
    return math.degrees(math.acos(min(1.0, max(-1.0, float((normals @ normals.T).min())))))
