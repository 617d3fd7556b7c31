"""Light and dark: the two classes of a picture's grey values, and how safely they stand apart.

Grey values are 0 .. 255, free pixels light and obstacles dark.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.binarise_kernels import split_histogram
from vision.look import (
    BUSY_NOISE,
    CALM_NOISE,
    MEAN,
    NO_CALMING,
    SAFE_MARGIN_SIGMAS,
    Look,
    calming_of,
)

LEAST_CONTRAST = 8.0
"""Grey levels between light and dark below which nothing is taken for an obstacle."""
LEAST_CONTRAST_SIGMAS = 5.0
"""The same in standard deviations of the noise."""
DARKEST_SIGMAS = 2.0
"""How far below the middle the darkest free pixels are taken to be, in spreads of the light."""


@dataclass(frozen=True, slots=True)
class Classes:
    """Two classes of grey values: their middles, how wide each is, and how many are dark."""

    dark: float
    light: float
    light_spread: float
    dark_share: float

    @property
    def level(self) -> float:
        """Half-way between the classes."""
        return 0.5 * (self.dark + self.light)

    @property
    def contrast(self) -> float:
        """Grey levels between the classes."""
        return self.light - self.dark


def classes_of(look: Look, strongest: float | None = None) -> Classes | None:
    """The two classes of a picture, seen through a little smoothing where it is noisy."""
    strongest = look.noise if strongest is None else strongest
    calming = MEAN if CALM_NOISE <= strongest < BUSY_NOISE else calming_of(strongest)
    found = split_classes(look.counts_after(calming), look.noise * calming.left)
    if found is None:
        found = _rare_pixels(look.grey_after(calming), strongest * calming.left)
    if found is None or calming is NO_CALMING:
        return found
    # the spread that noise explains, as the unsmoothed picture would have it
    explained = float(np.hypot(look.noise, found.light_spread))
    return replace(found, light_spread=explained)


def split_classes(histogram: NDArray[np.int64], noise: float) -> Classes | None:
    """The two classes of a histogram (256,), or None where it has one class only.

    Minimum error thresholding (Kittler and Illingworth, 1986), which does not mind a class
    of one pixel in a thousand; no class is narrower than the noise and a grey level.
    """
    least = max(LEAST_CONTRAST, LEAST_CONTRAST_SIGMAS * noise)
    found, dark, light, spread, dark_share = split_histogram(histogram, noise, least)
    return Classes(dark, light, spread, dark_share) if found else None


def room_left(classes: Classes, noise: float) -> float:
    """How far the darkest free pixels stay from the level, as a share of the contrast."""
    uneven = np.sqrt(max(classes.light_spread**2 - noise**2, 0.0))
    return float(0.5 - DARKEST_SIGMAS * uneven / classes.contrast)


def least_room(look: Look, classes: Classes, side: Literal["dark", "light"]) -> float:
    """The same for light obstacles too, which uneven light spreads more than it does the ground."""
    room = room_left(classes, look.noise)
    if side == "dark":
        return room
    obstacles = grey_spread(look.counts[: math.ceil(classes.level)])
    uneven = max(obstacles**2 - look.noise**2, 0.0) ** 0.5
    return min(room, float(0.5 - DARKEST_SIGMAS * uneven / classes.contrast))


def _rare_pixels(grey: NDArray[Any], noise: float) -> Classes | None:
    """Dark pixels so rare that no sample shows them: look at the extremes of all pixels."""
    lowest, highest, _, _ = cv2.minMaxLoc(grey)
    middle = float(np.median(grey[:: max(1, grey.shape[0] // 64)]))
    least = max(LEAST_CONTRAST, 2.0 * SAFE_MARGIN_SIGMAS * noise)
    if middle - lowest >= least and middle - lowest >= highest - middle:
        return Classes(lowest, middle, 0.0, 0.0)
    if highest - middle >= least:
        return Classes(middle, highest, 0.0, 1.0)
    return None


def grey_spread(counts: NDArray[np.int64]) -> float:
    """The grey values' spread: the quartiles' distance, as a normal distribution's sigma."""
    running = np.cumsum(counts)
    low, high = np.searchsorted(running, running[-1] * np.array([0.25, 0.75]))
    return float(high - low) / 1.349
