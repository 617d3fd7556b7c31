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

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from planner.scene import Binarisation
from vision.binarise_kernels import noise_sigma, sampled_histogram, split_histogram
from vision.room import Room

Method: TypeAlias = Literal["auto", "otsu", "fixed", "adaptive", "background"]
Polarity: TypeAlias = Literal["dark", "light", "auto"]
METHODS: tuple[Method, ...] = ("auto", "otsu", "fixed", "adaptive", "background")
POLARITIES: tuple[Polarity, ...] = ("dark", "light", "auto")

LEAST_CONTRAST = 8.0
"""Grey levels between light and dark below which nothing is taken for an obstacle."""
LEAST_CONTRAST_SIGMAS = 5.0
"""The same in standard deviations of the noise."""
SAFE_MARGIN_SIGMAS = 6.0
"""From here on no pixel of a whole picture crosses the level by noise alone."""
EVEN_MARGIN = 0.25
"""Least distance of the darkest free pixels from the level, as a share of the contrast, at
which light is even: the edge itself is measured against its own surroundings."""
DARKEST_SIGMAS = 2.0
"""How far below the middle the darkest free pixels are taken to be, in spreads of the light."""
CALM_NOISE, WILD_NOISE = 4.0, 25.0
"""Noise, in grey levels, from which a picture is smoothed by 1 and by 2 px where noise counts."""
BUSY_NOISE = 12.0
"""Noise up to which the mean of 3 x 3 pixels is smooth enough to be judged, and cheaper."""
LEFT_BY_GAUSSIAN = 0.2821
"""The share of white noise that a Gaussian of sigma 1 leaves; less for a wider one."""
LEFT_BY_BINOMIAL = 0.2734
"""The same for the binomial of 5 x 5 pixels, whose sigma is 1 too."""
FREE_LEVEL = 200.0
"""Grey value that free pixels get when the picture is divided by its light."""


MOSTLY = 0.65
"""Share of dark pixels beyond which polarity ``auto`` takes the light ones for obstacles."""


class PictureError(ValueError):
    """A picture cannot be used; the message says what is wrong with it."""


@dataclass(frozen=True, slots=True)
class Binary:
    """A picture in black and white.

    ``mask`` (h + 2, w') uint8: 1 is obstacle, with a margin of free pixels and rows of a
    multiple of eight bytes; ``grey`` (h, w), obstacles dark, ``level`` in its values;
    ``noise`` its standard deviation and ``contrast`` the step between free and obstacle.
    ``by_level``: the mask is what lies below the level in ``grey``, no more and no less.
    """

    mask: NDArray[np.uint8]
    grey: NDArray[Any]
    level: float
    noise: float
    contrast: float
    how: Binarisation
    remarks: tuple[str, ...] = ()
    by_level: bool = False

    @property
    def size(self) -> tuple[int, int]:
        """The picture's (width, height)."""
        return self.grey.shape[1], self.grey.shape[0]

    @property
    def inside(self) -> NDArray[np.uint8]:
        """The mask without its margin, (h, w)."""
        return self.mask[1:-1, 1 : self.grey.shape[1] + 1]


@dataclass(frozen=True, slots=True)
class Classes:
    """Two classes of grey values: their middles, how wide each is, and how many are dark."""

    dark: float
    light: float
    light_spread: float
    dark_share: float

    @property
    def level(self) -> float:
        """Half-way between the classes."""
        return 0.5 * (self.dark + self.light)

    @property
    def contrast(self) -> float:
        """Grey levels between the classes."""
        return self.light - self.dark


class _Look:
    """A grey picture, its noise and its histogram; smoothed once for every sigma asked for."""

    def __init__(self, grey: NDArray[Any], room: Room | None = None) -> None:
        self.grey = grey
        self.room = Room() if room is None else room
        self.counts: NDArray[np.int64] = sampled_histogram(grey)
        # two values only: drawn, not taken; what looks like noise is texture
        drawn = np.count_nonzero(self.counts) <= 2
        self.noise = 0.0 if drawn else float(noise_sigma(grey))
        self._smoothed: dict[float, NDArray[Any]] = {}

    def calmed(self, noise: float) -> tuple[NDArray[Any], float]:
        """The picture smoothed as noise demands, and the share of the noise that is left."""
        if noise < CALM_NOISE:
            return self.grey, 1.0
        sigma = 1.0 if noise < WILD_NOISE else 2.0
        if sigma not in self._smoothed:
            # the binomial takes half the time of the Gaussian of its width
            self._smoothed[sigma] = (
                cv2.GaussianBlur(self.grey, (5, 5), 0.0)
                if sigma == 1.0
                else cv2.GaussianBlur(self.grey, (0, 0), sigma)
            )
        return self._smoothed[sigma], LEFT_BY_BINOMIAL if sigma == 1.0 else LEFT_BY_GAUSSIAN / sigma


def as_array(image: NDArray[Any] | Sequence[Any]) -> NDArray[Any]:
    """A picture from an array, as it is, or from sequences of whole numbers, row by row.

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
    """The picture's grey values as (h, w) uint8, or float32 in 0 .. 255 from 16 bits.

    Takes uint8 or uint16 of shape (h, w), (h, w, 1), (h, w, 3) BGR or (h, w, 4) BGRA, where
    what is transparent counts as white. Raises ``PictureError`` for anything else. O(pixels).
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
        return grey.astype(np.float32) * np.float32(255.0 / max(brightest, 1))
    return np.ascontiguousarray(grey)


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
        threshold = _scaled_threshold(threshold, image)
    if ignore is not None and ignore.shape != grey.shape:
        raise PictureError(f"ignore has shape {ignore.shape}: must be the picture's {grey.shape}")
    side, why_side = _side(grey, polarity)
    if side == "light":
        grey = cv2.bitwise_not(grey) if grey.dtype == np.uint8 else 255 - grey
        threshold = None if threshold is None else 255.0 - threshold + 1e-6
    binary = _by_method(_Look(grey, room), side, method, threshold)
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


def _over_white(image: NDArray[Any]) -> NDArray[Any]:
    top = np.iinfo(image.dtype).max
    alpha = image[:, :, 3].astype(np.float32) / top
    grey = cv2.cvtColor(image[:, :, :3], cv2.COLOR_BGR2GRAY).astype(np.float32)
    blended: NDArray[Any] = np.rint(grey * alpha + top * (1.0 - alpha)).astype(image.dtype)
    return blended


def _scaled_threshold(threshold: float, image: NDArray[Any]) -> float:
    top = np.iinfo(image.dtype).max
    if not 0.0 <= threshold <= top:
        raise PictureError(f"threshold {threshold}: must lie in 0 .. {top}")
    if image.dtype == np.uint8:
        return float(threshold)
    return float(threshold) * 255.0 / max(int(image.max()), 1)


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
    look: _Look, side: Literal["dark", "light"], method: Method, threshold: float | None
) -> Binary:
    classes = _classes(look)
    if method == "fixed":
        level = 127.5 if threshold is None else threshold
        contrast = 2.0 * min(level, 255.0 - level) if classes is None else classes.contrast
        how = Binarisation("fixed", _shown(level, side), side, "the level was given")
        return _binary(look, level, contrast, how)
    if method == "adaptive":
        return _adaptive(look, classes, side)
    if method == "background":
        return _divided(look, side, "asked for")[0]
    if method == "otsu":
        if classes is None:
            return _uniform(look, side)
        level = _otsu(look.grey) + 0.5
        how = Binarisation("otsu", _shown(level, side), side, "asked for")
        return _binary(look, level, classes.contrast, how)
    if classes is not None and _least_room(look, classes, side) >= EVEN_MARGIN:
        return _even(look, classes, side)
    return _uneven(look, classes, side)


def _uneven(look: _Look, classes: Classes | None, side: Literal["dark", "light"]) -> Binary:
    """Divide by the light where that sets the classes apart better than one level does."""
    spread = _spread(look.counts) if classes is None else classes.light_spread
    if classes is None and spread <= 1.5 * look.noise + LEAST_CONTRAST / 4.0:
        return _uniform(look, side)
    divided, after = _divided(
        look, side, f"uneven light: free pixels spread by {spread:.0f} grey levels"
    )
    if after is None:
        return _uniform(look, side) if classes is None else _even(look, classes, side)
    if classes is None or _room(after, divided.noise) > _least_room(look, classes, side):
        return divided
    return _even(look, classes, side)


def _classes(look: _Look, strongest: float | None = None) -> Classes | None:
    """The two classes of a picture, seen through a little smoothing where it is noisy."""
    strongest = look.noise if strongest is None else strongest
    if CALM_NOISE <= strongest < BUSY_NOISE:
        calm, left = cv2.blur(look.grey, (3, 3)), 1.0 / 3.0
    else:
        calm, left = look.calmed(strongest)
    counts = look.counts if calm is look.grey else sampled_histogram(calm)
    found = split_classes(counts, look.noise * left)
    if found is None:
        found = _rare_pixels(calm, strongest * left)
    if found is None or left == 1.0:
        return found
    # the spread that noise explains, as the unsmoothed picture would have it
    explained = float(np.hypot(look.noise, found.light_spread))
    return replace(found, light_spread=explained)


def _spread(counts: NDArray[np.int64]) -> float:
    """The grey values' spread: the quartiles' distance, as a normal distribution's sigma."""
    running = np.cumsum(counts)
    low, high = np.searchsorted(running, running[-1] * np.array([0.25, 0.75]))
    return float(high - low) / 1.349


def _even(look: _Look, classes: Classes, side: Literal["dark", "light"]) -> Binary:
    reason = (
        f"even light: obstacles at {classes.dark:.0f}, free at {classes.light:.0f}, "
        f"noise {look.noise:.1f} grey levels; the level lies half-way"
    )
    how = Binarisation("otsu", _shown(classes.level, side), side, reason)
    return _binary(look, classes.level, classes.contrast, how)


def _uniform(look: _Look, side: Literal["dark", "light"]) -> Binary:
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
    return _binary(look, level, 255.0, how)


def _adaptive(look: _Look, classes: Classes | None, side: Literal["dark", "light"]) -> Binary:
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
    return _binary(_Look(centred, look.room), 127.5, contrast, how, noise=look.noise)


def _divided(
    look: _Look, side: Literal["dark", "light"], why: str
) -> tuple[Binary, Classes | None]:
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
    divided = _Look(flat, look.room)
    divided.noise = float(noise_sigma(flat))
    # where there is little light, division makes the noise stronger
    strongest = max(divided.noise, float(noise_sigma(look.grey)) * scale / float(light.min()))
    classes = _classes(divided, strongest)
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
    return _binary(divided, level, contrast, how, strongest_noise=strongest), classes


def light_surface(
    grey: NDArray[Any], side: Literal["dark", "light"] = "dark"
) -> NDArray[np.float32]:
    """The light on the free ground as a quadratic surface, (h, w) float32 >= 1.

    Asymmetric least squares on a thumbnail: what lies below the surface is likely obstacle
    and weighs little, then what lies far below it weighs nothing. With ``side`` light ``grey``
    is the picture's negative, and the surface that of the picture itself, whose obstacles lie
    above it.
    """
    height, width = grey.shape
    size = (min(48, width), min(36, height))
    small = cv2.resize(grey, size, interpolation=cv2.INTER_AREA).astype(np.float64)
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, size[0]), np.linspace(-1.0, 1.0, size[1]))
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1).reshape(-1, 6)
    values = small.ravel() if side == "dark" else small.ravel() - 255.0
    weights = np.ones(values.size)
    surface = values
    far = 0.75 if side == "dark" else 1.0 / 0.75
    for round_ in range(16):
        root = np.sqrt(weights)[:, None]
        surface = terms @ np.linalg.lstsq(terms * root, values * root[:, 0], rcond=None)[0]
        weights = np.where(values > surface, 1.0, 0.03)
        if round_ >= 8:
            weights = np.where(values > far * surface, 1.0, 1e-4)
    surface = surface if side == "dark" else -surface
    whole = cv2.resize(
        np.maximum(surface, 1.0).reshape(small.shape).astype(np.float32),
        (width, height),
        interpolation=cv2.INTER_CUBIC,
    )
    return np.maximum(whole, np.float32(1.0))


def split_classes(histogram: NDArray[np.int64], noise: float) -> Classes | None:
    """The two classes of a histogram (256,), or None where it has one class only.

    Minimum error thresholding (Kittler and Illingworth, 1986), which does not mind a class
    of one pixel in a thousand; no class is narrower than the noise and a grey level.
    """
    least = max(LEAST_CONTRAST, LEAST_CONTRAST_SIGMAS * noise)
    found, dark, light, spread, dark_share = split_histogram(histogram, noise, least)
    return Classes(dark, light, spread, dark_share) if found else None


def _room(classes: Classes, noise: float) -> float:
    """How far the darkest free pixels stay from the level, as a share of the contrast."""
    uneven = np.sqrt(max(classes.light_spread**2 - noise**2, 0.0))
    return float(0.5 - DARKEST_SIGMAS * uneven / classes.contrast)


def _least_room(look: _Look, classes: Classes, side: Literal["dark", "light"]) -> float:
    """The same for light obstacles too, which uneven light spreads more than it does the ground."""
    room = _room(classes, look.noise)
    if side == "dark":
        return room
    obstacles = _spread(look.counts[: math.ceil(classes.level)])
    uneven = max(obstacles**2 - look.noise**2, 0.0) ** 0.5
    return min(room, float(0.5 - DARKEST_SIGMAS * uneven / classes.contrast))


def _rare_pixels(grey: NDArray[Any], noise: float) -> Classes | None:
    """Dark pixels so rare that no sample shows them: look at the extremes of all pixels."""
    lowest, highest, _, _ = cv2.minMaxLoc(grey)
    middle = float(np.median(grey[:: max(1, grey.shape[0] // 64)]))
    least = max(LEAST_CONTRAST, 2.0 * SAFE_MARGIN_SIGMAS * noise)
    if middle - lowest >= least and middle - lowest >= highest - middle:
        return Classes(lowest, middle, 0.0, 0.0)
    if highest - middle >= least:
        return Classes(middle, highest, 0.0, 1.0)
    return None


def _otsu(grey: NDArray[Any]) -> float:
    eight = grey if grey.dtype == np.uint8 else np.rint(grey).astype(np.uint8)
    return float(cv2.threshold(eight, 0, 1, cv2.THRESH_BINARY | cv2.THRESH_OTSU)[0])


def _shown(level: float, side: Literal["dark", "light"]) -> float:
    """The level in the values of the picture as it came, where light may be obstacle."""
    return round(level if side == "dark" else 255.0 - level, 3)


def _binary(
    look: _Look,
    level: float,
    contrast: float,
    how: Binarisation,
    *,
    noise: float | None = None,
    strongest_noise: float | None = None,
) -> Binary:
    """Compare with the level, in a smoothed picture where noise alone could cross it."""
    remarks: tuple[str, ...] = ()
    grey = compared = look.grey
    noise = look.noise if noise is None else noise
    strongest = noise if strongest_noise is None else strongest_noise
    if strongest > 0.0 and 0.5 * contrast < SAFE_MARGIN_SIGMAS * strongest:
        compared, left = look.calmed(max(strongest, CALM_NOISE))
        sigma = LEFT_BY_GAUSSIAN / left
        remarks = (
            f"noise of up to {strongest:.0f} grey levels at a contrast of {contrast:.0f}: "
            f"the picture was smoothed by {sigma:.0f} px before the level was applied",
        )
    height, width = grey.shape
    stride = (width + 2 + 7) // 8 * 8
    mask = look.room.take("mask", (height + 2) * stride, np.uint8).reshape(-1, stride)
    mask[0] = mask[-1] = 0
    mask[:, 0] = 0
    mask[:, width + 1 :] = 0
    inside = mask[1:-1, 1 : width + 1]
    bound = float(np.ceil(level) - 1.0) if compared.dtype == np.uint8 else float(level)
    if compared.dtype == np.uint8:
        cv2.threshold(compared, bound, 1, cv2.THRESH_BINARY_INV, dst=inside)
    else:
        inside[:] = compared < level
    return Binary(mask, grey, level, noise, contrast, how, remarks, by_level=compared is grey)
