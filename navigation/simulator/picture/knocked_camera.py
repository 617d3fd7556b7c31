"""A simulated camera that is knocked: one that hangs otherwise takes its place.

Knocks are known beforehand from the configuration. Each place that the camera ever has is a
camera of its own, drawn before the run; the clock says which of them gives the next picture.
Seconds of the clock.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from navigation.simulator.picture.timed_camera import TimedCamera
from vision.camera.camera import Frame, SourceState


@dataclass(frozen=True, slots=True)
class Knock:
    """From when until when, in the clock's seconds, which camera shows the arena."""

    from_s: float
    until_s: float
    camera: TimedCamera[Any]


class KnockedCamera:
    """Several cameras as one; `vision.camera.camera.Camera` says what its members mean."""

    name = TimedCamera.name

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
    def reason(self) -> str:
        """Nothing to say."""
        return self._present.reason

    @property
    def rate_hz(self) -> float:
        """Frames a second really got lately; 0.0 before the second frame, and after a knock."""
        return self._present.rate_hz

    @property
    def may_repeat(self) -> bool:
        """As of the unknocked camera."""
        return self._unknocked.may_repeat

    @property
    def late_since_s(self) -> float:
        """As of the camera that shows the arena now."""
        return self._present.late_since_s

    def open(self) -> None:
        """Start giving frames."""
        self._present = self._now()
        self._present.open()

    def close(self) -> None:
        """Stop; it can be opened again."""
        self._present.close()

    def read(self, timeout_s: float) -> Frame | None:
        """The next frame at its time; None where that is later than ``timeout_s`` from now."""
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
        """The last of the knocks that are in force."""
        now_s = self._clock()
        for knock in reversed(self._knocks):
            if knock.from_s <= now_s < knock.until_s:
                return knock.camera
        return self._unknocked
