"""A simulated camera that is knocked: another one with the new pose replaces it.

Each pose has a camera of its own, drawn before the run; the clock decides which one gives the next
picture. Seconds of the clock.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from navigation.simulator.picture.timed_camera import TimedCamera
from vision.camera.camera import Frame, SourceState


@dataclass(frozen=True, slots=True)
class Knock:
    """Interval, in the clock's seconds, in which a camera shows the arena."""

    from_s: float
    until_s: float
    camera: TimedCamera[Any]


class KnockedCamera:
    """Several cameras as one; `vision.camera.camera.Camera` describes the members."""

    name, reason = TimedCamera.name, TimedCamera.reason

    def __init__(
        self, camera: TimedCamera[Any], knocks: Sequence[Knock], clock: Callable[[], float]
    ) -> None:
        self._unknocked, self._knocks = camera, tuple(knocks)
        self._clock = clock
        self._present = camera
        self._sequence = 0

    @property
    def state(self) -> SourceState:
        """``closed`` or ``running``."""
        return self._present.state

    @property
    def rate_hz(self) -> float:
        """Measured frames a second; 0.0 before the second frame and after a knock."""
        return self._present.rate_hz

    @property
    def may_repeat(self) -> bool:
        """True if the unknocked camera may repeat pictures."""
        return self._unknocked.may_repeat

    @property
    def late_since_s(self) -> float:
        """Time since which the present camera is late."""
        return self._present.late_since_s

    def open(self) -> None:
        """Start giving frames."""
        self._present = self._now()
        self._present.open()

    def close(self) -> None:
        """Stop; it can be opened again."""
        self._present.close()

    def read(self, timeout_s: float) -> Frame | None:
        """Next frame at its time; None if that is over ``timeout_s`` away."""
        wanted = self._now()
        if wanted is not self._present and self._present.state == "running":
            wanted.continue_after(self._present)
            self._present = wanted
        frame = self._present.read(timeout_s)
        if frame is None:
            return None
        self._sequence += 1
        return replace(frame, sequence=self._sequence - 1)

    def _now(self) -> TimedCamera[Any]:
        """Return the camera after the last knock in force."""
        now_s = self._clock()
        for knock in reversed(self._knocks):
            if knock.from_s <= now_s < knock.until_s:
                return knock.camera
        return self._unknocked
