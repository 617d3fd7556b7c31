"""The clock of a run in seconds: the wall's, or that of an entirely simulated world."""

from __future__ import annotations

import time
from collections.abc import Callable, MutableSequence
from typing import Final, TypeAlias

from navigation.config import Config
from navigation.config.known_robots import CLEARWAY
from navigation.config.several.each_camera import each_camera
from navigation.config.several.each_robot import robots_of
from navigation.config.values import SIMULATED
from navigation.simulator.slowing_clock import SlowingClock

ROBOT_SLACK_S: Final = 0.02
"""Longest delay of a robot's step, and of hearing what the robot says."""
CAMERA_SLACK_S: Final = 0.03
"""Longest delay of a picture's exposure, and of its arrival."""
LINK_SLACK_S: Final = 0.03
"""Longest delay of the thread that owns a robot's port."""
WAKEUP_SLACK_S: Final = 0.03
"""Longest delay in waking the measuring thread: too short for a robot to hold."""

WORTH_SAYING_S: Final = 1.0


class WallClock:
    """The wall's clock with the face of a `SlowingClock`."""

    lost_s = 0.0

    def __call__(self) -> float:
        """Now."""
        return time.monotonic()

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        time.sleep(seconds)  # the purpose of `wait`

    def waits_for(self, _name: str, _since_s: Callable[[], float], _slack_s: float) -> None:
        """Nothing to do."""

    def waits_for_this_thread(self) -> None:
        """Nothing to do."""


WorldClock: TypeAlias = SlowingClock | WallClock


def world_clock(
    config: Config, shared: MutableSequence[float] | None = None, side: int = 0
) -> WorldClock:
    """Make the clock of a world; ``shared`` with another process, as ``side``."""
    return SlowingClock(shared, side) if is_all_simulated(config) else WallClock()


def slowness(clock: WorldClock) -> tuple[str, ...]:
    """Final remarks if the simulated world fell behind the wall's clock."""
    if clock.lost_s < WORTH_SAYING_S:
        return ()
    return (
        f"this computer was busy: the simulated world was {clock.lost_s:.1f} s slower than "
        "the wall's clock",
    )


def is_all_simulated(config: Config) -> bool:
    """True if no camera or robot runs by the wall's clock, as drivers do."""
    cameras = list(each_camera(config).values()) or [config]
    return all(map(_is_simulated, robots_of(config).values())) and all(
        one.camera.source == SIMULATED for one in cameras
    )


def _is_simulated(robot: Config) -> bool:
    return robot.serial.port == SIMULATED and robot.robot.driver == CLEARWAY
