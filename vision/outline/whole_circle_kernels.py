"""Borders that are one circle, and circles cut into arcs.

Types: ``vision.outline.outline_types``; ``circle`` (3,): cx, cy, r, pixels.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF
from vision.outline.fit.edge_shape_kernels import (
    HUGE,
    circle_cost,
    circle_rms,
    fit_circle,
    goes_round,
    refine_circle,
)
from vision.outline.fit.separating_fit_kernels import (
    HALF,
    lose_fewest,
    lost_to_circle,
    separate_circle,
)
from vision.outline.fitted_borders import LINE
from vision.outline.limit_kernels import LOUD_PX, MOST_MISS_PX
from vision.shared.typed_numbers import ZERO

LEAST_LOST = 1.0
"""Loss that does not cut a circle into arcs, whatever its budget: defined, a pixel."""
CIRCLE_INWARDS = 0.31
"""Shift of a circle inwards by blur, as a share of its variance over the radius: measured; half in
theory, but profiles that meet a circle aslant see a wider blur. Less with noise, none from
``LOUD_PX`` on. ``vision.outline.corners.fillet_kernels.half_variance`` gives more: nearer for most
circles, but 0.08 px too much at a radius of 5 px and a blur of 1.5 px."""
ROUGH = 64
"""Points that distinguish most shapes from a circle: indifferent, to spare work."""
THIRDS = np.int64(3)
"""Arcs of a circle that does not separate its pixels: derived, each is less than half of it."""


@njit(**LEAF, inline="always")
def circle_of_all(border, cracks, costs, budget, held, price, circle, near):
    """Find the circle through a whole border: its cost and price, and True if it nearly fits.

    The cost is HUGE if there is none. Without grey a circle that loses at most ``budget`` pixels is
    accepted at any cost. It nearly fits if it runs beside every point but loses more, and the
    object is ``held`` to its budget. ``near`` (2, n) is scratch space.
    """
    px = border.x
    py = border.y
    n = border.n
    crisp = costs.crisp
    bilevel = cracks.n > 0
    dead_zone = costs.dead_zone
    sigma = costs.sigma
    worst = costs.worst
    # a sample rules out most other shapes
    count = ZERO
    for k in range(0, n, max(1, n // ROUGH)):
        near[0, count], near[1, count] = px[k], py[k]
        count += 1
    if not fit_circle(near[0], near[1], ZERO, count, circle):
        return HUGE, False
    far = circle_cost(px, py, ZERO, n, circle, crisp, dead_zone, sigma, 2.0 * worst, HUGE)
    if far >= HUGE or not fit_circle(px, py, ZERO, n, circle):
        return HUGE, False
    refine_circle(px, py, ZERO, n, circle)
    if not goes_round(px, py, n, circle[0], circle[1]):
        return HUGE, False
    if crisp:
        separate_circle(px, py, ZERO, n, circle, near)
    cost = circle_cost(px, py, ZERO, n, circle, crisp, dead_zone, sigma, worst, HUGE)
    if not crisp:
        return price + cost, False
    fitted = circle[2]
    if bilevel:
        # a few far points pull squared costs, but a pixel is lost or not
        lost = lose_fewest(cracks, circle, near[0], near[1])
        worst = MOST_MISS_PX
    else:
        lost = lost_to_circle(px, py, n, circle)
    if circle_cost(px, py, ZERO, n, circle, crisp, HALF, 1.0, worst, HUGE) >= HUGE:
        circle[2] = fitted
    elif lost <= budget:
        return price, False
    elif held and cost < HUGE and lost > LEAST_LOST:
        return HUGE, True
    return price + cost, False


@njit(**LEAF)
def cut_circle(border, circle, outline):
    """Cut a circle into three arcs; returns their number."""
    n = border.n
    for t in range(THIRDS):
        k = t * n // THIRDS
        x = border.x[k] - circle[0]
        y = border.y[k] - circle[1]
        share = circle[2] / max(math.sqrt(x * x + y * y), 1e-9)
        outline.breaks[t] = k
        outline.is_arc[t] = True
        outline.joints[t, 0] = circle[0] + x * share
        outline.joints[t, 1] = circle[1] + y * share
        for c in range(3):
            outline.shape[t, c] = circle[c]
        outline.shape[t, 4] = 0.0
    return THIRDS


@njit(**LEAF, inline="always")
def write_circle(border, circle, tolerance, place, finished):
    """Write a whole border's circle as its one edge, moved to ``place``."""
    data = finished.rows
    finished.kind[0] = LINE
    data[0, 5] = circle_rms(border.x, border.y, ZERO, border.n, circle)
    if not tolerance.crisp:
        blur = tolerance.blur_px
        quiet = max(1.0 - tolerance.spread_px / LOUD_PX, 0.0)
        circle[2] += quiet * CIRCLE_INWARDS * blur * blur / max(circle[2], blur)
    data[0, 0] = place.x + circle[0] - circle[2]
    data[0, 1] = place.y + circle[1]
    data[0, 2] = place.x + circle[0]
    data[0, 3] = place.y + circle[1]
    data[0, 4] = circle[2]
