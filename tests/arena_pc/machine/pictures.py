"""What a test's camera shows: a disc that moves, in the format that the camera was asked for."""

from __future__ import annotations

import cv2
import numpy as np

from tests.arena_pc.machine.uvc_descriptors import PictureFormat, PictureSize

RAW_IS_SLOW = (
    PictureFormat("YUYV", (PictureSize(640, 480, (5.0,)),)),
    PictureFormat("MJPG", (PictureSize(640, 480, (10.0, 5.0)),)),
)
"""As many webcams are, with a third of their rates: the machine is emulated."""


def moving_disc(fourcc: str, width: int, height: int, number: int) -> bytes:
    """A picture's bytes."""
    grey = np.full((height, width), 200, np.uint8)
    cv2.circle(grey, (20 * number % width, height // 2), height // 10, 40, -1)
    if fourcc == "MJPG":
        return cv2.imencode(".jpg", cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR))[1].tobytes()
    pixels = np.full((height, width, 2), 128, np.uint8)
    pixels[..., 0] = grey
    return pixels.tobytes()
