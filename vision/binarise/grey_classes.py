"""The two classes of a picture's grey values, and how well separated they are.

Grey values are 0 .. 255, obstacles dark.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.binarise.binarise_kernels import (
    SIGMAS,
    flat_histogram,
    plateau_share,
    split_histogram,
    steepest_level,
)
from vision.binarise.grey_picture import (
    FEWEST_SAMPLES,
    LEAST_CONTRAST,
    NO_SMOOTHING,
    GreyPicture,
)

LEAST_CONTRAST_SIGMAS = 5.0
"""Least contrast of two classes, in standard deviations of the noise. Chosen, by
``tests/vision/binarise``."""
PLATEAU, PLATEAU_SIGMAS = 0.04, 2.0
"""Largest distance of unblurred pixels from their class's middle, as a share of the contrast and in
standard deviations of the noise. Chosen, by ``tests/vision/binarise``."""
MOST_ON_PLATEAU = 0.7
"""Least share of such pixels in a class that needs no correction. Chosen, by
``tests/vision/binarise``."""
STEEP = 0.25
"""Least step between pixels that is an edge's, as a share of the contrast. Chosen, by
``tests/vision/binarise``."""


@dataclass(frozen=True, slots=True)
class Classes:
    """Middles and spreads of two classes of grey values, and the share of dark pixels.

    ``dark_spread`` is set only where it is not that of all dark pixels.
    """

    dark: float
    light: float
    light_spread: float
    dark_share: float
    dark_spread: float | None = None

    @property
    def level(self) -> float:
        """Level half-way between the classes."""
        return 0.5 * (self.dark + self.light)

    @property
    def contrast(self) -> float:
        """Grey levels between the classes."""
        return self.light - self.dark


def classes_of(picture: GreyPicture, strongest: float | None = None) -> Classes | None:
    """Two classes of a picture, smoothed a little if it is noisy."""
    strongest = picture.noise if strongest is None else strongest
    if picture.fine is not None:
        humps = picture.fine
        return Classes(humps.dark, humps.light, humps.within, humps.dark_share, humps.within)
    smoothing = picture.smoothing(strongest)
    counts = picture.counts_after(smoothing)
    found = split_classes(counts, picture.noise * smoothing.left)
    if found is None:
        found = _rare_pixels(picture.grey_after(smoothing), strongest * smoothing.left)
    else:
        found = _sharpened(found, picture, counts, picture.noise * smoothing.left)
    if found is None or smoothing is NO_SMOOTHING:
        return found
    # add the noise's spread, as the unsmoothed picture has it
    explained = math.hypot(picture.noise, found.light_spread)
    return replace(found, light_spread=explained)


def _sharpened(
    found: Classes, picture: GreyPicture, counts: NDArray[np.int64], noise: float
) -> Classes:
    """The classes, with the rarer one corrected if most of its pixels are edge.

    A blurred narrow wall's middle lies too near the other class, and its spread looks like uneven
    light. The level is then where edges are steepest, and the spread that of pixels off edges.
    ``noise`` is what is left in the histogram ``counts``.
    """
    dark_is_rare = found.dark_share < 0.5
    middle = found.dark if dark_is_rare else found.light
    reach = max(PLATEAU * found.contrast, PLATEAU_SIGMAS * noise)
    if plateau_share(counts, found.level, dark_is_rare, middle, reach) >= MOST_ON_PLATEAU:
        return found
    dark_side = np.arange(256) < found.level
    rare = dark_side if dark_is_rare else ~dark_side
    # two pixels of a plateau differ by at most its width
    wide = 2.0 * max(PLATEAU * found.contrast, PLATEAU_SIGMAS * picture.noise)
    flat = flat_histogram(picture.grey, wide)
    if not flat[rare].any():
        return found
    spread = grey_spread(np.where(rare, flat, 0))
    if math.sqrt(max(spread**2 - picture.noise**2, 0.0)) > PLATEAU * found.contrast:
        return found
    least = max(STEEP * found.contrast, LEAST_CONTRAST_SIGMAS * picture.noise)
    level = float(steepest_level(picture.grey, least))
    if level < 0.0:
        return found
    if dark_is_rare:
        dark = min(max(2.0 * level - found.light, 0.0), found.dark)
        return replace(found, dark=dark, dark_spread=spread)
    light = max(min(2.0 * level - found.dark, 255.0), found.light)
    return replace(found, light=light, light_spread=spread)


def split_classes(histogram: NDArray[np.int64], noise: float) -> Classes | None:
    """Two classes of a histogram (256,), or None if there is only one.

    Minimum error (Kittler and Illingworth, 1986) copes with a class of one pixel in a thousand.
    """
    least = max(LEAST_CONTRAST, LEAST_CONTRAST_SIGMAS * noise)
    found, dark, light, spread, dark_share = split_histogram(histogram, noise, least)
    return Classes(dark, light, spread, dark_share) if found else None


def unevenness(picture: GreyPicture, classes: Classes, side: Literal["dark", "light"]) -> float:
    """Spread of the free pixels beyond the noise, as a share of the contrast.

    Light obstacles count too: uneven light spreads them more than the ground.
    """
    spread = classes.light_spread
    if side == "light":
        dark = classes.dark_spread
        spread = max(
            spread,
            grey_spread(picture.counts[: math.ceil(classes.level)]) if dark is None else dark,
        )
    return math.sqrt(max(spread**2 - picture.noise**2, 0.0)) / classes.contrast


def significant_dark(
    picture: GreyPicture, noise: NDArray[np.float32], light: float
) -> float | None:
    """Middle of pixels significantly darker than free ones of one grey value, or None.

    ``noise`` (h, w) is the local standard deviation: in little light, noise alone has two classes.
    Smoothed pixels count if they exceed the noise by ``SIGMAS``, then if they are nearer to those
    than to free ones. None if they are fewer than ``FEWEST_SAMPLES``.
    """
    smoothing = picture.smoothing(float(noise.max()))
    smoothed = picture.grey_after(smoothing)
    least = np.maximum(noise * np.float32(SIGMAS * smoothing.left), 0.15 * light)
    found = smoothed[light - smoothed > least]
    for _ in range(2):
        if found.size < FEWEST_SAMPLES:
            return None
        found = found[found < 0.5 * (light + float(np.median(found)))]
    return float(np.median(found)) if found.size else None


def _rare_pixels(grey: NDArray[Any], noise: float) -> Classes | None:
    """Classes with one too rare for a sample, from the extremes of all pixels."""
    lowest, highest, _, _ = cv2.minMaxLoc(grey)
    middle = float(np.median(grey[:: max(1, grey.shape[0] // 64)]))
    least = max(LEAST_CONTRAST, 2.0 * SIGMAS * noise)
    if middle - lowest >= least and middle - lowest >= highest - middle:
        return Classes(lowest, middle, 0.0, 0.0)
    if highest - middle >= least:
        return Classes(middle, highest, 0.0, 1.0)
    return None


def grey_spread(counts: NDArray[np.int64]) -> float:
    """Spread of grey values: the quartiles' distance, as a normal distribution's sigma."""
    running = np.cumsum(counts)
    low, high = np.searchsorted(running, running[-1] * np.array([0.25, 0.75]))
    return float(high - low) / 1.349
