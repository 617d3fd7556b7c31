"""Test vectors of the wire, for both languages: ``python -m tests.support.wire.protocol_vectors``.

Writes tests/golden/protocol.json. A test makes them again and compares, so that a change of
the wire cannot happen by accident.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from firmware_protocol.wire.crc import crc32c
from firmware_protocol.wire.framing import Sender, WireFrame, encode_frame
from firmware_protocol.wire.messages import (
    ESTOP_FRAME,
    RELIABLE,
    SCHEMA_HASH,
    Ack,
    Challenge,
    Clear,
    CommandResult,
    Confirm,
    Hello,
    HelloAck,
    Lease,
    LeaseFlag,
    Message,
    Pause,
    PoseFix,
    ResetCause,
    ResetEstop,
    RobotCounters,
    RobotState,
    Start,
    Status,
    StatusFlag,
    StopReason,
    TimeSync,
    TimeSyncReply,
    Waypoint,
    WaypointFlag,
    Waypoints,
    schema_text,
)
from firmware_protocol.wire.mission import Mission, mission_seed

GOLDEN = Path(__file__).parents[2] / "golden" / "protocol.json"

WAYPOINTS = (
    Waypoint(0.0, 0.0, 0.0),
    Waypoint(1.234567, -0.000001, 0.3, heading_rad=math.pi, acceptance_m=0.005),
    Waypoint(-2147.483647, 2147.483647, 65.535, heading_rad=-3.1415, acceptance_m=6.5535),
    Waypoint(0.5, 0.25, 0.25, 0.0, 0.003, 25.5, WaypointFlag.STOP),
    Waypoint(0.1, 0.2, 0.0, -math.pi / 2, 0.0, 0.1, WaypointFlag.STOP | WaypointFlag.END),
    Waypoint(-0.0000005, 0.0000005, 0.0004),
)
_RECORDS = tuple(waypoint.pack() for waypoint in WAYPOINTS)

MESSAGES: tuple[tuple[str, Sender, Message], ...] = (
    ("hello", Sender.HOST, Hello(SCHEMA_HASH)),
    ("one waypoint", Sender.HOST, Waypoints(1, 0, _RECORDS[:1])),
    ("six waypoints", Sender.HOST, Waypoints(0xDEADBEEF, 70_000, _RECORDS)),
    ("start", Sender.HOST, Start(1, 0xDEADBEEF, 123_456)),
    ("pause", Sender.HOST, Pause(65_535)),
    ("clear", Sender.HOST, Clear(256, 0)),
    ("reset the emergency stop", Sender.HOST, ResetEstop(0x00FF)),
    ("lease", Sender.HOST, Lease(0.5, LeaseFlag.PERMIT, 0.041, 0xFFFFFFFF)),
    ("lease without a pose", Sender.HOST, Lease(0.0, LeaseFlag.ODOMETRY)),
    ("pose", Sender.HOST, PoseFix(1.5, -0.75, 3.1416, 0xFEDCBA98)),
    ("time request", Sender.HOST, TimeSync(0xFFFFFFFF)),
    ("challenge answered", Sender.HOST, Confirm(0xC0FFEE01)),
    ("challenge", Sender.ROBOT, Challenge(0xC0FFEE01)),
    ("acknowledgement", Sender.ROBOT, Ack(36)),
    ("time reply", Sender.ROBOT, TimeSyncReply(0xFFFFFFFF, 0, 250)),
    (
        "hello answered",
        Sender.ROBOT,
        HelloAck(
            major=1,
            minor=0,
            schema=SCHEMA_HASH,
            firmware=0x01020304,
            boot_id=0xCAFEF00D,
            reset_cause=ResetCause.BROWN_OUT,
            max_payload=112,
            rx_window=248,
            queue_size=32,
            state=RobotState.HOLD,
            mission=7,
            accept_next=40,
            exec_next=9,
            prefix_crc=0x12345678,
            exec_crc=0x9ABCDEF0,
        ),
    ),
    (
        "status",
        Sender.ROBOT,
        Status(
            time_us=0xFFFFFFFE,
            boot_id=0xCAFEF00D,
            mission=7,
            accept_next=40,
            exec_next=9,
            prefix_crc=0x12345678,
            exec_crc=0x9ABCDEF0,
            state=RobotState.RUN,
            flags=StatusFlag.MOVING | StatusFlag.PERMIT | StatusFlag.POSE_KNOWN,
            reason=StopReason.NONE,
            result=CommandResult.DONE,
            command=3,
            x_m=-1.25,
            y_m=0.75,
            heading_rad=1.5708,
            speed_m_s=-0.3,
            turn_rad_s=0.5,
            pose_age_s=math.inf,
            lease_left_s=0.45,
            counters=RobotCounters(1, 2, 3, 4, 5, 6, 7, 65_535),
        ),
    ),
)


def make_vectors() -> dict[str, Any]:
    """All vectors as plain data."""
    frames = []
    for number, (name, sender, message) in enumerate(MESSAGES):
        frame = WireFrame(
            kind=message.TYPE,
            session=(0x1234 + 0x1111 * number) & 0xFFFF,
            payload=message.pack(),
            sequence=number * 17 % 256 if message.TYPE in RELIABLE else 0,
            acknowledged=0 if sender is Sender.HOST else 255 - number,
            credit=0 if sender is Sender.HOST else 32 - number,
            reliable=message.TYPE in RELIABLE,
            nak=name == "acknowledgement",
        )
        frames.append(
            {
                "name": name,
                "sender": sender.name.lower(),
                "type": int(frame.kind),
                "session": frame.session,
                "sequence": frame.sequence,
                "acknowledged": frame.acknowledged,
                "credit": frame.credit,
                "reliable": frame.reliable,
                "nak": frame.nak,
                "payload": frame.payload.hex(),
                "wire": encode_frame(frame, sender).hex(),
            }
        )
    mission = Mission(0xDEADBEEF, WAYPOINTS)
    return {
        "schema_text": schema_text(),
        "schema": SCHEMA_HASH,
        "crc": [
            {"data": data.hex(), "crc": crc32c(data)}
            for data in (b"", b"123456789", bytes(32), b"\xff" * 32, bytes(range(124)))
        ],
        "estop": ESTOP_FRAME.hex(),
        "frames": frames,
        "mission": {
            "id": mission.id,
            "seed": mission_seed(mission.id),
            "records": [record.hex() for record in mission.records],
            "prefix_crcs": [mission.prefix_crc(n) for n in range(len(mission) + 1)],
        },
    }


def text() -> str:
    """The file's content."""
    return json.dumps(make_vectors(), indent=1) + "\n"


if __name__ == "__main__":
    GOLDEN.write_text(text())
    print(f"wrote {GOLDEN.name}")
