"""What a robot knows and its line does not say: for tests that speak for a host."""

from __future__ import annotations

from firmware_protocol.robot.connection import RobotConnection


def nonce_of(robot: RobotConnection) -> int:
    """The number that a host has to give back for the session it asks for."""
    low, high = robot.link.nonce
    return low | high << 16


def expected_of(robot: RobotConnection) -> int:
    """The sequence number that the robot takes next."""
    return robot.link.frames.expected


def counted(robot: RobotConnection, counter: int) -> int:
    """A counter of STATUS, by its place there."""
    return robot.link.count[counter]
