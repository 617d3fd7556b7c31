r"""Pictures from which the simulated camera is calibrated, as a person would take them.

A ChArUco board is held over the arena at several heights and tilts, then laid on the floor. Finally
twelve discs lie on surveyed places, and their centres are measured. `clearway calibrate` estimates
the camera from this, so a simulated run need not know the truth:

python -m benchmarks.camera.calibration_pictures configs/simulation.yaml FOLDER
    clearway calibrate FOLDER/board_*.png --squares 8x6 --square-mm 100 --marker-mm 75 \
        --dictionary DICT_5X5_100 --points FOLDER/survey.csv -o configs/simulation_calibration.yaml
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from navigation.config import Config, load_config
from navigation.simulator.picture.boards import BoardPainter, BoardPose
from navigation.simulator.picture.drawing import Appearance
from navigation.simulator.picture.pinhole import pinhole_of
from planner.scene import Bounds, CircleRecord, FloatArray, Scene, SceneObject
from vision.calibrate.board import BoardSpec
from vision.camera.camera import Image

BOARD = BoardSpec("charuco", 8, 6, 0.1, 0.075, "DICT_5X5_100")
FLOOR_AT_M = (0.8, 0.6)
"""Place of the board's lower left corner in the picture of the floor."""
SURVEY_GRID = (4, 3)
"""Surveyed places across and up."""
SURVEY_SPREAD = 0.55
"""Share by which they are spread further than evenly towards the walls."""
SURVEY_DISC_M = 0.02


class Stage:
    """The configuration's camera over a scene, with a board; all noise comes from its seed."""

    def __init__(self, config: Config, board: BoardSpec, scene: Scene) -> None:
        assert config.simulation is not None
        lens = config.simulation.camera
        look = Appearance(lens.blur_px, lens.noise_grey, lens.light_fall)
        self._pinhole, self._noise_grey = pinhole_of(config), lens.noise_grey
        self._painter = BoardPainter(self._pinhole, look, board, scene)
        self._rng = np.random.default_rng(config.simulation.seed)

    def picture(self, pose: BoardPose) -> Image:
        """Return the picture (h, w) of the board at a pose, with noise."""
        clean = self._painter.clean(pose)
        noise = self._rng.normal(0.0, self._noise_grey, clean.shape)
        return np.asarray(np.clip(np.rint(clean + noise), 0, 255).astype(np.uint8))

    def is_in_picture(self, pose: BoardPose) -> bool:
        """True if the whole board is visible."""
        corners = self._painter.corners_px(pose)
        return bool((corners > 0).all() and (corners < np.array(self._pinhole.size_px) - 1).all())


def flat_pose(x_m: float, y_m: float) -> BoardPose:
    """Pose on the floor, the print upright, its lower left corner at (x, y)."""
    return BoardPose(np.eye(3), np.array([x_m, y_m, 0.0]))


def held_poses(stage: Stage, bounds: Bounds, board: BoardSpec, count: int) -> Iterator[BoardPose]:
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
        if stage.is_in_picture(pose):
            found += 1
            yield pose


def board_pictures(
    config: Config, board: BoardSpec, count: int = 24
) -> Iterator[tuple[str, Image]]:
    """Yield names and pictures: ``count`` of the held board, one with it on the floor."""
    bounds = Bounds(*config.arena.bounds_m)
    stage = Stage(config, board, Scene("m", bounds, ()))
    for index, pose in enumerate(held_poses(stage, bounds, board, count)):
        yield f"board_{index:02d}.png", stage.picture(pose)
    yield "floor.png", stage.picture(flat_pose(*FLOOR_AT_M))


def survey_picture(config: Config, board: BoardSpec) -> tuple[Image, FloatArray]:
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
    stage = Stage(config, board, Scene("m", bounds, discs))
    return stage.picture(flat_pose(99.0, 99.0)), places


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


def main() -> None:
    """Write the pictures and the survey."""
    config, folder = load_config(sys.argv[1]), Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    for name, picture in board_pictures(config, BOARD):
        cv2.imwrite(str(folder / name), picture)
    picture, places = survey_picture(config, BOARD)
    cv2.imwrite(str(folder / "survey.png"), picture)
    lines = [
        f"{px:.3f},{py:.3f},{x:.4f},{y:.4f}"
        for (px, py), (x, y) in zip(measured_discs(picture), places, strict=True)
    ]
    (folder / "survey.csv").write_text("\n".join(lines) + "\n")
    print(f"wrote the pictures and survey.csv into {folder}")


if __name__ == "__main__":
    main()
