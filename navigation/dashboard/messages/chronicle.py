"""The recent past, for latecomers: the log, the driven track, the live charts.

Seconds of the run, metres; the log's times are wall-clock times.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any, Final

from navigation.config.secrecy.secrets import hide
from navigation.dashboard.messages.rings import Ring
from navigation.loop.run_state import RobotSnapshot
from navigation.mission.trust import Level
from navigation.shared.track import is_jump
from vision.camera.latest_frame import CameraStatus

LOG_LINES: Final = 200
"""The page shows these: it gets them in one message."""
TRACK_POINTS: Final = 6000
SAMPLE_EVERY_S: Final = 0.5
SAMPLES: Final = 240
STEP_M: Final = 0.004
"""Least distance between points of a track."""
COLUMNS: Final = (
    "time_s",
    "camera_hz",
    "wire_ms",
    "look_ms",
    "round_trip_ms",
    "link_hz",
    "roadmap_ms",
    "plan_ms",
    "clearance_m",
    "speed_m_s",
)
_NUMBERS = re.compile(r"[\d.]+")


@dataclass(frozen=True, slots=True)
class LogLine:
    """One event: wall-clock seconds, ``info``, ``order``, ``warn`` or ``stop``, the sentence."""

    wall_s: float
    level: str
    text: str


class Chronicle:
    """Log, track and samples. ``fastest_m_s``: the robot's highest speed.

    One of several puts its ``name`` before its lines in the common ``log``.
    """

    def __init__(
        self, fastest_m_s: float, name: str | None = None, log: Ring[LogLine] | None = None
    ) -> None:
        self._fastest_m_s, self._name = fastest_m_s, name
        self.log: Ring[LogLine] = Ring(LOG_LINES) if log is None else log
        self.track: Ring[tuple[float, float] | None] = Ring(TRACK_POINTS)
        """None where the line breaks: the robot has not driven what lies between."""
        self._seen: tuple[float, float, float] | None = None
        self.samples: Ring[list[float | None]] = Ring(SAMPLES)
        self._said: dict[str, str] = {}
        self._sampled_s = -math.inf
        self._frames_then = 0
        self._wire_s: float | None = None
        self._slowest_wire_s: float | None = None

    def note(self, wall_s: float, level: str, text: str) -> None:
        """Add a line to the log."""
        self.log.append(LogLine(wall_s, level, hide(text)))

    def see_arena(self, state: RobotSnapshot, camera: CameraStatus, wall_s: float) -> None:
        """Record news of camera and program, common to all robots."""
        if camera.reason or "camera" in self._said:
            self._say("camera", wall_s, "warn" if camera.reason else "info", _of_camera(camera))
        for trouble in state.troubles:
            self._say(trouble, wall_s, "warn", trouble)

    def see_robot(self, state: RobotSnapshot, wall_s: float) -> None:
        """Record news of the robot, its mission and its link."""
        mission = state.mission
        level = {"stopped": "stop", "failed": "warn", "holding": "warn"}.get(mission.state.value)
        self._say("mission", wall_s, level or "info", f"{mission.state.value}: {state.sentence}")
        down = state.link.down_reason
        if down is not None or "link" in self._said:
            text = f"link: {down}" if down else "link: up"
            self._say("link", wall_s, "warn" if down else "info", text)
        if state.pose is not None and state.trust is not Level.DOUBTED:
            self._drive((state.pose.captured_s, state.pose.x, state.pose.y))

    def sample(self, state: RobotSnapshot, camera: CameraStatus) -> None:
        """Add a charts' row every ``SAMPLE_EVERY_S``, with the slowest wire since the last."""
        wire_s = state.times.wire_s
        if wire_s is not None and wire_s != self._wire_s:
            self._slowest_wire_s = max(wire_s, self._slowest_wire_s or 0.0)
        self._wire_s = wire_s
        passed_s = state.time_s - self._sampled_s
        if passed_s < SAMPLE_EVERY_S:
            return
        frames = state.link.sent.frames_sent + state.link.received.frames
        rate = (frames - self._frames_then) / passed_s if math.isfinite(passed_s) else None
        self._sampled_s, self._frames_then = state.time_s, frames
        pose, times = state.pose, state.times
        row: dict[str, Any] = {
            "time_s": round(state.time_s, 2),
            "camera_hz": round(camera.rate_hz, 2),
            "wire_ms": _ms(self._slowest_wire_s),
            "look_ms": _ms(times.look_s),
            "round_trip_ms": _ms(state.link.rtt_s),
            "link_hz": None if rate is None else round(rate, 1),
            "roadmap_ms": _ms(times.roadmap_s),
            "plan_ms": _ms(times.plan_s),
            "clearance_m": None if state.clearance_m is None else round(state.clearance_m, 4),
            "speed_m_s": None if pose is None else round(math.hypot(pose.vx, pose.vy), 4),
        }
        self._slowest_wire_s = None
        self.samples.append([row[name] for name in COLUMNS])

    def _drive(self, seen: tuple[float, float, float]) -> None:
        before, self._seen = self._seen, seen
        if before is not None and is_jump(before, seen, self._fastest_m_s):
            self.track.append(None)
        last = self.track.last
        if last is None or math.dist(last, seen[1:]) >= STEP_M:
            self.track.append((round(seen[1], 4), round(seen[2], 4)))

    def _say(self, subject: str, wall_s: float, level: str, text: str) -> None:
        """Log a new sentence; changed figures alone do not make it new."""
        core = _NUMBERS.sub("#", text)
        if self._said.get(subject) != core:
            self._said[subject] = core
            self.note(wall_s, level, text if self._name is None else f"{self._name}: {text}")


def _of_camera(camera: CameraStatus) -> str:
    return f"camera {camera.state}: {camera.reason}" if camera.reason else f"camera {camera.state}"


def _ms(seconds: float | None) -> float | None:
    return None if seconds is None else round(seconds * 1e3, 2)
