"""Pictures of a calibration board under the simulated camera, as a person would take them.

The board is a ChArUco board on a stiff sheet, held over the arena at several heights and
tilts, and at last laid on the floor at a known place. `clearway calibrate` estimates the
camera from these pictures, so that a simulated run need not be told the truth.

    python -m navigation.simulator.boards configs/simulation.yaml FOLDER

writes `board_00.png` ... and, as the last, `floor.png`.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from navigation.config import Config, load_config
from navigation.simulator.drawing import ArenaPainter, Look, blurred, box_around, looked_up
from navigation.simulator.pinhole import Pinhole, pinhole_of
from planner.scene import Bounds, FloatArray, Scene
from vision.camera import Image

TEXELS_PER_SQUARE = 200
BOARD_SAMPLES = 4
PAPER_WHITE, PAPER_BLACK = 225.0, 30.0


@dataclass(frozen=True, slots=True)
class Board:
    """A ChArUco board: squares across and down, their side and the markers', the family."""

    columns: int = 8
    rows: int = 6
    square_m: float = 0.1
    marker_m: float = 0.075
    dictionary: str = "DICT_5X5_100"

    @property
    def size_m(self) -> tuple[float, float]:
        """Width and height of the sheet."""
        return self.columns * self.square_m, self.rows * self.square_m

    def opencv(self) -> cv2.aruco.CharucoBoard:
        """The same for OpenCV."""
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, self.dictionary))
        shape = (self.columns, self.rows)
        return cv2.aruco.CharucoBoard(shape, self.square_m, self.marker_m, dictionary)


@dataclass(frozen=True, slots=True)
class BoardPose:
    """Where the sheet's lower left corner is, (3,) metres, and how the sheet is turned.

    ``arena_from_board`` (3, 3): its x axis along the printed rows, y up the print, z towards
    the camera.
    """

    arena_from_board: FloatArray
    origin_m: FloatArray


class BoardPainter:
    """Draws a board anywhere over the arena."""

    def __init__(self, pinhole: Pinhole, look: Look, board: Board, scene: Scene) -> None:
        self._pinhole, self._look, self._board = pinhole, look, board
        self._painter = ArenaPainter(pinhole, look)
        self._background = self._painter.picture(scene)
        size = (board.columns * TEXELS_PER_SQUARE, board.rows * TEXELS_PER_SQUARE)
        print_ = board.opencv().generateImage(size)
        grey = np.where(print_ > 127, PAPER_WHITE, PAPER_BLACK).astype(np.uint8)
        self._texture = np.dstack([grey, np.full_like(grey, 255)])

    def picture(self, pose: BoardPose, rng: np.random.Generator) -> Image:
        """The picture (h, w) of the board at a pose, with noise."""
        picture = self._background.astype(np.float32)
        box = box_around(self._corners_px(pose), picture.shape)
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
                BOARD_SAMPLES,
            )
            grey, covered = cv2.split(blurred(seen, self._look.blur_px))
            lit = grey * self._painter.light[here]
            picture[here] = picture[here] * (1.0 - covered) + lit
        noise = rng.normal(0.0, self._look.noise_grey, picture.shape)
        return np.asarray(np.clip(np.rint(picture + noise), 0, 255).astype(np.uint8))

    def is_in_picture(self, pose: BoardPose) -> bool:
        """Whether the whole board is seen."""
        corners = self._corners_px(pose)
        return bool((corners > 0).all() and (corners < np.array(self._pinhole.size_px) - 1).all())

    def _corners_px(self, pose: BoardPose) -> FloatArray:
        width, height = self._board.size_m
        corners = np.array([[0, 0, 0], [width, 0, 0], [width, height, 0], [0, height, 0]])
        return self._pinhole.image_from_arena(corners @ pose.arena_from_board.T + pose.origin_m)


def flat_pose(x_m: float, y_m: float) -> BoardPose:
    """On the floor, the print upright, its lower left corner at (x, y)."""
    return BoardPose(np.eye(3), np.array([x_m, y_m, 0.0]))


def held_poses(
    painter: BoardPainter, bounds: Bounds, board: Board, count: int
) -> Iterator[BoardPose]:
    """Poses of a board held over the arena: everywhere in the picture, tilted every way."""
    width, height = board.size_m
    rng = np.random.default_rng(count)
    found = 0
    while found < count:
        centre = rng.uniform((bounds.x_min, bounds.y_min, 0.2), (bounds.x_max, bounds.y_max, 1.1))
        tilt_rad, towards_rad, turn_rad = rng.uniform((0.2, 0.0, -0.5), (0.75, math.tau, 0.5))
        axis = tilt_rad * np.array([math.cos(towards_rad), math.sin(towards_rad), 0.0])
        tilted, _ = cv2.Rodrigues(axis)
        turned, _ = cv2.Rodrigues(np.array([0.0, 0.0, turn_rad]))
        rotation = np.asarray(tilted @ turned, dtype=np.float64)
        pose = BoardPose(rotation, centre - rotation @ np.array([width / 2, height / 2, 0.0]))
        if painter.is_in_picture(pose):
            found += 1
            yield pose


def board_pictures(config: Config, board: Board, count: int = 24) -> Iterator[tuple[str, Image]]:
    """Names and pictures: ``count`` of the board in the hand, and the one on the floor.

    On the floor its lower left corner lies on the arena's (0.8, 0.6).
    """
    assert config.simulation is not None
    lens = config.simulation.camera
    look = Look(lens.blur_px, lens.noise_grey, lens.light_fall, config.vision.polarity)
    bounds = Bounds(*config.arena.bounds_m)
    painter = BoardPainter(pinhole_of(config), look, board, Scene("m", bounds, ()))
    rng = np.random.default_rng(config.simulation.seed)
    for index, pose in enumerate(held_poses(painter, bounds, board, count)):
        yield f"board_{index:02d}.png", painter.picture(pose, rng)
    yield "floor.png", painter.picture(flat_pose(*FLOOR_AT_M), rng)


FLOOR_AT_M = (0.8, 0.6)
"""Where the board's lower left corner lies in the last picture."""


def main() -> None:
    """Write the pictures; see the module's text."""
    config_file, folder = Path(sys.argv[1]), Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    for name, picture in board_pictures(load_config(config_file), Board()):
        cv2.imwrite(str(folder / name), picture)
        print(folder / name)


if __name__ == "__main__":
    main()
