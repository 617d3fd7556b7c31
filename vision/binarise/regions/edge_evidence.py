"""Whether the border between black and white lies where the picture has its edges.

Rules and units
- Grey values are 0 .. 255, obstacles dark. Light multiplies what the camera sees, so that a step
  in the dark is worth more: steps are compared by the square root of the picture's own values,
  whichever side obstacles are on. The logarithm would be right for the light alone, and puts the
  level of a blurred edge too near its dark side.
- Light that changes over many pixels makes no edge, however strong it is; a shadow's rim and a
  lamp's fall-off are borders that nothing speaks for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from vision.binarise.grey_classes import LEAST_CONTRAST, Classes
from vision.binarise.grey_picture import Look, calming_of
from vision.binarise.regions.edge_evidence_kernels import (
    REACH,
    SAMPLED_PAIRS,
    steps_across_level,
    steps_off_level,
    support_by_level,
    support_of_mask,
    typical_step,
)

FIRST_PAIRS = 16384
"""Pairs of pixels that are looked at first; more where few of them lie across the level."""
FEWEST_ACROSS = 32
"""Pairs across a level from which their mean is believed."""
WEAK_STEP, STRONG_STEP = 0.35, 1.3
"""Steps, as shares of the contrast, that are less or more than the classes make."""
PLAIN_STEP = 0.6
"""The least step, as a share of the contrast and of the light there is, that shows an obstacle."""
FEW = 0.2
"""Share of weak pairs up to which a level follows edges: a blurred edge's foot and noise. As many
may be found on one side of the level with a plain step: edges that it leaves out."""
FEW_STRONG = 0.04
"""The same of steps that are too strong: joints of a floor have many more edges than what is
far darker and stands on it, and no plain picture has such steps."""
CLEAR_STEP, CLEAR_SIGMAS = 0.15, 8.0
"""A step off the level that is an edge of its own: its share of the light, and in sigmas."""
FEWEST_CLEAR = 3
"""Such steps, of those looked at, from which on a level leaves something out."""
COST = 0.3
"""What a border has to have, as a share of the typical sharp step, to speak for itself."""
DARK_WORTH = 8.0
"""Grey levels that are added before the root: in the dark a grey level is not much."""
NOISE_WORTH = 5.0
"""The same in standard deviations of the noise."""
LEAST_SUPPORT = 0.5
"""What speaks for a border at least, as a share of its cost: noise has no more."""
PROMINENT = 0.04
"""How much a peak among the levels has to stand out, as a share of the most that speaks."""
NOWHERE = np.zeros((0, 0), np.uint8)
LEFT_PAIRS = 1 << 21
"""Pairs of pixels that are looked at for what a level has left out, about."""
LEFT_COST = 0.6
"""What a border there has to have, as a share of what noise has hardly anywhere."""
MOST_PEAKS = 2
"""Peaks beside the highest that are looked at."""
NEARLY_ALL, MOST = 0.95, 0.9
"""The share of the most that any level has from which the level half-way is as good, and where
the light is even anyway."""


def follows_edges(look: Look, classes: Classes, side: Literal["dark", "light"]) -> bool:
    """Whether edges as strong as the classes' contrast lie where their level is crossed.

    And whether there are hardly any elsewhere, weaker only as the light is.
    """
    height, width = look.grey.shape
    if min(height, width) <= REACH:
        return True
    level = np.float32(classes.level)
    weakest = np.float32(WEAK_STEP * classes.contrast)
    strongest = np.float32(STRONG_STEP * classes.contrast + 3.0 * look.noise)
    # without light a pixel is black, which is white where obstacles are light
    end = 0.0 if side == "dark" else 255.0
    # and half of an edge between black and white is no plain step, whatever light there is
    at_least = PLAIN_STEP * classes.contrast + NOISE_WORTH * look.noise
    lightest = classes.light if side == "dark" else end - classes.dark
    share = PLAIN_STEP * classes.contrast / (lightest + at_least)
    least = share * at_least + NOISE_WORTH * look.noise
    plain = tuple(np.float32(v) for v in (share, least, end, 1.0 if side == "dark" else -1.0))
    pairs = FIRST_PAIRS
    while True:
        found = steps_across_level(look.grey, level, weakest, strongest, plain, pairs)
        count, weak, strong, beside = found
        if count >= FEWEST_ACROSS or pairs >= 2 * height * width:
            return bool(max(weak, beside) <= FEW * count and strong <= FEW_STRONG * count)
        pairs *= 16


def leaves_out(look: Look, classes: Classes, side: Literal["dark", "light"]) -> bool:
    """Whether clear edges, fainter than the classes' own, lie off the classes' level."""
    height, width = look.grey.shape
    if min(height, width) <= 4 * REACH:
        return False
    least = max(LEAST_CONTRAST, CLEAR_SIGMAS * look.noise)
    end, sign = (0.0, 1.0) if side == "dark" else (255.0, -1.0)
    clear = tuple(np.float32(v) for v in (CLEAR_STEP, least, end, sign))
    left = steps_off_level(look.grey, np.float32(classes.level), clear, FIRST_PAIRS)
    return bool(left >= FEWEST_CLEAR)


@dataclass(frozen=True, slots=True)
class BestLevel:
    """The classes whose level edges speak for most, None where nothing speaks for any.

    ``pairs`` lie across it. ``others``: those of other levels for which edges speak more than for
    the levels beside them: in a shadow there may be edges that the best level has not.
    """

    pairs: int
    classes: Classes | None
    others: tuple[Classes, ...] = ()


class Support:
    """What a picture's edges say for one border or another: sums, larger is better.

    Sums are comparable for one picture only; nothing speaks for what has none or less.
    ``pairs``: how many are looked at, about. ``grey``: the picture, smoothed where it is noisy,
    ``noise`` what is left of it there.
    """

    def __init__(
        self, look: Look, side: Literal["dark", "light"], pairs: int = SAMPLED_PAIRS
    ) -> None:
        calming = calming_of(look.noise)
        self.grey: NDArray[Any] = look.grey_after(calming)
        left = self.noise = look.noise * calming.left
        own = np.arange(256.0)
        at_least = DARK_WORTH + NOISE_WORTH * left
        worth = np.sqrt(own + at_least)
        self._worth = worth if side == "dark" else -worth[::-1].copy()
        # the least contrast, and noise, at the light end of the picture
        least = LEAST_CONTRAST + 2.0 * NOISE_WORTH * left
        self._floor = float(worth[255] - worth[255 - math.ceil(min(least, 128.0))])
        typical = float(typical_step(self.grey, self._worth, pairs))
        self._cost = max(COST * typical, self._floor)
        self._pairs = pairs

    def best_level(self, counts: NDArray[np.int64], even: Classes | None) -> BestLevel:
        """The level that most speaks for.

        ``counts`` is the picture's histogram (256,); ``even`` its classes where the light is,
        whose own level is taken where it has not much less.
        """
        support, pairs = support_by_level(self.grey, NOWHERE, self._worth, self._cost, self._pairs)
        # where no pair lies across a level the sum is but rounding
        enough = np.maximum(LEAST_SUPPORT * self._cost * pairs, LEAST_SUPPORT * self._cost)
        believed = np.where(support >= enough, support, 0.0)
        most = float(believed.max())
        if most <= 0.0:
            return BestLevel(0, None)
        if even is not None and believed[math.ceil(even.level)] >= MOST * most:
            peaks = (_classes_at(believed, peak, counts) for peak in _peaks(believed)[1:])
            return BestLevel(int(pairs[math.ceil(even.level)]), even, tuple(peaks))
        found = _classes_at(believed, np.ones(257, dtype=np.bool_), counts)
        others = tuple(_classes_at(believed, peak, counts) for peak in _peaks(believed)[1:])
        return BestLevel(int(pairs[math.ceil(found.level)]), found, others)

    def levels_outside(self, shut: NDArray[np.uint8]) -> list[float]:
        """The levels that most edges speak for where ``shut`` (h, w) is 0, the best first.

        However faint those edges are beside the others, as far as noise has none like them.
        """
        cost = LEFT_COST * self._floor
        support, pairs = support_by_level(self.grey, shut, self._worth, cost, LEFT_PAIRS)
        enough = np.maximum(LEAST_SUPPORT * cost * pairs, LEAST_SUPPORT * cost)
        believed = np.where(support >= enough, support, 0.0)
        levels = []
        for peak in _peaks(believed):
            nearly = NEARLY_ALL * float(believed[peak].max())
            levels.append(float(np.flatnonzero((believed >= nearly) & peak).mean()))
        return levels

    def of_mask(self, mask: NDArray[np.uint8]) -> float:
        """What speaks for the borders of a padded mask."""
        return float(support_of_mask(self.grey, mask, self._worth, self._cost, self._pairs))


def _classes_at(
    believed: NDArray[np.float64], where: NDArray[np.bool_], counts: NDArray[np.int64]
) -> Classes:
    """The classes that the best of some levels (257,) makes of a histogram (256,)."""
    nearly = NEARLY_ALL * float(believed[where].max())
    level = int(np.flatnonzero((believed >= nearly) & where).mean())
    below = np.arange(256) < level
    dark, light = _middle(np.where(below, counts, 0)), _middle(np.where(below, 0, counts))
    half_way = math.ceil(0.5 * (dark + light))
    if believed[half_way] < nearly or not where[half_way]:
        # one class is two: what is next to the level counts
        reach = min(level - dark, light - level)
        dark, light = level - reach, level + reach
    return Classes(dark, light, 0.0, float(counts[below].sum() / counts.sum()))


def _peaks(believed: NDArray[np.float64]) -> list[NDArray[np.bool_]]:
    """The levels around each peak, the highest first: (257,) each.

    A peak stands ``PROMINENT`` of the most out of what lies between it and a higher one.
    """
    least = PROMINENT * float(believed.max())
    free = np.ones(257, dtype=np.bool_)
    peaks: list[NDArray[np.bool_]] = []
    while len(peaks) <= MOST_PEAKS and free.any() and believed[free].max() > least:
        top = int(np.argmax(np.where(free, believed, -1.0)))
        around = np.zeros(257, dtype=np.bool_)
        prominent = True
        for beyond in (range(top, 257), range(top, -1, -1)):
            lowest = believed[top]
            for level in beyond:
                if not free[level]:
                    prominent &= bool(lowest <= believed[top] - least)
                    break
                if believed[level] > lowest + least:
                    break
                lowest = min(lowest, believed[level])
                around[level] = True
        free &= ~around
        if prominent:
            peaks.append(around)
    return peaks


def _middle(counts: NDArray[np.int64]) -> float:
    """The median of the grey values that a histogram (256,) counts."""
    running = np.cumsum(counts)
    return float(np.searchsorted(running, 0.5 * running[-1]))
