"""The camera's own picture for viewers, with the markers and borders found in it.

Nothing is warped: borders and arena are where the program believes them to be, which shows a wrong
calibration. Pixels of the largest picture sent, x right, y down, as float32. Works in any thread.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from navigation.dashboard.messages.geometry import border_lines
from navigation.dashboard.messages.packed import pack
from navigation.dashboard.messages.picture import encode_widths
from planner.roadmap.roadmap import Roadmap
from planner.scene import Bounds, Scene
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame
from vision.markers.markers import RobotPose

SIDE_POINTS = 24
"""Points to a side of the arena: the lens bends it."""


class CameraView:
    """Packs pictures of one camera; ``width_px`` is the largest width sent."""

    def __init__(self, calibration: Calibration, arena: Bounds, width_px: int, quality: int):
        self._calibration, self._quality = calibration, quality
        width, height = calibration.size
        self._scale = min(1.0, width_px / width)
        self.size_px = (round(width * self._scale), round(height * self._scale))
        corners = np.array(arena.corners())
        shares = np.arange(SIDE_POINTS)[:, None] / SIDE_POINTS
        sides = [
            a + shares * (b - a) for a, b in zip(corners, np.roll(corners, -1, 0), strict=True)
        ]
        self._arena = self._in_picture(np.concatenate(sides))
        self._known: tuple[Roadmap | None, list[NDArray[np.float32]]] = (None, [])

    def _in_picture(self, points_m: NDArray[np.float64]) -> NDArray[np.float32]:
        pixels = self._calibration.image_from_arena(np.asarray(points_m, dtype=np.float64))
        return self._scaled(pixels)

    def _scaled(self, pixels: NDArray[np.float64]) -> NDArray[np.float32]:
        return np.asarray((pixels + 0.5) * self._scale - 0.5, dtype=np.float32)

    def messages(
        self,
        frame: Frame,
        poses: Mapping[int, RobotPose],
        roadmap: Roadmap | None,
        widths_px: Iterable[int],
        fields: Mapping[str, Any],
    ) -> dict[int, bytes]:
        """Messages by width: ``jpeg``, marker ``corners`` (k x 4), ``border`` with its firsts.

        Corners and border are in pixels of ``size_px``, whatever the JPEG's width.
        """
        if self._known[0] is not roadmap:
            scene = None if roadmap is None else roadmap.scene
            borders = border_lines(scene)[0] if isinstance(scene, Scene) else []
            self._known = (roadmap, [self._in_picture(border) for border in borders])
        lines = [self._arena, *self._known[1]]
        image = np.asarray(frame.image)
        if (image.shape[1], image.shape[0]) != self.size_px:
            small = cv2.resize(image, self.size_px, interpolation=cv2.INTER_AREA)
            image = np.asarray(small, dtype=np.uint8)
        corners = [self._scaled(pose.corners_px) for pose in poses.values()]
        found: dict[str, NDArray[np.generic]] = {
            "corners": np.array(corners, dtype=np.float32).reshape(-1, 2),
            "border": np.concatenate(lines),
            "border_first": np.cumsum([0, *map(len, lines)]).astype(np.int32),
        }
        head = {**fields, "size_px": self.size_px, "ids": list(poses)}
        jpegs = encode_widths(image, widths_px, self._quality)
        return {
            width: pack("camera", head, {"jpeg": jpeg, **found}) for width, jpeg in jpegs.items()
        }
