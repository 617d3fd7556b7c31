"""What a run is connected to: a camera, a serial port, and, where simulated, the truth.

The rest of the program gets a camera and a port and cannot tell which they are; only the
report asks for the truth. Units: metres, radians, seconds.
"""

from __future__ import annotations

import random
import shlex
import time
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType

import numpy as np

from navigation.config import Config
from navigation.config_sections import SIMULATED
from navigation.simulator.arena import SimulatedArena, load_arena
from navigation.simulator.camera import make_camera
from navigation.simulator.emulated_robot import EmulatedRobot
from navigation.simulator.pinhole import pinhole_of
from navigation.simulator.robot import SimulatedRobot
from navigation.simulator.settings import (
    drive_model_of,
    drive_settings_of,
    faults_of,
    true_start_of,
)
from planner.scene import FloatArray
from vision.calibration import Calibration
from vision.calibration_file import load_calibration
from vision.camera import Camera
from vision.sources import camera_for

Clock = Callable[[], float]


@dataclass(frozen=True, slots=True)
class Truth:
    """What only a simulation can know."""

    arena: SimulatedArena
    robot: SimulatedRobot | EmulatedRobot

    def track(self) -> FloatArray:
        """Where the robot really was: (n, 4) of the clock's seconds, x_m, y_m, heading_rad."""
        return self.robot.track()


class World:
    """Opens what the configuration names; a context manager that switches the robot on and off."""

    def __init__(self, config: Config, clock: Clock = time.monotonic) -> None:
        self.config = config
        self._clock = clock
        self.truth: Truth | None = None
        simulated_port = config.serial.port == SIMULATED
        simulated_camera = config.camera.source == SIMULATED
        if simulated_port:
            self.truth = Truth(load_arena(config), self._make_robot())
        self._arena = self.truth.arena if self.truth else None
        if simulated_camera and self._arena is None:
            self._arena = load_arena(config)
        self.port = self.truth.robot.port if self.truth else config.serial.port
        self.calibration = self._calibrate()

    def _make_robot(self) -> SimulatedRobot | EmulatedRobot:
        simulation = self.config.simulation
        seed = 0 if simulation is None else simulation.seed
        if simulation is not None and simulation.robot.emulator:
            return EmulatedRobot(
                shlex.split(simulation.robot.emulator),
                true_start_of(self.config),
                rng=np.random.default_rng(seed),
                model=drive_model_of(self.config),
                faults=faults_of(self.config),
                clock=self._clock,
            )
        return SimulatedRobot(
            true_start_of(self.config),
            rng=np.random.default_rng(seed),
            model=drive_model_of(self.config),
            settings=drive_settings_of(self.config),
            faults=faults_of(self.config),
            baud=self.config.serial.baud,
            boot_ids=random.Random(seed),
            clock=self._clock,
        )

    def _calibrate(self) -> Calibration:
        camera = self.config.camera
        if camera.calibration is not None:
            return load_calibration(camera.calibration)
        if camera.metres_per_pixel is not None:
            return Calibration.from_scale(camera.metres_per_pixel, camera.size_px)
        return pinhole_of(self.config).calibration()

    def open_camera(self) -> Camera:
        """A new camera, closed; the same source each time."""
        camera = self.config.camera
        if camera.source == SIMULATED:
            assert self._arena is not None
            return make_camera(self.config, self._arena, self._pose_now, self._clock)
        return camera_for(
            camera.source,
            clock=self._clock,
            rate_hz=camera.rate_hz,
            size=camera.size_px,
            loop=camera.loop,
        )

    def _pose_now(self) -> tuple[float, float, float]:
        if self.truth is not None:
            return self.truth.robot.pose()
        return true_start_of(self.config)

    def __enter__(self) -> World:
        if self.truth is not None:
            self.truth.robot.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self.truth is not None:
            self.truth.robot.stop()
