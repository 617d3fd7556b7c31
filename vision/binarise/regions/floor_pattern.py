"""Detection of a floor's own pattern: faint, sharp edges nearly everywhere on it.

Rules and units
- An obstacle lies in one place, a pattern everywhere: tiles with faint edges are counted.
- An edge is faint if its step has less than ``STRONG_SHARE`` of the light. Nothing counts within
  two ``STEP_REACH_PX`` of a stronger edge, which blur gives a faint foot.
"""

from __future__ import annotations

from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.binarise.binarise_kernels import STEP_REACH_PX
from vision.binarise.grey_classes import LEAST_CONTRAST_SIGMAS
from vision.binarise.grey_picture import LEAST_CONTRAST
from vision.binarise.regions.edge_evidence_kernels import mark_sharp_steps

TILES_A_SIDE = 8
"""Tiles along each side: chosen, joints of a floor are as near as an eighth of the picture."""
MOST_OF_IT = 0.5
"""Share of tiles with faint edges from which they are the floor's: chosen, more than half."""
STRONG_SHARE = 0.3
"""Share of the light that no pattern has: chosen, dark joints have up to 0.22."""
CROSSED = 0.25
"""Least faint pairs of a tile, as a share of its shorter side: chosen, a line through it has twice
that side."""
BY_CHANCE = 0.002
"""Share of a tile's pixels in faint pairs by noise alone: derived, twice the 0.04 % of two
differences beyond ``LEAST_CONTRAST_SIGMAS``."""


FAINT_STEP, STRONG = 1, 2
"""The marks of ``mark_sharp_steps``: defined."""


def least_step(noise: float) -> float:
    """Least step of a border in grey levels, as between two classes."""
    return max(LEAST_CONTRAST, LEAST_CONTRAST_SIGMAS * noise)


def faint_edges_apart(
    grey: NDArray[Any], noise: float, side: Literal["dark", "light"], reach: int
) -> int:
    """Number of faint, sharp steps more than ``reach`` pixels from every strong one."""
    marks = _marks(grey, noise, side)
    return int(np.count_nonzero((marks == FAINT_STEP) & ~_near(marks, reach)))


def near_strong_edges(
    grey: NDArray[Any],
    noise: float,
    side: Literal["dark", "light"],
    reach: int,
    own: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    """Mask (h, w) of pixels within ``reach`` of a step too strong for a floor's pattern.

    Steps whose dark end lies in ``own`` (h, w) do not count.
    """
    marks = _marks(grey, noise, side)
    marks[own] = 0
    return _near(marks, reach)


def has_pattern(grey: NDArray[Any], noise: float, side: Literal["dark", "light"]) -> bool:
    """True if most of the floor in a grey picture (h, w) has faint, sharp edges."""
    height, width = grey.shape
    if min(height, width) < TILES_A_SIDE:
        return False
    marks = _marks(grey, noise, side)
    floor = ~_near(marks, 2 * STEP_REACH_PX)
    free, crossed = _by_tile(floor), _by_tile(floor & (marks == FAINT_STEP))
    area = height * width / TILES_A_SIDE**2
    counted = free >= 0.5 * area
    least = CROSSED * min(height, width) / TILES_A_SIDE + BY_CHANCE * area
    patterned = int(np.count_nonzero(crossed[counted] >= least))
    return patterned > MOST_OF_IT * int(np.count_nonzero(counted))


def _marks(grey: NDArray[Any], noise: float, side: Literal["dark", "light"]) -> NDArray[np.uint8]:
    end, sign = (0.0, 1.0) if side == "dark" else (255.0, -1.0)
    marks: NDArray[np.uint8] = mark_sharp_steps(grey, least_step(noise), STRONG_SHARE, end, sign)
    return marks


def _near(marks: NDArray[np.uint8], reach: int) -> NDArray[np.bool_]:
    around = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    near: NDArray[np.bool_] = cv2.dilate((marks == STRONG).astype(np.uint8), around) > 0
    return near


def _by_tile(marks: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Number of marked pixels in each tile (TILES_A_SIDE, TILES_A_SIDE)."""
    counts = marks.astype(np.int64)
    for axis, length in enumerate(marks.shape):
        counts = np.add.reduceat(
            counts, np.arange(TILES_A_SIDE) * length // TILES_A_SIDE, axis=axis
        )
    return counts
