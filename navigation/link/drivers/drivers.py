"""Which drivers there are, by the name in `robot.driver`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from navigation.link.drivers.create2 import Create2Driver
from navigation.link.drivers.robot_driver import RobotDriver

DRIVERS: Final[Mapping[str, Callable[[], RobotDriver]]] = {
    "create2": Create2Driver,
}
