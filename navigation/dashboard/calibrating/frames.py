"""A run's pictures as a separate camera: lent, not taken away.

The run keeps its camera open and keeps looking: nothing is opened twice, and a failing camera fails
as in any run.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from vision.camera.camera import Clock, Frame, RateMeter, SourceState

LOOK_EVERY_S: Final = 0.005


class LentFrames:
    """The newest frames of a run; `vision.camera.camera.Camera` documents the members.

    ``newest`` gives the run's last frame; ``clock`` monotonic seconds, ``wait`` lets them pass.
    """

    name = "the run's camera"
    reason = ""
    may_repeat = False

    def __init__(
        self, newest: Callable[[], Frame | None], clock: Clock, wait: Callable[[float], None]
    ) -> None:
        self._newest, self._clock, self._wait = newest, clock, wait
        self._last: Frame | None = None
        self._meter = RateMeter()
        self.state: SourceState = "closed"

    @property
    def rate_hz(self) -> float:
        """Recent frames a second."""
        return self._meter.rate_hz

    def open(self) -> None:
        """Start with the next frame."""
        self._last = self._newest()
        self.state = "running"

    def read(self, timeout_s: float) -> Frame | None:
        """The next frame, None if none came in time."""
        until_s = self._clock() + timeout_s
        while self._clock() < until_s:
            frame = self._newest()
            if frame is not None and frame is not self._last:
                self._last = frame
                self._meter.add(frame.captured_s)
                return frame
            self._wait(LOOK_EVERY_S)
        return None

    def close(self) -> None:
        """The run keeps its camera."""
        self.state = "closed"
