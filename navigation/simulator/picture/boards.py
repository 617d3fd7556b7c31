"""Pictures of a calibration board anywhere under the simulated camera."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from navigation.simulator.picture.drawing import (
    Appearance,
    ArenaPainter,
    FloatImage,
    blurred,
    box_around,
    looked_up,
)
from navigation.simulator.picture.pinhole import Pinhole
from planner.scene import FloatArray, Scene
from vision.calibrate.board import BoardSpec
from vision.camera.camera import Image

TEXELS_PER_SQUARE = 200
BOARD_SAMPLES = 4
PAPER_WHITE, PAPER_BLACK = 225.0, 30.0


@dataclass(frozen=True, slots=True)
class BoardPose:
    """Pose of the sheet: its lower left corner, (3,) metres, and its rotation.

    ``arena_from_board`` (3, 3): x axis along the printed rows, y up the print, z towards the
    camera.
    """

    arena_from_board: FloatArray
    origin_m: FloatArray


def printed(board: BoardSpec) -> Image:
    """Return the print (height, width), black on white, of the squares alone."""
    columns, rows = board.inner
    size_px = ((columns + 1) * TEXELS_PER_SQUARE, (rows + 1) * TEXELS_PER_SQUARE)
    if board.kind == "charuco":
        return np.asarray(board.charuco().generateImage(size_px), dtype=np.uint8)
    dark = np.add.outer(np.arange(rows + 1), np.arange(columns + 1)) % 2 == 0
    cells = np.where(dark, 0, 255).astype(np.uint8)
    return np.asarray(cv2.resize(cells, size_px, interpolation=cv2.INTER_NEAREST), np.uint8)


class BoardPainter:
    """Painter of a board anywhere over the arena."""

    def __init__(self, pinhole: Pinhole, look: Appearance, board: BoardSpec, scene: Scene) -> None:
        self._pinhole, self._look, self._board = pinhole, look, board
        self._painter = ArenaPainter(pinhole, look)
        self._background = self._painter.picture(scene)
        grey = np.where(printed(board) > 127, PAPER_WHITE, PAPER_BLACK).astype(np.uint8)
        self._texture = np.dstack([grey, np.full_like(grey, 255)])

    def clean(self, pose: BoardPose, samples: int = BOARD_SAMPLES) -> FloatImage:
        """Return it without noise, in grey levels; ``samples`` a pixel and side."""
        picture = self._background.astype(np.float32)
        box = box_around(self.corners_px(pose), picture.shape)
        if box is not None:
            x0, y0, x1, y1 = box
            here = np.s_[y0:y1, x0:x1]
            scale, height_m = TEXELS_PER_SQUARE / self._board.square_m, self._board.size_m[1]
            texture_from_board = np.array(
                [[scale, 0.0, -0.5], [0.0, -scale, height_m * scale - 0.5], [0.0, 0.0, 1.0]]
            )
            board_from_ray = self._pinhole.sheet_from_ray(pose.arena_from_board, pose.origin_m)
            seen = looked_up(
                self._texture,
                self._painter.rays[here],
                texture_from_board @ board_from_ray,
                samples,
            )
            grey, covered = cv2.split(blurred(seen, self._look.blur_px))
            lit = grey * self._painter.light[here]
            picture[here] = picture[here] * (1.0 - covered) + lit
        return picture

    def corners_px(self, pose: BoardPose) -> FloatArray:
        """Corners (4, 2) of the board in the picture."""
        width, height = self._board.size_m
        corners = np.array([[0, 0, 0], [width, 0, 0], [width, height, 0], [0, height, 0]])
        return self._pinhole.image_from_arena(corners @ pose.arena_from_board.T + pose.origin_m)
