"""Objects and holes that uneven light or noise has made, told by how faint their borders are.

Rules and units
- Grey values are 0 .. 255, obstacles dark. Light multiplies what the camera sees, so that what is
  made of the same stuff has the same share of the light wherever it lies: the step across its
  border, divided by the light there. A shadow's rim, and noise where there is little light, have
  a fraction of that.
- The step is the mean over the whole border, of pixels ``REACH`` apart across it: it grows with the
  depth alone, and its error falls with the border's length, so that no count of pixels is asked
  for. What a soft shadow or noise had made was found to have 0.02 to 0.19, obstacles 0.5 to 0.67.
- The masks that are left are compared by what their borders have in all: one that leaves out
  obstacles in a shadow has less.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.binarise.binary import Binary
from vision.binarise.regions.edge_evidence_kernels import REACH, steps_of_regions

FAINT = 0.4
"""What a border has to have of the share that most of them have."""
COST = 0.5
"""What it has to have to speak for a mask, in such shares."""
SIGMAS, ALIKE = 6.0, 4.0
"""How far a border's steps stand out of the noise at least, and how many pairs share theirs."""


@dataclass(frozen=True, slots=True)
class Regions:
    """A mask's regions, (n,) each, the first of them what is in none; ``labels`` (h, w).

    ``shares`` are the steps across their borders as shares of the light, ``sharp`` how much of
    them is sharp, ``pairs`` the pairs of pixels, ``steps`` the sums of their steps.
    """

    shares: NDArray[np.float64]
    sharp: NDArray[np.float64]
    pairs: NDArray[np.int64]
    steps: NDArray[np.float64]
    labels: NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class Judged:
    """A picture in black and white without what is faint, and what is left in it.

    ``pairs`` of pixels across its borders, ``shares`` the sum of their steps as shares of the
    light, ``typical`` the share that most of them have. ``left_out`` (h, w): what
    is faint but no noise.
    """

    binary: Binary
    pairs: float = 0.0
    shares: float = 0.0
    typical: float = 0.0
    left_out: NDArray[np.bool_] | None = None

    def worth(self, typical: float) -> float:
        """What speaks for it beside others of which the largest ``typical`` share is given."""
        return self.shares - COST * typical * self.pairs


def without_faint(
    binary: Binary, grey: NDArray[Any], noise: float, side: Literal["dark", "light"]
) -> Judged:
    """The mask without the objects, and the holes, whose borders are faint in ``grey`` (h, w).

    Nor with objects whose borders ``noise``, the standard deviation in ``grey``, could have made.
    The mask itself is changed. O(pixels).
    """
    inside = binary.inside
    if min(inside.shape) <= 2 * REACH:
        return Judged(binary)
    objects = regions_of(grey, inside, 8, side)
    shares, pairs = objects.shares, objects.pairs
    if not (shares > 0.0).any():
        return Judged(binary)
    typical = _typical(shares, pairs)
    faint = (shares < FAINT * typical) & (pairs > 0)
    significant = stand_out(objects, noise)
    left_out = (faint & significant)[objects.labels]
    faint |= ~significant
    inside[faint[objects.labels]] = 0
    kept = ~faint
    total, across = float((shares * pairs)[kept].sum()), float(pairs[kept].sum())
    # seen from a hole the obstacle is the darker side
    holes = regions_of(grey, 1 - inside, 4, side)
    spaces = holes.labels
    filled = (-holes.shares < FAINT * typical) & (holes.pairs > 0)
    rim = (spaces[0], spaces[-1], spaces[:, 0], spaces[:, -1])
    filled[np.unique(np.concatenate(rim))] = False
    inside[filled[spaces]] = 1
    changed = bool(faint.any() or filled.any())
    cleaned = replace(binary, by_level=False) if changed else binary
    return Judged(cleaned, across, total, typical, left_out)


def regions_of(
    grey: NDArray[Any], inside: NDArray[Any], connectivity: int, side: Literal["dark", "light"]
) -> Regions:
    """The connected regions of a mask (h, w), and the steps across their borders."""
    count, found = cv2.connectedComponents(inside, connectivity=connectivity)
    labels = np.asarray(found, dtype=np.int32)
    end, sign = (0.0, 1.0) if side == "dark" else (255.0, -1.0)
    steps, light, sharp, pairs = steps_of_regions(grey, labels, count, end, sign)
    sharp = np.where(steps > 0.0, sharp / np.where(steps > 0.0, steps, 1.0), 0.0)
    return Regions(steps / np.maximum(light, 1.0), sharp, pairs, steps, labels)


def stand_out(regions: Regions, noise: float) -> NDArray[np.bool_]:
    """Which regions' borders ``noise``, a standard deviation, could not have made."""
    # neighbours share their noise: about every fourth pair is one by itself
    least = SIGMAS * noise * np.sqrt(2.0 * ALIKE * regions.pairs)
    stands: NDArray[np.bool_] = regions.steps >= least
    return stands


def _typical(shares: NDArray[np.float64], pairs: NDArray[np.int64]) -> float:
    """The mean share, weighed by itself and the pairs: what is faint hardly counts."""
    weights = np.maximum(shares, 0.0) * pairs
    return float((weights * shares).sum() / max(weights.sum(), 1e-9))
