"""The laboratory's configuration, arena and camera, for the tests of the simulator."""

from __future__ import annotations

import pytest

from navigation.config import Config, load_config
from navigation.simulator.arena import SimulatedArena, load_arena
from navigation.simulator.picture.camera import SimulatedCamera, make_camera
from navigation.simulator.picture.pinhole import Pinhole, pinhole_of
from tests.navigation.simulator.drawn import Clock


@pytest.fixture(scope="module")
def config() -> Config:
    return load_config("configs/simulation.yaml", {})


@pytest.fixture(scope="module")
def arena(config: Config) -> SimulatedArena:
    return load_arena(config)


@pytest.fixture(scope="module")
def pinhole(config: Config) -> Pinhole:
    return pinhole_of(config)


@pytest.fixture(scope="module")
def still(config: Config, arena: SimulatedArena) -> SimulatedCamera:
    clock = Clock()
    return make_camera(
        config, arena, [(config.robot, lambda _at_s: (0.2, 0.2, 0.0))], clock, clock.wait
    )
