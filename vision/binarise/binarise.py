"""The pixels that are obstacle, with the method and the reason.

Rules and units
- Grey values are 0 .. 255, obstacles dark: 16 bits are scaled by the brightest pixel, light
  obstacles turned into dark ones.
- A pixel below the level is obstacle.
- Methods: ``otsu`` (one level, from the histogram), ``fixed`` (the caller's), ``adaptive`` (the
  mean of the neighbourhood), ``background`` (division by a fitted surface of the light).
- ``auto`` takes one level in even light and divides by the light otherwise.
- ``Binary.grey`` has one level for the whole picture; sub-pixel edges are measured in it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from planner.scene import Binarisation
from vision.binarise import METHODS, POLARITIES, Method, Polarity
from vision.binarise.binarise_kernels import SIGMAS, noise_sigma
from vision.binarise.grey_classes import (
    Classes,
    classes_of,
    grey_spread,
    significant_dark,
    split_classes,
    unevenness,
)
from vision.binarise.grey_picture import (
    FEWEST_SAMPLES,
    LEAST_CONTRAST,
    SMOOTHED_NOISE,
    SMOOTHINGS,
    Binary,
    GreyPicture,
    as_array,
    as_grey,
    black_and_white,
    scaled_threshold,
)
from vision.binarise.light_surface import FREE_LEVEL, light_surface
from vision.binarise.regions.edge_evidence import (
    NEARLY_ALL,
    EdgeEvidence,
    follows_edges,
    leaves_out,
    with_left_out,
)
from vision.binarise.unresolved import Unresolved, unresolved_structure
from vision.picture_error import PictureError
from vision.shared.array_pool import ArrayPool

MOST_UNEVEN = 0.125
"""Largest spread of free pixels in even light, as a share of the contrast: chosen, the darkest, of
two such spreads, stay half as far from the level as they would without. In uneven light, the least
distance between level and class."""
SURELY_EVEN = 0.5 / SIGMAS
"""The same where noise, or the glow around light obstacles, hides edges that are left out: derived,
no free pixel comes near the level then."""
LIT_SHARE = 0.95
"""Place in its histogram of the best lit part of an edgeless picture: chosen."""
MOSTLY = 0.65
"""Share of dark pixels beyond which polarity ``auto`` takes the light ones for obstacles: chosen,
an arena has more free space than obstacles."""


def binarise(
    image: NDArray[Any] | Sequence[Any],
    *,
    polarity: Polarity = "dark",
    method: Method = "auto",
    threshold: float | None = None,
    ignore: NDArray[np.bool_] | None = None,
    pool: ArrayPool | None = None,
) -> Binary:
    """Decide for every pixel if it is obstacle.

    ``threshold`` (0 .. 255, or 0 .. 65535 for 16 bits) is the level of method ``fixed``: dark
    obstacles lie below it, light ones not. Pixels of ``ignore`` (h, w) are always free. ``pool``
    holds the mask, which is valid until ``pool`` is used again. Raises ``PictureError`` if no pixel
    is free or an option is wrong.
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
    binary = _by_method(GreyPicture(grey, pool), side, method, threshold)
    if why_side:
        how = binary.how
        how = Binarisation(how.method, how.threshold, side, f"{how.reason}; {why_side}")
        binary = replace(binary, how=how)
    if ignore is not None:
        width = grey.shape[1]
        binary.mask[1:-1, 1 : width + 1][ignore] = 0
        binary = replace(binary, by_level=False)
    first_row = binary.inside[0]
    if first_row[0] and first_row.all() and cv2.countNonZero(binary.mask) == grey.size:
        raise PictureError(
            f"the picture has no free space: all {grey.shape[1]} x {grey.shape[0]} pixels are "
            f"{'black' if side == 'dark' else 'white'}, which is what obstacles are: "
            f"{binary.how.reason}"
        )
    return binary


def warm_up(polarity: Polarity = "dark") -> None:
    """Compile or load the kernels for uneven light, noise and thin walls: a shadow in a run must
    not wait."""
    ground = np.full((96, 128), 200.0)
    ground[20:60, 20:50] = 40.0
    ground[30:33, 70:120] = 40.0
    light = np.linspace(1.0, 0.25, 128)
    walls = np.full((96, 128), 200.0)
    walls[20:80:20] = walls[21:80:20] = walls[22:80:20] = 40.0
    noise = np.random.default_rng(0).normal(0.0, 1.0, ground.shape)
    blurred = cv2.GaussianBlur(walls, (0, 0), 0.7)
    uneven = ground * light
    wild = 0.7 * ground + 50.0 + 60.0 * noise
    lighter = ground.copy()
    lighter[70:90, 20:50] = 150.0
    drawn = (ground, ground + 20.0 * noise, wild, uneven, uneven + 8.0 * noise, blurred, lighter)
    for each in drawn:
        shown = each if polarity != "light" else 255.0 - each
        picture = np.clip(np.rint(shown), 0.0, 255.0).astype(np.uint8)
        binarise(picture, polarity=polarity)


def _side(grey: NDArray[Any], polarity: Polarity) -> tuple[Literal["dark", "light"], str]:
    """Side of the level that obstacles lie on; ``auto`` takes the rarer one."""
    if polarity != "auto":
        return polarity, ""
    picture = GreyPicture(grey)
    classes = split_classes(picture.counts, noise_sigma(grey))
    if picture.fine is not None:
        classes = classes_of(picture)
    if classes is None or classes.dark_share <= MOSTLY:
        share = 0.0 if classes is None else classes.dark_share
        return "dark", f"obstacles are dark: dark pixels are {share:.1%} of the picture"
    share = 1.0 - classes.dark_share
    return "light", f"obstacles are light: light pixels are {share:.1%} of the picture"


def _by_method(
    picture: GreyPicture, side: Literal["dark", "light"], method: Method, threshold: float | None
) -> Binary:
    classes = classes_of(picture)
    match method:
        case "fixed":
            return _fixed(picture, classes, side, 127.5 if threshold is None else threshold)
        case "otsu":
            return _by_otsu(picture, classes, side)
        case "adaptive":
            return _adaptive(picture, classes, side)
        case "background":
            return _best_divided(picture, side)
        case "auto":
            return _auto(picture, classes, side)


def _fixed(
    picture: GreyPicture, classes: Classes | None, side: Literal["dark", "light"], level: float
) -> Binary:
    contrast = 2.0 * min(level, 255.0 - level) if classes is None else classes.contrast
    how = Binarisation("fixed", _shown(level, side), side, "the level was given")
    return black_and_white(picture, level, contrast, how)


def _by_otsu(
    picture: GreyPicture, classes: Classes | None, side: Literal["dark", "light"]
) -> Binary:
    if classes is None:
        return _uniform(picture, side)
    level = _otsu(picture.grey) + 0.5
    how = Binarisation("otsu", _shown(level, side), side, "asked for")
    return black_and_white(picture, level, classes.contrast, how)


def _auto(picture: GreyPicture, classes: Classes | None, side: Literal["dark", "light"]) -> Binary:
    if classes is not None and picture.fine is not None:
        return _fine(picture, classes, side)
    too_fine = unresolved_structure(picture, classes, side)
    if too_fine is not None:
        return _unresolved(picture, side, too_fine)
    spread = grey_spread(picture.counts) if classes is None else classes.light_spread
    if classes is None and spread <= 1.5 * picture.noise + LEAST_CONTRAST / 4.0:
        return _uniform(picture, side)
    even = classes
    uneven = math.inf if classes is None else unevenness(picture, classes, side)
    if uneven > MOST_UNEVEN:
        even = None
    # noise, and the glow around light obstacles, hide left-out edges
    sure = uneven <= SURELY_EVEN
    surely = sure or (side == "dark" and picture.noise < SMOOTHED_NOISE)
    if (
        even is not None
        and surely
        and follows_edges(picture, even)
        and not leaves_out(picture, even.level, side)
    ):
        return _even(picture, even, side)
    evidence = EdgeEvidence(picture, side, even=even is not None)
    best, across = evidence.best_level(picture.counts, even)
    if across < FEWEST_SAMPLES:
        evidence = EdgeEvidence(picture, side, 2 * picture.grey.size, even is not None)
        best, _ = evidence.best_level(picture.counts, even)
    why = f"uneven light: free pixels spread by {spread:.0f} grey levels"
    judged = [(evidence.judge.real(one), 1.0) for one in _divided(picture, side, why)]
    # a division, or the level of even light, wins with slightly less: both lie nearer to half-way
    for each in dict.fromkeys(one for one in (even, best) if one is not None):
        level = (_even if each is even else _level)(picture.apart(), each, side)
        as_good = 1.0 / NEARLY_ALL if each is even and sure else NEARLY_ALL
        judged.append((evidence.judge.real(level), as_good))
    judged = [one for one in judged if one[0].speaks > 0.0]
    if not judged:
        return _edgeless(picture, side)
    typical = max(one.typical for one, _ in judged)
    judged.sort(key=lambda one: one[1] * one[0].worth(typical), reverse=True)
    best_of_all, *others = (one for one, _ in judged)
    return with_left_out(best_of_all, others, evidence)


def _even(picture: GreyPicture, classes: Classes, side: Literal["dark", "light"]) -> Binary:
    reason = (
        f"even light: obstacles at {classes.dark:.0f}, free at {classes.light:.0f}, "
        f"noise {picture.noise:.1f} grey levels; the level lies half-way"
    )
    how = Binarisation("otsu", _shown(classes.level, side), side, reason)
    return black_and_white(picture, classes.level, classes.contrast, how)


def _fine(picture: GreyPicture, classes: Classes, side: Literal["dark", "light"]) -> Binary:
    if SIGMAS * picture.noise <= 0.5 * classes.contrast:
        return _even(picture, classes, side)
    level = classes.level + picture.noise
    reason = (
        f"walls or ways of a few pixels: obstacles at {classes.dark:.0f}, free at "
        f"{classes.light:.0f}, noise {picture.noise:.1f} grey levels; the level lies that much "
        "nearer to free than half-way"
    )
    how = Binarisation("otsu", _shown(level, side), side, reason)
    return black_and_white(picture, level, classes.contrast, how)


def _level(picture: GreyPicture, classes: Classes, side: Literal["dark", "light"]) -> Binary:
    reason = (
        f"uneven light, but edges are sharpest at one level: obstacles at {classes.dark:.0f}, "
        f"free at {classes.light:.0f}, noise {picture.noise:.1f} grey levels"
    )
    how = Binarisation("otsu", _shown(classes.level, side), side, reason)
    # contrast is lowest where light is weakest
    margin = MOST_UNEVEN * classes.contrast
    return black_and_white(picture, classes.level, classes.contrast, how, margin=margin)


def _uniform(picture: GreyPicture, side: Literal["dark", "light"]) -> Binary:
    mean = float(cv2.mean(picture.grey)[0])
    why = f"no contrast: every pixel is within noise of {mean:.0f}"
    return _all_alike(picture, side, mean, why)


def _edgeless(picture: GreyPicture, side: Literal["dark", "light"]) -> Binary:
    """Make an edgeless picture all free or all obstacle, by its best-lit part."""
    running = np.cumsum(picture.counts)
    lit = float(np.searchsorted(running, LIT_SHARE * running[-1]))
    return _all_alike(picture, side, lit, f"no edges: the light runs up to {lit:.0f} and is uneven")


def _unresolved(picture: GreyPicture, side: Literal["dark", "light"], found: Unresolved) -> Binary:
    why = (
        "walls and ways may be too fine for the picture: the ground's grey varies by "
        f"{found.spread:.0f} levels from pixel to pixel, more than noise does, so that all of it "
        "counts as obstacle; focus the camera, bring it closer, use more pixels, or more light"
    )
    # not a method whose level may be applied to part of a later picture
    how = Binarisation("unresolved", _shown(found.level, side), side, why)
    margin = found.level - found.middle
    binary = black_and_white(
        picture, found.level, 2.0 * margin, how, strongest_noise=found.spread, margin=margin
    )
    return replace(binary, remarks=(*binary.remarks, why))


def _all_alike(
    picture: GreyPicture, side: Literal["dark", "light"], grey: float, why: str
) -> Binary:
    dark = grey < 127.5
    reason = f"{why}, {'darker' if dark else 'lighter'} than half"
    how = Binarisation("fixed", 127.5, side, reason)
    return black_and_white(picture, 256.0 if dark else -1.0, 255.0, how)


def _adaptive(
    picture: GreyPicture, classes: Classes | None, side: Literal["dark", "light"]
) -> Binary:
    grey = picture.grey
    block = (min(grey.shape) // 4) | 1
    mean = cv2.blur(grey.astype(np.float32), (block, block), borderType=cv2.BORDER_REPLICATE)
    contrast = 2.0 * LEAST_CONTRAST if classes is None else classes.contrast
    # farther below the mean than noise gets after the widest smoothing
    at_least = SIGMAS * SMOOTHINGS[-1].left * picture.noise
    offset = max(LEAST_CONTRAST, 0.1 * contrast, at_least)
    centred = np.clip(grey - mean + np.float32(offset + 127.5), 0.0, 255.0)
    how = Binarisation(
        "adaptive",
        offset,
        side,
        f"a pixel is obstacle {offset:.0f} grey levels below the mean of {block} x {block} pixels",
    )
    centred = centred.astype(np.float32, copy=False)
    return black_and_white(
        GreyPicture(centred, picture.pool), 127.5, contrast, how, noise=picture.noise, margin=offset
    )


def _best_divided(picture: GreyPicture, side: Literal["dark", "light"]) -> Binary:
    found = _divided(picture, side, "asked for")
    if len(found) == 1:
        return found[0]
    judge = EdgeEvidence(picture, side).judge
    judged = [judge.real(replace(one, mask=one.mask.copy())) for one in found]
    typical = max(one.typical for one in judged)
    return max(zip(found, judged, strict=True), key=lambda one: one[1].worth(typical))[0]


def _divided(picture: GreyPicture, side: Literal["dark", "light"], why: str) -> list[Binary]:
    """Picture divided by the light, at the level between its classes.

    In noise a second mask uses the level half-way to significantly darker pixels. Each mask has its
    own memory.
    """
    light, top = light_surface(picture.grey, side), 0.0
    if side == "light":
        # light multiplies the camera's values, not their negative
        ratio = (np.float32(255.0) - picture.grey) / light
        top = max(float(cv2.blur(ratio, (3, 3)).max()), 1.0 + LEAST_CONTRAST / FREE_LEVEL)
        flat = np.clip((top - ratio) * np.float32(FREE_LEVEL / (top - 1.0)), 0.0, 255.0)
    else:
        flat = np.clip(picture.grey / light * np.float32(FREE_LEVEL), 0.0, 255.0)
    scale = FREE_LEVEL / (top - 1.0) if side == "light" else FREE_LEVEL
    flat = flat.astype(np.float32, copy=False)
    divided = GreyPicture(flat)
    if divided.fine is None:
        divided.noise = float(noise_sigma(divided.grey))
    # division amplifies noise where there is little light
    noise = np.float32(noise_sigma(picture.grey) * scale) / light
    strongest = max(divided.noise, float(noise.max()))
    why = (
        f"{why}; divided by a quadratic surface of the light, which runs from "
        f"{float(light.min()):.0f} to {float(light.max()):.0f}"
    )

    def at(level: float, contrast: float) -> Binary:
        shown = top - level / scale if side == "light" else level / FREE_LEVEL
        how = Binarisation("background", round(shown, 4), side, why)
        return black_and_white(divided.apart(), level, contrast, how, strongest_noise=strongest)

    classes = classes_of(divided, strongest)
    plain = (0.5 * FREE_LEVEL, FREE_LEVEL)
    if classes is not None:
        plain = (classes.level, classes.contrast)
    found = [at(*plain)]
    dark = significant_dark(divided, noise, FREE_LEVEL) if strongest >= SMOOTHED_NOISE else None
    if dark is not None:
        found.append(at(0.5 * (FREE_LEVEL + dark), FREE_LEVEL - dark))
    return found


def _otsu(grey: NDArray[Any]) -> float:
    eight = grey if grey.dtype == np.uint8 else np.rint(grey).astype(np.uint8)
    return float(cv2.threshold(eight, 0, 1, cv2.THRESH_BINARY | cv2.THRESH_OTSU)[0])


def _shown(level: float, side: Literal["dark", "light"]) -> float:
    """Level in the original picture's values, where obstacles may be light."""
    return round(level if side == "dark" else 255.0 - level, 3)
