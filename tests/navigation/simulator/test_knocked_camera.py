"""A simulated camera that is knocked: one after the other, with numbers and times that go on."""

from __future__ import annotations

import numpy as np
import pytest

from navigation.config import Config
from navigation.run.simulated_camera import camera_over
from navigation.simulator.arena import SimulatedArena
from navigation.simulator.picture.camera import SimulatedCamera
from navigation.simulator.picture.knocked_camera import KnockedCamera
from navigation.simulator.picture.pinhole import pinhole_of
from tests.navigation.simulator.drawn import Clock
from vision.camera.camera import Camera, Frame
from vision.markers.marker_search import find_markers

POSE = (0.2, 0.2, 0.0)
PLACE = (1.9, 0.9)


def knocked(config: Config, *knocks: dict[str, object]) -> Config:
    values = config.model_dump()
    values["simulation"]["camera"]["knocks"] = knocks
    values["arena"]["floor_markers"] = [{"marker_id": 20, "size_m": 0.1, "place_m": PLACE}]
    return Config.model_validate(values)


def over(config: Config, arena: SimulatedArena, clock: Clock) -> Camera:
    return camera_over(
        config, [(0.0, arena)], {}, [(config.robot, lambda _at_s: POSE)], clock, clock(), clock.wait
    )


def floor_marker(frame: Frame) -> np.ndarray:
    """Its middle in pixels."""
    return {i: quad.mean(axis=0) for i, quad in find_markers(frame.image, "DICT_4X4_50")}[20]


def test_each_picture_is_of_the_camera_as_it_hangs_then(
    config: Config, arena: SimulatedArena
) -> None:
    changed = knocked(
        config,
        {"from_s": 0.3, "tilt_deg": (1.0, 0.0), "until_s": 0.5},
        {"from_s": 0.7, "shift_m": (0.0, 0.1, 0.0), "turn_deg": 2.0},
    )
    clock = Clock()
    camera, began_s = over(changed, arena, clock), clock()
    assert isinstance(camera, KnockedCamera)
    camera.open()
    frames = [frame for _ in range(30) if (frame := camera.read(1.0)) is not None]
    camera.close()
    assert [frame.sequence for frame in frames] == list(range(30))
    times = np.array([frame.captured_s for frame in frames]) - began_s
    assert np.diff(times).min() > 0.0
    assert changed.simulation is not None
    first, second = changed.simulation.camera.knocks
    for at_s, knock in ((0.1, None), (0.4, first), (0.6, None), (0.9, second)):
        frame = frames[int(np.abs(times - at_s).argmin())]
        wanted = pinhole_of(changed, knock).image_from_arena(np.array([PLACE]))[0]
        assert floor_marker(frame) == pytest.approx(wanted, abs=0.7)


def test_without_knocks_it_is_the_plain_camera(config: Config, arena: SimulatedArena) -> None:
    assert isinstance(over(knocked(config), arena, Clock()), SimulatedCamera)
