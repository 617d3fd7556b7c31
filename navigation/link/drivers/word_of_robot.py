"""Sentences for people about a robot with a fault.

A sentence says what is seen, and what to check. It changes only with its cause, so that a log has
it once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from navigation.config.known_robots import KNOWN_ROBOTS, KnownRobot
from navigation.link.drivers.robot_driver import Heard

PATIENCE_S: Final = 1.5
"""Time that a greeted robot has to answer before it counts as silent."""
GARBAGE: Final = 160
"""Bytes without one message, longer than any, at which this is no robot of this kind."""
DAMAGED_SHARE: Final = 0.05
LOW_BATTERY: Final = 0.15


@dataclass(frozen=True, slots=True)
class Word:
    """Report of the driver's process on its robot; sent whole to the daemon.

    ``silence``: why the robot is out of reach, None while it is not. ``fault``: why it must not
    drive. ``remark``: what people should know although it drives. ``stands``: its wheels report,
    and do not turn.
    """

    silence: str | None
    fault: str | None = None
    remark: str = ""
    identity: str | None = None
    battery: float | None = None
    stands: bool = False


def silence_of(
    robot: KnownRobot, port: str, baud: int, heard: Heard, fresh_bytes: int, waited_s: float
) -> str:
    """Reason why the robot is out of reach although its port is open.

    ``fresh_bytes`` came since its last message, or since the port was opened.
    """
    if heard.stranger is not None:
        other = KNOWN_ROBOTS[heard.stranger].title
        return (
            f"{port} has {_an(other)} on it, not {_an(robot.title)}: set robot.driver to "
            f"{heard.stranger}, or plug in the other robot"
        )
    if heard.held is not None:
        return f"the {robot.title} on {port} {heard.held}"
    if fresh_bytes >= GARBAGE:
        hint = "" if baud == robot.baud else f" (serial.baud is {baud}, its own is {robot.baud})"
        return (
            f"bytes come from {port} that are no words of {_an(robot.title)}: another robot, "
            f"another baud{hint}, or a second program on the port?"
        )
    if heard.identity is not None:
        return f"the {robot.title} on {port} has gone silent: {robot.help}"
    if waited_s < PATIENCE_S:
        return f"greeting the {robot.title} on {port}"
    return f"the {robot.title} on {port} does not answer: {robot.help}"


def remark_of(robot: KnownRobot, port: str, heard: Heard, damaged: int, messages: int) -> str:
    """Remark on a robot that answers; counts are of the last seconds."""
    if damaged > DAMAGED_SHARE * (messages + damaged) and damaged > 3:
        return (
            f"much of what the {robot.title} sends arrives damaged: a bad cable, or a second "
            f"program that reads {port}?"
        )
    if heard.remark is not None:
        return f"the {robot.title} {heard.remark}"
    if heard.battery is not None and heard.battery < LOW_BATTERY:
        return f"the {robot.title}'s battery is nearly empty: charge it"
    return ""


def _an(name: str) -> str:
    return f"an {name}" if name[0] in "aeioAEIO" else f"a {name}"
