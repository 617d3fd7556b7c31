"""A grey picture, its noise and histogram, and its mask once the level is known.

Rules and units
- Grey values are 0 .. 255: 16 bits are scaled by the brightest pixel; transparent is white. Noise
  is its standard deviation.
- A pixel below the level is obstacle.
- Where noise alone could cross the level, a smoothed picture is compared and small dots are added
  by their depth, unless that would delete thin walls (``vision.binarise.humps``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from planner.scene import Binarisation
from vision.binarise.binarise_kernels import SIGMAS, noise_sigma, sampled_histogram
from vision.binarise.humps import TWO_HUMPED, Humps, deletes
from vision.binarise.smoothing_kernels import (
    dots_left_out,
    mark_below_but_dots,
    mark_dots,
    smoothed_histogram,
)
from vision.picture_error import PictureError
from vision.shared.array_pool import ArrayPool

LEAST_CONTRAST = 8.0
"""Grey levels between light and dark below which nothing is an obstacle. Chosen, by
``tests/vision/binarise``."""
FEWEST_SAMPLES = 32
"""Least samples of a mean or middle: chosen, it is known to a sixth of their scatter."""
SMOOTHED_NOISE = 0.5 * LEAST_CONTRAST
"""Noise, in grey levels, from which a picture is smoothed: derived, half the least contrast."""


@dataclass(frozen=True, slots=True)
class Smoothing:
    """Smoothing by ``sigma_px``; ``left``: the share of white noise that remains."""

    sigma_px: float
    left: float


NO_SMOOTHING = Smoothing(0.0, 1.0)
"""The picture itself: defined."""
BINOMIAL = Smoothing(1.0, 0.2734)
"""The binomial of 5 x 5 pixels, in a third of a Gaussian's time: derived, 70 / 256 of the noise."""
WIDE_GAUSSIAN = Smoothing(2.0, 0.1411)
"""A Gaussian: derived, it leaves 1 / (2 sqrt(pi) sigma) of the noise."""
SMOOTHINGS = (NO_SMOOTHING, BINOMIAL, WIDE_GAUSSIAN)
"""Smoothings, weakest first; a level is applied after the first that leaves little noise."""


def smoothing_of(noise: float) -> Smoothing:
    """Smoothing after which such noise hardly crosses a level.

    The wide one only if the binomial would leave noise of the least contrast.
    """
    if noise < SMOOTHED_NOISE:
        return NO_SMOOTHING
    return BINOMIAL if BINOMIAL.left * noise < LEAST_CONTRAST else WIDE_GAUSSIAN


class GreyPicture:
    """A grey picture, its noise and its histogram; smoothed on demand."""

    def __init__(self, grey: NDArray[Any], pool: ArrayPool | None = None) -> None:
        self.grey = grey = read_only(grey)
        self.pool = ArrayPool() if pool is None else pool
        self.counts: NDArray[np.int64] = sampled_histogram(grey)
        self._counts_after: dict[Smoothing, NDArray[np.int64]] = {NO_SMOOTHING: self.counts}
        # two values: drawn, not photographed; apparent noise is texture
        bilevel = np.count_nonzero(self.counts) <= 2
        self.noise = 0.0 if bilevel else float(noise_sigma(grey))
        self.fine = self._fine_structure()
        if self.fine is not None:
            self.noise = min(self.noise, self.fine.within)

    def _fine_structure(self) -> Humps | None:
        """Humps of the histogram, if smoothing would delete fine structure."""
        if self.noise < SMOOTHED_NOISE:
            return None
        humps = Humps.of(self.counts)
        if humps.apart < TWO_HUMPED or humps.contrast < LEAST_CONTRAST:
            return None
        return humps if deletes(humps, self.counts_after(BINOMIAL)) else None

    def smoothing(self, noise: float | None = None) -> Smoothing:
        """Smoothing for ``noise``, or the picture's own.

        ``NO_SMOOTHING`` if it would delete fine structure.
        """
        if self.fine is not None:
            return NO_SMOOTHING
        return smoothing_of(self.noise if noise is None else noise)

    def apart(self) -> GreyPicture:
        """The same picture with its own memory, for a mask to be compared with others."""
        other = copy(self)
        other.pool = ArrayPool()
        return other

    def halved(self) -> GreyPicture:
        """Picture of half the size: means of 2 x 2 pixels."""
        height, width = (side // 2 for side in self.grey.shape)
        whole = self.grey[: 2 * height, : 2 * width]
        return GreyPicture(cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA))

    def counts_after(self, smoothing: Smoothing) -> NDArray[np.int64]:
        """Histogram (256,) of the smoothed picture, from a sample."""
        known = self._counts_after.get(smoothing)
        if known is None:
            whole = smoothing is BINOMIAL and self.grey.dtype == np.uint8
            count = smoothed_histogram if whole else sampled_histogram
            known = count(self.grey if whole else self.grey_after(smoothing))
            self._counts_after[smoothing] = known
        return known

    def grey_after(self, smoothing: Smoothing) -> NDArray[Any]:
        """The smoothed picture (h, w)."""
        if smoothing is NO_SMOOTHING:
            return self.grey
        if smoothing is BINOMIAL:
            return read_only(cv2.GaussianBlur(self.grey, (5, 5), 0.0))
        return read_only(cv2.GaussianBlur(self.grey, (0, 0), smoothing.sigma_px))

    def mask_below(self, level: float, smoothing: Smoothing, noise: float) -> NDArray[np.uint8]:
        """Padded mask (h + 2, w'), 1 where the smoothed picture lies below the level.

        Dots too small for it are added if they exceed ``noise``. The margin is zero, rows have a
        multiple of eight bytes; valid until the pool is used again.
        """
        height, width = self.grey.shape
        stride = (width + 2 + 7) // 8 * 8
        mask = self.pool.take("mask", (height + 2) * stride, np.uint8).reshape(-1, stride)
        mask[0] = mask[-1] = mask[:, 0] = 0
        mask[:, width + 1 :] = 0
        inside = mask[1:-1, 1 : width + 1].view(np.bool_)
        whole = self.grey.dtype == np.uint8
        bound = min(max(math.ceil(level) - 1, -1), 255)
        if whole and smoothing is BINOMIAL:
            places = mark_below_but_dots(self.grey, bound, mask)
            mark_dots(self.grey, noise, places, mask)
            return mask
        smoothed = self.grey_after(smoothing)
        if whole:
            np.less_equal(smoothed, bound, out=inside)
        else:
            np.less(smoothed, level, out=inside)
        if smoothing is not NO_SMOOTHING:
            of_its_kind = np.uint8(min(bound + 1, 255)) if whole else self.grey.dtype.type(level)
            mark_dots(self.grey, noise, dots_left_out(self.grey, of_its_kind, mask), mask)
        return mask


@dataclass(frozen=True, slots=True)
class Binary:
    """A picture in black and white.

    ``mask`` (h + 2, w') uint8: 1 is obstacle, with a margin of free pixels and rows of a multiple
    of eight bytes. ``grey`` (h, w): obstacles dark, with ``level`` in its values; ``contrast``: the
    step between free and obstacle. ``by_level``: the mask is exactly ``grey`` below the level.
    ``doubtful``: noise alone could have made single pixels. ``fine``: it has structure that
    smoothing would delete.
    """

    mask: NDArray[np.uint8]
    grey: NDArray[Any]
    level: float
    noise: float
    contrast: float
    how: Binarisation
    remarks: tuple[str, ...] = ()
    by_level: bool = False
    doubtful: bool = False
    fine: bool = False

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture."""
        return self.grey.shape[1], self.grey.shape[0]

    @property
    def inside(self) -> NDArray[np.uint8]:
        """The mask without its margin, (h, w)."""
        return self.mask[1:-1, 1 : self.grey.shape[1] + 1]


def black_and_white(
    picture: GreyPicture,
    level: float,
    contrast: float,
    how: Binarisation,
    *,
    noise: float | None = None,
    strongest_noise: float | None = None,
    margin: float | None = None,
) -> Binary:
    """Compare a picture with the level, smoothed if noise alone could cross it."""
    remarks: tuple[str, ...] = ()
    noise = picture.noise if noise is None else noise
    strongest = noise if strongest_noise is None else strongest_noise
    margin = 0.5 * contrast if margin is None else margin
    safe = [one for one in SMOOTHINGS if SIGMAS * strongest * one.left <= margin]
    smoothing = safe[0] if safe else SMOOTHINGS[-1]
    if picture.fine is not None and smoothing is not NO_SMOOTHING:
        # crossings of noise stay obstacles: none is taken for a speck
        remarks = (
            f"walls or ways of a few pixels at a contrast of {contrast:.0f}: the picture was not "
            "smoothed, which would delete them, and single pixels of noise may be obstacles",
        )
        safe, smoothing = [NO_SMOOTHING], NO_SMOOTHING
    if smoothing is not NO_SMOOTHING:
        remarks = (
            f"noise of up to {strongest:.0f} grey levels at a contrast of {contrast:.0f}: the "
            f"picture was smoothed by {smoothing.sigma_px:.0f} px before the level was applied",
        )
    mask = picture.mask_below(level, smoothing, strongest)
    by_level = smoothing is NO_SMOOTHING
    fine = picture.fine is not None
    return Binary(
        mask, picture.grey, level, noise, contrast, how, remarks, by_level, not safe, fine
    )


def as_array(image: NDArray[Any] | Sequence[Any]) -> NDArray[Any]:
    """Picture from an array, unchanged, or from rows of whole numbers.

    Numbers up to 255 make 8 bits, up to 65535 16. Raises ``PictureError`` for anything else.
    """
    if isinstance(image, np.ndarray):
        return image
    if not isinstance(image, Sequence) or isinstance(image, (str, bytes)):
        raise PictureError(
            f"the picture is a {type(image).__name__}: must be a NumPy array or rows of numbers"
        )
    try:
        values = np.array(image)
    except ValueError:
        raise PictureError("the picture's rows are not equally long") from None
    if values.dtype == np.uint8 or values.dtype == np.uint16 or values.size == 0:
        return values.astype(np.uint8) if values.size == 0 else values
    if values.dtype.kind not in "iu":
        raise PictureError(f"the picture's values are {values.dtype}: must be whole numbers")
    low, high = int(values.min()), int(values.max())
    if low < 0 or high > 65535:
        raise PictureError(f"the picture's values are {low} .. {high}: must lie in 0 .. 65535")
    return values.astype(np.uint8 if high <= 255 else np.uint16)


def as_grey(image: NDArray[Any] | Sequence[Any]) -> NDArray[Any]:
    """Grey values of a picture as (h, w) uint8, or float32 in 0 .. 255 from 16 bits.

    Takes uint8 or uint16, (h, w), (h, w, 1), (h, w, 3) BGR or (h, w, 4) BGRA. Raises
    ``PictureError`` for anything else. O(pixels).
    """
    image = as_array(image)
    if image.dtype not in (np.uint8, np.uint16):
        raise PictureError(f"the picture's values are {image.dtype}: must be uint8 or uint16")
    if image.ndim not in (2, 3) or (image.ndim == 3 and image.shape[2] not in (1, 3, 4)):
        raise PictureError(
            f"the picture's shape is {image.shape}: must be (h, w), (h, w, 3) or (h, w, 4)"
        )
    if image.size == 0:
        raise PictureError(f"the picture is empty: {image.shape[1]} x {image.shape[0]} pixels")
    grey = image
    if image.ndim == 3 and image.shape[2] == 1:
        grey = image[:, :, 0]
    elif image.ndim == 3 and image.shape[2] == 3:
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    elif image.ndim == 3:
        grey = _over_white(image)
    if grey.dtype == np.uint16:
        brightest = int(grey.max())
        return read_only(grey.astype(np.float32) * np.float32(255.0 / max(brightest, 1)))
    return read_only(grey)


def read_only(grey: NDArray[Any]) -> NDArray[Any]:
    """The picture, contiguous and read-only: writable arrays would recompile kernels."""
    shown = np.ascontiguousarray(grey).view()
    shown.setflags(write=False)
    return shown


def scaled_threshold(threshold: float, image: NDArray[Any]) -> float:
    """Scale a threshold in the values of ``image`` to ``as_grey``'s 0 .. 255.

    Raises ``PictureError`` if it is no value of the picture.
    """
    top = np.iinfo(image.dtype).max
    is_number = isinstance(threshold, (int, float, np.integer, np.floating))
    if not is_number or isinstance(threshold, bool):
        given = " ".join(repr(threshold).split())
        raise PictureError(f"threshold {given}: must be a number in 0 .. {top}")
    if not 0.0 <= threshold <= top:
        raise PictureError(f"threshold {threshold}: must lie in 0 .. {top}")
    if image.dtype == np.uint8:
        return float(threshold)
    return float(threshold) * 255.0 / max(int(image.max()), 1)


def _over_white(image: NDArray[Any]) -> NDArray[Any]:
    top = np.iinfo(image.dtype).max
    alpha = image[:, :, 3].astype(np.float32) / top
    grey = cv2.cvtColor(image[:, :, :3], cv2.COLOR_BGR2GRAY).astype(np.float32)
    blended: NDArray[Any] = np.rint(grey * alpha + top * (1.0 - alpha)).astype(image.dtype)
    return blended
