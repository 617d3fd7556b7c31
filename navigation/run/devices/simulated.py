"""The simulated robot of a configuration, and where the simulated camera sees it.

Metres, radians, seconds of the clock that is passed in.
"""

from __future__ import annotations

import random
import shlex
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from navigation.config import Config
from navigation.config.known_robots import CLEARWAY
from navigation.run.devices.driven import twin_of
from navigation.simulator.emulated_robot import EmulatedRobot
from navigation.simulator.picture.camera import SimulatedCamera
from navigation.simulator.robot import SimulatedRobot
from navigation.simulator.settings import (
    drive_model_of,
    drive_settings_of,
    faults_of,
    true_start_of,
)
from navigation.simulator.shared_pose import PoseFileError, PoseReader
from navigation.simulator.twins.twin_robot import TwinRobot
from vision.camera.camera import CameraError

AnySimulatedRobot: TypeAlias = SimulatedRobot | EmulatedRobot | TwinRobot


def simulated_robot(config: Config, clock: Callable[[], float]) -> AnySimulatedRobot:
    """The robot behind a new pseudo-terminal, switched off."""
    simulation = config.simulation
    seed = 0 if simulation is None else simulation.seed
    if simulation is not None and simulation.robot.emulator:
        return EmulatedRobot(
            shlex.split(simulation.robot.emulator),
            true_start_of(config),
            rng=np.random.default_rng(seed),
            model=drive_model_of(config),
            faults=faults_of(config),
            clock=clock,
        )
    if config.robot.driver != CLEARWAY:
        return twin_of(config, clock)
    return SimulatedRobot(
        true_start_of(config),
        rng=np.random.default_rng(seed),
        model=drive_model_of(config),
        settings=drive_settings_of(config),
        faults=faults_of(config),
        baud=config.serial.baud,
        boot_ids=random.Random(seed),
        clock=clock,
    )


def shared_pose(config: Config) -> PoseReader | None:
    """The file in which a robot of another process tells where it is; None without one."""
    path = None if config.simulation is None else config.simulation.robot.poses
    return None if path is None else PoseReader(path)


def pose_of(
    config: Config, robot: AnySimulatedRobot | None, shared: PoseReader | None
) -> tuple[float, float, float]:
    """Where the robot is, as the simulated camera sees it; its start where nobody knows."""
    if robot is not None:
        return robot.pose()
    if shared is not None:
        try:
            return shared.read()
        except PoseFileError as error:
            raise CameraError(f"{SimulatedCamera.name}: {error}") from None
    return true_start_of(config)
