"""Recording of a run in its own thread: `put` never waits, and the loops never notice.

Rules
- Events are never dropped. Pictures beyond the configured rate are left out; if the writer lags by
  more than a few, new ones are dropped and counted.
- Events are on their way to the disk within ``FLUSH_EVERY_S``: a kill loses no more.
- A recording that cannot continue (disk full) ends and says so; the run continues.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from datetime import datetime
from importlib.metadata import version
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Final

from navigation.config import Config
from navigation.config.secrecy.secrets import hide, hide_in
from navigation.config.several.each_robot import each_robot
from navigation.mission.mission import State
from navigation.recording.events import (
    Counted,
    Level,
    PictureTaken,
    RecordedEvent,
    RobotsSeen,
    SceneSeen,
    Told,
    ZonesChanged,
)
from navigation.recording.files import RecordingError, RecordingFiles
from navigation.recording.json_bodies import FLEET_WAITS, LINK, configuration_body
from planner.zones.zone import Zone
from vision.calibration.calibration import Calibration
from vision.calibration.calibration_file import calibration_text
from vision.camera.camera import Frame
from vision.markers.markers import RobotPose

if TYPE_CHECKING:
    from navigation.loop.run_state import RobotSnapshot

FLUSH_EVERY_S: Final = 0.2
CLOSE_WITHIN_S: Final = 5.0
"""A disk that hangs must not keep the run from ending."""
MOST_PICTURES_WAITING: Final = 8
COUNTERS_EVERY_S: Final = 1.0
RATE_SLACK: Final = 0.9
"""Share of a period after which a picture is on time: cameras are not punctual."""

_LEVELS: Final[dict[State, Level]] = {
    State.HOLDING: "warning",
    State.STOPPED: "error",
    State.FAILED: "error",
}


@dataclass(frozen=True, slots=True)
class RecordingCounts:
    """Counts of a recording so far; ``failed`` is the reason of an early end."""

    pictures: int = 0
    dropped: int = 0
    events: int = 0
    waiting: int = 0
    """Put, and not yet written."""
    files: int = 0
    removed: int = 0
    failed: str = ""


class Recorder:
    """Recorder of one run; a context manager that starts and ends the thread.

    ``began`` is the clock's present reading as wall time. ``file`` names the only file in
    ``folder``.
    """

    def __init__(
        self,
        config: Config,
        calibration: Calibration,
        folder: Path,
        *,
        file: str | None = None,
        clock: Callable[[], float],
        began: datetime,
    ) -> None:
        self.config = config
        self._clock = clock
        self._anchor_s = clock()
        self._anchor_ns = round(began.timestamp() * 1e9)
        self._calibration = calibration_text(calibration)
        self._wake = threading.Condition()
        self._waiting: deque[RecordedEvent] = deque()
        self._pictures_waiting = 0
        self._stopping = False
        self._last_picture_s = -math.inf
        self._counted: dict[str, tuple[float, bool]] = {}
        """When a link's counters were recorded, and True if it was up."""
        self._said: dict[str, tuple[State, str]] = {}
        self._waits: tuple[Mapping[str, str], Mapping[str, str]] = ({}, {})
        self._has_zones = False
        self._put = self._pictures = self._dropped = self._events = 0
        self._failed = ""
        self.turns = 0
        names = {one.robot.marker_id: name for name, one in each_robot(config).items()}
        self._files = RecordingFiles(
            folder, config.recording, began, self._header, self._stamp_ns, names, file
        )
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)

    def _header(self, part: int) -> dict[str, object]:
        return configuration_body(
            self.config,
            self._calibration,
            version("clearway"),
            part,
            self._anchor_s,
            self._anchor_ns,
        )

    def _stamp_ns(self, time_s: float) -> int:
        return self._anchor_ns + round((time_s - self._anchor_s) * 1e9)

    def __enter__(self) -> Recorder:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with self._wake:
            self._stopping = True
            self._wake.notify()
        self._thread.join(CLOSE_WITHIN_S)
        if self._thread.is_alive():
            self._fail(f"{self.path}: the disk has not taken the end within {CLOSE_WITHIN_S:g} s")

    @property
    def path(self) -> Path:
        """File being written."""
        return self._files.path

    def counts(self) -> RecordingCounts:
        """Counts so far."""
        with self._wake:
            return RecordingCounts(
                self._pictures,
                self._dropped,
                self._events,
                self._put - self._pictures - self._events,
                self._files.files,
                self._files.removed,
                self._failed,
            )

    def has_ended(self) -> bool:
        """True if nothing more will be written."""
        return bool(self._failed) or not self._thread.is_alive()

    def summary(self) -> str:
        """Return one sentence on the recording."""
        counts = self.counts()
        parts = [f"{counts.pictures} pictures", f"{counts.events} events"]
        if counts.dropped:
            parts.append(f"{counts.dropped} pictures dropped")
        if counts.removed:
            parts.append(f"{counts.removed} old files removed")
        sentence = f"recorded {', '.join(parts)} in {self.path}"
        return f"{sentence}; ended early: {counts.failed}" if counts.failed else sentence

    # From the loops: never waits.

    def saw(self, frame: Frame, poses: Mapping[int, RobotPose], seen: SceneSeen | None) -> None:
        """Record a picture, its robots by marker id, and the scene if new."""
        self._picture(frame)
        revision = None if seen is None else seen.revision
        self.put(RobotsSeen(frame.captured_s, tuple(poses.values()), revision))
        if seen is not None:
            self.put(seen)

    def _picture(self, frame: Frame) -> None:
        period_s = 1.0 / self.config.recording.picture_rate_hz
        if frame.captured_s - self._last_picture_s < RATE_SLACK * period_s:
            return
        self._last_picture_s = frame.captured_s
        with self._wake:
            if self._failed:
                return
            if self._pictures_waiting >= MOST_PICTURES_WAITING:
                self._dropped += 1
                return
            self._pictures_waiting += 1
            self._append(PictureTaken(frame))

    def put(self, event: RecordedEvent) -> None:
        """Record anything but a picture."""
        with self._wake:
            if not self._failed:
                self._append(event)

    def _append(self, event: RecordedEvent) -> None:
        self._put += 1
        self._waiting.append(event)
        self._wake.notify()

    def state(self, now: RobotSnapshot, time_s: float, robot: str = "") -> None:
        """Record the state if its sentence is news, and counters now and then."""
        news = (now.mission.state, now.sentence)
        if news != self._said.get(robot):
            self._said[robot] = news
            level = _LEVELS.get(now.mission.state, "info")
            sentence = hide(f"{now.mission.state.value}: {now.sentence}")
            self.put(Told(time_s, level, sentence, robot or "mission"))
        link, (counted_s, was_up) = now.link, self._counted.get(robot, (-math.inf, False))
        is_up = link.down_reason is None
        if time_s - counted_s >= COUNTERS_EVERY_S or is_up is not was_up:
            self._counted[robot] = (time_s, is_up)
            values = {
                "state": link.state.value,
                "down_reason": link.down_reason,
                "rtt_s": link.rtt_s,
                "executed": link.executed,
                "sent": asdict(link.sent),
                "received": asdict(link.received),
            }
            topic = f"{LINK}/{robot}" if robot else LINK
            self.put(Counted(time_s, topic, hide_in(values)))

    def robots(
        self,
        each: Mapping[str, RobotSnapshot],
        waits: Mapping[str, str],
        waits_for: Mapping[str, str],
        time_s: float,
    ) -> None:
        """Record the states of several robots and, if new, which wait."""
        for name, one in each.items():
            self.state(one, time_s, name)
        if (waits, waits_for) != self._waits:
            self._waits = (waits, waits_for)
            values = {"waits": dict(waits), "waits_for": dict(waits_for)}
            self.put(Counted(time_s, FLEET_WAITS, hide_in(values)))

    def zones(self, zones: tuple[Zone, ...], revision: int, time_s: float) -> None:
        """Record the zones in force and the scene's revision; none at first are no change."""
        if zones or self._has_zones:
            self._has_zones = True
            self.put(ZonesChanged(time_s, revision, zones))

    # The recorder's thread.

    def _run(self) -> None:
        flushed_s = self._clock()
        while True:
            self.turns += 1
            with self._wake:
                self._wake.wait_for(lambda: self._waiting or self._stopping, FLUSH_EVERY_S)
                batch, self._waiting = self._waiting, deque()
                self._pictures_waiting = 0
                stopping = self._stopping
            try:
                for event in batch:
                    self._write(event)
                now_s = self._clock()
                if now_s - flushed_s >= FLUSH_EVERY_S:
                    self._files.flush()
                    flushed_s = now_s
                if stopping and not batch:
                    self._files.close()
                    return
            except RecordingError as error:
                self._fail(str(error))
                return
            except Exception as error:  # noqa: BLE001 - the run continues; said in the summary
                self._fail(f"{self.path}: unexpected {type(error).__name__}: {error}")
                return

    def _write(self, event: RecordedEvent) -> None:
        self._files.write(event)
        self.turns += 1
        with self._wake:
            if isinstance(event, PictureTaken):
                self._pictures += 1
            else:
                self._events += 1

    def _fail(self, reason: str) -> None:
        with self._wake:
            self._failed = reason
            self._waiting.clear()
