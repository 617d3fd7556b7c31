"""The simulated robots of one arena and the cameras above it, in real time.

Metres, radians, seconds of the clock that is passed in.
"""

from __future__ import annotations

import threading
from functools import partial
from typing import Any

from navigation.config import Config
from navigation.config.several.each_camera import each_camera
from navigation.config.several.each_robot import robots_of
from navigation.config.values import SIMULATED
from navigation.run.devices.simulated import pose_of, shared_pose, simulated_robot
from navigation.run.devices.world_clock import CAMERA_SLACK_S, ROBOT_SLACK_S, WorldClock
from navigation.run.simulated_camera import camera_over
from navigation.simulator.arena import load_arena
from navigation.simulator.happenings import arenas_over_time, tracks_of
from navigation.simulator.picture.knocked_camera import KnockedCamera
from navigation.simulator.picture.timed_camera import TimedCamera
from navigation.simulator.robot import SimulatedRobot, wait_until_due
from planner.scene import FloatArray


def is_simulated(config: Config) -> bool:
    """True if a robot or a camera is simulated."""
    ports = [one.serial.port for one in robots_of(config).values()]
    return SIMULATED in (*(one.camera.source for one in cameras_of(config).values()), *ports)


def cameras_of(config: Config) -> dict[str | None, Config]:
    """Configuration of each camera by name; a single one has none."""
    several = each_camera(config)
    return {name: several[name] for name in several} if several else {None: config}


class Simulation:
    """Everything simulated in a configuration, switched off until `start`."""

    def __init__(self, config: Config, clock: WorldClock) -> None:
        self.clock = clock
        self._configs = robots_of(config)
        self._cameras = cameras_of(config)
        self._arenas = arenas_over_time(config, load_arena(config))
        self._tracks = tracks_of(config)
        self._thread: threading.Thread | None = None
        self._stop = threading.Event()
        self.robots: dict[str, SimulatedRobot] = {}
        try:
            for name, one in self._configs.items():
                if one.serial.port == SIMULATED:
                    self.robots[name] = simulated_robot(one, clock)
        except BaseException:
            self.stop()
            raise
        for name, robot in self.robots.items():
            clock.waits_for(f"robot {name}", robot.late_since_s, ROBOT_SLACK_S)
        self._shared = {
            name: shared_pose(one) for name, one in self._configs.items() if name not in self.robots
        }
        self._began_s = clock()

    @property
    def ports(self) -> dict[str, str]:
        """Ports of the simulated robots, by name."""
        return {name: robot.port for name, robot in self.robots.items()}

    def track(self, name: str) -> FloatArray:
        """Track of a robot: (n, 4) of the clock's seconds, x_m, y_m, heading_rad."""
        return self.robots[name].track()

    def pose(self, name: str) -> tuple[float, float, float]:
        """Present pose of a robot."""
        return self.pose_at(name, self.clock())

    def pose_at(self, name: str, at_s: float) -> tuple[float, float, float]:
        """Pose of a robot at a moment of the clock, not long ago."""
        return pose_of(self._configs[name], self.robots.get(name), self._shared.get(name), at_s)

    def open_camera(self, name: str | None = None) -> TimedCamera[Any] | KnockedCamera:
        """Make a closed camera, always of the same source."""
        camera = camera_over(
            self._cameras[name],
            self._arenas,
            self._tracks,
            [(one.robot, partial(self.pose_at, who)) for who, one in self._configs.items()],
            self.clock,
            self._began_s,
            self.clock.wait,
        )
        # replaces the last camera of this name
        self.clock.waits_for(f"camera {name}", lambda: camera.late_since_s, CAMERA_SLACK_S)
        return camera

    def start(self) -> None:
        """Switch the robots on; times in the arena count from here."""
        self._began_s = self.clock()
        for robot in self.robots.values():
            robot.switched_on()
        self._thread = threading.Thread(target=self._run, name="simulated robots", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Switch the robots off."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
        for robot in self.robots.values():
            robot.stop()

    def _run(self) -> None:
        """Step all robots in one thread: eight threads would wait for each other."""
        robots = list(self.robots.values())
        try:
            while robots and not self._stop.is_set():
                wait_until_due(robots, min(robot.turn() for robot in robots))
        finally:
            for robot in robots:
                robot.switched_off()
