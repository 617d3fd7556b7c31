"""Times of a simulated camera: exposure and delivery of its pictures, in the clock's seconds."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Generic, TypeAlias, TypeVar

from vision.camera.camera import CameraError, Clock, Frame, Image, RateMeter, SourceState

Wait: TypeAlias = Callable[[float], None]
_Prepared = TypeVar("_Prepared")


class TimedCamera(ABC, Generic[_Prepared]):
    """Camera with a rate; `vision.camera.camera.Camera` describes the members.

    ``clock`` gives monotonic seconds and ``wait`` lets them pass: real ones in a run, the
    simulation's own in virtual time.
    """

    name = "simulated camera"
    reason = ""
    """It never fails."""

    def __init__(
        self, clock: Clock, wait: Wait, rate_hz: float, latency_s: float, *, may_repeat: bool
    ) -> None:
        self._clock, self._wait = clock, wait
        self._period_s, self._latency_s = 1.0 / rate_hz, latency_s
        self.may_repeat = may_repeat
        """True if eight bits do not show the noise: pictures are equal while nothing moves."""
        self._meter = RateMeter()
        self.state: SourceState = "closed"
        """``closed`` or ``running``."""
        self._next_s = 0.0
        self.late_since_s = math.inf
        """Exposure of the next picture, or of the one that its reader has in hand."""
        self._sequence = 0

    @property
    def rate_hz(self) -> float:
        """Measured frames a second; 0.0 before the second frame."""
        return self._meter.rate_hz

    def open(self) -> None:
        """Start giving frames."""
        self.state = "running"
        self._next_s = self._clock()

    def continue_after(self, other: TimedCamera[_Prepared]) -> None:
        """Start giving frames at the time of the other, closed camera's next one."""
        self.state, self._next_s = "running", other._next_s
        other.close()

    def close(self) -> None:
        """Stop; it can be opened again."""
        self.state = "closed"
        self.late_since_s = math.inf

    def read(self, timeout_s: float) -> Frame | None:
        """Next frame at its time; None if that is over ``timeout_s`` away.

        A late reader misses frames, as with a real camera.
        """
        if self.state != "running":
            raise CameraError(f"{self.name}: is not open")
        self.late_since_s = self._next_s
        delay_s = self._next_s - self._clock()
        if delay_s > timeout_s:
            self._wait(timeout_s)
            return None
        prepared = self._prepare()
        delay_s = self._next_s - self._clock()
        if delay_s > 0.0:
            self._wait(delay_s)
        self.late_since_s = captured_s = self._clock()
        late = max(0, int((captured_s - self._next_s) / self._period_s))
        self._next_s += (late + 1) * self._period_s
        image = self._expose(prepared, captured_s)
        if self._latency_s > 0.0:
            self._wait(max(0.0, captured_s + self._latency_s - self._clock()))
        self._meter.add(captured_s)
        self._sequence += 1
        return Frame(image, captured_s, self._sequence - 1, self.name)

    @abstractmethod
    def _prepare(self) -> _Prepared:
        """Do the work possible before the exposure at ``_next_s``."""

    @abstractmethod
    def _expose(self, prepared: _Prepared, captured_s: float) -> Image:
        """Return the picture of the moment ``captured_s``, which may have passed."""
