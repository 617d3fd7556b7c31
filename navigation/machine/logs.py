"""Log of a run: one line an event on stderr, for a journal, a log collector or a person.

Rules
- A line is one event, a name (docs/operations.md) and fields: JSON, or ``time level event words``.
- Only news is logged: a change of state, of the reason, of the camera, of the link, a new plan.
- A non-character, such as half of a surrogate pair, is written as its number.
- Under systemd a text line begins with its priority, ``<4>``, which the journal removes.

Times in lines are UTC; fields have their units in their names.
"""

from __future__ import annotations

import contextlib
import io
import json
import math
import re
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final, Literal, TextIO, TypeAlias

from navigation.config.secrecy.secrets import hide_in
from navigation.mission.mission import State

Level: TypeAlias = Literal["debug", "info", "warning", "error"]
LEVELS: Final[tuple[Level, ...]] = ("debug", "info", "warning", "error")
PRIORITY: Final[dict[Level, int]] = {"debug": 7, "info": 6, "warning": 4, "error": 3}
"""Priorities of syslog, which the journal uses too."""

MOST_FILE_BYTES: Final = 10_000_000
_TIME: Final = re.compile(r"\b\d+(\.\d+)? m?s\b")
STATE_LEVELS: Final[Mapping[State, Level]] = {
    State.HOLDING: "warning",
    State.STOPPED: "warning",
    State.FAILED: "error",
}


class EventLog:
    """Writer of events at ``level`` and above to ``stream``.

    ``form``: ``json``, ``text``, or None for no log. ``now`` gives the wall time; ``priorities``
    puts the journal's before each text line.
    """

    def __init__(
        self,
        stream: TextIO | io.TextIOBase,
        form: Literal["json", "text"] | None,
        *,
        now: Callable[[], datetime],
        level: Level = "info",
        priorities: bool = False,
    ) -> None:
        self._stream, self._form = stream, form
        self._now = now
        self._least = LEVELS.index(level)
        self._priorities = priorities
        self.trouble = ""
        """Reason why the last event could not be written, or empty."""
        self._name = "the log"

    @classmethod
    def to_file(cls, file: Path, *, now: Callable[[], datetime]) -> EventLog:
        """Open a log file of at most ``MOST_FILE_BYTES``; its last line says that it is full.

        A file that cannot be opened or written is a `trouble`.
        """
        try:
            log = cls(_LimitedFile(file), "json", now=now)
        except OSError as error:
            log = cls(io.StringIO(), None, now=now)
            log.trouble = f"{file}: cannot be written: {error.strerror or error}"
        log._name = str(file)
        return log

    def close(self) -> None:
        """Close the stream."""
        with contextlib.suppress(OSError, ValueError):  # its last event has reported that
            self._stream.close()

    def write(self, level: Level, event: str, **fields: Any) -> None:
        """Write one event; None values are left out of text and null in JSON."""
        if self._form is None or LEVELS.index(level) < self._least:
            return
        time = self._now().astimezone(UTC).isoformat(timespec="milliseconds")
        time = time.replace("+00:00", "Z")
        plain = {name: hide_in(_plain(value)) for name, value in fields.items()}
        if self._form == "json":
            body = {"time": time, "level": level, "event": event, **plain}
            line = json.dumps(body, allow_nan=False, ensure_ascii=False)
        else:
            words = [f"{name}={_word(value)}" for name, value in plain.items() if value is not None]
            line = " ".join([f"{time} {level:<7} {event}", *words])
            if self._priorities:
                line = f"<{PRIORITY[level]}>{line}"
        try:
            self._stream.write(line.encode("utf-8", "backslashreplace").decode() + "\n")
            self._stream.flush()
        except (OSError, ValueError) as error:  # a full disk, a closed reader
            reason = error.strerror if isinstance(error, OSError) else None
            self.trouble = f"{self._name}: cannot be written: {reason or error}"
        else:
            self.trouble = ""


class _LimitedFile(io.TextIOBase):
    def __init__(self, file: Path) -> None:
        self._file = file.open("a", encoding="utf-8")
        self._left = MOST_FILE_BYTES

    def write(self, line: str, /) -> int:
        """Append a line if it fits."""
        if self._left > 0:
            self._left -= self._file.write(line)
            if self._left <= 0:
                self._file.write('{"event": "full"}\n')
        return len(line)

    def flush(self) -> None:
        self._file.flush()

    def close(self) -> None:
        self._file.close()


def _timeless(sentence: str | None) -> str | None:
    """Remove the times from a sentence: a longer duration is no news."""
    return None if sentence is None else _TIME.sub("", sentence)


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return round(value, 6) if math.isfinite(value) else None
    return value if isinstance(value, str | int | bool | list | dict | None) else str(value)


def _word(value: Any) -> str:
    text = value if isinstance(value, str) else json.dumps(value)
    simple = text and text.isprintable() and not any(c in text for c in ' "=')
    return text if simple else json.dumps(text, ensure_ascii=False)


class RunLog:
    """Reporter of a run's news to several logs."""

    def __init__(self, *logs: EventLog) -> None:
        self.logs = list(logs)
        self._last: dict[tuple[str, str], Any] = {}

    def write(self, level: Level, event: str, **fields: Any) -> None:
        """Write one event to every log."""
        for log in self.logs:
            log.write(level, event, **fields)

    @property
    def trouble(self) -> str:
        """Names of the logs that cannot be written, and why; empty if all can."""
        return "; ".join(log.trouble for log in self.logs if log.trouble)

    def cycle(self, robots: Mapping[str, Any], camera: Any) -> None:
        """Log a cycle: each robot's `RobotSnapshot` by name, and the `CameraStatus`.

        A single robot has the empty name, and its events name no robot.
        """
        for name, now in robots.items():
            self._robot(name, now)
        if self._is_news("camera", "", (camera.state, _timeless(camera.reason))):
            fine = camera.state in ("running", "starting")
            reason = camera.reason or None
            self.write("info" if fine else "warning", "camera", state=camera.state, reason=reason)

    def _robot(self, name: str, now: Any) -> None:
        of = {"robot": name} if name else {}
        mission = now.mission
        if self._is_news("state", name, (mission.state, _timeless(now.sentence))):
            pose = now.pose
            self.write(
                STATE_LEVELS.get(mission.state, "info"),
                "state",
                **of,
                state=mission.state.value,
                reason=now.sentence,
                x_m=None if pose is None else pose.x,
                y_m=None if pose is None else pose.y,
                heading_rad=None if pose is None else pose.heading_rad,
                clearance_m=now.clearance_m,
            )
        visited, count = mission.visited, len(mission.stations)
        if self._is_news("station", name, (mission.stations, visited)) and visited:
            self.write("info", "station", **of, visited=visited, stations=count)
        path = now.path
        if self._is_news("plan", name, path) and path is not None:
            clearance_m = path.min_clearance
            self.write("info", "plan", **of, length_m=path.length, min_clearance_m=clearance_m)
        down = now.link.down_reason
        if self._is_news("link", name, (_timeless(down),)):
            level: Level = "info" if down is None else "warning"
            self.write(level, "link", **of, state="up" if down is None else "down", reason=down)

    def _is_news(self, event: str, robot: str, value: Any) -> bool:
        key = event, robot
        if key in self._last and self._same(self._last[key], value):
            return False
        self._last[key] = value
        return True

    @staticmethod
    def _same(one: Any, other: Any) -> bool:
        return one is other or (isinstance(one, tuple) and one == other)
