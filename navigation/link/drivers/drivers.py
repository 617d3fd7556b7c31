"""All drivers, by the name in `robot.driver`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from navigation.link.drivers.create2 import Create2Driver
from navigation.link.drivers.epuck2 import Epuck2Driver
from navigation.link.drivers.robot_driver import RobotDriver
from navigation.link.drivers.turtlebot3 import Turtlebot3Driver
from navigation.link.drivers.waveshare import WaveshareDriver

DRIVERS: Final[Mapping[str, Callable[[], RobotDriver]]] = {
    "create2": Create2Driver,
    "turtlebot3": Turtlebot3Driver,
    "epuck2": Epuck2Driver,
    "waveshare": WaveshareDriver,
}

DRIVERS_BY_MODEL: Final[Mapping[str, Callable[[str], RobotDriver]]] = {
    "waveshare": WaveshareDriver,
}
"""Drivers that have to know which of the maker's robots it is."""


def new_driver(name: str, model: str | None = None) -> RobotDriver:
    """Make a driver; ``model`` is one of `KnownRobot.models`, None the first or only one."""
    return DRIVERS[name]() if model is None else DRIVERS_BY_MODEL[name](model)
