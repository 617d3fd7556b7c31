"""Lines, arcs and circles through sub-pixel edge points; every decision by residual.

Pixels (or rectified pixels), y down. The tolerance follows the picture's noise, the steepness of
its edges, and whether it was drawn without grey.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision.borders.contours import Contours, EdgePoints
from vision.outline.bilevel.separation_kernels import runs_between_two_greys
from vision.outline.fit.edge_prices import LEAST_LINE, edge_prices
from vision.outline.fit.outline_kernels import KNOWN_PX
from vision.outline.fitted_borders import FittedBorders
from vision.outline.fitting_kernels import fit_borders
from vision.outline.fitting_memory import make_fitted, memory_for
from vision.outline.limit_kernels import LOUD_PX, NOISY_PX, QUIET_PX, allow_losses, longest_of
from vision.outline.outline_types import CrackPixels, Prices
from vision.outline.separated_border_kernels import fit_separated_borders

SMOOTHING = 0.5311
"""Noise left by the profile's five-pixel Gaussian: derived, 1 / sqrt(2 sqrt(pi)) at sigma 1."""
FREE_PX = 0.12
"""Free deviation in a picture with grey (chosen); half of it in noise, where it would hide true
corners."""
STAIRCASE_PX = 0.5
"""Free deviation in a picture of black and white only, or blurred afterwards: derived, a pixel's
centre is no farther off its border."""


class Tolerance(NamedTuple):
    """Deviations that a fit allows: ``dead_zone_px`` is free, ``sigma_px`` the spread beyond it.

    ``crisp``: the picture has no grey at its edges; ``spread_px``: the noise of a point.
    ``blur_px``: spread of light at an edge (sigma). ``guard_px``: distance from a corner within
    which blur bends the border, and points take no part in a fit. ``trim_px``: the same while
    corners are sought.
    """

    crisp: bool
    dead_zone_px: float
    sigma_px: float
    spread_px: float
    blur_px: float
    guard_px: float
    trim_px: float

    @property
    def prices(self) -> Prices:
        """Saving that a line, an arc and a circle must bring."""
        return edge_prices(self.dead_zone_px, self.sigma_px, self.spread_px, self.crisp)


def tolerance_of(edges: EdgePoints, noise: float, contrast: float) -> Tolerance:
    """Tolerance for a picture's noise (grey levels), contrast and edges."""
    spread = SMOOTHING * noise / (edges.slope * max(contrast, 1.0))
    sigma = float(np.hypot(KNOWN_PX, spread))
    crispness = edges.crispness if edges.crispness > 0.3 else 0.0
    blur = edges.blur_px
    noisy = min(max((spread - QUIET_PX) / (NOISY_PX - QUIET_PX), 0.0), 1.0)
    free = FREE_PX * (1.0 - 0.5 * noisy)
    # so far out, noise outweighs the rest of the bend
    loud = min(1.0, spread / LOUD_PX)
    return Tolerance(
        crisp=crispness > 0.5,
        dead_zone_px=free + (STAIRCASE_PX - free) * max(crispness, staircase_share(edges, sigma)),
        sigma_px=sigma,
        spread_px=spread,
        blur_px=blur,
        guard_px=max(1.0, (2.1 - 1.1 * loud) * blur),
        trim_px=max(1.0, (2.1 - 0.65 * loud) * blur),
    )


def staircase_share(edges: EdgePoints, sigma_px: float) -> float:
    """Share of the pixels' staircase left at edges with grey: 0 .. 1.

    It counts only if it saves more than one more line must.
    """
    common, whole = edges.staircase
    saved = (2.0 * common - whole) / sigma_px**2
    return min(common / whole, 1.0) if saved > LEAST_LINE else 0.0


def is_bilevel(grey: NDArray[Any], borders: Contours) -> bool:
    """True if every border runs between the same two values of grey. O(1) for most others."""
    return bool(runs_between_two_greys(grey, borders.x, borders.y, borders.direction))


def fit_edges(
    points: NDArray[np.float64],
    starts: NDArray[np.int64],
    borders: Contours,
    tolerance: Tolerance,
    *,
    bilevel: bool = False,
) -> FittedBorders:
    """Partition every border into lines and arcs, or take it for a circle. O(points).

    ``bilevel``: the picture has two values of grey, and is in pixels: every border's edges must
    separate its obstacle pixels from free ones.
    """
    count = len(starts) - 1
    known = len(borders.x) if bilevel else 0
    longest = longest_of(starts)
    if bilevel:
        longest = max(longest, longest_of(borders.starts))
    budgets = np.empty(count)
    pixels = np.zeros(count, np.int64)
    allow_losses(starts, borders.area, borders.owner, pixels, budgets)
    fitted = make_fitted(count, max(len(points), known) + count)
    given = (np.ascontiguousarray(points), starts, budgets, pixels)
    rest = (tolerance, tolerance.prices, memory_for(longest), fitted)
    if bilevel:
        cracks = CrackPixels(borders.x, borders.y, borders.direction, borders.starts)
        edges = fit_separated_borders(*given, cracks, *rest)
    else:
        edges = fit_borders(*given, *rest)
    kind, rows = fitted.kind[:edges].copy(), fitted.rows[:edges].copy()
    return FittedBorders(fitted.border_kind, fitted.edge_starts, kind, rows)
