r"""Pictures of a calibration board under the simulated camera, like a person's.

A ChArUco board is held over the arena at several heights and tilts, then laid on the floor. Finally
twelve discs lie on surveyed places, and their centres are measured. `clearway calibrate` estimates
the camera from this, so a simulated run need not know the truth:

python -m navigation.simulator.picture.boards configs/simulation.yaml FOLDER
    clearway calibrate FOLDER/board_*.png --squares 8x6 --square-mm 100 --marker-mm 75 \
        --dictionary DICT_5X5_100 --points FOLDER/survey.csv -o configs/simulation_calibration.yaml
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
from navigation.simulator.picture.drawing import (
    Appearance,
    ArenaPainter,
    FloatImage,
    blurred,
    box_around,
    looked_up,
)
from navigation.simulator.picture.pinhole import Pinhole, pinhole_of
from planner.scene import Bounds, CircleRecord, FloatArray, Scene, SceneObject
from vision.camera.camera import Image
from vision.markers.marker_search import dictionary_by_name

TEXELS_PER_SQUARE = 200
BOARD_SAMPLES = 4
PAPER_WHITE, PAPER_BLACK = 225.0, 30.0


@dataclass(frozen=True, slots=True)
class PrintedBoard:
    """A ChArUco board: squares across and down, their side and the markers', the family.

    A chessboard if ``dictionary`` is empty.
    """

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
        """OpenCV's object for a ChArUco board."""
        dictionary = dictionary_by_name(self.dictionary)
        shape = (self.columns, self.rows)
        return cv2.aruco.CharucoBoard(shape, self.square_m, self.marker_m, dictionary)

    def sheet(self, size_px: tuple[int, int]) -> Image:
        """Return the print (height, width), black on white; ``size_px`` is width and height."""
        if self.dictionary:
            return np.asarray(self.opencv().generateImage(size_px), dtype=np.uint8)
        dark = np.add.outer(np.arange(self.rows), np.arange(self.columns)) % 2 == 0
        cells = np.where(dark, 0, 255).astype(np.uint8)
        return np.asarray(cv2.resize(cells, size_px, interpolation=cv2.INTER_NEAREST), np.uint8)


@dataclass(frozen=True, slots=True)
class BoardPose:
    """Pose of the sheet: its lower left corner, (3,) metres, and its rotation.

    ``arena_from_board`` (3, 3): x axis along the printed rows, y up the print, z towards the
    camera.
    """

    arena_from_board: FloatArray
    origin_m: FloatArray


class BoardPainter:
    """Painter of a board anywhere over the arena."""

    def __init__(
        self, pinhole: Pinhole, look: Appearance, board: PrintedBoard, scene: Scene
    ) -> None:
        self._pinhole, self._look, self._board = pinhole, look, board
        self._painter = ArenaPainter(pinhole, look)
        self._background = self._painter.picture(scene)
        size = (board.columns * TEXELS_PER_SQUARE, board.rows * TEXELS_PER_SQUARE)
        print_ = board.sheet(size)
        grey = np.where(print_ > 127, PAPER_WHITE, PAPER_BLACK).astype(np.uint8)
        self._texture = np.dstack([grey, np.full_like(grey, 255)])

    def picture(self, pose: BoardPose, rng: np.random.Generator) -> Image:
        """Return the picture (h, w) of the board at a pose, with noise."""
        picture = self.clean(pose)
        noise = rng.normal(0.0, self._look.noise_grey, picture.shape)
        return np.asarray(np.clip(np.rint(picture + noise), 0, 255).astype(np.uint8))

    def clean(self, pose: BoardPose, samples: int = BOARD_SAMPLES) -> FloatImage:
        """Return it without noise, in grey levels; ``samples`` a pixel and side."""
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
                samples,
            )
            grey, covered = cv2.split(blurred(seen, self._look.blur_px))
            lit = grey * self._painter.light[here]
            picture[here] = picture[here] * (1.0 - covered) + lit
        return picture

    def is_in_picture(self, pose: BoardPose) -> bool:
        """True if the whole board is visible."""
        corners = self._corners_px(pose)
        return bool((corners > 0).all() and (corners < np.array(self._pinhole.size_px) - 1).all())

    def _corners_px(self, pose: BoardPose) -> FloatArray:
        width, height = self._board.size_m
        corners = np.array([[0, 0, 0], [width, 0, 0], [width, height, 0], [0, height, 0]])
        return self._pinhole.image_from_arena(corners @ pose.arena_from_board.T + pose.origin_m)


def flat_pose(x_m: float, y_m: float) -> BoardPose:
    """Pose on the floor, the print upright, its lower left corner at (x, y)."""
    return BoardPose(np.eye(3), np.array([x_m, y_m, 0.0]))


def held_poses(
    painter: BoardPainter, bounds: Bounds, board: PrintedBoard, count: int
) -> Iterator[BoardPose]:
    """Yield poses of a board over the arena, throughout the picture and in all tilts."""
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


def board_pictures(
    config: Config, board: PrintedBoard, count: int = 24
) -> Iterator[tuple[str, Image]]:
    """Yield names and pictures: ``count`` of the held board, one with it on the floor."""
    painter, bounds, rng = _painter(config, board, Scene("m", Bounds(*config.arena.bounds_m), ()))
    for index, pose in enumerate(held_poses(painter, bounds, board, count)):
        yield f"board_{index:02d}.png", painter.picture(pose, rng)
    yield "floor.png", painter.picture(flat_pose(*FLOOR_AT_M), rng)


def survey_picture(config: Config, board: PrintedBoard) -> tuple[Image, FloatArray]:
    """Return a picture of discs on the floor, and their centres' surveyed places (n, 2).

    Places are row by row from the lower left.
    """
    bounds = Bounds(*config.arena.bounds_m)
    columns = np.linspace(bounds.x_min, bounds.x_max, SURVEY_GRID[0] + 2)[1:-1]
    rows = np.linspace(bounds.y_min, bounds.y_max, SURVEY_GRID[1] + 2)[1:-1]
    columns += (columns - columns.mean()) * SURVEY_SPREAD
    rows += (rows - rows.mean()) * SURVEY_SPREAD
    places = np.array([(x, y) for y in rows for x in columns])
    discs = tuple(
        SceneObject(number, (CircleRecord((x, y), SURVEY_DISC_M),))
        for number, (x, y) in enumerate(places.tolist())
    )
    painter, _, rng = _painter(config, board, Scene("m", bounds, discs))
    return painter.picture(flat_pose(99.0, 99.0), rng), places


def measured_discs(picture: Image) -> FloatArray:
    """Measure the discs' centres (n, 2) in pixels, row by row from the lower left.

    The centroid of a disc's darkness uses all grey values, so it is far finer than a pixel.
    """
    count, _, boxes, _ = cv2.connectedComponentsWithStats((picture < 125).astype(np.uint8))
    centres = []
    for number in range(1, count):
        x, y, width, height, _ = (int(v) for v in boxes[number])
        window = picture[y - 4 : y + height + 4, x - 4 : x + width + 4].astype(np.float64)
        floor = float(np.median(np.concatenate([window[0], window[-1], window[:, 0]])))
        dark = np.where(window < 0.9 * floor, floor - window, 0.0)
        down, right = np.indices(dark.shape)
        weight = dark.sum()
        centres.append(
            (x - 4 + (dark * right).sum() / weight, y - 4 + (dark * down).sum() / weight)
        )
    across = SURVEY_GRID[0]
    upwards = sorted(centres, key=lambda centre: -centre[1])
    lines = [sorted(upwards[i : i + across]) for i in range(0, len(upwards), across)]
    return np.array([centre for line in lines for centre in line])


def _painter(
    config: Config, board: PrintedBoard, scene: Scene
) -> tuple[BoardPainter, Bounds, np.random.Generator]:
    assert config.simulation is not None
    lens = config.simulation.camera
    look = Appearance(lens.blur_px, lens.noise_grey, lens.light_fall)
    painter = BoardPainter(pinhole_of(config), look, board, scene)
    return painter, scene.bounds, np.random.default_rng(config.simulation.seed)


FLOOR_AT_M = (0.8, 0.6)
"""Place of the board's lower left corner in the picture of the floor."""
SURVEY_GRID = (4, 3)
"""Surveyed places across and up."""
SURVEY_SPREAD = 0.55
"""Share by which they are spread further than evenly towards the walls."""
SURVEY_DISC_M = 0.02


def main() -> None:
    """Write the pictures and the survey."""
    config, folder = load_config(sys.argv[1]), Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    for name, picture in board_pictures(config, PrintedBoard()):
        cv2.imwrite(str(folder / name), picture)
    picture, places = survey_picture(config, PrintedBoard())
    cv2.imwrite(str(folder / "survey.png"), picture)
    lines = [
        f"{px:.3f},{py:.3f},{x:.4f},{y:.4f}"
        for (px, py), (x, y) in zip(measured_discs(picture), places, strict=True)
    ]
    (folder / "survey.csv").write_text("\n".join(lines) + "\n")
    print(f"wrote the pictures and survey.csv into {folder}")


if __name__ == "__main__":
    main()
