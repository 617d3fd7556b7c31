"""The messages: frozen data with SI units outside, micrometres and 1e-4 rad on the wire.

- ``pack()`` gives the payload, ``unpack(payload)`` reads one; the header is framing's.
- A message made here checks its ranges (LocalError); one read from the wire is checked before
  it is trusted (RemoteError). Integers are little-endian.
- Host messages have types below 0x80, robot messages from 0x80 on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from struct import Struct
from typing import ClassVar, Final, Self, TypeAlias, TypeVar

from firmware_protocol.crc import crc32c
from firmware_protocol.errors import LocalError, RemoteError
from firmware_protocol.framing import MAX_PAYLOAD, VERSION, Frame, Sender, encode_frame

MINOR_VERSION: Final = 0
WAYPOINT_BYTES: Final = 16
WAYPOINTS_PER_FRAME: Final = (MAX_PAYLOAD - 10) // WAYPOINT_BYTES
HEADING_FREE: Final = -32768
NO_POSE_MS: Final = 0xFFFF
"""A pose age that means: there has been no pose."""
UM_PER_M: Final = 1_000_000
_RADIAN: Final = 10_000
_HALF_TURN: Final = 31_416


class MessageType(IntEnum):
    """The type byte of a frame."""

    HELLO = 0x01
    WAYPOINTS = 0x10
    START = 0x11
    PAUSE = 0x12
    CLEAR = 0x13
    RESET_ESTOP = 0x14
    LEASE = 0x20
    POSE = 0x21
    TIMESYNC = 0x22
    ESTOP = 0x2E
    HELLO_ACK = 0x81
    ACK = 0x90
    STATUS = 0x91
    TIMESYNC_REPLY = 0xA2


class RobotState(IntEnum):
    """What the robot is doing; the table of changes is in ``robot_state``."""

    BOOT = 0
    IDLE = 1
    RUN = 2
    HOLD = 3
    ESTOP = 4


class StopReason(IntEnum):
    """Why the robot is not in RUN (the last cause)."""

    NONE = 0
    BOOTED = 1
    NEW_SESSION = 2
    PAUSED = 3
    CLEARED = 4
    MISSION_DONE = 5
    LEASE_LAPSED = 6
    NO_PERMIT = 7
    POSE_STALE = 8
    OFF_PATH = 9
    STUCK = 10
    ESTOP_HOST = 11
    ESTOP_LOCAL = 12
    DISARMED = 13
    ESTOP_RESET = 14


STOP_SENTENCES: Final = {
    StopReason.NONE: "it has not been stopped",
    StopReason.BOOTED: "it has just booted",
    StopReason.NEW_SESSION: "the link was made anew",
    StopReason.PAUSED: "it was told to pause",
    StopReason.CLEARED: "its queue was cleared",
    StopReason.MISSION_DONE: "it has finished its mission",
    StopReason.LEASE_LAPSED: "its lease ran out: the control loop went silent",
    StopReason.NO_PERMIT: "the control loop withdrew its permit to drive",
    StopReason.POSE_STALE: "the camera's last pose is too old",
    StopReason.OFF_PATH: "it is too far from its path",
    StopReason.STUCK: "it cannot reach its target",
    StopReason.ESTOP_HOST: "the host pressed the emergency stop",
    StopReason.ESTOP_LOCAL: "the emergency stop on the robot was pressed",
    StopReason.DISARMED: "it disarmed itself after a long silence",
    StopReason.ESTOP_RESET: "the emergency stop was reset",
}
"""Plain words for every reason, to be read after "the robot stands because"."""


class ResetCause(IntEnum):
    """Why the robot's processor started."""

    UNKNOWN = 0
    POWER_ON = 1
    EXTERNAL = 2
    BROWN_OUT = 3
    WATCHDOG = 4


class CommandResult(IntEnum):
    """What became of the last command."""

    NONE = 0
    DONE = 1
    WRONG_MISSION = 2
    WRONG_INDEX = 3
    WRONG_STATE = 4
    NO_LEASE = 5
    NO_POSE = 6
    SAME_SESSION = 7


class WaypointFlag(IntFlag):
    """STOP: come to rest here, and turn to the heading if there is one. END: the last one."""

    NONE = 0
    STOP = 1
    END = 2


class StatusFlag(IntFlag):
    """Bits of STATUS."""

    NONE = 0
    MOVING = 1
    LEASE_VALID = 2
    PERMIT = 4
    POSE_KNOWN = 8
    UNDERRUN = 16
    MISSION_DONE = 32


class LeaseFlag(IntFlag):
    """Bits of LEASE. PERMIT: may drive. ODOMETRY: may drive without the camera's poses."""

    NONE = 0
    PERMIT = 1
    ODOMETRY = 2


def wrap_angle(angle_rad: float) -> float:
    """The same angle in (-pi, pi]."""
    wrapped = math.remainder(angle_rad, math.tau)
    return math.pi if wrapped == -math.pi else wrapped


def _scaled(name: str, value: float, scale: float, low: int, high: int) -> int:
    if not math.isfinite(value):
        raise LocalError(f"{name} = {value}: must be finite")
    number = round(value * scale)
    if not low <= number <= high:
        raise LocalError(f"{name} = {value}: must be in [{low / scale:g}, {high / scale:g}]")
    return number


def _position(name: str, value_m: float) -> int:
    return _scaled(name, value_m, UM_PER_M, -0x7FFFFFFF, 0x7FFFFFFF)


def _heading(value_rad: float | None) -> int:
    if value_rad is None:
        return HEADING_FREE
    if not math.isfinite(value_rad):
        raise LocalError(f"heading_rad = {value_rad}: must be finite")
    inside = value_rad if abs(value_rad) <= math.pi else wrap_angle(value_rad)
    return round(inside * _RADIAN)


def _heading_from(wire: int) -> float | None:
    if wire == HEADING_FREE:
        return None
    if not -_HALF_TURN <= wire <= _HALF_TURN:
        raise RemoteError(f"heading {wire}: must be in [-{_HALF_TURN}, {_HALF_TURN}] or free")
    # the last step of the wire lies just beyond half a turn
    return max(-math.pi, min(math.pi, wire / _RADIAN))


def _clamped(value: float, scale: float, high: int) -> int:
    """For times whose excess says nothing more: infinity is the highest value."""
    if math.isnan(value) or value < 0.0:
        raise LocalError(f"time {value}: must be >= 0")
    return high if value * scale >= high else round(value * scale)


def _exact(what: str, layout: Struct, payload: bytes) -> tuple[int, ...]:
    if len(payload) != layout.size:
        raise RemoteError(f"{what} of {len(payload)} bytes: must have {layout.size}")
    return layout.unpack(payload)


_Known = TypeVar("_Known", bound=IntEnum)


def _known(enum: type[_Known], value: int) -> _Known:
    try:
        return enum(value)
    except ValueError:
        raise RemoteError(f"{enum.__name__} {value}: unknown") from None


@dataclass(frozen=True, slots=True)
class Hello:
    """The host opens a session; sent until answered. Layout frozen for ever."""

    major: int = VERSION
    minor: int = MINOR_VERSION
    schema: int = -1
    """-1 stands for this program's own schema."""

    TYPE: ClassVar[MessageType] = MessageType.HELLO
    LAYOUT: ClassVar[Struct] = Struct("<BBI")

    def pack(self) -> bytes:
        """The payload."""
        schema = SCHEMA_HASH if self.schema == -1 else self.schema
        return self.LAYOUT.pack(self.major, self.minor, schema)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; RemoteError where it is none."""
        major, minor, schema = _exact("HELLO", cls.LAYOUT, payload)
        return cls(major, minor, schema)


@dataclass(frozen=True, slots=True)
class HelloAck:
    """The robot's answer: who it is and where it stands. Layout frozen for ever."""

    major: int
    minor: int
    schema: int
    firmware: int
    boot_id: int
    reset_cause: ResetCause
    max_payload: int
    rx_window: int
    queue_size: int
    state: RobotState
    mission: int
    accept_next: int
    exec_next: int
    prefix_crc: int
    """CRC over the mission id and the accepted waypoints, see ``mission``."""
    exec_crc: int
    """The same over the executed waypoints, in the order in which they were executed."""

    TYPE: ClassVar[MessageType] = MessageType.HELLO_ACK
    LAYOUT: ClassVar[Struct] = Struct("<BBIIIBBHBBIIIII")

    def pack(self) -> bytes:
        """The payload."""
        return self.LAYOUT.pack(
            self.major,
            self.minor,
            self.schema,
            self.firmware,
            self.boot_id,
            self.reset_cause,
            self.max_payload,
            self.rx_window,
            self.queue_size,
            self.state,
            self.mission,
            self.accept_next,
            self.exec_next,
            self.prefix_crc,
            self.exec_crc,
        )

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; RemoteError where it is none."""
        v = list(_exact("HELLO_ACK", cls.LAYOUT, payload))
        cause, state = _known(ResetCause, v[5]), _known(RobotState, v[9])
        return cls(v[0], v[1], v[2], v[3], v[4], cause, v[6], v[7], v[8], state, *v[10:])


@dataclass(frozen=True, slots=True)
class Waypoint:
    """One target: where, how fast to pass it, and how exactly.

    ``heading_rad`` counts only where the robot stops (flag STOP or END); None is any.
    ``acceptance_m`` is the radius within which the point counts as reached; at a stop it is
    the tolerance of the position, 0 for the robot's own. ``dwell_s`` is how long to stand.
    Ranges: |x|, |y| < 2147 m, speed to 65 m/s, acceptance to 6.5 m, dwell to 25.5 s.
    """

    x_m: float
    y_m: float
    speed_m_s: float
    heading_rad: float | None = None
    acceptance_m: float = 0.0
    dwell_s: float = 0.0
    flags: WaypointFlag = WaypointFlag.NONE

    LAYOUT: ClassVar[Struct] = Struct("<iihHHBB")

    def pack(self) -> bytes:
        """The 16 bytes of the wire; LocalError where a value does not fit."""
        return self.LAYOUT.pack(
            _position("x_m", self.x_m),
            _position("y_m", self.y_m),
            _heading(self.heading_rad),
            _scaled("speed_m_s", self.speed_m_s, 1e3, 0, 0xFFFF),
            _scaled("acceptance_m", self.acceptance_m, 1e4, 0, 0xFFFF),
            _scaled("dwell_s", self.dwell_s, 10.0, 0, 0xFF),
            self.flags,
        )

    @classmethod
    def unpack(cls, record: bytes) -> Self:
        """Read the 16 bytes; RemoteError where a value is out of range."""
        x, y, heading, speed, acceptance, dwell, flags = _exact("waypoint", cls.LAYOUT, record)
        if flags & ~3:
            raise RemoteError(f"waypoint flags {flags:#x}: only STOP and END are known")
        if -0x80000000 in (x, y):
            raise RemoteError("waypoint at -2**31: not a position")
        return cls(
            x / UM_PER_M,
            y / UM_PER_M,
            speed / 1e3,
            _heading_from(heading),
            acceptance / 1e4,
            dwell / 10.0,
            WaypointFlag(flags),
        )


@dataclass(frozen=True, slots=True)
class Waypoints:
    """Up to six consecutive waypoints of a mission, as the 16-byte records of the wire."""

    mission: int
    first: int
    records: tuple[bytes, ...]

    TYPE: ClassVar[MessageType] = MessageType.WAYPOINTS
    LAYOUT: ClassVar[Struct] = Struct("<IIBB")

    def pack(self) -> bytes:
        """The payload; LocalError where there are too many."""
        if not 1 <= len(self.records) <= WAYPOINTS_PER_FRAME:
            raise LocalError(
                f"{len(self.records)} waypoints in a frame: 1 to {WAYPOINTS_PER_FRAME} fit"
            )
        head = self.LAYOUT.pack(self.mission, self.first, len(self.records), 0)
        return head + b"".join(self.records)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload and check every record; RemoteError where one is wrong."""
        if len(payload) < cls.LAYOUT.size:
            raise RemoteError(f"WAYPOINTS of {len(payload)} bytes: at least {cls.LAYOUT.size}")
        mission, first, count, _flags = cls.LAYOUT.unpack_from(payload)
        if not 1 <= count <= WAYPOINTS_PER_FRAME:
            raise RemoteError(f"WAYPOINTS count {count}: must be in [1, {WAYPOINTS_PER_FRAME}]")
        if len(payload) != cls.LAYOUT.size + WAYPOINT_BYTES * count:
            raise RemoteError(f"WAYPOINTS of {len(payload)} bytes do not hold {count} waypoints")
        records = tuple(
            payload[at : at + WAYPOINT_BYTES]
            for at in range(cls.LAYOUT.size, len(payload), WAYPOINT_BYTES)
        )
        for record in records:
            Waypoint.unpack(record)
        return cls(mission, first, records)


@dataclass(frozen=True, slots=True)
class Start:
    """Drive, from waypoint ``exec_next`` of ``mission``; ``command`` numbers the commands."""

    command: int
    mission: int
    exec_next: int

    TYPE: ClassVar[MessageType] = MessageType.START
    LAYOUT: ClassVar[Struct] = Struct("<HII")

    def pack(self) -> bytes:
        """The payload."""
        return self.LAYOUT.pack(self.command, self.mission, self.exec_next)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; RemoteError where it is none."""
        command, mission, exec_next = _exact("START", cls.LAYOUT, payload)
        return cls(command, mission, exec_next)


@dataclass(frozen=True, slots=True)
class Pause:
    """Stop under control and keep the queue."""

    command: int

    TYPE: ClassVar[MessageType] = MessageType.PAUSE
    LAYOUT: ClassVar[Struct] = Struct("<H")

    def pack(self) -> bytes:
        """The payload."""
        return self.LAYOUT.pack(self.command)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; RemoteError where it is none."""
        (command,) = _exact("PAUSE", cls.LAYOUT, payload)
        return cls(command)


@dataclass(frozen=True, slots=True)
class Clear:
    """Stop under control, drop the queue; ``mission`` is the one to come (0: none)."""

    command: int
    mission: int

    TYPE: ClassVar[MessageType] = MessageType.CLEAR
    LAYOUT: ClassVar[Struct] = Struct("<HI")

    def pack(self) -> bytes:
        """The payload."""
        return self.LAYOUT.pack(self.command, self.mission)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; RemoteError where it is none."""
        command, mission = _exact("CLEAR", cls.LAYOUT, payload)
        return cls(command, mission)


@dataclass(frozen=True, slots=True)
class ResetEstop:
    """Leave the latched stop; the robot obeys only in a session younger than the stop."""

    command: int

    TYPE: ClassVar[MessageType] = MessageType.RESET_ESTOP
    LAYOUT: ClassVar[Struct] = Struct("<H")

    def pack(self) -> bytes:
        """The payload."""
        return self.LAYOUT.pack(self.command)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; RemoteError where it is none."""
        (command,) = _exact("RESET_ESTOP", cls.LAYOUT, payload)
        return cls(command)


@dataclass(frozen=True, slots=True)
class Lease:
    """The control loop lives and, with PERMIT, lets the robot drive for ``ttl_s`` longer."""

    ttl_s: float
    flags: LeaseFlag
    pose_age_s: float = math.inf

    TYPE: ClassVar[MessageType] = MessageType.LEASE
    LAYOUT: ClassVar[Struct] = Struct("<HBH")

    def pack(self) -> bytes:
        """The payload; LocalError where the time is negative."""
        ttl = _clamped(self.ttl_s, 1e3, 0xFFFF)
        return self.LAYOUT.pack(ttl, self.flags, _clamped(self.pose_age_s, 1e3, NO_POSE_MS))

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; RemoteError where it is none."""
        ttl, flags, age = _exact("LEASE", cls.LAYOUT, payload)
        if flags & ~3:
            raise RemoteError(f"LEASE flags {flags:#x}: only PERMIT and ODOMETRY are known")
        return cls(ttl / 1e3, LeaseFlag(flags), math.inf if age == NO_POSE_MS else age / 1e3)


@dataclass(frozen=True, slots=True)
class PoseFix:
    """Where the camera saw the robot ``age_s`` before this frame was sent (at most 6.5 s)."""

    x_m: float
    y_m: float
    heading_rad: float
    age_s: float

    TYPE: ClassVar[MessageType] = MessageType.POSE
    LAYOUT: ClassVar[Struct] = Struct("<iihH")

    def pack(self) -> bytes:
        """The payload; LocalError where a value does not fit."""
        x, y = _position("x_m", self.x_m), _position("y_m", self.y_m)
        return self.LAYOUT.pack(x, y, _heading(self.heading_rad), _clamped(self.age_s, 1e4, 0xFFFF))

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; RemoteError where it is none."""
        x, y, wire_heading, age = _exact("POSE", cls.LAYOUT, payload)
        heading = _heading_from(wire_heading)
        if heading is None:
            raise RemoteError("POSE without a heading")
        return cls(x / UM_PER_M, y / UM_PER_M, heading, age / 1e4)


@dataclass(frozen=True, slots=True)
class TimeSync:
    """The host asks for the robot's clock; microseconds, modulo 2**32."""

    host_sent_us: int

    TYPE: ClassVar[MessageType] = MessageType.TIMESYNC
    LAYOUT: ClassVar[Struct] = Struct("<I")

    def pack(self) -> bytes:
        """The payload."""
        return self.LAYOUT.pack(self.host_sent_us)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; RemoteError where it is none."""
        (host_sent_us,) = _exact("TIMESYNC", cls.LAYOUT, payload)
        return cls(host_sent_us)


@dataclass(frozen=True, slots=True)
class TimeSyncReply:
    """The robot's clock at receiving and at answering; microseconds, modulo 2**32."""

    host_sent_us: int
    robot_received_us: int
    robot_sent_us: int

    TYPE: ClassVar[MessageType] = MessageType.TIMESYNC_REPLY
    LAYOUT: ClassVar[Struct] = Struct("<III")

    def pack(self) -> bytes:
        """The payload."""
        return self.LAYOUT.pack(self.host_sent_us, self.robot_received_us, self.robot_sent_us)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; RemoteError where it is none."""
        sent, received, answered = _exact("TIMESYNC_REPLY", cls.LAYOUT, payload)
        return cls(sent, received, answered)


@dataclass(frozen=True, slots=True)
class Ack:
    """The robot acknowledges at once; sequence and credit stand in the frame's header."""

    accept_next: int

    TYPE: ClassVar[MessageType] = MessageType.ACK
    LAYOUT: ClassVar[Struct] = Struct("<I")

    def pack(self) -> bytes:
        """The payload."""
        return self.LAYOUT.pack(self.accept_next)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; RemoteError where it is none."""
        (accept_next,) = _exact("ACK", cls.LAYOUT, payload)
        return cls(accept_next)


@dataclass(frozen=True, slots=True)
class RobotCounters:
    """What the robot's receiver has seen since it booted; each modulo 2**16."""

    frames: int = 0
    crc_errors: int = 0
    format_errors: int = 0
    """COBS, length and size errors together."""
    overruns: int = 0
    session_errors: int = 0
    gaps: int = 0
    duplicates: int = 0
    rejected: int = 0
    """Whole frames whose content was refused."""


@dataclass(frozen=True, slots=True)
class Status:
    """Where the robot stands, 20 times a second; cumulative, so that none may be missed."""

    time_us: int
    boot_id: int
    mission: int
    accept_next: int
    exec_next: int
    prefix_crc: int
    exec_crc: int
    state: RobotState
    flags: StatusFlag
    reason: StopReason
    result: CommandResult
    """What became of command number ``command``."""
    command: int
    x_m: float
    y_m: float
    heading_rad: float
    speed_m_s: float
    turn_rad_s: float
    pose_age_s: float
    lease_left_s: float
    counters: RobotCounters = RobotCounters()

    TYPE: ClassVar[MessageType] = MessageType.STATUS
    LAYOUT: ClassVar[Struct] = Struct("<IIIIIIIBBBBHiihhhHH8H")

    def pack(self) -> bytes:
        """The payload; positions, speeds and ages beyond the wire's range are clamped."""
        c = self.counters
        counts = (
            c.frames,
            c.crc_errors,
            c.format_errors,
            c.overruns,
            c.session_errors,
            c.gaps,
            c.duplicates,
            c.rejected,
        )
        return self.LAYOUT.pack(
            self.time_us,
            self.boot_id,
            self.mission,
            self.accept_next,
            self.exec_next,
            self.prefix_crc,
            self.exec_crc,
            self.state,
            self.flags,
            self.reason,
            self.result,
            self.command,
            _saturated(self.x_m * UM_PER_M, 0x7FFFFFFF),
            _saturated(self.y_m * UM_PER_M, 0x7FFFFFFF),
            _heading(self.heading_rad),
            _saturated(self.speed_m_s * 1e3, 0x7FFF),
            _saturated(self.turn_rad_s * 1e3, 0x7FFF),
            _clamped(self.pose_age_s, 1e3, NO_POSE_MS),
            _clamped(self.lease_left_s, 1e3, 0xFFFF),
            *(count & 0xFFFF for count in counts),
        )

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; RemoteError where it is none."""
        v = list(_exact("STATUS", cls.LAYOUT, payload))
        heading = _heading_from(v[14])
        if heading is None:
            raise RemoteError("STATUS without a heading")
        if v[8] & ~0x3F:
            raise RemoteError(f"STATUS flags {v[8]:#x}: unknown")
        return cls(
            time_us=v[0],
            boot_id=v[1],
            mission=v[2],
            accept_next=v[3],
            exec_next=v[4],
            prefix_crc=v[5],
            exec_crc=v[6],
            state=_known(RobotState, v[7]),
            flags=StatusFlag(v[8]),
            reason=_known(StopReason, v[9]),
            result=_known(CommandResult, v[10]),
            command=v[11],
            x_m=v[12] / UM_PER_M,
            y_m=v[13] / UM_PER_M,
            heading_rad=heading,
            speed_m_s=v[15] / 1e3,
            turn_rad_s=v[16] / 1e3,
            pose_age_s=math.inf if v[17] == NO_POSE_MS else v[17] / 1e3,
            lease_left_s=v[18] / 1e3,
            counters=RobotCounters(*v[19:]),
        )


def _saturated(value: float, high: int) -> int:
    return max(-high, min(high, round(value)))


Message: TypeAlias = (
    Hello
    | HelloAck
    | Waypoints
    | Start
    | Pause
    | Clear
    | ResetEstop
    | Lease
    | PoseFix
    | TimeSync
    | TimeSyncReply
    | Ack
    | Status
)

MESSAGES: Final = {
    message.TYPE: message
    for message in (
        Hello,
        Waypoints,
        Start,
        Pause,
        Clear,
        ResetEstop,
        Lease,
        PoseFix,
        TimeSync,
        HelloAck,
        Ack,
        Status,
        TimeSyncReply,
    )
}
RELIABLE: Final = frozenset(
    (
        MessageType.WAYPOINTS,
        MessageType.START,
        MessageType.PAUSE,
        MessageType.CLEAR,
        MessageType.RESET_ESTOP,
    )
)
"""The types that are numbered, acknowledged and sent again until they arrive."""


def read_message(frame: Frame) -> Message:
    """The message in a frame; RemoteError where its type or content is unknown."""
    message = MESSAGES.get(_known(MessageType, frame.kind))
    if message is None:
        raise RemoteError(f"{MessageType(frame.kind).name} carries no message")
    return message.unpack(frame.payload)


def schema_text() -> str:
    """The layouts of all messages in one line each; its CRC is the schema's hash."""
    lines = [f"{int(kind):02x} {message.LAYOUT.format}" for kind, message in MESSAGES.items()]
    return "\n".join([*lines, f"waypoint {Waypoint.LAYOUT.format}"])


SCHEMA_HASH: Final = crc32c(schema_text().encode())
"""Both ends must have the same; a robot with another is refused with a sentence."""

ESTOP_FRAME: Final = encode_frame(Frame(MessageType.ESTOP, 0), Sender.HOST)
"""Constant and without a session: 15 bytes that a robot can match in its interrupt."""
