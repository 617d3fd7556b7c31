"""Structure of the ground that is too fine for the picture: walls that no level can find.

Rules and units
- Grey values are 0 .. 255, obstacles dark. Walls and ways narrower than a lens's blur run together
  to a grey in between, which looks like a floor; a twentieth of their contrast remains.
- White noise is as strong between neighbouring pixels as between distant ones. What a lens has
  blurred differs little from its neighbour (``BEYOND_NOISE``), and differs from the pixel next but
  one as much as from those farther away (``FULL_APART``): it is fine. Light, blots and the edges of
  what is larger keep on growing with the distance.
- A floor's own texture is fine too, but has less of the light (``LEAST_SHARE``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.binarise.binarise_kernels import REACH, SAMPLE
from vision.binarise.grey_classes import Classes, grey_spread
from vision.binarise.grey_picture import BINOMIAL, FEWEST, LEAST_CONTRAST, Look

LEAST_SHARE = 0.045
"""How much of the light, and of the contrast of plain obstacles, the structure's standard deviation
is at least: chosen, walls of 1 px at a blur of 1 px have 0.058 of the light where they are black,
0.051 where they are white, and 0.079 of the contrast; cloth has 0.024 of the light
(``benchmarks.vision.regions``)."""
LEAST = 0.5 * LEAST_CONTRAST
"""The same in grey levels: derived, two grey values in equal parts have that standard deviation
where they are the least contrast apart."""
HINT, HALF = 1.1, 0.5
"""How much the floor's grey spreads at least where that is looked at, in standard deviations of the
noise and as a share of the least: chosen, for time. Of noise alone whole grey values spread by up
to 1.07, and their quartiles are coarse."""
BEYOND_NOISE = 1.15
"""How much stronger the changes over two pixels are than those over one, at least: chosen, noise
alone has 1.07 in a picture of 500 pixels; walls of 1 px have 1.2 in noise of 10 grey levels."""
FULL_APART = 1.25
"""How much stronger those over ``REACH`` pixels are than those over two, at most: chosen, walls of
1 px have 1.0, pictures of rooms 1.5 to 2."""
APART = 4.0
"""How far two classes are apart at least, in standard deviations of the larger one: chosen, two
parts of one hump are up to 2.7, and a block on unresolved walls 8."""
ALL = 256.0
"""The level below which all grey values lie: defined."""
FINE = 2
"""Pixels apart over which fine structure changes fully: derived, a wall's width and a way's."""


@dataclass(frozen=True, slots=True)
class Unresolved:
    """Structure around a grey of ``middle``, of which ``spread`` is the standard deviation.

    It lies below the ``level``.
    """

    middle: float
    spread: float
    level: float


def unresolved_structure(
    look: Look, classes: Classes | None, side: Literal["dark", "light"]
) -> Unresolved | None:
    """What of the picture is too fine for it, in the class that most of its pixels have.

    None where that has no such structure nearly everywhere, or no more than a floor's texture.
    O(pixels) where its grey spreads more than noise does, else O(1).
    """
    ground = _Ground.of(look, classes)
    light = ground.middle if side == "dark" else 255.0 - ground.middle
    least = max(LEAST, LEAST_SHARE * max(light, ground.contrast))
    if ground.spread < max(HALF * least, HINT * look.noise):
        return None
    smoothed = look.grey_after(BINOMIAL)
    inside = (smoothed >= ground.first) & (smoothed < ground.end)
    around = np.ones((2 * REACH + 1, 2 * REACH + 1), np.uint8)
    apart = cv2.erode(inside.astype(np.uint8), around) != 0
    if np.count_nonzero(apart) < 0.5 * np.count_nonzero(inside):
        return None
    next_to, fine, wide = (change_over(look.grey, apart, reach) for reach in (1, FINE, REACH))
    if fine < BEYOND_NOISE * next_to or fine**2 < next_to**2 + least**2:
        return None
    if wide > FULL_APART * fine:
        return None
    return Unresolved(ground.middle, fine, ground.end)


class _Ground(NamedTuple):
    """The grey values that most pixels have, first .. end, their middle and spread.

    ``contrast``: how far those of the others are away, 0 where there are none.
    """

    first: float
    end: float
    middle: float
    spread: float
    contrast: float

    @classmethod
    def of(cls, look: Look, classes: Classes | None) -> _Ground:
        counts = look.counts
        if classes is not None and 0.0 < classes.dark_share < 1.0:
            level, contrast = classes.level, classes.contrast
            if classes.dark_share > 0.5:
                spread = grey_spread(counts[: math.ceil(level)])
                ground = cls(0.0, level, classes.dark, spread, contrast)
            else:
                spread = classes.light_spread
                left = look.noise * look.calming().left
                # seen through smoothing, which leaves little of what is fine
                if spread**2 > look.noise**2 + (HINT * left) ** 2 and left < look.noise:
                    spread = grey_spread(counts[math.ceil(level) :])
                ground = cls(level, ALL, classes.light, spread, contrast)
            if contrast >= APART * spread:
                return ground
        # neither rare pixels nor parts of one hump are classes
        middle = float(np.searchsorted(np.cumsum(counts), 0.5 * counts.sum()))
        return cls(0.0, ALL, middle, grey_spread(counts), 0.0)


def change_over(grey: NDArray[Any], seen: NDArray[np.bool_], apart: int) -> float:
    """How much pixels so far ``apart`` change, as white noise of that standard deviation does.

    By the median second difference, in both directions, around pixels (h, w) that are ``seen``; 0
    for too few of them. Of a sample.
    """
    every = max(1, math.isqrt(2 * grey.size // SAMPLE))
    along = _bends(grey[::every], seen[::every], apart)
    across = _bends(grey.T[::every], seen.T[::every], apart)
    bends = np.sort(np.concatenate([along, across]))
    if len(bends) < FEWEST:
        return 0.0
    # the mean of the middle fifth: whole grey values have few medians
    middle = bends[2 * len(bends) // 5 : 3 * len(bends) // 5 + 1].mean()
    return float(middle) / (0.6744898 * math.sqrt(6.0))


def _bends(lines: NDArray[Any], seen: NDArray[np.bool_], apart: int) -> NDArray[np.float32]:
    """The second differences along each line, of three pixels ``apart`` around one that is seen."""
    if lines.shape[1] <= 2 * apart:
        return np.empty(0, np.float32)
    shown = lines.astype(np.float32)
    before, here, behind = shown[:, : -2 * apart], shown[:, apart:-apart], shown[:, 2 * apart :]
    bends: NDArray[np.float32] = np.abs(before - 2.0 * here + behind)[seen[:, apart:-apart]]
    return bends
