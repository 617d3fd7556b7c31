"""Report of one robot's run. Metres, degrees, seconds; latencies in milliseconds."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from planner.borders.polyline import distances_to_polyline
from planner.scene import FloatArray

ROWS_AT_ONCE: Final = 256
"""Rows of a track that are compared with a path at once: a few megabytes."""


@dataclass(frozen=True, slots=True)
class TrackingError:
    """Distance of the robot from its planned path while driving, metres."""

    rms: float | None = None
    max: float | None = None


@dataclass(frozen=True, slots=True)
class LinkCounts:
    """Counts of the traffic on the wire."""

    frames: int = 0
    bytes: int = 0
    retransmits: int = 0
    crc_errors: int = 0
    rtt_ms: float | None = None


@dataclass(frozen=True, slots=True)
class FrameCounts:
    """Counts of the camera's frames and their use."""

    captured: int = 0
    dropped: int = 0
    processed: int = 0


@dataclass(frozen=True, slots=True)
class CaptureToWire:
    """Time from a frame's capture to its pose fix on the wire, milliseconds."""

    p50: float | None = None
    p99: float | None = None


@dataclass(frozen=True, slots=True)
class Latencies:
    """Latencies of a run."""

    capture_to_wire: CaptureToWire = field(default_factory=CaptureToWire)


@dataclass(frozen=True, slots=True)
class Report:
    """Summary of one robot's run; None for an unknown value."""

    state: str
    reason: str
    stations: int
    stations_visited: int
    waypoints_sent: int
    waypoints_executed: int
    replans: int
    min_clearance_m: float | None
    tracking_error_m: TrackingError
    goal_error_m: float | None
    goal_error_deg: float | None
    duration_s: float
    link: LinkCounts
    frames: FrameCounts
    latency_ms: Latencies
    ground_truth: bool
    """True if clearance, tracking and goal errors are the simulation's truth, not the camera's."""
    track_jumps: int = 0
    """Jumps of the track: the robot was lifted, or was unseen between."""

    @classmethod
    def of_nothing(cls, reason: str, stations: int) -> Report:
        """Make the report of a run that ended before it had its devices."""
        return cls(
            state="stopped",
            reason=reason,
            stations=stations,
            stations_visited=0,
            waypoints_sent=0,
            waypoints_executed=0,
            replans=0,
            min_clearance_m=None,
            tracking_error_m=TrackingError(),
            goal_error_m=None,
            goal_error_deg=None,
            duration_s=0.0,
            link=LinkCounts(),
            frames=FrameCounts(),
            latency_ms=Latencies(),
            ground_truth=False,
        )

    def in_short(self) -> str:
        """Return one line, for one of several robots."""
        off = self.goal_error_m
        goal = "" if off is None else f", {off * 1e3:.1f} mm from its goal"
        return f"{self.state}, {self.stations_visited} of {self.stations} stations{goal}"

    def _jumps(self) -> list[tuple[str, str]]:
        if not self.track_jumps:
            return []
        times = "once" if self.track_jumps == 1 else f"{self.track_jumps} times"
        sentence = f"broken {times}: the robot was carried, or was not seen; what lies between"
        return [("track", f"{sentence} is not counted as driven")]

    def lines(self) -> list[tuple[str, str]]:
        """Return pairs of label and value, for a person."""
        t, c = self.tracking_error_m, self.latency_ms.capture_to_wire
        source = "ground truth" if self.ground_truth else "camera"
        return [
            ("state", f"{self.state}: {self.reason}"),
            ("stations visited", f"{self.stations_visited} of {self.stations}"),
            ("waypoints executed", f"{self.waypoints_executed} of {self.waypoints_sent} sent"),
            ("new plans", str(self.replans)),
            ("least clearance", _millimetres(self.min_clearance_m) + f" ({source})"),
            ("tracking error", f"{_millimetres(t.rms)} rms, {_millimetres(t.max)} at most"),
            (
                "goal error",
                f"{_millimetres(self.goal_error_m)}, {_number(self.goal_error_deg)} deg",
            ),
            *self._jumps(),
            ("duration", f"{self.duration_s:.1f} s"),
            (
                "link",
                f"{self.link.frames} frames, {self.link.bytes} bytes, "
                f"{self.link.retransmits} sent again, {self.link.crc_errors} damaged, "
                f"round trip {_number(self.link.rtt_ms)} ms",
            ),
            (
                "camera",
                f"{self.frames.captured} frames, {self.frames.processed} processed, "
                f"{self.frames.dropped} dropped",
            ),
            ("picture to command", f"{_number(c.p50)} ms p50, {_number(c.p99)} ms p99"),
        ]


def tracking_error(track: FloatArray, path: FloatArray) -> FloatArray:
    """Distance (n,) of each position of a track (n, 2) from the planned path (k, 2)."""
    parts = np.split(track, range(ROWS_AT_ONCE, len(track), ROWS_AT_ONCE))
    return np.concatenate([distances_to_polyline(path, part) for part in parts])


def rms_and_max(errors: FloatArray) -> TrackingError:
    """Root mean square and maximum of distances (n,); None if there are none."""
    if errors.size == 0:
        return TrackingError()
    return TrackingError(math.sqrt(float(np.mean(errors**2))), float(errors.max()))


def percentiles_ms(latencies_s: list[float]) -> CaptureToWire:
    """Median and 99th percentile."""
    if not latencies_s:
        return CaptureToWire()
    p50, p99 = np.percentile(np.array(latencies_s) * 1e3, [50.0, 99.0])
    return CaptureToWire(float(p50), float(p99))


def _millimetres(value_m: float | None) -> str:
    return "unknown" if value_m is None else f"{value_m * 1e3:.1f} mm"


def _number(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.2f}"
