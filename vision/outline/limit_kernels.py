"""Limits on what edges may miss, from a picture's noise, blur and greys.

Rules and units
- Pixels, but ``OutlineLimits.skip`` in points and budgets in square pixels.
- ``tolerance``: see ``vision.outline.fitting.Tolerance``.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF, OWNING
from vision.outline.fit.outline_kernels import KNOWN_PX, STRAY_PX
from vision.outline.outline_types import OutlineLimits

QUIET_PX, NOISY_PX = 0.1, 0.2
"""Noise of a point between which a picture becomes noisy: chosen."""
LOUD_PX = 0.5 * (QUIET_PX + NOISY_PX)
"""Noise that outweighs what little blur does: derived, half-way."""
CRISP_TANGENT_PX = 0.3
"""Largest miss of two smoothly joined edges without grey: chosen. With grey ``KNOWN_PX``, noise
aside."""
CUT_PX = 0.7
"""Blur's worth of a missing corner pixel: chosen, the sides still meet there."""
MOST_MISS_PX = 1.0
"""Largest distance of an edge from a border without noise: defined, the pixel that is promised, at
a tip too."""
FREE_LOSS_PX = 0.02
"""Deviation that is no lost area: chosen."""
CHORD_PX = 0.2
"""Largest distance of a ragged stretch's chord from its border points: chosen."""
CRISP_CHORD_PX = 0.34
"""The same without grey: indifferent, half a pixel along the axis at 45 degrees."""
LOSS_SHARE, LEAST_LOSS = 0.0035, 1.0
"""Area that an object's edges may lose, as a share of its own, and in pixels: defined, the promise
of the page on outlines."""


@njit(**LEAF)
def limits_of(tolerance, bilevel):
    """The limits of a picture; ``bilevel``: edges must separate every crack's pixels."""
    crisp = tolerance.crisp
    dead_zone = tolerance.dead_zone_px
    sigma = tolerance.sigma_px
    spread = tolerance.spread_px
    worst = dead_zone + 0.12 if crisp else 0.35 + dead_zone + 4.5 * sigma
    return OutlineLimits(
        crisp,
        worst,
        min(worst, STRAY_PX),
        0.9 if crisp else 0.35 + dead_zone + 2.5 * sigma,
        math.ceil(tolerance.trim_px),
        tolerance.guard_px,
        CUT_PX if bilevel else tolerance.blur_px,
        CRISP_TANGENT_PX if crisp else KNOWN_PX + spread,
        FREE_LOSS_PX + 2.0 * spread,
        MOST_MISS_PX + 4.5 * spread,
        CRISP_CHORD_PX if crisp else CHORD_PX + 2.0 * spread,
        _expected_cost(dead_zone, sigma, spread),
    )


@njit(**LEAF)
def _expected_cost(dead_zone, sigma, spread):
    if spread <= 0.0:
        return 0.0
    a = dead_zone / spread
    tail = 0.5 * math.erfc(a / math.sqrt(2.0))
    density = math.exp(-0.5 * a * a) / math.sqrt(2.0 * math.pi)
    return 2.0 * ((1.0 + a * a) * tail - a * density) * (spread / sigma) ** 2


@njit(**OWNING)
def allow_losses(point_starts, areas, owners, pixels, budgets):
    """Fill each border's ``budgets``, and ``pixels``, its object's without holes.

    An object's loss is divided among its borders by their points.
    """
    borders = areas.shape[0]
    lengths = np.zeros(borders, np.int64)
    for b in range(borders):
        pixels[owners[b]] += areas[b]
        lengths[owners[b]] += point_starts[b + 1] - point_starts[b]
    for b in range(borders):
        pixels[b] = pixels[owners[b]]
        allowed = max(LOSS_SHARE * pixels[b], LEAST_LOSS)
        length = point_starts[b + 1] - point_starts[b]
        budgets[b] = allowed * length / max(lengths[owners[b]], 1)


@njit(**LEAF)
def longest_of(starts):
    """Length of the longest of consecutive sequences."""
    longest = 0
    for b in range(starts.shape[0] - 1):
        longest = max(longest, starts[b + 1] - starts[b])
    return longest
