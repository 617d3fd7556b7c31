"""The host's end of the link, sans-IO: bytes in, events out, one frame at a time out.

- ``receive_bytes`` and ``tick`` take the time; ``next_event`` returns events; ``bytes_to_send``
  returns at most one frame, paced to the baud rate, so that no queue delays an emergency stop.
- Orders (``upload``, ``start``, ``pause``, ``clear``, ``reset_estop``) are wishes, sent until
  STATUS confirms them. Lease and pose are sent once; a newer one replaces an unsent one.
- After a lost link the robot is at rest and drives again only on a new ``start``.
- Seconds of the host's monotonic clock; metres and radians.
"""

from __future__ import annotations

import math
import random
from collections import deque
from typing import Final

from firmware_protocol.host.counters import HostCounters
from firmware_protocol.host.events import (
    EstopConfirmed,
    Event,
    LinkChanged,
    RobotRebooted,
    StatusReceived,
    StrayHello,
)
from firmware_protocol.host.line.clock_sync import ClockEstimate
from firmware_protocol.host.line.diagnosis import TAKEN_OVER, why_refused, why_silent
from firmware_protocol.host.line.hearing import Hearing
from firmware_protocol.host.line.send_window import RttEstimate, SendWindow
from firmware_protocol.host.outgoing import Outgoing
from firmware_protocol.host.sessions import HostSessions
from firmware_protocol.host.state import LinkEvent, LinkState, state_after
from firmware_protocol.host.upload import Upload
from firmware_protocol.host.wanted_mission import WantedMission
from firmware_protocol.wire.errors import LocalError, RemoteError
from firmware_protocol.wire.framing import FrameParser, Sender, WireFrame
from firmware_protocol.wire.messages import (
    SCHEMA_HASH,
    Ack,
    Challenge,
    HelloAck,
    Lease,
    LeaseFlag,
    PoseFix,
    RobotState,
    Status,
    TimeSyncReply,
    read_message,
)
from firmware_protocol.wire.mission import Mission

SILENCE_S: Final = 0.5
"""Silence of the session after which the link is lost."""
TICK_S: Final = 0.02
"""Longest time between two looks at the timeouts."""
CLOSED_TICK_S: Final = 0.1
EARLY_S: Final = 1e-6
"""A look so much too early costs nothing; rounding must not make one late."""
REFUSED_S: Final = 8.0
"""Time for which a refusal is believed: two requests may get lost."""


class HostConnection:
    """One robot on one line.

    ``rng`` gives session numbers; ``baud`` paces the output, if not None.
    """

    def __init__(self, rng: random.Random, baud: int | None = 115_200) -> None:
        self.state = LinkState.CLOSED
        self.parser = FrameParser(Sender.ROBOT)
        self.counters = HostCounters()
        self.rtt = RttEstimate()
        self.robot: HelloAck | None = None
        self.status: Status | None = None
        self.status_s = -math.inf
        self._boot_id: int | None = None
        self._events: deque[Event] = deque()
        self._mission = WantedMission(self._events.append, self._change)
        self._sessions = HostSessions(rng)
        self._out = Outgoing(self._sessions, self.counters, baud)
        self._hearing = Hearing()
        self._reason = "the port is not open"
        self._opened_s = 0.0
        self.heard_s = -math.inf
        """Time of the session's last frame."""
        self._bytes_s = -math.inf
        self._refused_s = -math.inf
        self._taken = False
        """True if another host had the robot when the link was lost."""

    def open(self, now_s: float) -> None:
        """Ask for a robot on the open port. LocalError if it was open already."""
        self._change(LinkEvent.OPEN, "looking for a robot")
        self._opened_s = now_s
        self._out.pace.reset()
        self._new_session(now_s)

    def close(self, reason: str = "the port was closed") -> None:
        """End the link with its port; orders in flight are given up."""
        self._drop_session()
        self._change(LinkEvent.CLOSE, reason)
        self._reason = reason

    def upload(
        self, mission: Mission, now_s: float, start: bool = True, released: int | None = None
    ) -> None:
        """Replace the mission: stop under control, clear, send, and (``start``) drive.

        A mission that the robot already holds continues. LocalError for the id of a void mission:
        part of it may have been driven. ``released``: number of waypoints sent before
        :meth:`release`; None: all.
        """
        upload = self._mission.give(mission)
        if released is not None:
            upload.hold_back(released)
        self._out.commands.want_mission()
        self._change(LinkEvent.MISSION_OVER, "a mission was given")
        if self.status is not None and self.state is LinkState.STREAM:
            void = upload.see_status(self.status, 0, False)
            if void is not None:
                self._void(void)
                return
        if start:
            self.start(now_s)

    def release(self, mission_id: int, count: int) -> None:
        """Release the first ``count`` waypoints, if this is still the mission."""
        if self.upload_state is not None and self.upload_state.mission.id == mission_id:
            self.upload_state.release(count)

    def start(self, now_s: float) -> None:
        """Drive the mission; LocalError without one."""
        if self.upload_state is None:
            raise LocalError("start: there is no mission")
        self._out.commands.want_start(now_s)

    def pause(self) -> None:
        """Stop under control, mission kept."""
        self._out.commands.want_pause()

    def clear(self) -> None:
        """Stop under control, mission forgotten."""
        self._mission.upload = None
        self._out.commands.want_clear()
        self._change(LinkEvent.MISSION_OVER, "the mission was cleared")

    def lease(
        self,
        now_s: float,
        ttl_s: float,
        permit: bool,
        pose_age_s: float = math.inf,
        odometry: bool = False,
    ) -> None:
        """Send a lease once: the control loop lived at ``now_s``. ``odometry``: may drive without
        poses.

        It expires ``ttl_s`` later by the robot's clock.
        """
        flags = LeaseFlag(LeaseFlag.PERMIT * permit | LeaseFlag.ODOMETRY * odometry)
        self._out.freshest.give_lease(Lease(ttl_s, flags, pose_age_s), now_s)

    def pose_fix(self, x_m: float, y_m: float, heading_rad: float, captured_s: float) -> None:
        """Send once the camera's pose of the robot at host time ``captured_s``."""
        self._out.freshest.give_pose(PoseFix(x_m, y_m, heading_rad), captured_s)

    def estop(self) -> None:
        """Send the emergency stop, past every queue, until the robot confirms it."""
        self._out.want_estop()

    def reset_estop(self, now_s: float) -> None:
        """Leave the emergency stop, in a fresh session; the mission is void."""
        self._out.estop_wanted = False
        self._out.commands.reset_wanted = True
        if self.state.is_up:
            self._drop_session()
            self._change(LinkEvent.RENEW, "a fresh session, to leave the emergency stop")
            self._new_session(now_s)

    @property
    def upload_state(self) -> Upload | None:
        """Progress of the robot's mission; None without one."""
        return self._mission.upload

    def next_event(self) -> Event | None:
        """Return the oldest unread event, or None."""
        return self._events.popleft() if self._events else None

    @property
    def estop_pending(self) -> bool:
        """True if an emergency stop awaits confirmation."""
        return self._out.estop_wanted

    @property
    def leaving_estop(self) -> bool:
        """True if the robot is to leave its emergency stop and has not answered.

        Until then reports mean the old stop.
        """
        return self._out.commands.reset_wanted

    def why_no_permit(self, now_s: float) -> str | None:
        """Reason why no lease can be given; None if one can."""
        return self._out.clock.why_unknown(now_s)

    @property
    def clock(self) -> ClockEstimate:
        """Estimate of the robot's clock."""
        return self._out.clock.estimate

    @property
    def pose_captured_s(self) -> float:
        """Capture time of the last pose sent."""
        return self._out.freshest.pose_captured_s

    def why_down(self, now_s: float) -> str | None:
        """Reason why no order can be given, if any."""
        if self.state.is_up:
            return self._hearing.why_deaf
        if self.state in (LinkState.CLOSED, LinkState.REFUSED):
            return self._reason
        if self.state is LinkState.LINK_LOST and self._sessions.foreigner_speaks(now_s):
            return TAKEN_OVER
        since_s = now_s - max(self._bytes_s, self._opened_s)
        silent = now_s - self._bytes_s > SILENCE_S
        return why_silent(self.parser.counters, since_s if silent else None)

    def receive_bytes(self, data: bytes, now_s: float) -> None:
        """Take arrived bytes, in any portion."""
        if data:
            self._bytes_s = now_s
        for frame in self.parser.feed(data):
            self._receive(frame, now_s)

    def _receive(self, frame: WireFrame, now_s: float) -> None:
        if self.state is LinkState.CLOSED:
            return
        if frame.session != self._sessions.present:
            if self._sessions.is_late(frame, now_s):
                self.counters.late_session += 1
            else:
                self._meet_a_stranger(frame, now_s)
            return
        try:
            message = read_message(frame)
        except RemoteError:
            self.counters.nonsense += 1
            return
        if isinstance(message, HelloAck):
            self._greeted(message, now_s)
            return
        if self.state.is_asking:
            return
        self.heard_s = now_s
        self._out.window.acknowledge(frame.acknowledged, now_s)
        if frame.nak:
            self.counters.naks += 1
            self._out.window.complained(now_s)
        match message:
            case Challenge(nonce):
                self._out.nonce = nonce if self.state is LinkState.VERIFY else None
            case Ack(accept_next):
                if self.upload_state is not None:
                    self.upload_state.see_ack(accept_next, frame.credit)
            case Status():
                self._take_status(message, frame, now_s)
            case TimeSyncReply():
                self._out.clock.take(message, now_s)
                self.counters.clock_jumps = self._out.clock.jumps
            case _:
                self.counters.nonsense += 1

    def _meet_a_stranger(self, frame: WireFrame, now_s: float) -> None:
        self.counters.foreign_session += 1
        self.counters.stray_hellos = self._sessions.stray_hellos
        if self._sessions.stray_is_news(now_s):
            self._events.append(StrayHello(frame.session))

    def _greeted(self, hello: HelloAck, now_s: float) -> None:
        if not self.state.is_asking:
            return
        self.robot = hello
        why = why_refused(hello.major, hello.schema, SCHEMA_HASH)
        if why is not None:
            self._refused_s, self._reason = now_s, why
            self._change(LinkEvent.REFUSED, why)
            self._sessions.wait_long(now_s)
            return
        self._out.nonce = None
        self._out.window = SendWindow(hello.rx_window)
        self._out.window.rtt = self.rtt
        self.heard_s = now_s
        self._hearing.begin(now_s)
        self.counters.taken_back += self._taken
        back = "the other host has fallen silent: the robot is taken back"
        self._change(LinkEvent.GREETED, back if self._taken else "a robot has answered")
        self._taken = False

    def _take_status(self, status: Status, frame: WireFrame, now_s: float) -> None:
        self.status, self.status_s = status, now_s
        self._hearing.report(status.counters, now_s)
        if self.state is LinkState.VERIFY:
            self._verify(status)
        self._out.clock.compare(status, now_s)
        if status.state is RobotState.ESTOP and self._out.estop_wanted:
            self._out.estop_wanted = False
            self._events.append(EstopConfirmed())
        if self.upload_state is not None and self.state is not LinkState.REBOOTED:
            self._follow_mission(self.upload_state, status, frame)
        ended = self._out.commands.settle(status, now_s)
        if ended is not None:
            self._events.append(ended)
        self._events.append(StatusReceived(status, now_s))

    def _verify(self, status: Status) -> None:
        known, self._boot_id = self._boot_id, status.boot_id
        if known is None or known == status.boot_id:
            self._change(LinkEvent.VERIFIED, "the link is up")
            return
        self.counters.reboots += 1
        assert self.robot is not None
        self._out.clock.new_boot()
        self._out.commands.reset_wanted = False  # it has not kept its emergency stop
        self._change(LinkEvent.REBOOT, "the robot has rebooted: its mission is gone")
        self._events.append(RobotRebooted(status.boot_id, self.robot.reset_cause))
        if self.upload_state is not None:
            self._void("the robot has rebooted")

    def _follow_mission(self, upload: Upload, status: Status, frame: WireFrame) -> None:
        if status.state is RobotState.ESTOP:
            self._void("the robot is in its emergency stop")
            return
        window = self._out.window
        everything = window.idle and frame.acknowledged == window.next_sequence
        void = self._mission.follow(upload, status, frame.credit, everything)
        if void is not None:
            self._void(void)
            self._out.commands.want_pause()

    def _void(self, reason: str) -> None:
        self._mission.void(reason)
        self._out.commands.want_no_start()
        if self.state is LinkState.DRAIN:
            self._change(LinkEvent.MISSION_OVER, reason)

    def tick(self, now_s: float) -> None:
        """Handle timeouts: call at least every ``TICK_S``, and before :meth:`bytes_to_send`."""
        if self.state.is_asking or self.state is LinkState.CLOSED:
            if self.state is LinkState.REFUSED and now_s - self._refused_s > REFUSED_S:
                self._change(LinkEvent.SILENCE, f"no answer for {REFUSED_S:g} s")
            return
        if now_s - self.heard_s > SILENCE_S:
            self.counters.links_lost += 1
            silent_s = now_s - self.heard_s
            self._drop_session()
            self._taken = self._sessions.foreigner_speaks(now_s)
            why = TAKEN_OVER if self._taken else f"no frame for {silent_s:.2f} s"
            self._change(LinkEvent.SILENCE, why)
            self._new_session(now_s)
            return
        self._out.window.tick(now_s)

    def bytes_to_send(self, now_s: float) -> bytes:
        """At most one frame; empty if none is due or the line is busy."""
        if self.state is LinkState.CLOSED:
            return b""
        data = self._out.next_bytes(self.state, self.status, self.upload_state, now_s)
        if data:
            self._hearing.sent()
        return data

    def deadline_s(self, now_s: float) -> float:
        """Time to call :meth:`tick` and :meth:`bytes_to_send` again, at most ``TICK_S`` away.

        Until then nothing is due if nothing arrives, no order is given, and nothing was due now.
        """
        if self.state is LinkState.CLOSED:
            return now_s + CLOSED_TICK_S
        times_s = self._out.due_times_s(self.state, now_s)
        soon_s = (t for t in times_s if t > now_s - EARLY_S)
        return max(now_s, min(now_s + TICK_S, self._timeout_s, *soon_s) - EARLY_S)

    @property
    def _timeout_s(self) -> float:
        if self.state is LinkState.REFUSED:
            return self._refused_s + REFUSED_S
        if self.state.is_asking:
            return math.inf
        return min(self.heard_s + SILENCE_S, self._out.window.deadline_s())

    def _new_session(self, now_s: float) -> None:
        self._sessions.renew(now_s)
        self.counters.sessions += 1

    def _drop_session(self) -> None:
        ended = self._out.commands.give_up()
        if ended is not None:
            self._events.append(ended)
        self._out.drop_session()
        self.heard_s = -math.inf
        if self.upload_state is not None:
            self.upload_state.new_session()

    def _change(self, event: LinkEvent, reason: str) -> None:
        old = self.state
        self.state = new = state_after(old, event)
        if new is not old:
            self._events.append(LinkChanged(old, new, reason))
