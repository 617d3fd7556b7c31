"""Calibration pictures: OpenCV finds the board's corners where geometry says they are."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from benchmarks.camera.calibration_pictures import (
    BOARD,
    Stage,
    board_pictures,
    flat_pose,
    held_poses,
    measured_discs,
    survey_picture,
)
from navigation.config import Config, load_config
from navigation.simulator.picture.boards import BoardPose, printed
from navigation.simulator.picture.pinhole import pinhole_of
from planner.scene import Bounds, FloatArray, Scene
from vision.camera.camera import Image
from vision.markers.marker_search import MarkerError

BOUNDS = Bounds(0.0, 0.0, 2.4, 1.8)


@pytest.fixture(scope="module")
def config() -> Config:
    return load_config("configs/simulation.yaml", {})


@pytest.fixture(scope="module")
def stage(config: Config) -> Stage:
    return Stage(config, BOARD, Scene("m", BOUNDS, ()))


def _found(picture: Image) -> tuple[FloatArray, FloatArray]:
    """The inner corners' places on the board (n, 2), y up the print, and in the picture."""
    detector = cv2.aruco.CharucoDetector(BOARD.charuco())
    corners, ids, _, _ = detector.detectBoard(picture)
    assert ids is not None
    across = BOARD.columns - 1
    numbers = np.array(ids).ravel()
    column, row = numbers % across + 1, numbers // across + 1
    on_board = BOARD.square_m * np.column_stack([column, BOARD.rows - row])
    return on_board, np.array(corners, dtype=np.float64).reshape(-1, 2)


def _errors_px(config: Config, pose: BoardPose, picture: Image) -> FloatArray:
    on_board, seen = _found(picture)
    in_space = np.column_stack([on_board, np.zeros(len(on_board))]) @ pose.arena_from_board.T
    assert len(seen) == (BOARD.columns - 1) * (BOARD.rows - 1)
    return seen - pinhole_of(config).image_from_arena(in_space + pose.origin_m)


def test_a_board_on_the_floor_is_where_it_was_laid(config: Config, stage: Stage) -> None:
    pose = flat_pose(0.8, 0.6)
    errors = _errors_px(config, pose, stage.picture(pose))
    assert np.sqrt((errors**2).mean()) < 0.1
    assert np.abs(errors.mean(axis=0)).max() < 0.05


def test_held_boards_are_seen_where_they_are_held(config: Config, stage: Stage) -> None:
    for pose in held_poses(stage, BOUNDS, BOARD, 4):
        errors = _errors_px(config, pose, stage.picture(pose))
        assert np.sqrt((errors**2).mean()) < 0.15
        assert np.abs(errors.mean(axis=0)).max() < 0.08


def test_held_boards_are_tilted_and_all_over_the_picture(stage: Stage) -> None:
    poses = list(held_poses(stage, BOUNDS, BOARD, 24))
    tilts = [np.degrees(np.arccos(pose.arena_from_board[2, 2])) for pose in poses]
    middles = np.array([pose.origin_m + pose.arena_from_board @ [0.4, 0.3, 0.0] for pose in poses])
    assert min(tilts) > 10
    assert max(tilts) < 45
    assert (np.ptp(middles, axis=0) > (0.8, 0.5, 0.5)).all()


def test_the_last_picture_is_the_board_on_the_floor(config: Config) -> None:
    pictures = list(board_pictures(config, BOARD, count=2))
    assert [name for name, _ in pictures] == ["board_00.png", "board_01.png", "floor.png"]
    errors = _errors_px(config, flat_pose(0.8, 0.6), pictures[-1][1])
    assert np.abs(errors).max() < 0.5


def test_discs_on_surveyed_places_are_measured_to_a_fraction_of_a_pixel(config: Config) -> None:
    picture, places = survey_picture(config, BOARD)
    errors = measured_discs(picture) - pinhole_of(config).image_from_arena(places)
    assert errors.shape == (12, 2)
    assert np.abs(errors).max() < 0.1
    assert np.ptp(places, axis=0) == pytest.approx([2.232, 1.395])


def test_a_dictionary_goes_by_any_of_its_names_and_an_unknown_one_is_said() -> None:
    long, short = (printed(replace(BOARD, dictionary=name)) for name in ("DICT_5X5_100", "5x5_100"))
    assert (long == short).all()
    with pytest.raises(MarkerError, match="marker dictionary 'DICT_5X5' is unknown; did you mean"):
        replace(BOARD, dictionary="DICT_5X5").charuco()
