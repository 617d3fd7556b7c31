"""Choice of Brown's lens model or the fisheye's: the one that predicts unseen views.

Rules
- Views are left out by turns and get only a pose (`left_out`): a model that overfits fails.
- Brown's stays unless the fisheye's is better by a fiftieth: narrow lenses suit both.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from vision.calibrate.board import BoardView
from vision.calibrate.lens import Lens, estimate_lens
from vision.calibration.calibration import CalibrationError
from vision.calibration.lens_model import MODELS

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
    found = {m: lenses[m].left_out_rms_px if m in lenses else None for m in MODELS}
    residuals = {m: math.inf if rms_px is None else rms_px for m, rms_px in found.items()}
    better = residuals["fisheye"] < _BETTER * residuals["brown"]
    chosen = "fisheye" if better or "brown" not in lenses else "brown"
    if chosen not in lenses:
        raise refusals[chosen]
    return replace(lenses[chosen], left_out_px=tuple(residuals.items()))
