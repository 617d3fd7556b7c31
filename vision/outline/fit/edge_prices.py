"""Prices: the saving that one more line, arc or circle must bring.

Rules and units
- A stretch's cost is the sum over its points of ((|deviation| - dead zone) / sigma)^2 beyond the
  dead zone (see ``vision.outline.fit.edge_shape_kernels``); a price is in the same units.
- With every free number of a fit, white noise without a dead zone saves a chi-square of one degree
  of freedom, of mean 1. A break in a line brings two numbers, and saves more than t at a place with
  probability exp(-t / 2). A dead zone, or a sigma above the spread, lessens both.
- Lenses and prints bend lines, so the price does not fall below ``LEAST_LINE``.
"""

from __future__ import annotations

import math

from vision.outline.outline_types import Prices

LINE_CHANCE = 18.0
"""A line's price in units of noise's mean saving: chosen, the least that keeps false corners below
1 % at blur 1.5 and noise 20 (0.4 % measured; 1.5 % with 10). From 19 on, polygons with corners of
150 degrees begin to pass for arcs at noise 20."""
LEAST_LINE = 3.0**2 + 1.0
"""A line's price with hardly any noise: derived, one point more than three sigma off."""
SHARES = 1.0, 2.2, 1.8
"""Prices of a line, an arc and a whole circle in lines: chosen, an arc replaces two lines and a
corner, and a little, since a polygon of short sides is nearly round."""
CRISP_SHARES = 1.0, 2.0, 1.6
"""The same without grey: chosen, a small arc is hardly more than its staircase."""


def edge_prices(
    dead_zone_px: float, sigma_px: float, spread_px: float, crisp: bool = False
) -> Prices:
    """The prices of a line, an arc and a circle.

    ``spread_px``: the noise of a point; ``crisp``: the picture has no grey; the other two are those
    of the costs.
    """
    line = max(LEAST_LINE, LINE_CHANCE * saving_of_noise(dead_zone_px, sigma_px, spread_px))
    shares = CRISP_SHARES if crisp else SHARES
    return Prices(*(line * share for share in shares))


def saving_of_noise(dead_zone_px: float, sigma_px: float, spread_px: float) -> float:
    """Mean saving of noise with one more free number of a fit.

    The mean square of the slope of a point's cost over its mean curvature (P. J. Huber, Robust
    Statistics, 1981): 1 without a dead zone.
    """
    if spread_px <= 0.0:
        return 0.0
    a = dead_zone_px / spread_px
    beyond = math.erfc(a / math.sqrt(2.0))
    density = math.exp(-0.5 * a * a) / math.sqrt(2.0 * math.pi)
    square = (1.0 + a * a) * beyond - 2.0 * a * density
    return square / max(beyond, 1e-12) * (spread_px / sigma_px) ** 2
