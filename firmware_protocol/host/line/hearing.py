"""Evidence that the robot hears what it is sent, from the counts in its reports.

With one broken wire, the robot reports but obeys nothing: the number of frames taken in STATUS
stays the same although frames are sent. Seconds of the host's monotonic clock.
"""

from __future__ import annotations

from typing import Final

from firmware_protocol.wire.messages import RobotCounters

DEAF_S: Final = 1.0
"""The lease ends after half of it: the robot is at rest when this is reported."""
DEAF_FRAMES: Final = 8
"""A line that loses one frame in two loses this many in a row once in 256 times."""


class Hearing:
    """Tracker of the robot's count."""

    def __init__(self) -> None:
        self.why_deaf: str | None = None
        """A sentence if the robot does not hear, else None."""
        self._counts: RobotCounters | None = None
        self._heard_s = 0.0
        self._sent = 0

    def begin(self, now_s: float) -> None:
        """Begin with a robot that has answered."""
        self._counts, self._heard_s, self._sent = None, now_s, 0
        self.why_deaf = None

    def sent(self) -> None:
        """Count one frame sent."""
        self._sent += 1

    def report(self, counts: RobotCounters, now_s: float) -> None:
        """Take the robot's newest count of frames."""
        if self._counts is None or counts.frames != self._counts.frames:
            self._counts, self._heard_s, self._sent = counts, now_s, 0
            self.why_deaf = None
        elif now_s - self._heard_s > DEAF_S and self._sent >= DEAF_FRAMES:
            self.why_deaf = _in_words(_damaged(counts) - _damaged(self._counts))


def _damaged(counts: RobotCounters) -> int:
    return counts.crc_errors + counts.format_errors + counts.overruns


def _in_words(damaged: int) -> str:
    if damaged > 0:
        return (
            "the robot does not understand what it is sent: its reports come, and what reaches it "
            "is damaged: check the wire from the computer to the robot (TX) and its ground"
        )
    return (
        "the robot does not hear what it is sent: its reports come, but acknowledge nothing: "
        "check the wire from the computer to the robot (TX)"
    )
