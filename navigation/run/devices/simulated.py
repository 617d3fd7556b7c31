"""The simulated robot of a configuration, and its pose for the simulated camera."""

from __future__ import annotations

import random
from collections.abc import Callable

import numpy as np

from navigation.config import Config
from navigation.config.known_robots import CLEARWAY
from navigation.simulator.picture.camera import SimulatedCamera
from navigation.simulator.robot import SimulatedRobot
from navigation.simulator.settings import (
    drive_model_of,
    drive_settings_of,
    faults_of,
    true_start_of,
)
from navigation.simulator.shared_pose import PoseFileError, PoseReader
from navigation.simulator.twins.clearway import ClearwayTwin
from navigation.simulator.twins.kinds import TWINS
from navigation.simulator.twins.twin import Twin
from vision.camera.camera import CameraError


def simulated_robot(config: Config, clock: Callable[[], float]) -> SimulatedRobot:
    """Make the robot behind a new pseudo-terminal, switched off."""
    simulation = config.simulation
    return SimulatedRobot(
        true_start_of(config),
        twin=_twin_of(config),
        rng=np.random.default_rng(0 if simulation is None else simulation.seed),
        model=drive_model_of(config),
        faults=faults_of(config),
        baud=config.serial.baud,
        clock=clock,
    )


def _twin_of(config: Config) -> Twin:
    if config.robot.driver != CLEARWAY:
        return TWINS[config.robot.driver]()
    seed = 0 if config.simulation is None else config.simulation.seed
    settings, model = drive_settings_of(config), drive_model_of(config)
    return ClearwayTwin(settings, model=model, boot_ids=random.Random(seed))


def shared_pose(config: Config) -> PoseReader | None:
    """Open the file with the pose of another process's robot; None without one."""
    path = None if config.simulation is None else config.simulation.robot.poses
    return None if path is None else PoseReader(path)


def pose_of(
    config: Config, robot: SimulatedRobot | None, shared: PoseReader | None, at_s: float
) -> tuple[float, float, float]:
    """Pose of the robot, as the simulated camera sees it; its start if unknown.

    ``at_s`` is the moment of the clock: another process's robot has only its present pose.
    """
    if robot is not None:
        return robot.pose_at(at_s)
    if shared is not None:
        try:
            return shared.read()
        except PoseFileError as error:
            raise CameraError(f"{SimulatedCamera.name}: {error}") from None
    return true_start_of(config)
