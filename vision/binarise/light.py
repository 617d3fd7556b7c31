"""The light on the ground, as a surface over the picture.

Grey values are 0 .. 255.
"""

from __future__ import annotations

from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray


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
