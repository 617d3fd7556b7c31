"""State of the link and the robot at one moment, read off the host's end of the line. Seconds."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Final

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.counters import HostCounters
from firmware_protocol.host.state import LinkState
from firmware_protocol.wire.framing import ParserCounters
from firmware_protocol.wire.messages import (
    STOP_SENTENCES,
    RobotState,
    Status,
    StatusFlag,
    StopReason,
)


@dataclass(frozen=True, slots=True)
class LinkSnapshot:
    """State of link and robot; ages are those at the time of the snapshot.

    ``down_reason`` is None while the link is up, else a plain sentence. ``status`` is the robot's
    last report, None before the first. ``mission_id`` (None if it holds none), ``accepted``,
    ``executed`` and ``mission_done`` are the robot's. ``moving`` is True in RUN and until the robot
    is at rest after it. ``no_permit`` says why the robot cannot be given a lease, None if it can;
    ``standing_reason`` says why the robot is not running, None while it is in RUN.
    ``leaving_estop``: the robot was ordered out of its emergency stop and has not answered; its
    report is the old stop. ``clock_offset_s`` is the robot's clock minus the host's, wrong by at
    most ``clock_error_s``; with it ``status_taken_s`` is when the robot took ``status``, in host
    seconds. All three are None before the clock is known. ``fault`` says why a robot is in its
    emergency stop or, behind a driver, what is wrong with it, and ``remark`` what people should
    know although it drives. ``stands``: True if a robot behind a driver reports rest; None for our
    own firmware, which reports it in ``status``.
    """

    state: LinkState
    down_reason: str | None
    heard_age_s: float
    status: Status | None = None
    status_age_s: float = math.inf
    mission_id: int | None = None
    accepted: int = 0
    executed: int = 0
    mission_done: bool = False
    running: bool = False
    moving: bool = False
    estopped: bool = False
    estop_pending: bool = False
    leaving_estop: bool = False
    disarmed: bool = False
    stands: bool | None = None
    no_permit: str | None = None
    standing_reason: str | None = None
    rtt_s: float | None = None
    clock_offset_s: float | None = None
    clock_error_s: float | None = None
    fault: str | None = None
    remark: str = ""
    status_taken_s: float | None = None
    sent: HostCounters = field(default_factory=HostCounters)
    received: ParserCounters = field(default_factory=ParserCounters)


FRESH_S: Final = 0.5
"""Age from which a report, one of 20 a second, is not known of now."""


def is_at_rest(snapshot: LinkSnapshot) -> bool:
    """True if the robot is known to be at rest now."""
    if snapshot.stands is not None:
        return snapshot.stands
    fresh = snapshot.down_reason is None and snapshot.status_age_s <= FRESH_S
    return fresh and not snapshot.moving


def doubt_of_stop(snapshot: LinkSnapshot) -> str | None:
    """Doubt about an emergency stop that was sent; None if the robot is known to be at rest."""
    confirmed = snapshot.estopped and not snapshot.leaving_estop
    why = snapshot.down_reason
    # without a driver's process the daemon itself has the robot, and keeps the stop
    kept = confirmed or (snapshot.stands is not None and why is not None)
    if kept and is_at_rest(snapshot):
        return None
    if why is None:
        why = "it has not been heard to stand" if confirmed else "it has not confirmed the stop"
    return f"the emergency stop was sent, and it is not known yet that the robot is at rest: {why}"


def snapshot_of(
    host: HostConnection, now_s: float, *, port_fault: str, estop_waits: bool
) -> LinkSnapshot:
    """Present state.

    ``port_fault`` is the reason while the port is closed; ``estop_waits``: the host's end does not
    know yet of an emergency stop that was ordered.
    """
    reason = host.why_down(now_s)
    if host.state is LinkState.CLOSED:
        reason = port_fault
    known = host.clock.ready
    of_link = LinkSnapshot(
        state=host.state,
        down_reason=reason,
        heard_age_s=now_s - host.heard_s,
        rtt_s=host.rtt.smoothed_s if host.rtt.samples else None,
        clock_offset_s=host.clock.offset_s(now_s) if known else None,
        clock_error_s=host.clock.error_s(now_s) if known else None,
        sent=replace(host.counters),
        received=replace(host.parser.counters),
        estop_pending=host.estop_pending or estop_waits,
        leaving_estop=host.leaving_estop,
    )
    status = host.status
    if status is None:
        return of_link
    no_permit = host.why_no_permit(now_s) if host.state.is_up else None
    running = status.state is RobotState.RUN
    return replace(
        of_link,
        status=status,
        status_age_s=now_s - host.status_s,
        status_taken_s=host.clock.host_s(status.time_us, host.status_s) if known else None,
        mission_id=status.mission or None,
        accepted=status.accept_next,
        executed=status.exec_next,
        mission_done=bool(status.flags & StatusFlag.MISSION_DONE),
        running=running,
        moving=running or bool(status.flags & StatusFlag.MOVING),
        estopped=status.state is RobotState.ESTOP,
        disarmed=status.reason is StopReason.DISARMED,
        fault=STOP_SENTENCES[status.reason] if status.state is RobotState.ESTOP else None,
        no_permit=no_permit,
        standing_reason=None if running else no_permit or STOP_SENTENCES[status.reason],
    )
