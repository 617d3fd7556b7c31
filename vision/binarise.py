"""Black and white: which pixels are obstacle, by which method and why.

Rules and units
- Grey values are 0 .. 255, obstacles dark, once ``as_grey`` has looked at the picture: a
  16-bit picture is scaled by its brightest pixel, light obstacles are turned into dark ones.
- A pixel is obstacle where its grey value lies below the level.
- Methods: ``otsu`` (one level, from the histogram), ``fixed`` (the caller's), ``adaptive``
  (the mean of the neighbourhood), ``background`` (division by a fitted surface of the light).
- ``auto`` takes one level where the light is even, and divides by the light where it is not.
- ``Binary.grey`` is what the mask was made from, with one level for the whole picture: the
  sub-pixel edges are measured in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from planner.scene import Binarisation
from vision.binarise_kernels import noise_sigma, sampled_histogram
from vision.binary import Binary, black_and_white
from vision.grey import PictureError, as_array, as_grey, scaled_threshold
from vision.grey_classes import (
    LEAST_CONTRAST,
    Classes,
    classes_of,
    grey_spread,
    least_room,
    room_left,
    split_classes,
)
from vision.light import light_surface
from vision.look import Look
from vision.room import Room

Method: TypeAlias = Literal["auto", "otsu", "fixed", "adaptive", "background"]
Polarity: TypeAlias = Literal["dark", "light", "auto"]
METHODS: tuple[Method, ...] = ("auto", "otsu", "fixed", "adaptive", "background")
POLARITIES: tuple[Polarity, ...] = ("dark", "light", "auto")

EVEN_MARGIN = 0.25
"""Least distance of the darkest free pixels from the level, as a share of the contrast, at
which light is even: the edge itself is measured against its own surroundings."""
FREE_LEVEL = 200.0
"""Grey value that free pixels get when the picture is divided by its light."""
MOSTLY = 0.65
"""Share of dark pixels beyond which polarity ``auto`` takes the light ones for obstacles."""


def binarise(
    image: NDArray[Any] | Sequence[Any],
    *,
    polarity: Polarity = "dark",
    method: Method = "auto",
    threshold: float | None = None,
    ignore: NDArray[np.bool_] | None = None,
    room: Room | None = None,
) -> Binary:
    """Decide for every pixel whether it is obstacle.

    ``threshold`` (0 .. 255, or 0 .. 65535 for 16 bits) is the level of method ``fixed``: a
    dark obstacle's pixels lie below it, a light one's at it or above. Pixels of ``ignore``
    (h, w) are free whatever they look like. ``room`` is where the mask is made, which then
    stays only until the room is used again. Raises ``PictureError`` where there is no free
    pixel, or an option is wrong. O(pixels).
    """
    if method not in METHODS:
        raise PictureError(f"method {method!r}: must be one of {', '.join(METHODS)}")
    if polarity not in POLARITIES:
        raise PictureError(f"polarity {polarity!r}: must be one of {', '.join(POLARITIES)}")
    image = as_array(image)
    grey = as_grey(image)
    if threshold is not None:
        if method not in ("auto", "fixed"):
            raise PictureError(f"threshold {threshold}: only method fixed takes one, not {method}")
        method = "fixed"
        threshold = scaled_threshold(threshold, image)
    if ignore is not None and ignore.shape != grey.shape:
        raise PictureError(f"ignore has shape {ignore.shape}: must be the picture's {grey.shape}")
    side, why_side = _side(grey, polarity)
    if side == "light":
        grey = cv2.bitwise_not(grey) if grey.dtype == np.uint8 else 255 - grey
        threshold = None if threshold is None else 255.0 - threshold + 1e-6
    binary = _by_method(Look(grey, room), side, method, threshold)
    if why_side:
        how = binary.how
        how = Binarisation(how.method, how.threshold, side, f"{how.reason}; {why_side}")
        binary = replace(binary, how=how)
    if ignore is not None:
        width = grey.shape[1]
        binary.mask[1:-1, 1 : width + 1][ignore] = 0
        binary = replace(binary, by_level=False)
    # where the first row has a free pixel the others need not be looked at
    first_row = binary.inside[0]
    if first_row.all() and cv2.countNonZero(binary.mask) == grey.size:
        raise PictureError(
            f"the picture has no free space: all {grey.shape[1]} x {grey.shape[0]} pixels are "
            f"{'black' if side == 'dark' else 'white'}, which is what obstacles are"
        )
    return binary


def _side(grey: NDArray[Any], polarity: Polarity) -> tuple[Literal["dark", "light"], str]:
    """Which side of the level obstacles lie on: the rarer, where it is ours to find out."""
    if polarity != "auto":
        return polarity, ""
    classes = split_classes(sampled_histogram(grey), noise_sigma(grey))
    if classes is None or classes.dark_share <= MOSTLY:
        share = 0.0 if classes is None else classes.dark_share
        return "dark", f"obstacles are dark: dark pixels are {share:.1%} of the picture"
    share = 1.0 - classes.dark_share
    return "light", f"obstacles are light: light pixels are {share:.1%} of the picture"


def _by_method(
    look: Look, side: Literal["dark", "light"], method: Method, threshold: float | None
) -> Binary:
    classes = classes_of(look)
    if method == "fixed":
        level = 127.5 if threshold is None else threshold
        contrast = 2.0 * min(level, 255.0 - level) if classes is None else classes.contrast
        how = Binarisation("fixed", _shown(level, side), side, "the level was given")
        return black_and_white(look, level, contrast, how)
    if method == "adaptive":
        return _adaptive(look, classes, side)
    if method == "background":
        return _divided(look, side, "asked for")[0]
    if method == "otsu":
        if classes is None:
            return _uniform(look, side)
        level = _otsu(look.grey) + 0.5
        how = Binarisation("otsu", _shown(level, side), side, "asked for")
        return black_and_white(look, level, classes.contrast, how)
    if classes is not None and least_room(look, classes, side) >= EVEN_MARGIN:
        return _even(look, classes, side)
    return _uneven(look, classes, side)


def _uneven(look: Look, classes: Classes | None, side: Literal["dark", "light"]) -> Binary:
    """Divide by the light where that sets the classes apart better than one level does."""
    spread = grey_spread(look.counts) if classes is None else classes.light_spread
    if classes is None and spread <= 1.5 * look.noise + LEAST_CONTRAST / 4.0:
        return _uniform(look, side)
    divided, after = _divided(
        look, side, f"uneven light: free pixels spread by {spread:.0f} grey levels"
    )
    if after is None:
        return _uniform(look, side) if classes is None else _even(look, classes, side)
    if classes is None or room_left(after, divided.noise) > least_room(look, classes, side):
        return divided
    return _even(look, classes, side)


def _even(look: Look, classes: Classes, side: Literal["dark", "light"]) -> Binary:
    reason = (
        f"even light: obstacles at {classes.dark:.0f}, free at {classes.light:.0f}, "
        f"noise {look.noise:.1f} grey levels; the level lies half-way"
    )
    how = Binarisation("otsu", _shown(classes.level, side), side, reason)
    return black_and_white(look, classes.level, classes.contrast, how)


def _uniform(look: Look, side: Literal["dark", "light"]) -> Binary:
    """A picture without contrast is all free or all obstacle."""
    mean = float(cv2.mean(look.grey)[0])
    level = 256.0 if mean < 127.5 else -1.0
    how = Binarisation(
        "fixed",
        127.5,
        side,
        f"no contrast: every pixel is within noise of {mean:.0f}, "
        f"{'darker' if mean < 127.5 else 'lighter'} than half",
    )
    return black_and_white(look, level, 255.0, how)


def _adaptive(look: Look, classes: Classes | None, side: Literal["dark", "light"]) -> Binary:
    grey = look.grey
    block = (min(grey.shape) // 4) | 1
    mean = cv2.blur(grey.astype(np.float32), (block, block), borderType=cv2.BORDER_REPLICATE)
    offset = LEAST_CONTRAST if classes is None else max(LEAST_CONTRAST, 0.1 * classes.contrast)
    centred = np.clip(grey - mean + np.float32(offset + 127.5), 0.0, 255.0)
    how = Binarisation(
        "adaptive",
        offset,
        side,
        f"a pixel is obstacle {offset:.0f} grey levels below the mean of {block} x {block} pixels",
    )
    contrast = 2.0 * LEAST_CONTRAST if classes is None else classes.contrast
    centred = centred.astype(np.float32, copy=False)
    return black_and_white(Look(centred, look.room), 127.5, contrast, how, noise=look.noise)


def _divided(look: Look, side: Literal["dark", "light"], why: str) -> tuple[Binary, Classes | None]:
    light, top = light_surface(look.grey, side), 0.0
    if side == "light":
        # light multiplies what the camera saw, not its negative
        ratio = (np.float32(255.0) - look.grey) / light
        top = max(float(cv2.blur(ratio, (3, 3)).max()), 1.0 + LEAST_CONTRAST / FREE_LEVEL)
        flat = np.clip((top - ratio) * np.float32(FREE_LEVEL / (top - 1.0)), 0.0, 255.0)
    else:
        flat = np.clip(look.grey / light * np.float32(FREE_LEVEL), 0.0, 255.0)
    scale = FREE_LEVEL / (top - 1.0) if side == "light" else FREE_LEVEL
    flat = flat.astype(np.float32, copy=False)
    divided = Look(flat, look.room)
    divided.noise = float(noise_sigma(flat))
    # where there is little light, division makes the noise stronger
    strongest = max(divided.noise, float(noise_sigma(look.grey)) * scale / float(light.min()))
    classes = classes_of(divided, strongest)
    level = 0.5 * FREE_LEVEL if classes is None else classes.level
    contrast = FREE_LEVEL if classes is None else classes.contrast
    shown = top - level / scale if side == "light" else level / FREE_LEVEL
    how = Binarisation(
        "background",
        round(shown, 4),
        side,
        f"{why}; divided by a quadratic surface of the light, which runs from "
        f"{float(light.min()):.0f} to {float(light.max()):.0f}",
    )
    return black_and_white(divided, level, contrast, how, strongest_noise=strongest), classes


def _otsu(grey: NDArray[Any]) -> float:
    eight = grey if grey.dtype == np.uint8 else np.rint(grey).astype(np.uint8)
    return float(cv2.threshold(eight, 0, 1, cv2.THRESH_BINARY | cv2.THRESH_OTSU)[0])


def _shown(level: float, side: Literal["dark", "light"]) -> float:
    """The level in the values of the picture as it came, where light may be obstacle."""
    return round(level if side == "dark" else 255.0 - level, 3)
