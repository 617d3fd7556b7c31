"""The level that a picture's edges support, and the obstacles that the chosen level leaves out.

Rules and units
- Grey values are 0 .. 255, obstacles dark. Steps are compared by the square root of the picture's
  own values (``Judge.worth``): a step in the dark is worth more.
- Light that changes over many pixels makes no edge: nothing supports a shadow's rim as a border. -
- Edges outside the mask's surroundings are searched again for their best levels. A region below one
  is an obstacle too if it touches nothing of the mask, and its border is sharp and exceeds the
  noise.
- In uneven light and on a patterned floor it needs a share of the light too (``judge.py``).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.binarise.binarise_kernels import SAMPLE, SIGMAS, STEP_REACH_PX
from vision.binarise.grey_classes import Classes
from vision.binarise.grey_picture import (
    FEWEST_SAMPLES,
    LEAST_CONTRAST,
    Binary,
    GreyPicture,
)
from vision.binarise.light_surface import without_light
from vision.binarise.regions.edge_evidence_kernels import (
    SAMPLED_PAIRS,
    steps_across_level,
    steps_off_level,
    support_by_level,
)
from vision.binarise.regions.floor_pattern import faint_edges_apart, has_pattern
from vision.binarise.regions.judge import (
    BLOCK_PX,
    FAINT,
    FAINT_LEAST_SHARE,
    THICK_PX,
    THIN_SHARE,
    Judge,
    JudgedPicture,
)

FIRST_PAIRS = SAMPLE // 2
"""Pairs of pixels read first; more where few lie across the level. Derived, two pixels make one."""
WEAK_STEP, STRONG_STEP = 0.35, 1.3
"""Steps, as shares of the contrast, that are too weak or too strong for the classes. Chosen, by
``tests/vision/binarise``."""
FEW = 0.2
"""Share of weak pairs up to which a level follows edges. Chosen, by ``tests/vision/binarise``."""
FEW_STRONG = 0.04
"""The same of strong pairs: joints of a floor have far more edges than dark objects on it. Chosen,
by ``tests/vision/binarise``."""
CLEAR_SIGMAS = SIGMAS * math.sqrt(2.0)
"""A clear step off the level, in standard deviations of a pixel: derived, a difference of two."""
FEWEST_CLEAR = 3
"""Clear steps from which a level leaves something out. Chosen, by ``tests/vision/binarise``."""
NOWHERE = np.zeros((0, 0), np.uint8)
"""No pixel is excluded: defined."""
LEFT_PAIRS = 1 << 21
"""Pairs read for what a level has left out, about: indifferent."""
NEARLY_ALL = 0.95
"""Share of the largest support from which a level is as good. Chosen, by
``tests/vision/binarise``."""
SPECKS = 0.2
"""Share of an obstacle's pixels below which those in the mask are specks: chosen."""
SAID = 0.5 * FAINT_LEAST_SHARE
"""Share of the light from which a remark names a region: derived, half of the least."""


def follows_edges(picture: GreyPicture, classes: Classes) -> bool:
    """True if edges at the level are as strong as the classes' contrast."""
    height, width = picture.grey.shape
    if min(height, width) <= STEP_REACH_PX:
        return True
    level = np.float32(classes.level)
    weakest = np.float32(WEAK_STEP * classes.contrast)
    strongest = np.float32(STRONG_STEP * classes.contrast + 3.0 * picture.noise)
    pairs = FIRST_PAIRS
    while True:
        count, weak, strong = steps_across_level(picture.grey, level, weakest, strongest, pairs)
        if count >= FEWEST_SAMPLES or pairs >= 2 * height * width:
            return bool(weak <= FEW * count and strong <= FEW_STRONG * count)
        pairs *= 16


def leaves_out(picture: GreyPicture, level: float, side: Literal["dark", "light"]) -> bool:
    """True if clear edges lie off a level, fainter than the edges across it."""
    height, width = picture.grey.shape
    if min(height, width) <= 4 * STEP_REACH_PX:
        return False
    least = max(LEAST_CONTRAST, CLEAR_SIGMAS * picture.noise)
    end, sign = (0.0, 1.0) if side == "dark" else (255.0, -1.0)

    def clear_steps(share: float) -> bool:
        clear = tuple(np.float32(v) for v in (share, least, end, sign))
        left = steps_off_level(picture.grey, np.float32(level), clear, FEWEST_CLEAR)
        return bool(left >= FEWEST_CLEAR)

    if not clear_steps(0.0):
        return False
    # artefacts of compression, and a floor's pattern, have a smaller share of the light
    smoothing = picture.smoothing()
    grey, noise = picture.grey_after(smoothing), picture.noise * smoothing.left
    apart = faint_edges_apart(grey, noise, side, BLOCK_PX) >= FEWEST_CLEAR
    return (apart and not has_pattern(grey, noise, side)) or clear_steps(THIN_SHARE)


class EdgeEvidence:
    """Support of a picture's edges for each level: sums, larger is better.

    Sums are comparable for one picture only; zero or less is no support. ``pairs``: about the
    number read. ``even``: the light is known to be even. ``grey``: the picture, smoothed if noisy;
    ``noise``: what is left in it.
    """

    def __init__(
        self,
        picture: GreyPicture,
        side: Literal["dark", "light"],
        pairs: int = SAMPLED_PAIRS,
        even: bool = False,
    ) -> None:
        self.judge = Judge.of(picture, side, pairs, even)
        smoothing = picture.smoothing()
        self.grey, self.noise = picture.grey_after(smoothing), picture.noise * smoothing.left
        self._cost = max(FAINT * self.judge.typical(pairs), self.judge.least)
        self._pairs = pairs

    def best_level(
        self, counts: NDArray[np.int64], even: Classes | None
    ) -> tuple[Classes | None, int]:
        """Classes of the best supported level, and the pairs across it; None without support.

        ``counts`` (256,) is the histogram; ``even`` are its classes in even light, preferred unless
        they have much less support.
        """
        believed, pairs = self._believed(NOWHERE, self._cost, self._pairs)
        most = float(believed.max())
        if most <= 0.0:
            return None, 0
        best = even
        if even is None or believed[math.ceil(even.level)] < NEARLY_ALL * most:
            best = _classes_at(believed, counts)
        assert best is not None
        return best, int(pairs[math.ceil(best.level)])

    def level_outside(self, shut: NDArray[np.uint8]) -> float | None:
        """Level best supported where ``shut`` (h, w) is 0, None without any.

        Its edges may be fainter than the others, but not as noise.
        """
        believed, _ = self._believed(shut, FAINT * self.judge.faintest, LEFT_PAIRS)
        most = float(believed.max())
        if most <= 0.0:
            return None
        return float(np.flatnonzero(believed >= NEARLY_ALL * most).mean())

    def _believed(
        self, shut: NDArray[np.uint8], cost: float, sample: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Support for each level (257,), 0 if too little, and the pairs."""
        judge = self.judge
        support, pairs = support_by_level(judge.grey, judge.seen(shut), judge.values, cost, sample)
        # without pairs, the sum is only rounding
        enough = FAINT * cost * np.maximum(pairs, 1.0)
        return np.where(support >= enough, support, 0.0), pairs


def _classes_at(believed: NDArray[np.float64], counts: NDArray[np.int64]) -> Classes:
    """Classes that the best of all levels (257,) makes of a histogram (256,)."""
    nearly = NEARLY_ALL * float(believed.max())
    level = int(np.flatnonzero(believed >= nearly).mean())
    below = np.arange(256) < level
    dark, light = _middle(np.where(below, counts, 0)), _middle(np.where(below, 0, counts))
    if believed[math.ceil(0.5 * (dark + light))] < nearly:
        # one class is really two: only greys next to the level count
        reach = min(level - dark, light - level)
        dark, light = level - reach, level + reach
    return Classes(dark, light, 0.0, float(counts[below].sum() / counts.sum()))


def _middle(counts: NDArray[np.int64]) -> float:
    running = np.cumsum(counts)
    return float(np.searchsorted(running, 0.5 * running[-1]))


def with_left_out(
    judged: JudgedPicture, others: Iterable[JudgedPicture], evidence: EdgeEvidence
) -> Binary:
    """The mask, changed in place, with obstacles of other masks and levels, and remarks.

    Levels are searched in the picture without its light, then as it is. A remark names other
    regions above the noise.
    """
    binary = judged.binary
    inside = binary.inside
    left = judged.left_out
    shut = _around(inside)
    flat, stronger = without_light(evidence.grey, evidence.judge.side)
    picture = GreyPicture(flat)
    picture.noise = max(picture.noise, stronger * evidence.noise)
    found = 0
    for asked in (EdgeEvidence(picture, evidence.judge.side, even=evidence.judge.even), evidence):
        # each level is searched in what the others have not found
        while (level := asked.level_outside(shut)) is not None:
            below = (asked.grey < level).astype(np.uint8)
            more = _add_obstacles(below, inside, shut, left, evidence.judge)
            if more == 0:
                break
            found += more
    # last: there an obstacle and its shadow may be one region
    for other in others:
        found += _add_obstacles(other.binary.inside, inside, shut, left, evidence.judge)
    remarks = binary.remarks
    if found:
        many = f"{found} obstacles that are lighter, or shaded, are seen at levels of their own"
        one = "an obstacle that is lighter, or shaded, is seen at a level of its own"
        remarks += (one if found == 1 else many,)
    remarks += _said(left, inside, evidence.judge)
    return replace(binary, by_level=binary.by_level and not found, remarks=remarks)


def _around(inside: NDArray[Any]) -> NDArray[np.uint8]:
    near = np.ones((2 * STEP_REACH_PX + 1, 2 * STEP_REACH_PX + 1), np.uint8)
    return np.asarray(cv2.dilate(inside, near), dtype=np.uint8)


def _add_obstacles(
    below: NDArray[np.uint8],
    inside: NDArray[np.uint8],
    shut: NDArray[np.uint8],
    left: NDArray[np.bool_],
    judge: Judge,
) -> int:
    """Add obstacles of a level's mask ``below`` (h, w) to ``inside``; return their number.

    They touch nothing of ``shut``, the mask and its surroundings, except their own specks. Other
    regions above the noise are marked in ``left``.
    """
    regions = judge.regions(below)
    labels = regions.labels
    size = regions.stand_out.size
    touching = np.zeros(size, dtype=np.bool_)
    touching[labels[shut != 0]] = True
    # a level that an obstacle's noise crosses leaves specks of it in the mask
    area = np.bincount(labels.ravel(), minlength=size)
    known = np.bincount(labels[inside != 0], minlength=size)
    specks = (known > 0) & (known < SPECKS * area)
    specks[labels[cv2.distanceTransform(inside, cv2.DIST_L2, 3) >= THICK_PX]] = False
    free = ~touching | specks
    free[0] = False
    kept = free & judge.faint_obstacles(regions, below)
    left |= (regions.stand_out & free & ~kept)[labels]
    more = kept[labels]
    inside[more] = 1
    shut |= _around(more.astype(np.uint8))
    return int(np.count_nonzero(kept))


def _said(
    left: NDArray[np.bool_],
    inside: NDArray[np.uint8],
    judge: Judge,
) -> tuple[str, ...]:
    if not left.any():
        return ()
    regions = judge.regions(left.astype(np.uint8))
    labels = regions.labels
    missing = regions.shares >= SAID
    missing[labels[inside != 0]] = False
    missing[0] = False
    count = int(np.count_nonzero(missing))
    if not count:
        return ()
    y, x = np.unravel_index(int(np.argmax(missing[labels])), labels.shape)
    share = float(regions.shares[labels[y, x]])
    what = "region was" if count == 1 else "regions were"
    return (
        f"{count} faint {what} taken for uneven light or the floor's own pattern: the first "
        f"begins at ({x}, {y}) px, its border has {share:.0%} of the light there",
    )
