"""The simulated fisheye against OpenCV's and against vision's, and its dark rim."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from navigation.config import Config, ConfigError, load_config
from navigation.simulator.picture.drawing import ArenaPainter
from navigation.simulator.picture.pinhole import Pinhole, pinhole_of
from planner.scene import Bounds, CircleRecord, Scene, SceneObject
from tests.navigation.simulator.drawn import PLAIN

FOUR = [-0.04, 0.012, -0.006, 0.001]


def configured(folder: Path, **camera: object) -> Config:
    settings = yaml.safe_load(Path("configs/simulation.yaml").read_text())
    del settings["camera"]["calibration"]
    settings["simulation"]["arena"] = str(Path("configs/arenas/laboratory.txt").resolve())
    settings["simulation"]["camera"].update(
        {"lens_model": "fisheye", "distortion": FOUR, "focal_px": 330, **camera}
    )
    file = folder / "fisheye.yaml"
    file.write_text(yaml.safe_dump(settings))
    return load_config(file, {})


@pytest.fixture
def fisheye(tmp_path: Path) -> Pinhole:
    return pinhole_of(configured(tmp_path, position_m=[1.155, 0.975, 1.0]))


def test_its_projection_is_opencv_s_and_vision_s(fisheye: Pinhole) -> None:
    places = np.random.default_rng(0).uniform((-3.0, -3.0), (5.0, 5.0), (300, 2))
    turn, _ = cv2.Rodrigues(np.array(fisheye.camera_from_arena))
    shift = -fisheye.camera_from_arena @ fisheye.position_m
    space = np.column_stack([places, np.zeros(300)]).reshape(-1, 1, 3)
    seen, _ = cv2.fisheye.projectPoints(space, turn, shift, fisheye.matrix, np.array(FOUR))
    assert np.abs(fisheye.image_from_arena(places) - seen.reshape(-1, 2)).max() < 1e-8
    calibration = fisheye.calibration()
    assert np.abs(calibration.image_from_arena(places) - seen.reshape(-1, 2)).max() < 1e-8
    assert np.abs(fisheye.arena_from_image(seen.reshape(-1, 2)) - places).max() < 1e-6


def test_outside_the_circle_that_it_shows_the_picture_is_dark(fisheye: Pinhole) -> None:
    painter = ArenaPainter(fisheye, PLAIN)
    disc = SceneObject(0, (CircleRecord((1.2, 0.9), 0.2),))
    picture = painter.picture(Scene("m", Bounds(0, 0, 2.4, 1.8), (disc,)))
    rays = fisheye.rays(np.array([(640.0, 480.0), (2.0, 2.0), (1277.0, 957.0)]))
    assert np.isnan(rays[1:]).all()
    assert picture[2, 2] == picture[957, 1277] == 0
    x, y = np.rint(fisheye.image_from_arena([[1.2, 0.9]])[0]).astype(int)
    assert picture[y, x] < 60 < picture[y, x + 200]


@pytest.mark.parametrize(
    ("terms", "said"),
    [([0.0] * 5, "5 numbers: must be 4, as lens_model is fisheye"), ([], "0 numbers: must be 4")],
)
def test_a_wrong_number_of_terms_is_named(tmp_path: Path, terms: list[float], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        configured(tmp_path, distortion=terms)
