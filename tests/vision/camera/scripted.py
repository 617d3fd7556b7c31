"""A clock and a camera that do what a test's script says."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from vision.camera.camera import CameraError, Frame, SourceState
from vision.camera.latest_frame import LatestFrame


class Clock:
    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s

    def wait(self, pause_s: float) -> None:
        self.now_s += pause_s


def picture(value: int) -> np.ndarray:
    return np.full((8, 8), value % 256, np.uint8)


Event = np.ndarray | None | CameraError


class ScriptedCamera:
    """Gives, read after read, what a script says: a picture, nothing, or an error."""

    may_repeat = False
    rate_hz = 30.0
    reason = ""
    name = "camera T"

    def __init__(self, clock: Clock, script: Iterator[Event], step_s: float = 0.1) -> None:
        self._clock, self._script, self._step_s = clock, script, step_s
        self.state: SourceState = "closed"
        self.opened = self.closed = 0

    def open(self) -> None:
        self.opened += 1
        self.state = "running"

    def read(self, timeout_s: float) -> Frame | None:
        self._clock.now_s += self._step_s
        event = next(self._script, "end")
        if isinstance(event, str):
            self.state, self.reason = "ended", "no more"
            return None
        if isinstance(event, CameraError):
            raise event
        return None if event is None else Frame(event, self._clock.now_s, 0, self.name)

    def close(self) -> None:
        self.closed += 1
        self.state = "closed"


def reader_of(clock: Clock, *scripts: list[Event]) -> tuple[LatestFrame, list[ScriptedCamera]]:
    cameras = [ScriptedCamera(clock, iter(s)) for s in scripts]
    waiting = iter(cameras)
    return LatestFrame(lambda: next(waiting), clock), cameras
