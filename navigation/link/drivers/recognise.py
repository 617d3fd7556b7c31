"""Recognition of the robot on a port: each driver greets it in turn, and none drives it.

In every protocol a greeting is a stop and a question, and means nothing in the others.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from navigation.config.known_robots import KNOWN_ROBOTS
from navigation.link.drivers.drivers import DRIVERS
from navigation.link.drivers.robot_driver import Heard
from navigation.link.drivers.robot_port import RobotPort
from navigation.link.drivers.word_of_robot import PATIENCE_S, silence_of
from navigation.link.serial_port import PortError

PAUSE_S: Final = 0.005


@dataclass(frozen=True, slots=True)
class Recognised:
    """The robot that answers, a name of `DRIVERS`, and its report; or the reason why none does."""

    name: str | None
    sentence: str
    battery: float | None = None
    fault: str | None = None


def recognise(
    path: str,
    baud: int,
    wanted: str,
    clock: Callable[[], float] = time.monotonic,
    wait: Callable[[float], None] = time.sleep,
) -> Recognised:
    """Greet as the ``wanted`` driver, then as the others; PortError if the port cannot be used.

    Takes up to ``PATIENCE_S`` for each.
    """
    others = [name for name in DRIVERS if name != wanted]
    why = ""
    for name in (wanted, *others):
        heard, came, waited_s = _greet(name, path, baud, clock, wait)
        if heard.identity is not None:
            return Recognised(name, heard.identity, heard.battery, heard.fault)
        if name == wanted:
            why = silence_of(KNOWN_ROBOTS[wanted], path, baud, heard, came, waited_s)
    return Recognised(None, why)


def _greet(
    name: str,
    path: str,
    baud: int,
    clock: Callable[[], float],
    wait: Callable[[float], None],
) -> tuple[Heard, int, float]:
    driver, port = DRIVERS[name](), RobotPort(path, baud)
    began_s, came = clock(), 0
    if not port.open(began_s):
        raise PortError(str(port.fault))
    try:
        driver.open(began_s)
        while (now_s := clock()) - began_s <= PATIENCE_S and driver.heard.identity is None:
            data = port.read(now_s)
            came += len(data)
            driver.receive(data, now_s)
            driver.drive(0.0, 0.0)
            port.write(driver.bytes_to_send(now_s) if port.is_free else b"", now_s)
            if port.fault is not None:
                raise PortError(port.fault)
            wait(PAUSE_S)
    finally:
        port.close()
    return driver.heard, came, PATIENCE_S
