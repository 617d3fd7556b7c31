"""All messages: reading a frame's payload, the schema's hash, the emergency stop's frame.

- ``pack()`` gives a payload, ``unpack(payload)`` reads one; the header is framing's.
- A message checks its ranges: LocalError, from the wire RemoteError. Integers are little-endian.
- Host messages have types below 0x80, robot messages from 0x80 on.
"""

from __future__ import annotations

from typing import Final, TypeAlias, get_args

from firmware_protocol.wire.crc import crc32c
from firmware_protocol.wire.errors import RemoteError
from firmware_protocol.wire.framing import Sender, WireFrame, encode_frame
from firmware_protocol.wire.host_messages import (
    MINOR_VERSION,
    WAYPOINT_BYTES,
    WAYPOINTS_PER_FRAME,
    Clear,
    Confirm,
    Hello,
    Lease,
    Pause,
    PoseFix,
    ResetEstop,
    Start,
    TimeSync,
    Waypoint,
    Waypoints,
)
from firmware_protocol.wire.robot_messages import (
    Ack,
    Challenge,
    HelloAck,
    RobotCounters,
    Status,
    TimeSyncReply,
)
from firmware_protocol.wire.values import known, wrap_angle
from firmware_protocol.wire.vocabulary import (
    STOP_SENTENCES,
    CommandResult,
    LeaseFlag,
    MessageType,
    ResetCause,
    RobotState,
    StatusFlag,
    StopReason,
    WaypointFlag,
)

Message: TypeAlias = (
    Hello
    | Confirm
    | Waypoints
    | Start
    | Pause
    | Clear
    | ResetEstop
    | Lease
    | PoseFix
    | TimeSync
    | HelloAck
    | Challenge
    | Ack
    | Status
    | TimeSyncReply
)
"""In the order of the schema."""

MESSAGES: Final[dict[MessageType, type[Message]]] = {one.TYPE: one for one in get_args(Message)}
RELIABLE: Final = frozenset(
    (
        MessageType.WAYPOINTS,
        MessageType.START,
        MessageType.PAUSE,
        MessageType.CLEAR,
        MessageType.RESET_ESTOP,
    )
)
"""Types that are numbered, acknowledged and sent again until they arrive."""


def read_message(frame: WireFrame) -> Message:
    """Read the message in a frame; RemoteError for an unknown type or content."""
    message = MESSAGES.get(known(MessageType, frame.kind))
    if message is None:
        raise RemoteError(f"{MessageType(frame.kind).name} carries no message")
    return message.unpack(frame.payload)


def schema_text() -> str:
    """The layouts of all messages, one line each; their CRC is the schema's hash."""
    lines = [f"{int(kind):02x} {message.LAYOUT.format}" for kind, message in MESSAGES.items()]
    return "\n".join([*lines, f"waypoint {Waypoint.LAYOUT.format}"])


SCHEMA_HASH: Final = crc32c(schema_text().encode())
"""Equal at both ends; a robot with another is refused."""

ESTOP_FRAME: Final = encode_frame(WireFrame(MessageType.ESTOP, 0), Sender.HOST)
"""Constant, without a session: 15 bytes that a robot can match in its interrupt."""

__all__ = [
    "ESTOP_FRAME",
    "MESSAGES",
    "MINOR_VERSION",
    "RELIABLE",
    "SCHEMA_HASH",
    "STOP_SENTENCES",
    "WAYPOINTS_PER_FRAME",
    "WAYPOINT_BYTES",
    "Ack",
    "Challenge",
    "Clear",
    "CommandResult",
    "Confirm",
    "Hello",
    "HelloAck",
    "Lease",
    "LeaseFlag",
    "Message",
    "MessageType",
    "Pause",
    "PoseFix",
    "ResetCause",
    "ResetEstop",
    "RobotCounters",
    "RobotState",
    "Start",
    "Status",
    "StatusFlag",
    "StopReason",
    "TimeSync",
    "TimeSyncReply",
    "Waypoint",
    "WaypointFlag",
    "Waypoints",
    "read_message",
    "schema_text",
    "wrap_angle",
]
