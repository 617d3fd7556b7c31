"""Obstacles that the level taken has left out, for they are lighter, or lie in a deep shadow.

Rules and units
- Grey values are 0 .. 255, obstacles dark. No level is right for obstacles of 40 and of 180 on
  a floor of 215, nor for what lies in full light and in a shadow of 70 %.
- The edges that are neither in nor near the mask are asked once more for their best levels, and
  what lies below one of them is an obstacle too where it touches nothing of the mask, and where
  its border is sharp, stands out of the noise and has at least ``LEAST_SHARE`` of the light: a
  shadow's rim is soft, and noise has less.
- What is thin besides has to have ``THIN_SHARE``: the joints of a floor look like faint cables.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.binarise.binarise_kernels import REACH
from vision.binarise.grey_picture import Binary, Look
from vision.binarise.light import without_light
from vision.binarise.regions.edge_evidence import Support
from vision.binarise.regions.judge import LEAST_SHARE, THICK_PX, Judge, Judged, faint_obstacles

SPECKS = 0.2
"""Share of an obstacle's pixels below which those in the mask already are no obstacle: chosen."""
SAID = 0.5 * LEAST_SHARE
"""The share from which a region is said to have been left out: derived, half of what one has."""


def with_left_out(judged: Judged, others: Iterable[Judged], support: Support) -> Binary:
    """The mask with the obstacles that other masks and levels show, and remarks on them.

    And on the rest: what is no noise, but is left out of the mask. The mask itself is changed.
    O(pixels) a level.
    """
    binary = judged.binary
    inside = binary.inside
    left = judged.left_out
    shut = _around(inside)
    found = 0
    for asked in _asked(support):
        # each level is asked for what the others have not found
        while (level := asked.level_outside(shut)) is not None:
            below = (asked.grey < level).astype(np.uint8)
            more = _add_obstacles(below, inside, shut, left, support.judge)
            if more == 0:
                break
            found += more
    # last: an obstacle and the shadow beside it may be one region there
    for other in others:
        found += _add_obstacles(other.binary.inside, inside, shut, left, support.judge)
    remarks = binary.remarks
    if found:
        many = f"{found} obstacles that are lighter, or shaded, are seen at levels of their own"
        one = "an obstacle that is lighter, or shaded, is seen at a level of its own"
        remarks += (one if found == 1 else many,)
    remarks += _said(left, inside, support.judge)
    return replace(binary, by_level=binary.by_level and not found, remarks=remarks)


def _asked(support: Support) -> Iterator[Support]:
    """Whom levels are asked of: the picture without its light, and then as it is."""
    side = support.judge.side
    flat, stronger = without_light(support.grey, side)
    divided = Look(flat)
    divided.noise = max(divided.noise, stronger * support.noise)
    yield Support(divided, side)
    yield support


def _around(inside: NDArray[Any]) -> NDArray[np.uint8]:
    """A mask (h, w) and what is near it."""
    near = np.ones((2 * REACH + 1, 2 * REACH + 1), np.uint8)
    return np.asarray(cv2.dilate(inside, near), dtype=np.uint8)


def _add_obstacles(
    below: NDArray[np.uint8],
    inside: NDArray[np.uint8],
    shut: NDArray[np.uint8],
    left: NDArray[np.bool_],
    judge: Judge,
) -> int:
    """Mark the obstacles of ``below`` (h, w), a level's, that ``inside`` has not yet; how many.

    They touch nothing of ``shut``, which is the mask and what is near, but specks of themselves.
    What else is no noise is marked in ``left``.
    """
    regions = judge.regions(below)
    labels = regions.labels
    size = regions.stand_out.size
    touching = np.zeros(size, dtype=np.bool_)
    touching[labels[shut != 0]] = True
    # a level that an obstacle's own noise crosses leaves specks of it
    area = np.bincount(labels.ravel(), minlength=size)
    known = np.bincount(labels[inside != 0], minlength=size)
    specks = (known > 0) & (known < SPECKS * area)
    specks[labels[cv2.distanceTransform(inside, cv2.DIST_L2, 3) >= THICK_PX]] = False
    free = ~touching | specks
    free[0] = False
    kept = free & faint_obstacles(regions, below)
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
    """A sentence on the regions that are in the mask (h, w) in no part; none without any."""
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
