"""Judgement of a mask's regions by the steps across their borders.

Rules and units
- Grey values are 0 .. 255, obstacles dark. Light multiplies what the camera sees, so one material
  has the same share of the light everywhere: its border's step over the light there. A shadow's
  rim, and noise in little light, have less.
- The step is the mean over the whole border, of pixels ``STEP_REACH_PX`` apart across it.
- A picture out of focus, whose edges are not sharp over ``STEP_REACH_PX`` pixels, is halved.
- A region is real if its border exceeds the noise (``SIGMAS``) on all sides but short ones, is
  sharp (``LEAST_SHARP``), and either is of the others' material (``FAINT``) or has the contrast
  that two classes need (``least_step``).
- In uneven light, and on a patterned floor (``floor_pattern.py``), contrast is not enough: a border
  fainter than the others needs ``THIN_SHARE`` of the light, or ``FAINT_LEAST_SHARE`` where it is
  thick. A floor's joints look like faint cables.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.binarise.binarise_kernels import SIGMAS, STEP_REACH_PX
from vision.binarise.grey_classes import LEAST_CONTRAST_SIGMAS
from vision.binarise.grey_picture import LEAST_CONTRAST, NO_SMOOTHING, Binary, GreyPicture
from vision.binarise.regions.edge_evidence_kernels import (
    LEAST_SHARP,
    OUTER,
    steps_of_regions,
    typical_step,
)
from vision.binarise.regions.floor_pattern import has_pattern, least_step, near_strong_edges

SELECTED = 3.0
"""Step, in standard deviations, of noise at borders that a level draws in it: derived, 1.6 at the
level half-way, 2.4 at 2 sigma off it and 3 at 2.7, beyond which borders are short."""
PAIRS_ALIKE = 4.0
"""Pairs of pixels that share their noise: derived, every pixel is in two pairs to the right and
down, and the binomial smooths over two pixels each way."""
OUT_OF_FOCUS = 2.0
"""Factor by which halving sharpens steps of a picture out of focus: derived, at a blur of 2 px
(``benchmarks.vision.regions --tuning``: 177 pictures right, 172 with 3)."""
LEAST_HALF_PX = 2 * (STEP_REACH_PX + 2 * OUTER)
"""Pixels of half a picture's shortest side: derived, twice what a pair reads."""
FAINT = 0.5
"""Part of most borders' share that a border needs to be of the same stuff, and part of its own that
each side needs: derived, half-way to none."""
SHORT_SIDE = 0.15
"""Share of a border's pairs from which a side is checked: chosen, blurred tips of triangles have
0.13, and bars would fail by their ends."""
FAINT_LEAST_SHARE = 0.1
"""Least share of the light of a faint border where light or floor is not even: chosen, an obstacle
of 180 on a floor of 215 has 0.11."""
THICK_PX = 3.0
"""Least distance of a faint obstacle's middle from its border there: chosen, joints are thinner."""
SPECK_PX = 12
"""Pixels of a faint region that noise does not make: chosen, twice those of noise twice as strong
in one part of the picture (``tests/vision/joined``)."""
BLOCK_PX = 8
"""Distance from a strong edge within which a compressed picture has faint ones: derived, the side
of JPEG's blocks."""
THIN_SHARE = 0.15
"""Least share of the light of a border both faint and thin there, and of a step off the level
there: chosen, cables of half the contrast have 0.12 to 0.3, joints of a floor 0.1
(``benchmarks.vision.regions --tuning``: 60 of 80 cables found, 44 with 0.18; with 0.12 soft steps
count)."""


@dataclass(frozen=True, slots=True)
class Regions:
    """Regions of a mask, (n,) each, the first being everything outside them; ``labels`` (h, w).

    ``shares`` are the steps across their borders as shares of the light, ``pairs`` the numbers of
    pixel pairs. ``stand_out``: the steps exceed the noise. ``beyond``: worth of their mean beyond
    the least. ``sharp``: the border is sharp.
    """

    steps: NDArray[np.float64]
    shares: NDArray[np.float64]
    pairs: NDArray[np.int64]
    stand_out: NDArray[np.bool_]
    beyond: NDArray[np.float64]
    sharp: NDArray[np.bool_]
    labels: NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class JudgedPicture:
    """A picture in black and white with real regions only, and totals over its borders.

    ``pairs``: pixel pairs across them; ``shares``: sum of their steps as shares of the light;
    ``typical``: the share of most. ``speaks``: worth of their steps beyond the least; without any
    there are no edges. ``left_out`` (h, w): neither real nor noise.
    """

    binary: Binary
    pairs: float
    shares: float
    typical: float
    speaks: float
    left_out: NDArray[np.bool_]

    def worth(self, typical: float) -> float:
        """Support beyond faint borders, given the largest ``typical`` share among the masks
        compared."""
        return self.shares - FAINT * typical * self.pairs


@dataclass(frozen=True)
class Judge:
    """Judge of borders in ``grey`` (h', w') with noise of standard deviation ``noise``.

    ``every``: rows and columns of a mask for each of its own. ``smoothed``: it is not the original
    picture. ``even``: the light is known to be even.
    """

    grey: NDArray[Any]
    noise: float
    side: Literal["dark", "light"]
    every: int = 1
    smoothed: bool = False
    even: bool = False

    @classmethod
    def of(
        cls, picture: GreyPicture, side: Literal["dark", "light"], pairs: int, even: bool = False
    ) -> Judge:
        """Judge of a picture, smoothed if noisy and halved if out of focus.

        About ``pairs`` pairs of pixels are read for that.
        """
        judge = cls._seeing(picture, side, 1, even)
        if min(picture.grey.shape) < 2 * LEAST_HALF_PX:
            return judge
        other = cls._seeing(picture.halved(), side, 2, even)
        return other if other.typical(pairs) >= OUT_OF_FOCUS * judge.typical(pairs) else judge

    @classmethod
    def _seeing(
        cls, picture: GreyPicture, side: Literal["dark", "light"], every: int, even: bool
    ) -> Judge:
        smoothing = picture.smoothing()
        grey, noise = picture.grey_after(smoothing), picture.noise * smoothing.left
        return cls(grey, noise, side, every, smoothing is not NO_SMOOTHING, even)

    def worth(self, light: NDArray[np.float64]) -> NDArray[np.float64]:
        """Worth of grey values, whose differences are compared.

        The root, because light multiplies what the camera sees and its noise grows with the root;
        the logarithm puts the level of a blurred edge too near its dark side. The least contrast is
        added before the root.
        """
        root: NDArray[np.float64] = np.sqrt(
            light + LEAST_CONTRAST + LEAST_CONTRAST_SIGMAS * self.noise
        )
        return root

    @property
    def values(self) -> NDArray[np.float64]:
        """Worth of each grey value (256,), whichever side obstacles are on."""
        worth = self.worth(np.arange(256.0))
        return worth if self.side == "dark" else -worth[::-1].copy()

    @property
    def least(self) -> float:
        """Least worth of a border's step: the least contrast, and noise, in light."""
        return self._worth_in_light(LEAST_CONTRAST + 2.0 * LEAST_CONTRAST_SIGMAS * self.noise)

    @property
    def faintest(self) -> float:
        """The same for regions fainter than the others, where contrast alone is enough.

        Not for smoothed pictures, whose noise has edges as wide as a lens's.
        """
        if self.smoothed or self.needs_share:
            return self.least
        return self._worth_in_light(least_step(self.noise))

    def _worth_in_light(self, step: float) -> float:
        light, less = self.worth(np.array([255.0, 255.0 - math.ceil(min(step, 128.0))]))
        return float(light - less)

    @cached_property
    def needs_share(self) -> bool:
        """True if contrast is not enough: uneven light, or a patterned floor."""
        return not self.even or has_pattern(self.grey, self.noise, self.side)

    def typical(self, pairs: int) -> float:
        """Worth of the step of the strongest sharp edges, from about ``pairs`` pairs."""
        return float(typical_step(self.grey, self.values, pairs))

    def seen(self, mask: NDArray[Any]) -> NDArray[Any]:
        """Mask or labels (h, w) at the judge's own pixels (h', w')."""
        if self.every == 1:
            return mask
        height, width = self.grey.shape
        step = self.every
        return np.ascontiguousarray(mask[: height * step : step, : width * step : step])

    def regions(self, inside: NDArray[Any]) -> Regions:
        """Connected regions of a mask (h, w), and the steps across their borders."""
        count, found = cv2.connectedComponents(inside, connectivity=8)
        labels = np.asarray(found, dtype=np.int32)
        end, sign = (0.0, 1.0) if self.side == "dark" else (255.0, -1.0)
        sides = steps_of_regions(self.grey, self.seen(labels), count, end, sign)
        steps, light, pairs = (sides[k].sum(axis=1) for k in (0, 1, 3))
        step, lit = steps / np.maximum(pairs, 1), light / np.maximum(pairs, 1)
        beyond = self.worth(lit) - self.worth(np.maximum(lit - step, 0.0)) - self.faintest
        # standard deviation of the sum of the steps
        error = self.noise * np.sqrt(2.0 * PAIRS_ALIKE * sides[3])
        chance = SELECTED * pairs + SIGMAS * np.sqrt(2.0 * PAIRS_ALIKE * pairs)
        stand_out = steps >= self.noise * chance
        stand_out &= pairs > 0
        shares = steps / np.maximum(light, 1.0)
        weak = sides[0] + 3.0 * error < FAINT * shares[:, None] * sides[1]
        # a wall's end is no longer than what blur rounds
        around = ~(weak & (sides[3] >= SHORT_SIDE * pairs[:, None])).any(axis=1)
        sharp = sides[2] >= LEAST_SHARP * steps
        return Regions(step, shares, pairs, stand_out & around, beyond, sharp, labels)

    def faint_obstacles(self, regions: Regions, inside: NDArray[Any]) -> NDArray[np.bool_]:
        """Mask (n,) of regions that are real although others have far more of the light.

        ``inside`` (h, w) is not 0 where they are searched. Contrast over noise is enough, except in
        uneven light and on a patterned floor.
        """
        found = regions.stand_out & regions.sharp
        few = found & (regions.shares < THIN_SHARE)
        if not few[1:].any():
            return found
        if not self.needs_share:
            enough = (regions.steps >= least_step(self.noise)) & self._is_no_speck(regions, few)
            few &= ~enough
        away = cv2.distanceTransform(inside, cv2.DIST_L2, 3)
        thick = np.zeros(found.size, dtype=np.bool_)
        thick[regions.labels[away >= THICK_PX]] = True
        return found & (~few | (thick & (regions.shares >= FAINT_LEAST_SHARE)))

    def _is_no_speck(self, regions: Regions, few: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Mask (n,) of regions not made by noise or compression; it matters for the ``few`` only.

        Noise stronger in places makes specks there. Artefacts of compression lie mostly beside an
        edge.
        """
        count = regions.steps.size
        labels = self.seen(regions.labels)
        reach = BLOCK_PX // self.every
        near = near_strong_edges(self.grey, self.noise, self.side, reach, few[labels])
        pixels = np.bincount(labels.ravel(), minlength=count)
        apart = np.bincount(labels[near], minlength=count) < 0.5 * pixels
        large: NDArray[np.bool_] = np.bincount(regions.labels.ravel(), minlength=count) >= SPECK_PX
        return large & apart

    def real(self, binary: Binary) -> JudgedPicture:
        """Remove regions whose borders do not count from the mask."""
        inside = binary.inside
        objects = self.regions(inside)
        shares, pairs = objects.shares, objects.pairs
        typical = _typical(shares, pairs)
        kept = objects.stand_out & objects.sharp
        kept &= (shares >= FAINT * typical) | self.faint_obstacles(objects, inside)
        left_out = (objects.stand_out & ~kept)[objects.labels]
        inside[~kept[objects.labels]] = 0
        total, across = float((shares * pairs)[kept].sum()), float(pairs[kept].sum())
        cleaned = binary if kept[1:].all() else replace(binary, by_level=False)
        speaks = float((objects.beyond * pairs)[kept].sum())
        return JudgedPicture(cleaned, across, total, typical, speaks, left_out)


def _typical(shares: NDArray[np.float64], pairs: NDArray[np.int64]) -> float:
    """Mean share weighted by itself and the pairs, so that faint ones hardly count."""
    weights = np.maximum(shares, 0.0) * pairs
    return float((weights * shares).sum() / max(weights.sum(), 1e-9))
