"""Structure of the ground too fine for the picture: walls that no level can find.

Rules and units
- Grey values are 0 .. 255, obstacles dark. Walls and ways narrower than a lens's blur merge into a
  floor-like grey with a twentieth of their contrast.
- White noise is as strong between neighbours as between distant pixels. Blurred structure differs
  little between neighbours (``BEYOND_NOISE``), but as much over two pixels as over more
  (``FULL_APART``); light and larger edges differ more with the distance.
- A floor's own texture is fine too, but has less of the light (``STRUCTURE_SHARE``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.binarise.binarise_kernels import SAMPLE, STEP_REACH_PX
from vision.binarise.grey_classes import Classes, grey_spread
from vision.binarise.grey_picture import BINOMIAL, FEWEST_SAMPLES, LEAST_CONTRAST, GreyPicture

STRUCTURE_SHARE = 0.045
"""Least standard deviation of the structure, as a share of the light and of the contrast of plain
obstacles: chosen, walls of 1 px at a blur of 1 px have 0.051 or more, cloth 0.024
(``benchmarks.vision.regions``)."""
LEAST_SPREAD = 0.5 * LEAST_CONTRAST
"""The same in grey levels: derived, two equally frequent values at the least contrast."""
HINT, HINT_SHARE = 1.1, 0.5
"""Least spread of the floor's grey for structure to be sought, in standard deviations of the noise
and as a share of the least: chosen, for time; noise alone spreads whole grey values by up to 1.07.
"""
BEYOND_NOISE = 1.15
"""Least ratio of changes over two pixels to those over one: chosen, noise alone has 1.07 in a
picture of 500 pixels; walls of 1 px have 1.2 in noise of 10 grey levels."""
FULL_APART = 1.25
"""Largest ratio of changes over ``STEP_REACH_PX`` pixels to those over two: chosen, walls of 1 px
have 1.0, pictures of rooms 1.5 to 2."""
CLASSES_APART = 4.0
"""Least distance between two classes, in standard deviations of the larger one: chosen, parts of
one hump have 2.7, a block on unresolved walls 8."""
ALL = 256.0
"""Level above all grey values: defined."""
FINE = 2
"""Pixels over which fine structure changes fully: derived, a wall and a way."""


@dataclass(frozen=True, slots=True)
class Unresolved:
    """Structure around a grey of ``middle``, of standard deviation ``spread``, below ``level``."""

    middle: float
    spread: float
    level: float


def unresolved_structure(
    picture: GreyPicture, classes: Classes | None, side: Literal["dark", "light"]
) -> Unresolved | None:
    """Structure too fine for the picture, in the class of most of its pixels.

    None if it is not in most places, or is no more than a floor's texture.
    """
    ground = _Ground.of(picture, classes)
    light = ground.middle if side == "dark" else 255.0 - ground.middle
    least = max(LEAST_SPREAD, STRUCTURE_SHARE * max(light, ground.contrast))
    if ground.spread < max(HINT_SHARE * least, HINT * picture.noise):
        return None
    smoothed = picture.grey_after(BINOMIAL)
    inside = (smoothed >= ground.first) & (smoothed < ground.end)
    around = np.ones((2 * STEP_REACH_PX + 1, 2 * STEP_REACH_PX + 1), np.uint8)
    apart = cv2.erode(inside.astype(np.uint8), around) != 0
    if np.count_nonzero(apart) < 0.5 * np.count_nonzero(inside):
        return None
    next_to, fine, wide = (
        change_over(picture.grey, apart, reach) for reach in (1, FINE, STEP_REACH_PX)
    )
    if fine < BEYOND_NOISE * next_to or fine**2 < next_to**2 + least**2:
        return None
    if wide > FULL_APART * fine:
        return None
    return Unresolved(ground.middle, fine, ground.end)


class _Ground(NamedTuple):
    """Range first .. end of most pixels' grey, its middle and spread; ``contrast`` to the others,
    or 0."""

    first: float
    end: float
    middle: float
    spread: float
    contrast: float

    @classmethod
    def of(cls, picture: GreyPicture, classes: Classes | None) -> _Ground:
        counts = picture.counts
        if classes is not None and 0.0 < classes.dark_share < 1.0:
            level, contrast = classes.level, classes.contrast
            if classes.dark_share > 0.5:
                spread = grey_spread(counts[: math.ceil(level)])
                ground = cls(0.0, level, classes.dark, spread, contrast)
            else:
                spread = classes.light_spread
                left = picture.noise * picture.smoothing().left
                if spread**2 > picture.noise**2 + (HINT * left) ** 2 and left < picture.noise:
                    spread = grey_spread(counts[math.ceil(level) :])
                ground = cls(level, ALL, classes.light, spread, contrast)
            if contrast >= CLASSES_APART * spread:
                return ground
        # rare pixels and parts of one hump are not classes
        middle = float(np.searchsorted(np.cumsum(counts), 0.5 * counts.sum()))
        return cls(0.0, ALL, middle, grey_spread(counts), 0.0)


def change_over(grey: NDArray[Any], seen: NDArray[np.bool_], apart: int) -> float:
    """Change over ``apart`` pixels, as the standard deviation of white noise that changes as much.

    From a sample: the median second difference around ``seen`` pixels (h, w); 0 if too few.
    """
    every = max(1, math.isqrt(2 * grey.size // SAMPLE))
    along = _bends(grey[::every], seen[::every], apart)
    across = _bends(grey.T[::every], seen.T[::every], apart)
    bends = np.sort(np.concatenate([along, across]))
    if len(bends) < FEWEST_SAMPLES:
        return 0.0
    # mean of the middle fifth: integers have few medians
    middle = bends[2 * len(bends) // 5 : 3 * len(bends) // 5 + 1].mean()
    return float(middle) / (0.6744898 * math.sqrt(6.0))


def _bends(lines: NDArray[Any], seen: NDArray[np.bool_], apart: int) -> NDArray[np.float32]:
    """Absolute second differences along lines, over ``apart`` pixels."""
    if lines.shape[1] <= 2 * apart:
        return np.empty(0, np.float32)
    shown = lines.astype(np.float32)
    before, here, behind = shown[:, : -2 * apart], shown[:, apart:-apart], shown[:, 2 * apart :]
    bends: NDArray[np.float32] = np.abs(before - 2.0 * here + behind)[seen[:, apart:-apart]]
    return bends
