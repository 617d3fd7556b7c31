"""The wire: messages, framing, and both ends of the serial link, sans-IO.

``docs/protocol.md`` has the bits and the reasons. A host needs ``HostConnection``,
``Mission`` and ``Waypoint``; a robot ``RobotConnection`` and ``RobotController``; ``firmware/``
holds the same robot in C99.
"""

from firmware_protocol.drive_settings import DriveSettings
from firmware_protocol.errors import LocalError, RemoteError
from firmware_protocol.host import HostConnection
from firmware_protocol.host_state import LinkState
from firmware_protocol.messages import RobotState, Status, StopReason, Waypoint, WaypointFlag
from firmware_protocol.mission import Mission
from firmware_protocol.robot import RobotController
from firmware_protocol.robot_connection import Identity, RobotConnection

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
