"""The daemon's own stop when no driver's process has the robot; sans-IO.

The process's driver repeats the maker's stop until the robot reports rest. Until then the sentences
say what is unknown. Seconds.
"""

from __future__ import annotations

import math
from typing import Final

from navigation.link.drivers.robot_driver import RobotDriver
from navigation.link.drivers.standing import Standing
from navigation.link.drivers.word_of_robot import Word

SAID_AFTER_S: Final = 0.7
"""Time by which a robot that brakes and reports is heard to be at rest."""


class RobotHalt:
    """Orders one robot to stop. ``port`` is only for its sentences."""

    def __init__(self, driver: RobotDriver, port: str) -> None:
        self._driver = driver
        self._name = f"the {driver.robot.title} on {port}"
        self._standing = Standing()
        self._began_s = math.inf

    def begin(self, now_s: float) -> None:
        """Take the port: the first bytes are a stop."""
        self._began_s = now_s
        heard = self._driver.heard
        heard.stranger = heard.held = None
        self._driver.open(now_s)
        self._standing.begin(now_s)

    def receive(self, data: bytes, now_s: float) -> None:
        """Take the robot's reports."""
        if data:
            self._driver.receive(data, now_s)
        self._standing.look(self._driver.heard)

    def bytes_to_send(self, now_s: float) -> bytes:
        """Bytes due; call once the port has taken the last ones."""
        self._driver.drive(0.0, 0.0)
        return self._driver.bytes_to_send(now_s)

    def stands(self, now_s: float) -> bool:
        """True if it reports rest."""
        return self._standing.is_known(now_s)

    @property
    def is_held(self) -> bool:
        """True if it answers but takes no orders to drive, as on a charger."""
        return self._driver.heard.held is not None

    def word(self, why: str, now_s: float) -> Word:
        """State of the robot, and ``why`` no driver has it."""
        if self.stands(now_s):
            return Word(f"{why}; {self._name} stands", stands=True)
        if now_s - self._began_s < SAID_AFTER_S:
            return Word(f"{why}; {self._name} is being stopped")
        return Word(f"{why}; {self.doubt}")

    @property
    def doubt(self) -> str:
        """Sentence about a robot that does not report rest."""
        return (
            f"{self._name} was ordered to stand and has not been heard to: "
            f"{self._driver.robot.help}"
        )
