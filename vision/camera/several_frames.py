"""The newest frames of several cameras, as if they were one.

Rules
- Each camera has its own `LatestFrame`, so none delays another. A frame's ``source`` is the
  camera's name here.
- If several have a picture, they take turns.
- They run while any of them does; a camera's trouble is reported with its name.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import replace

from vision.camera.camera import Camera, Clock, Frame
from vision.camera.latest_frame import CameraStatus, LatestFrame, WatchLimits


class SeveralFrames:
    """`LatestFrame` of several cameras: each of ``open_cameras``, by name, makes a closed one."""

    def __init__(
        self,
        open_cameras: Mapping[str, Callable[[], Camera]],
        clock: Clock,
        limits: WatchLimits | None = None,
    ) -> None:
        self._news = threading.Condition()
        self._each = {
            name: LatestFrame(open_camera, clock, limits, self._news)
            for name, open_camera in open_cameras.items()
        }
        self._order = list(self._each)
        self._found: Frame | None = None
        self._woken = False

    @property
    def turns(self) -> int:
        """Count that grows while any thread works."""
        return sum(one.turns for one in self._each.values())

    def start(self) -> None:
        """Start a thread for each camera."""
        for one in self._each.values():
            one.start()

    def stop(self) -> None:
        """End the threads and close the cameras."""
        for one in self._each.values():
            one.stop()

    def has_died(self) -> bool:
        """True if a thread ended by a program error; `start` after `stop` helps."""
        return any(one.has_died() for one in self._each.values())

    def take(self, timeout_s: float = 0.0) -> Frame | None:
        """Return the newest frame of any camera not yet taken; None if none came in time.

        Waits up to ``timeout_s`` (real) seconds, or until `wake`.
        """
        with self._news:
            self._news.wait_for(lambda: self._woken or self._find(), timeout_s)
            self._woken = False
            found, self._found = self._found, None
        return found

    def _find(self) -> bool:
        for name in self._order:
            frame = self._each[name].take(0.0)
            if frame is not None:
                self._found = replace(frame, source=name)
                self._order.remove(name)
                self._order.append(name)
                return True
        return False

    def wake(self) -> None:
        """End the present or next wait of `take`."""
        with self._news:
            self._woken = True
            self._news.notify_all()

    def step(self) -> float:
        """Do one turn of each without threads. Return the pause (s)."""
        return min(one.step() for one in self._each.values())

    def status(self) -> CameraStatus:
        """State of all together, and of each by name."""
        each = [(name, one.status()) for name, one in self._each.items()]
        ages_s = [one.age_s for _, one in each if one.age_s is not None]
        running = [one for _, one in each if one.state == "running"]
        return CameraStatus(
            state="running" if running else each[0][1].state,
            reason="; ".join(f"{name}: {one.reason}" for name, one in each if one.reason),
            rate_hz=min((one.rate_hz for one in running), default=0.0),
            captured=sum(one.captured for _, one in each),
            dropped=sum(one.dropped for _, one in each),
            reopened=sum(one.reopened for _, one in each),
            age_s=min(ages_s, default=None),
            each=tuple(each),
        )
