"""The camera's picture for viewers: seen straight from above, to scale, as JPEG.

- The picture is warped onto the arena's floor, so that the page's drawings lie in place. Things
  with a height lean outwards, as for the camera.
- ``window`` is the shown part of the floor: the arena with a rim. x right, y up.
- Pages cannot make the program encode more sizes than `SIZES`.
- Works in any thread.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from planner.scene import Bounds
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame
from vision.markers.markers import RobotPose

RIM = 0.04
"""Width shown around the arena, as a share of its longer side."""

OUT_OF_SIGHT_PX = -100.0
"""Place outside every picture, for floor that no pixel shows."""

SIZES: Final = 8
"""Chosen: a picture's width is one of as many parts of the configured one. A page gets at most an
eighth more than it shows, and all sizes together have 3.2 times the pixels of the largest."""
SMOOTHING_PX: Final = 0.6
"""Measured (`benchmarks.page_traffic`): takes away noise, a fifth of the bytes; edges stay as sharp
as in the next smaller size."""


def width_for(shown_px: int, most_px: int) -> int:
    """Least width of a picture that fills ``shown_px`` pixels, else ``most_px``."""
    widths = (max(1, most_px * part // SIZES) for part in range(1, SIZES + 1))
    return next((width for width in widths if width >= shown_px), most_px)


def encode_widths(
    image: NDArray[np.uint8], widths_px: Iterable[int], quality: int
) -> dict[int, NDArray[np.uint8]]:
    """JPEG of a picture at each width, or at its own if that is less."""
    height, full_px = image.shape[:2]
    smooth = cv2.GaussianBlur(image, (3, 3), SMOOTHING_PX)
    # progressive with its own code tables: a quarter fewer bytes, mostly of even floor
    settings = [
        *(cv2.IMWRITE_JPEG_QUALITY, quality),
        *(cv2.IMWRITE_JPEG_PROGRESSIVE, 1),
        *(cv2.IMWRITE_JPEG_OPTIMIZE, 1),
    ]
    encoded = {}
    for width_px in widths_px:
        sized = smooth
        if width_px < full_px:
            size = (width_px, max(1, round(height * width_px / full_px)))
            sized = cv2.resize(smooth, size, interpolation=cv2.INTER_AREA)
        _, jpeg = cv2.imencode(".jpg", sized, settings)
        encoded[width_px] = np.asarray(jpeg, dtype=np.uint8).reshape(-1)
    return encoded


class TopView:
    """Warps and packs pictures of one camera."""

    def __init__(self, calibration: Calibration, arena: Bounds, width_px: int, quality: int):
        rim = RIM * max(arena.width, arena.height)
        self.arena = arena
        self.window = Bounds(
            arena.x_min - rim, arena.y_min - rim, arena.x_max + rim, arena.y_max + rim
        )
        self.metres_per_pixel = self.window.width / width_px
        self.size_px = (width_px, max(1, round(self.window.height / self.metres_per_pixel)))
        self._calibration = calibration
        self._quality = quality
        self._maps = self._warp(calibration)

    def _warp(self, calibration: Calibration) -> tuple[NDArray[np.int16], NDArray[np.uint16]]:
        """Source of each pixel of the view, in OpenCV's fixed-point form."""
        width, height = self.size_px
        x = self.window.x_min + (np.arange(width) + 0.5) * self.metres_per_pixel
        y = self.window.y_max - (np.arange(height) + 0.5) * self.metres_per_pixel
        floor = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        seen = np.nan_to_num(calibration.image_from_arena(floor), nan=OUT_OF_SIGHT_PX)
        source = seen.astype(np.float32).reshape(height, width, 2)
        whole, part = cv2.convertMaps(source[..., 0], source[..., 1], cv2.CV_16SC2)
        return np.asarray(whole, dtype=np.int16), np.asarray(part, dtype=np.uint16)

    def seen_m(self, pose: RobotPose) -> tuple[float, float]:
        """Place of a robot's marker in the view: it leans outwards, having a height."""
        corner_mean = pose.corners_px.mean(axis=0, keepdims=True)
        ((x, y),) = self._calibration.arena_from_image(corner_mean).tolist()
        return x, y

    def jpegs(self, frame: Frame, widths_px: Iterable[int]) -> dict[int, NDArray[np.uint8]]:
        """Encoded view of a frame by width; floor out of the camera's sight is mid-grey."""
        image = np.asarray(frame.image)
        if frame.size != self._calibration.size:
            image = np.asarray(cv2.resize(image, self._calibration.size), dtype=np.uint8)
        view = cv2.remap(image, *self._maps, cv2.INTER_LINEAR, borderValue=(128, 128, 128))
        return encode_widths(np.asarray(view, dtype=np.uint8), widths_px, self._quality)
