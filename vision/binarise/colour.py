"""Obstacles that differ from the floor in colour, though not in grey.

Rules and units
- A pixel is obstacle if any channel differs from the floor to the obstacles' side.
- The floor's colour is the most frequent one. Light multiplies all channels alike, so a shadow is a
  multiple of the floor's colour.
- Each pixel counts by its channel farthest from the floor; edges are measured in that picture.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from planner.scene import Binarisation
from vision.binarise import Method, Polarity
from vision.binarise.binarise import binarise
from vision.binarise.binarise_kernels import SAMPLE, STEP_REACH_PX
from vision.binarise.grey_picture import Binary
from vision.binarise.light_surface import FREE_LEVEL
from vision.picture_error import PictureError
from vision.shared.array_pool import ArrayPool

LEAST_DEPTH = 40.0
"""Grey levels of one channel from the floor that light does not explain: chosen, lamps and shadows
tint a grey floor less."""
BIN = 16
"""Width of a bin of the colours' histogram: chosen, above one colour's noise."""


def binarise_by_colour(
    image: NDArray[Any],
    *,
    polarity: Polarity,
    method: Method,
    threshold: float | None,
    ignore: NDArray[np.bool_] | None,
    pool: ArrayPool,
) -> Binary:
    """Binarise as ``vision.binarise.binarise.binarise`` does; method ``auto`` sees colours too.

    If colours show more, the method is ``colour`` and the level a distance from the floor's colour.
    Raises ``PictureError``. O(pixels).
    """
    found = None
    if method == "auto" and threshold is None and image.ndim == 3 and image.shape[2] in (3, 4):
        found = _Colours.of(image, ignore)
    if found is None or not (found.darker.any() or found.lighter.any()):
        return binarise(
            image, polarity=polarity, method=method, threshold=threshold, ignore=ignore, pool=pool
        )
    grey = error = None
    side: Literal["dark", "light"] = "light" if polarity == "light" else "dark"
    try:
        grey = binarise(image, polarity=polarity, ignore=ignore, pool=pool)
        side = grey.how.polarity
    except PictureError as of_one_grey:
        # colours may still show obstacles
        error = of_one_grey
    unseen = found.unseen_in(grey, side)
    if unseen > 0:
        apart = binarise(found.beside_the_floor(side), polarity=side, ignore=ignore)
        if found.unseen_in(apart, side) < unseen:
            return replace(apart, how=_how(apart.how, found.floor))
    if grey is None:
        assert error is not None
        raise error
    return grey


def _how(how: Binarisation, floor: NDArray[np.float64]) -> Binarisation:
    blue, green, red = (round(float(value)) for value in floor)
    reason = (
        f"by colour: grey does not tell all obstacles from the floor of red {red}, green {green}, "
        f"blue {blue}, so each pixel counts by its channel farthest from it; {how.reason}"
    )
    return Binarisation("colour", how.threshold, how.polarity, reason)


class _Colours:
    """Colour picture (h, w, 3) uint8, its floor's colour, and pixels not explained by light."""

    def __init__(self, picture: NDArray[np.uint8], ignore: NDArray[np.bool_] | None) -> None:
        self.picture = picture
        height, width = picture.shape[:2]
        self.step = max(1, int(np.sqrt(height * width / SAMPLE)))
        sample = np.ascontiguousarray(picture[:: self.step, :: self.step])
        self.floor = _most_frequent(sample)
        self.darker, self.lighter = _unexplained(sample, self.floor)
        if ignore is not None:
            looked_at = ~ignore[:: self.step, :: self.step]
            self.darker &= looked_at
            self.lighter &= looked_at

    @classmethod
    def of(cls, image: NDArray[Any], ignore: NDArray[np.bool_] | None) -> _Colours | None:
        if image.dtype not in (np.uint8, np.uint16) or image.size == 0:
            return None
        picture = image[:, :, :3]
        if image.dtype == np.uint16:
            picture = cv2.convertScaleAbs(picture, alpha=255.0 / max(int(picture.max()), 1))
        if image.shape[2] == 4:
            alpha = image[:, :, 3:].astype(np.float32) / np.iinfo(image.dtype).max
            picture = np.rint(picture * alpha + 255.0 * (1.0 - alpha)).astype(np.uint8)
        return cls(np.ascontiguousarray(picture), ignore)

    def unseen_in(self, binary: Binary | None, side: Literal["dark", "light"]) -> int:
        """Number of sampled pixels with their own colour, neither obstacle nor beside one."""
        pixels = self.darker if side == "dark" else self.lighter
        if binary is None:
            return int(np.count_nonzero(pixels))
        seen = np.ascontiguousarray(binary.inside[:: self.step, :: self.step])
        reach = 2 * (1 + (STEP_REACH_PX - 1) // self.step) + 1
        around = cv2.dilate(seen, np.ones((reach, reach), np.uint8))
        return int(np.count_nonzero(_without_specks(pixels & (around == 0))))

    def beside_the_floor(self, side: Literal["dark", "light"]) -> NDArray[np.uint8]:
        """Picture (h, w) of the channel farthest from the floor to that side."""
        values = np.arange(256.0)[:, None]
        scale = FREE_LEVEL / 255.0
        base = FREE_LEVEL if side == "dark" else 255.0 - FREE_LEVEL
        table = np.clip(np.rint(base + scale * (values - self.floor)), 0.0, 255.0)
        apart = cv2.LUT(self.picture, table.astype(np.uint8)[:, None, :])
        blue, green, red = cv2.split(apart)
        farthest = cv2.min if side == "dark" else cv2.max
        return np.asarray(farthest(farthest(blue, green), red), dtype=np.uint8)


def _most_frequent(sample: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Median colour (3,) near the middle of the fullest bin."""
    channels = [np.ascontiguousarray(sample[:, :, c]).ravel() for c in range(3)]
    parts = [channel // BIN for channel in channels]
    bins = parts[0] + np.int32(16) * parts[1] + np.int32(256) * parts[2]
    fullest = int(np.bincount(bins, minlength=4096).argmax())
    middle = [fullest // 16**c % 16 * BIN + (BIN - 1) / 2.0 for c in range(3)]
    near = np.ones(bins.shape, dtype=np.bool_)
    for channel, value in zip(channels, middle, strict=True):
        near &= (channel >= value - BIN) & (channel <= value + BIN)
    floor = []
    for channel in channels:
        running = np.cumsum(np.bincount(channel[near], minlength=256))
        floor.append(np.searchsorted(running, 0.5 * running[-1]))
    return np.array(floor, dtype=np.float64)


def _unexplained(
    sample: NDArray[np.uint8], floor: NDArray[np.float64]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Masks (h, w) of pixels too dark and too light for light on the floor."""
    # one channel at a time, which is faster
    values = [sample[:, :, c].astype(np.float32) for c in range(3)]
    light = [np.float32(value) for value in floor]
    ratios = [(v + 1.0) * (1.0 / (f + 1.0)) for v, f in zip(values, light, strict=True)]
    shade = np.minimum(np.maximum(np.maximum(ratios[0], ratios[1]), ratios[2]), 1.0)
    glare = np.maximum(np.minimum(np.minimum(ratios[0], ratios[1]), ratios[2]), 1.0)
    darker = np.zeros(shade.shape, dtype=np.bool_)
    lighter = np.zeros(shade.shape, dtype=np.bool_)
    for value, f in zip(values, light, strict=True):
        darker |= shade * f - value >= LEAST_DEPTH
        lighter |= value - np.minimum(glare * f, np.float32(255.0)) >= LEAST_DEPTH
    return _without_specks(darker), _without_specks(lighter)


def _without_specks(pixels: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Keep only regions three pixels wide, unlike noise and fringes of compression."""
    opened = cv2.morphologyEx(pixels.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    return np.asarray(opened, dtype=np.bool_)
