"""Counters of the host's end of the link."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class HostCounters:
    """Counts of the host's end, beside the parser's own counters."""

    frames_sent: int = 0
    bytes_sent: int = 0
    sessions: int = 0
    links_lost: int = 0
    taken_back: int = 0
    """Number of times that another host had the robot and fell silent."""
    stray_hellos: int = 0
    """Number of answers of the robot to a HELLO that was none of ours."""
    clock_jumps: int = 0
    reboots: int = 0
    naks: int = 0
    retransmits: int = 0
    timeouts: int = 0
    foreign_session: int = 0
    late_session: int = 0
    nonsense: int = 0
    stale: int = 0
    """Leases and poses that had become too old before they could be sent."""
