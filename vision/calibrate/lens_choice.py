"""Choice of Brown's lens model or the fisheye's: the one that predicts unseen views.

Rules
- A fifth of the views is left out at a time and gets only a pose: a model that overfits fails.
- Brown's stays unless the fisheye's is better by a fiftieth: narrow lenses suit both.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vision.calibrate.board import BoardView
from vision.calibrate.left_out import residuals_px
from vision.calibrate.lens import MIN_VIEWS, Lens, estimate_lens, fit_lens
from vision.calibration.calibration import CalibrationError, FloatArray
from vision.calibration.lens_model import MODELS

_FOLDS = 5
_BETTER = 0.98
"""Share of Brown's residual below which the fisheye's model is taken."""


def choose_lens(views: Sequence[BoardView], terms: int | None = None) -> Lens:
    """Fit both models and return the better one on left-out views.

    ``Lens.left_out_px`` has both, rms px, infinite for a model that fits nothing. Raises
    ``CalibrationError`` if neither can be fitted.
    """
    lenses: dict[str, Lens] = {}
    refusals: dict[str, CalibrationError] = {}
    for model in MODELS:
        try:
            lenses[model] = estimate_lens(views, terms, model)
        except CalibrationError as error:
            refusals[model] = error
    if not lenses:
        raise refusals[MODELS[0]]
    names = {name for lens in lenses.values() for name, _ in lens.used}
    size = next(iter(lenses.values())).size
    used = [v for v in views if v.name in names and v.size == size]
    residuals = {m: left_out_px(used, lenses[m]) if m in lenses else math.inf for m in MODELS}
    better = residuals["fisheye"] < _BETTER * residuals["brown"]
    chosen = "fisheye" if better or "brown" not in lenses else "brown"
    if chosen not in lenses:
        raise refusals[chosen]
    return replace(lenses[chosen], left_out_px=tuple(residuals.items()))


def left_out_px(views: Sequence[BoardView], lens: Lens) -> float:
    """Rms over the corners of left-out views; infinite without a fit."""
    squares: list[FloatArray] = []
    for fold in range(min(_FOLDS, len(views))):
        rest = [v for i, v in enumerate(views) if i % _FOLDS != fold]
        if len(rest) < MIN_VIEWS:
            return math.inf
        try:
            fit = fit_lens(rest, lens.terms, lens.model, lens.camera_matrix)
        except CalibrationError:
            return math.inf
        for view in views[fold::_FOLDS]:
            squares.append((residuals_px(view, fit) ** 2).sum(axis=1))
    return float(np.sqrt(np.concatenate(squares).mean())) if squares else math.inf
