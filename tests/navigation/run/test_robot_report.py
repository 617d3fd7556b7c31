"""The report: DESIGN's fields, strict JSON, and numbers that a reader can trust."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from navigation.run.robot_report import (
    CaptureToWire,
    FrameCounts,
    Latencies,
    LinkCounts,
    Report,
    TrackingError,
    percentiles_ms,
    rms_and_max,
    tracking_error,
)
from navigation.run.run_report import RunReport


def run_of(report: Report) -> RunReport:
    return RunReport(report.state, report.reason, report.duration_s, {"": report})


def empty_report() -> Report:
    return Report(
        "failed", "no camera", 2, 0, 0, 0, 0, None, TrackingError(), None, None, 1.5,
        LinkCounts(), FrameCounts(), Latencies(), ground_truth=False,
    )  # fmt: skip


def test_the_json_has_every_field_of_the_design(tmp_path: Path) -> None:
    file = tmp_path / "report.json"
    run_of(empty_report()).write(file)
    data = json.loads(file.read_text())
    assert set(data) >= {
        "state", "reason", "stations", "waypoints_sent", "waypoints_executed", "replans",
        "min_clearance_m", "tracking_error_m", "goal_error_m", "goal_error_deg", "duration_s",
        "link", "frames", "latency_ms",
    }  # fmt: skip
    assert set(data["tracking_error_m"]) == {"rms", "max"}
    assert set(data["link"]) == {"frames", "bytes", "retransmits", "crc_errors", "rtt_ms"}
    assert set(data["frames"]) == {"captured", "dropped", "processed"}
    assert set(data["latency_ms"]["capture_to_wire"]) == {"p50", "p99"}


def test_a_track_with_jumps_says_so() -> None:
    assert "track" not in dict(empty_report().lines())
    told = dict(replace(empty_report(), track_jumps=2).lines())["track"]
    assert told.startswith("broken 2 times")


def test_what_is_unknown_is_said_to_be_unknown() -> None:
    lines = dict(empty_report().lines())
    assert lines["least clearance"] == "unknown (camera)"
    assert "unknown" in lines["goal error"]


def test_a_number_that_is_none_cannot_be_written() -> None:
    report = Report(
        "done", "", 1, 1, 1, 1, 0, math.nan, TrackingError(), None, None, 1.0,
        LinkCounts(), FrameCounts(), Latencies(), ground_truth=True,
    )  # fmt: skip
    with pytest.raises(ValueError, match="Out of range"):
        run_of(report).to_json()


def test_tracking_errors_are_distances_from_the_path() -> None:
    path = np.array([(0.0, 0.0), (2.0, 0.0)])
    track = np.array([(0.5, 0.03), (1.0, -0.04), (2.0, 0.0)])
    errors = tracking_error(track, path)
    assert errors == pytest.approx([0.03, 0.04, 0.0])
    assert rms_and_max(errors).max == pytest.approx(0.04)
    assert rms_and_max(errors).rms == pytest.approx(0.05 / math.sqrt(3))
    assert rms_and_max(np.empty(0)) == TrackingError(None, None)


def test_percentiles_are_milliseconds() -> None:
    assert percentiles_ms([0.01] * 99 + [0.05]).p50 == pytest.approx(10.0)
    assert percentiles_ms([]) == CaptureToWire(None, None)
