"""The wire: messages, framing, and both ends of the serial link, sans-IO.

``docs/protocol.md`` has the bits and the reasons. Hosts need ``HostConnection``, ``Mission``,
``Waypoint``; robots ``RobotConnection`` and ``RobotController``, which wrap ``robot/clearway``;
``firmware/`` is the same robot in C99.
"""

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.state import LinkState
from firmware_protocol.robot.connection import Identity, RobotConnection
from firmware_protocol.robot.controller import RobotController
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.errors import LocalError, RemoteError
from firmware_protocol.wire.messages import RobotState, Status, StopReason, Waypoint, WaypointFlag
from firmware_protocol.wire.mission import Mission

__all__ = [
    "DriveSettings",
    "HostConnection",
    "Identity",
    "LinkState",
    "LocalError",
    "Mission",
    "RemoteError",
    "RobotConnection",
    "RobotController",
    "RobotState",
    "Status",
    "StopReason",
    "Waypoint",
    "WaypointFlag",
]
