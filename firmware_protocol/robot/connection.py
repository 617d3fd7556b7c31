"""The robot's end of the link, sans-IO: bytes in, decisions through the controller, bytes out.

- ``receive_bytes`` takes what has arrived; ``next_frame`` hands out one frame at a time, by
  urgency, so that a board needs one transmit buffer and nothing waits behind a queue.
- HELLO asks for a session; it opens when the host has given the CHALLENGE's number back. Until
  then the present session goes on: a stray HELLO changes nothing, and a recording opens nothing.
- A frame counts only in the present session; HELLO, CONFIRM and ESTOP need none.
- What is told is the present state: nothing is lost if a frame is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from firmware_protocol.robot.controller import QUEUE_SIZE, RobotController
from firmware_protocol.wire.crc import crc32c
from firmware_protocol.wire.errors import RemoteError
from firmware_protocol.wire.framing import (
    MAX_PAYLOAD,
    VERSION,
    Frame,
    FrameParser,
    Sender,
    encode_frame,
)
from firmware_protocol.wire.link import NAK_INTERVAL_S, Arrival, ReceiveSequence
from firmware_protocol.wire.messages import (
    MINOR_VERSION,
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
    Message,
    MessageType,
    Pause,
    PoseFix,
    ResetCause,
    ResetEstop,
    RobotCounters,
    Start,
    Status,
    TimeSync,
    TimeSyncReply,
    Waypoints,
    read_message,
)

RX_WINDOW: Final = 248
"""Two full frames of waypoints, and less than a receive ring of 256 bytes."""
STATUS_INTERVAL_S: Final = 0.05
STATUS_SPACING_S: Final = 0.01
"""A change is told at once, but no more often than this; a stop is told without waiting."""


@dataclass(frozen=True, slots=True)
class Identity:
    """Who the robot is; ``boot_id`` differs from boot to boot."""

    boot_id: int
    firmware: int = 0
    reset_cause: ResetCause = ResetCause.POWER_ON
    schema: int = SCHEMA_HASH


class RobotConnection:
    """Parses the host's bytes for a controller and reports its state."""

    def __init__(self, identity: Identity, controller: RobotController) -> None:
        self.identity = identity
        self.controller = controller
        self.parser = FrameParser(Sender.HOST)
        self.session: int | None = None
        self.session_errors = 0
        self.gaps = 0
        self.duplicates = 0
        self.rejected = 0
        self.overruns = 0
        self._asked: int | None = None
        """The session that a host has asked for and not yet confirmed."""
        self._nonce = identity.boot_id
        """What the host has to give back for it; made from boot and clocks, one after another."""
        self._challenge_due = False
        self._sequence = ReceiveSequence()
        self._command = 0
        self._result = CommandResult.NONE
        self._hello_session: int | None = None
        self._ack_due = False
        self._nak_due = False
        self._nak_s = -math.inf
        self._sync: tuple[int, int] | None = None
        self._status_s = -math.inf

    # Bytes in.

    def receive_bytes(self, data: bytes, now_s: float) -> None:
        """Take bytes from the line, in any portion, and act on the frames in them."""
        self.controller.tick(now_s)
        start = 0
        while (end := data.find(0, start) + 1) > 0:
            self._take(data[start:end], now_s)
            start = end
        self._take(data[start:], now_s)

    def _take(self, data: bytes, now_s: float) -> None:
        """Take bytes that end at most one frame."""
        faults = self.parser.counters.faults
        frames = self.parser.feed(data)
        if self.parser.counters.faults != faults and self.session is not None:
            # something was damaged: ask at once, do not wait for the host's timeout
            self._nak_due = True
        for frame in frames:
            self._receive(frame, now_s)

    def _receive(self, frame: Frame, now_s: float) -> None:
        if frame.kind == MessageType.ESTOP:
            self.controller.emergency_stop()
            return
        if frame.session == 0:
            self.session_errors += 1
            return
        if frame.kind == MessageType.HELLO:
            self._greet(frame, now_s)
            return
        if frame.kind == MessageType.CONFIRM:
            self._confirm(frame, now_s)
            return
        if frame.session != self.session:
            self.session_errors += 1
            return
        try:
            message = _read_from_host(frame)
        except RemoteError:
            self.rejected += 1
            if frame.reliable and self._sequence.judge(frame.sequence) is Arrival.NEXT:
                # a whole frame of nonsense will not get better by being sent again
                self._sequence.take()
                self._ack_due = True
            return
        if frame.reliable != (message.TYPE in RELIABLE):
            self.rejected += 1
        elif frame.reliable:
            self._receive_reliable(frame, message, now_s)
        elif not self._act(message, now_s):
            self.rejected += 1

    def _greet(self, frame: Frame, now_s: float) -> None:
        try:
            hello = Hello.unpack(frame.payload)
        except RemoteError:
            self.rejected += 1
            return
        self._hello_session = frame.session
        same = hello.major == VERSION and hello.schema == self.identity.schema
        if frame.session == self.session or not same:
            return
        self._challenge_due = True
        if frame.session != self._asked:
            self._asked = frame.session
            self._nonce = crc32c(_clock_us(now_s).to_bytes(4, "little"), self._nonce)

    def _confirm(self, frame: Frame, now_s: float) -> None:
        if frame.session != self._asked or frame.payload != Confirm(self._nonce).pack():
            self.session_errors += 1
            return
        self.controller.open_session(now_s)
        self.session, self._asked = frame.session, None
        self._challenge_due = False
        self._sequence = ReceiveSequence()
        self._command, self._result = 0, CommandResult.NONE
        self._ack_due = self._nak_due = False
        self._sync = None
        self._status_s = -math.inf

    def _receive_reliable(self, frame: Frame, message: Message, now_s: float) -> None:
        self._ack_due = True
        arrival = self._sequence.judge(frame.sequence)
        if arrival is Arrival.DUPLICATE:
            self.duplicates += 1
        elif arrival is Arrival.GAP:
            self.gaps += 1
            self._nak_due = True
        elif self._act(message, now_s):
            self._sequence.take()
        else:
            self.rejected += 1

    def _act(self, message: Message, now_s: float) -> bool:
        """Do what a message says; False where it cannot be taken now."""
        control = self.controller
        match message:
            case Waypoints():
                return control.accept(message)
            case Start(command, mission, exec_next):
                self._answer(command, control.start(mission, exec_next, now_s))
            case Pause(command):
                self._answer(command, control.pause())
            case Clear(command, mission):
                self._answer(command, control.clear(mission))
            case ResetEstop(command):
                self._answer(command, control.reset_estop())
            case Lease():
                self._ack_due = True  # a short sign of life where noise eats the long STATUS
                return control.lease(message, now_s)
            case PoseFix():
                return control.pose_fix(message, now_s)
            case TimeSync(host_sent_us):
                self._sync = (host_sent_us, _clock_us(now_s))
            case _:  # HELLO was answered before; the others come from robots only
                raise RemoteError(f"{message.TYPE.name} does not come from a host")
        return True

    def _answer(self, command: int, result: CommandResult) -> None:
        self._command, self._result = command, result
        self.controller.news = True

    # Bytes out.

    def next_frame(self, now_s: float) -> bytes:
        """The most urgent frame that is due, empty where none is; call when the line is free."""
        self.controller.tick(now_s)
        if self._hello_session is not None:
            session, self._hello_session = self._hello_session, None
            return self._frame(self._hello_ack(), session)
        if self._challenge_due:
            self._challenge_due = False
            return self._frame(Challenge(self._nonce), self._asked)
        if self.session is None:
            return b""
        if self._nak_due and now_s - self._nak_s >= NAK_INTERVAL_S:
            self._nak_s = now_s
            self._nak_due = self._ack_due = False
            return self._frame(Ack(self.controller.accept_next), nak=True)
        if self._ack_due:
            self._ack_due = False
            return self._frame(Ack(self.controller.accept_next))
        if self._sync is not None:
            sent_us, received_us = self._sync
            self._sync = None
            return self._frame(TimeSyncReply(sent_us, received_us, _clock_us(now_s)))
        if self._status_due(now_s):
            self._status_s = now_s
            self.controller.news = self.controller.alarm = False
            return self._frame(self.status(now_s))
        return b""

    def _status_due(self, now_s: float) -> bool:
        waited_s = now_s - self._status_s
        if waited_s >= STATUS_INTERVAL_S or self.controller.alarm:
            return True
        return waited_s >= STATUS_SPACING_S and self.controller.news

    def status(self, now_s: float) -> Status:
        """The robot's present state."""
        control, count = self.controller, self.parser.counters
        pose = control.estimate.pose
        return Status(
            time_us=_clock_us(now_s),
            boot_id=self.identity.boot_id,
            mission=control.mission,
            accept_next=control.accept_next,
            exec_next=control.exec_next,
            prefix_crc=control.prefix_crc,
            exec_crc=control.exec_crc,
            state=control.state,
            flags=control.status_flags(now_s),
            reason=control.reason,
            result=self._result,
            command=self._command,
            x_m=pose.x_m,
            y_m=pose.y_m,
            heading_rad=pose.heading_rad,
            speed_m_s=control.speed_m_s,
            turn_rad_s=control.turn_rad_s,
            pose_age_s=control.pose_age_s(now_s),
            lease_left_s=control.lease_left_s(now_s),
            counters=RobotCounters(
                frames=count.frames,
                crc_errors=count.crc_errors + count.echoes,
                format_errors=count.faults - count.crc_errors - count.echoes,
                overruns=self.overruns,
                session_errors=self.session_errors,
                gaps=self.gaps,
                duplicates=self.duplicates,
                rejected=self.rejected,
            ),
        )

    def _hello_ack(self) -> HelloAck:
        control = self.controller
        return HelloAck(
            major=VERSION,
            minor=MINOR_VERSION,
            schema=self.identity.schema,
            firmware=self.identity.firmware,
            boot_id=self.identity.boot_id,
            reset_cause=self.identity.reset_cause,
            max_payload=MAX_PAYLOAD,
            rx_window=RX_WINDOW,
            queue_size=QUEUE_SIZE,
            state=control.state,
            mission=control.mission,
            accept_next=control.accept_next,
            exec_next=control.exec_next,
            prefix_crc=control.prefix_crc,
            exec_crc=control.exec_crc,
        )

    def _frame(
        self,
        message: HelloAck | Challenge | Ack | TimeSyncReply | Status,
        session: int | None = None,
        nak: bool = False,
    ) -> bytes:
        frame = Frame(
            kind=message.TYPE,
            session=self.session or 0 if session is None else session,
            payload=message.pack(),
            acknowledged=self._sequence.expected,
            credit=self.controller.credit,
            nak=nak,
        )
        return encode_frame(frame, Sender.ROBOT)


def _read_from_host(frame: Frame) -> Message:
    if frame.kind >= MessageType.HELLO_ACK:
        raise RemoteError(f"message type {frame.kind:#04x} does not come from a host")
    return read_message(frame)


def _clock_us(now_s: float) -> int:
    return round(now_s * 1e6) & 0xFFFFFFFF
