"""The newest frame of a camera, read in a thread of its own.

Rules
- The latest frame wins; frames not taken in time are counted as dropped.
- A source that fails, stalls or freezes is reopened with growing pauses.
- A live sensor hardly ever gives the same picture twice: a repeated one is not passed on, and
  repetition means a frozen camera, except for a source with `may_repeat`.
- A read, an opening or a closing that hangs inside a driver cannot be stopped: its thread and
  camera are left behind and new ones made, up to `MOST_LEFT_BEHIND`. They may hold the camera: that
  is reported, and no other program blamed.
- The clock is passed in; only waiting for a frame takes real time.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

from vision.camera.camera import (
    Camera,
    CameraAbsentError,
    CameraError,
    CameraHeldError,
    Clock,
    Frame,
    identical,
)

CameraState: TypeAlias = Literal[
    "closed", "starting", "running", "stalled", "frozen", "lost", "ended"
]

MOST_LEFT_BEHIND: Final = 3
"""Most hanging threads at a time; the next one that hangs is waited for."""


@dataclass(frozen=True, slots=True)
class WatchLimits:
    """Limits from which a source counts as stalled or frozen, and pauses between openings (s).

    A repeating picture is frozen after ``frozen_s`` and ``frozen_frames`` repetitions: H.264 at 100
    kbit/s repeats a still arena nine times. ``hung_s`` exceeds the five seconds in which a device
    or stream may report silence. An absent camera is sought every ``absent_pause_s``, which opens
    nothing.
    """

    read_timeout_s: float = 0.5
    stalled_s: float = 1.0
    frozen_s: float = 1.0
    frozen_frames: int = 12
    hung_s: float = 8.0
    first_pause_s: float = 0.25
    longest_pause_s: float = 8.0
    absent_pause_s: float = 0.5


@dataclass(frozen=True, slots=True)
class CameraStatus:
    """State of a camera; ``reason`` is empty while all is well.

    ``age_s`` is the age of the newest frame, None before the first; ``reopened`` counts further
    openings. ``each``: the status of several cameras, by name.
    """

    state: CameraState
    reason: str
    rate_hz: float
    captured: int
    dropped: int
    reopened: int
    age_s: float | None
    each: tuple[tuple[str, CameraStatus], ...] = ()


class LatestFrame:
    """Newest frame of a camera, which is opened again when it fails.

    ``open_camera`` makes a new, closed camera each time. Use a context manager, or ``start()`` and
    ``stop()``; without a thread, ``step()``. ``news`` may be shared and is notified of every new
    frame.
    """

    def __init__(
        self,
        open_camera: Callable[[], Camera],
        clock: Clock,
        limits: WatchLimits | None = None,
        news: threading.Condition | None = None,
    ) -> None:
        self._open_camera = open_camera
        self._clock = clock
        self._limits = limits or WatchLimits()
        self._news = news or threading.Condition()
        self._stopping = threading.Event()
        self._generation = 0
        self._frame: Frame | None = None
        self._taken = True
        self._woken = False
        self._status = CameraStatus("closed", "", 0.0, 0, 0, 0, None)
        self._reader = _Reader(self, 0)
        self._left_behind: list[_Reader] = []
        self._thread: threading.Thread | None = None
        self.turns = 0
        """Grows while the thread works, whatever the camera does."""

    def __enter__(self) -> LatestFrame:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def start(self) -> None:
        """Start the thread that reads the camera; harmless while it runs."""
        if self._thread is None:
            self._stopping.clear()
            self._start_thread()

    def stop(self, timeout_s: float = 2.0) -> None:
        """End the thread and close the camera; a hung read is left behind after the timeout."""
        self._stopping.set()
        thread, self._thread = self._thread, None
        if thread is None:
            self._reader.close()
        else:
            thread.join(timeout_s)
        with self._news:
            self._next_reader()
            self._status = replace(self._status, state="closed", reason="")
            self._news.notify_all()

    def has_died(self) -> bool:
        """True if the thread ended by a program error; `start` after `stop` helps."""
        thread = self._thread
        return thread is not None and thread.ident is not None and not thread.is_alive()

    def take(self, timeout_s: float = 0.0) -> Frame | None:
        """Return the newest frame not yet taken, waiting up to ``timeout_s`` (real) seconds.

        None if none came in time, or if `wake` was called.
        """
        self._leave_hung_reader()
        with self._news:
            if timeout_s > 0.0:
                self._news.wait_for(lambda: self._woken or not self._taken, timeout_s)
            self._woken = False
            if self._taken:
                return None
            self._taken = True
            return self._frame

    def wake(self) -> None:
        """End the present or next wait of `take`."""
        with self._news:
            self._woken = True
            self._news.notify_all()

    def status(self) -> CameraStatus:
        """Present state of the camera."""
        self._leave_hung_reader()
        now_s = self._clock()
        with self._news:
            status, frame = self._status, self._frame
        age_s = None if frame is None else max(0.0, now_s - frame.captured_s)
        stale = age_s is not None and age_s > self._limits.stalled_s
        if stale and age_s is not None and status.state == "running":
            return replace(status, state="stalled", reason=_no_picture(age_s), age_s=age_s)
        return replace(status, age_s=age_s)

    def step(self) -> float:
        """Do one turn without a thread: open when due, read, publish. Return the pause (s)."""
        return self._reader.step()

    def _start_thread(self) -> None:
        reader = self._reader
        self._thread = threading.Thread(
            target=self._run, args=(reader,), name="clearway-camera", daemon=True
        )
        self._thread.start()

    def _run(self, reader: _Reader) -> None:
        ended_well = False
        try:
            while not self._stopping.is_set() and reader.generation == self._generation:
                self.turns += 1
                pause_s = reader.step()
                if pause_s > 0.0:
                    self._stopping.wait(pause_s)
            ended_well = True
        finally:
            if not ended_well:
                reason = f"{reader.name}the camera's thread ended by an error of the program"
                self._say(reader, "lost", reason, again=False)
            reader.close()

    def _leave_hung_reader(self) -> None:
        """Replace a reader whose read, open or close has not returned for ``hung_s``."""
        with self._news:
            busy_s = self._reader.busy_s(self._clock())
            if busy_s <= self._limits.hung_s:
                return
            name = self._reader.name
            hang = f"{name}a reading of the camera has hung for {busy_s:.1f} s"
            if len(self._hanging()) >= MOST_LEFT_BEHIND:
                reason = f"{hang}, and {MOST_LEFT_BEHIND} earlier ones hang: waiting for it"
                self._status = replace(self._status, state="lost", reason=reason)
                return
            self._next_reader()
            self._reader.failures = 1  # keeps the present report
            self._status = replace(
                self._status,
                state="lost",
                reason=f"{hang}; opening the camera again",
                reopened=self._status.reopened + 1,
            )
            if self._thread is not None and not self._stopping.is_set():
                self._start_thread()

    def _next_reader(self) -> None:
        self._left_behind = [*self._hanging(), self._reader]
        self._generation += 1
        self._reader = _Reader(self, self._generation)

    def _hanging(self) -> list[_Reader]:
        now_s = self._clock()
        return [reader for reader in self._left_behind if reader.busy_s(now_s) > 0.0]

    def _why_held(self, error: CameraHeldError) -> str:
        """Holder of the camera: this program, if an earlier reading of its own hangs."""
        now_s = self._clock()
        with self._news:
            hung_s = max((reader.busy_s(now_s) for reader in self._hanging()), default=0.0)
        if hung_s == 0.0:
            return str(error)
        return (
            f"{error.seen}; Clearway's own earlier reading of it has hung for {hung_s:.0f} s and "
            "may hold it: if that lasts, disconnect the camera and connect it again"
        )

    def _publish(self, reader: _Reader, frame: Frame, rate_hz: float, reason: str) -> None:
        with self._news:
            if reader.generation != self._generation:
                return
            status = self._status
            self._frame = replace(frame, sequence=status.captured)
            self._status = replace(
                status,
                state="running",
                reason=reason,
                rate_hz=rate_hz,
                captured=status.captured + 1,
                dropped=status.dropped + (not self._taken),
            )
            self._taken = False
            self._news.notify_all()

    def _say(self, reader: _Reader, state: CameraState, reason: str, *, again: bool) -> None:
        with self._news:
            if reader.generation != self._generation:
                return
            self._status = replace(
                self._status,
                state=state,
                reason=reason,
                rate_hz=self._status.rate_hz if state == "running" else 0.0,
                reopened=self._status.reopened + again,
            )
            self._news.notify_all()


class _Reader:
    """One camera from opening to failure, and the pauses between attempts."""

    def __init__(self, owner: LatestFrame, generation: int) -> None:
        self.generation = generation
        self.name = ""
        """Prefix of messages."""
        self._owner = owner
        self._limits = owner._limits
        self._camera: Camera | None = None
        self._busy_since_s: float | None = None
        self._pause_s = 0.0
        self._due_s: float | None = None
        self.failures = 0
        self._last_frame: Frame | None = None
        self._last_news_s = 0.0
        self._same_since_s: float | None = None
        self._repeats = 0
        self._ended = False

    def busy_s(self, now_s: float) -> float:
        """Seconds that the present read, open or close has taken; 0.0 if none runs."""
        since_s = self._busy_since_s
        return 0.0 if since_s is None else now_s - since_s

    def close(self) -> None:
        camera, self._camera = self._camera, None
        if camera is None:
            return
        self._busy_since_s = self._owner._clock()
        try:
            camera.close()
        finally:
            self._busy_since_s = None

    def step(self) -> float:
        now_s = self._owner._clock()
        if self._ended:
            return self._limits.read_timeout_s
        if self._camera is None:
            if self._due_s is not None and now_s < self._due_s:
                return self._due_s - now_s
            return self._open(now_s)
        return self._read(self._camera, now_s)

    def _open(self, now_s: float) -> float:
        self._busy_since_s = now_s
        if self.failures == 0:
            self._owner._say(self, "starting", "the camera is being opened", again=False)
        try:
            camera = self._owner._open_camera()
            self.name = f"{camera.name}: "
            camera.open()
        except CameraHeldError as error:
            return self._fail(self._owner._why_held(error), "lost")
        except CameraError as error:
            return self._fail(str(error), "lost", isinstance(error, CameraAbsentError))
        finally:
            self._busy_since_s = None
        self._camera = camera
        self._last_news_s = self._owner._clock()
        self._same_since_s = None
        return 0.0

    def _read(self, camera: Camera, now_s: float) -> float:
        self._busy_since_s = now_s
        try:
            frame = camera.read(self._limits.read_timeout_s)
        except CameraError as error:
            return self._fail(str(error), "lost", isinstance(error, CameraAbsentError))
        finally:
            self._busy_since_s = None
        now_s = self._owner._clock()
        if frame is not None:
            return self._accept(camera, frame, now_s)
        if camera.state == "ended":
            self._ended = True
            self.close()
            self._owner._say(self, "ended", camera.reason, again=False)
            return 0.0
        silent_s = now_s - self._last_news_s
        if silent_s > self._limits.stalled_s:
            return self._fail(f"{camera.name}: {_no_picture(silent_s)}", "stalled")
        return 0.0

    def _accept(self, camera: Camera, frame: Frame, now_s: float) -> float:
        self._last_news_s = now_s
        last, self._last_frame = self._last_frame, frame
        if not camera.may_repeat and last is not None and identical(frame.image, last.image):
            return self._count_repeat(camera, now_s)
        self._same_since_s = None
        if last is not None:
            self.failures = 0  # alive: the next failure starts with a short pause
        self._owner._publish(self, frame, camera.rate_hz, camera.reason)
        return 0.0

    def _count_repeat(self, camera: Camera, now_s: float) -> float:
        if self._same_since_s is None:
            self._same_since_s, self._repeats = now_s, 0
        self._repeats += 1
        same_s = now_s - self._same_since_s
        if same_s <= self._limits.frozen_s or self._repeats < self._limits.frozen_frames:
            return 0.0
        reason = f"{camera.name}: the same picture for {same_s:.1f} s; the camera is frozen"
        return self._fail(reason, "frozen")

    def _fail(self, reason: str, state: CameraState, absent: bool = False) -> float:
        self.close()
        limits = self._limits
        # bounded: 2.0 ** failures overflows after a night without a camera
        longest_s = limits.absent_pause_s if absent else limits.longest_pause_s
        pause_s = min(limits.first_pause_s * 2.0 ** min(self.failures, 30), longest_s)
        # no failure: plugged in, it starts with a short pause
        self.failures = 1 if absent else self.failures + 1
        self._due_s = self._owner._clock() + pause_s
        again = f"{reason.rstrip('.')}; trying again in {pause_s:.2g} s"
        self._owner._say(self, state, again, again=True)
        return pause_s


def _no_picture(silent_s: float) -> str:
    return f"no picture for {silent_s:.1f} s"
