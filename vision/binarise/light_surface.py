"""Light on the ground, as a surface over the picture.

Local light is measured in a thumbnail, one pixel for ``STEP_REACH_PX``: light has no sharper edges.
"""

from __future__ import annotations

from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.binarise.binarise_kernels import STEP_REACH_PX

FREE_LEVEL = 200.0
"""Grey value of the free floor in a picture divided by its light or beside the floor's colour:
chosen, with room above for noise and lighter pixels."""
WIDEST_OBSTACLE = 0.33
"""Largest obstacle, as a share of the shorter side, where local light is measured: chosen, a third.
"""


def light_surface(
    grey: NDArray[Any], side: Literal["dark", "light"] = "dark"
) -> NDArray[np.float32]:
    """Light on the free ground as a quadratic surface, (h, w) float32 >= 1.

    Asymmetric least squares on a thumbnail: pixels below the surface weigh little, later those far
    below hardly anything. With ``side`` light, ``grey`` is the negative, the surface that of the
    picture, and obstacles lie above it.
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
        # six equations, not one per pixel; a picture one pixel wide leaves some unknown
        weighted = terms.T * weights
        surface = terms @ np.linalg.lstsq(weighted @ terms, weighted @ values, rcond=None)[0]
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


def without_light(
    grey: NDArray[Any], side: Literal["dark", "light"]
) -> tuple[NDArray[np.uint8], float]:
    """Picture (h, w) whose free ground is ``FREE_LEVEL``, and the factor by which noise grows in
    the weakest light.

    The picture is divided by a closing: only dark structure narrower than a share
    ``WIDEST_OBSTACLE`` is filled, evenly rising light stays. With ``side`` light, ``grey`` is the
    negative, and an opening removes light obstacles.
    """
    height, width = grey.shape
    camera = grey if side == "dark" else 255 - grey
    small = cv2.resize(
        camera,
        (max(width // STEP_REACH_PX, 1), max(height // STEP_REACH_PX, 1)),
        interpolation=cv2.INTER_AREA,
    ).astype(np.float32)
    wide = 2 * round(0.5 * WIDEST_OBSTACLE * min(small.shape)) + 1
    filled = cv2.morphologyEx(
        small,
        cv2.MORPH_CLOSE if side == "dark" else cv2.MORPH_OPEN,
        np.ones((wide, wide), np.uint8),
        borderType=cv2.BORDER_REPLICATE,
    )
    light = cv2.resize(filled, (width, height), interpolation=cv2.INTER_LINEAR)
    shown = camera.astype(np.float32)
    darker, lighter = (shown, light) if side == "dark" else (light, shown)
    flat = darker * np.float32(FREE_LEVEL) / np.maximum(lighter, np.float32(1.0))
    least = max(float(filled.min()), 1.0)
    return np.asarray(np.clip(np.rint(flat), 0.0, 255.0), dtype=np.uint8), FREE_LEVEL / least
