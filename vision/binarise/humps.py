"""Two humps of a picture's histogram distinguish fine structure from noise.

Noise has one. Walls and ways of a few pixels have two, which smoothing merges.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.binarise.binarise_kernels import halve_histogram

TWO_HUMPED = 0.75
"""Least share of a histogram's variance between two humps: derived, one hump has at most that, with
all values equally frequent."""
CONTRAST_KEPT = 0.75
"""Share of the contrast that harmless smoothing keeps at least: chosen, walls and ways of 3 px keep
0.69 at most, those of 4 px, which survive, up to 0.79."""


@dataclass(frozen=True, slots=True)
class Humps:
    """Dark and light half of a histogram.

    ``within``: the standard deviation in the halves; ``apart``: the share of the variance between
    them.
    """

    dark: float
    light: float
    dark_share: float
    within: float
    apart: float

    @property
    def contrast(self) -> float:
        """Grey levels between the means."""
        return self.light - self.dark

    @classmethod
    def of(cls, counts: NDArray[np.int64]) -> Humps:
        """Halves of a histogram (256,) with the least variance (Otsu, 1979)."""
        dark, light, share, between, variance = halve_histogram(counts)
        within = math.sqrt(max(variance - between, 0.0))
        return cls(dark, light, share, within, between / variance if variance > 0.0 else 0.0)


def deletes(as_it_came: Humps, smoothed: NDArray[np.int64]) -> bool:
    """True if smoothing, with the histogram ``smoothed`` (256,), deletes fine structure."""
    return Humps.of(smoothed).contrast < CONTRAST_KEPT * as_it_came.contrast
