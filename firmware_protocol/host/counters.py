"""Counters of the host's end."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class HostCounters:
    """Counts of the host's end, beside the parser's."""

    frames_sent: int = 0
    bytes_sent: int = 0
    sessions: int = 0
    links_lost: int = 0
    taken_back: int = 0
    """Times that another host had the robot and fell silent."""
    stray_hellos: int = 0
    """Answers of the robot to HELLOs that were none of ours."""
    clock_jumps: int = 0
    reboots: int = 0
    naks: int = 0
    retransmits: int = 0
    timeouts: int = 0
    foreign_session: int = 0
    late_session: int = 0
    nonsense: int = 0
    stale: int = 0
    """Leases and poses that were too old to be sent."""
