"""From whatever shows a picture to its grey values.

Rules and units
- Grey values are 0 .. 255: 8 bits as they are, a 16-bit picture scaled by its brightest pixel.
- What is transparent counts as white.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.errors import PictureError


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
        return read_only(grey.astype(np.float32) * np.float32(255.0 / max(brightest, 1)))
    return read_only(grey)


def read_only(grey: NDArray[Any]) -> NDArray[Any]:
    """The same picture, rows side by side, that nobody may change.

    A camera's frame is no other: kernels are compiled once more for what may be changed.
    """
    shown = np.ascontiguousarray(grey).view()
    shown.setflags(write=False)
    return shown


def scaled_threshold(threshold: float, image: NDArray[Any]) -> float:
    """A threshold in the values of ``image`` on the scale of ``as_grey``, 0 .. 255.

    Raises ``PictureError`` where it is no number, or outside the values the picture can have.
    """
    top = np.iinfo(image.dtype).max
    is_number = isinstance(threshold, (int, float, np.integer, np.floating))
    if not is_number or isinstance(threshold, bool):
        raise PictureError(f"threshold {threshold!r}: must be a number in 0 .. {top}")
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
