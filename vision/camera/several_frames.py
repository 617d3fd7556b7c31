"""The newest frames of several cameras, as if they were one.

Rules
- Each camera is read by a `LatestFrame` of its own: one that hangs, freezes or is unplugged keeps
  no other one waiting. A frame's ``source`` is the name of its camera here.
- Who waits is woken by whichever camera gives a picture; they take turns where several have one.
- As a whole they run while any of them does; what is not well with one is said with its name.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import replace

from vision.camera.camera import Camera, Clock, Frame
from vision.camera.latest_frame import CameraStatus, LatestFrame, WatchLimits


class SeveralFrames:
    """`LatestFrame` of several cameras: ``open_cameras`` by name, each makes a new, closed one."""

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
        """Grows while any of their threads works: one camera that hangs is said by its status."""
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
        """Whether a thread has ended by an error of the program; `start` after `stop` helps."""
        return any(one.has_died() for one in self._each.values())

    def take(self, timeout_s: float = 0.0) -> Frame | None:
        """The newest frame of one of them that was not yet taken; None where none came in time.

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
        """End the wait of `take`, the present one or the next: there is other news."""
        with self._news:
            self._woken = True
            self._news.notify_all()

    def step(self) -> float:
        """One turn of each without threads; the pause to make (s)."""
        return min(one.step() for one in self._each.values())

    def status(self) -> CameraStatus:
        """What they do together, and each of them by name."""
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
