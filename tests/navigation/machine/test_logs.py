"""The log of events: one line each, machine-readable, and only what is news."""

from __future__ import annotations

import io
import json
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from navigation.link.serial_link import LinkSnapshot, LinkState
from navigation.loop.recorder import RecordingCounts
from navigation.loop.run_state import RunState
from navigation.machine import logs
from navigation.machine.logs import EventLog, RunLog
from navigation.machine.sd_notify import Notifier, Watchdog
from navigation.mission.mission import MissionProgress, State, Station
from navigation.run.attendance import Attendance
from vision.camera.latest_frame import CameraStatus

NOW = datetime(2026, 3, 4, 5, 6, 7, 891000, tzinfo=timezone(timedelta(hours=2)))


def log(form: Any, **options: Any) -> tuple[EventLog, io.StringIO]:
    stream = io.StringIO()
    return EventLog(stream, form, now=lambda: NOW, **options), stream


def test_an_event_is_one_line_of_json_with_its_time_in_utc() -> None:
    events, stream = log("json")
    events.write("warning", "state", reason="two\nlines", x_m=1.23456789, pose=None)
    assert stream.getvalue().count("\n") == 1
    assert json.loads(stream.getvalue()) == {
        "time": "2026-03-04T03:06:07.891Z",
        "level": "warning",
        "event": "state",
        "reason": "two\nlines",
        "x_m": 1.234568,
        "pose": None,
    }


def test_numbers_that_json_has_no_word_for_are_null() -> None:
    events, stream = log("json")
    events.write("info", "plan", length_m=float("inf"))
    assert json.loads(stream.getvalue())["length_m"] is None


def test_a_line_of_text_quotes_what_needs_it_and_leaves_out_what_is_not_there() -> None:
    events, stream = log("text")
    events.write("info", "state", reason='a "word"', state="driving", x_m=None, text="a\nb")
    expected = r'2026-03-04T03:06:07.891Z info    state reason="a \"word\"" state=driving'
    assert stream.getvalue() == expected + ' text="a\\nb"\n'


@pytest.mark.parametrize("form", ["json", "text"])
def test_half_of_a_pair_is_written_as_its_number(form: str, tmp_path: Path) -> None:
    with (tmp_path / "log").open("w+", encoding="utf-8") as stream:
        EventLog(stream, form, now=lambda: NOW).write("info", "said", reason="\udcff\x1b")  # type: ignore[arg-type]
        stream.seek(0)
        assert "\\udcff\\u001b" in stream.read()


def test_the_journal_gets_syslog_s_priorities() -> None:
    events, stream = log("text", priorities=True)
    events.write("error", "watchdog")
    events.write("info", "ready")
    assert [line[:3] for line in stream.getvalue().splitlines()] == ["<3>", "<6>"]


@pytest.mark.parametrize(("level", "count"), [("debug", 4), ("info", 3), ("error", 1)])
def test_what_is_below_the_level_is_not_written(level: Any, count: int) -> None:
    events, stream = log("json", level=level)
    for each in logs.LEVELS:
        events.write(each, "said")
    assert stream.getvalue().count("\n") == count


def test_without_a_form_nothing_is_written() -> None:
    events, stream = log(None)
    events.write("error", "said")
    assert stream.getvalue() == ""


def test_a_file_that_is_full_says_so_and_takes_no_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(logs, "MOST_FILE_BYTES", 1000)
    events = EventLog.to_file(tmp_path / "events.jsonl", now=lambda: datetime.now(UTC))
    for _ in range(100):
        events.write("info", "said", line="x" * 50)
    events.close()
    lines = (tmp_path / "events.jsonl").read_text().splitlines()
    assert json.loads(lines[-1]) == {"event": "full"}
    assert 1000 <= sum(map(len, lines)) < 1300


# News.


@dataclass(frozen=True)
class Now:
    """What `RunLog.cycle` looks at of a daemon's state."""

    mission: MissionProgress
    sentence: str
    link: LinkSnapshot
    pose: None = None
    path: None = None
    clearance_m: float | None = None
    troubles: tuple[str, ...] = ()


STATIONS = (Station(1.0, 1.0), Station(2.0, 1.0))
DRIVING = Now(
    MissionProgress(STATIONS, state=State.DRIVING, reason="driving"),
    "driving",
    LinkSnapshot(LinkState.STREAM, None, 0.0),
)
FINE = CameraStatus("running", "", 30.0, 1, 0, 0, 0.0)


def run_log() -> tuple[RunLog, io.StringIO]:
    events, stream = log("json")
    return RunLog(events), stream


def events_of(stream: io.StringIO) -> list[tuple[str, str]]:
    """(level, event) of each line since the last time."""
    lines = [json.loads(line) for line in stream.getvalue().splitlines()]
    stream.seek(0)
    stream.truncate()
    return [(line["level"], line["event"]) for line in lines]


def test_a_cycle_without_news_writes_nothing() -> None:
    run, stream = run_log()
    run.cycle({"": DRIVING}, FINE)
    assert events_of(stream) == [("info", "state"), ("info", "link"), ("info", "camera")]
    for _ in range(100):
        run.cycle({"": DRIVING}, FINE)
    assert events_of(stream) == []


def test_that_something_lasts_longer_by_now_is_no_news() -> None:
    run, stream = run_log()
    held = replace(DRIVING.mission, state=State.HOLDING)
    for ms in range(200, 30_000, 50):
        sentence = f"no picture from the camera for {ms} ms"
        down = replace(DRIVING.link, down_reason=f"no byte for {ms / 1e3:.1f} s: is it on?")
        lost = replace(FINE, state="lost", reason=f"unplugged; trying again in {ms / 1e3:g} s")
        run.cycle({"": replace(DRIVING, mission=held, sentence=sentence, link=down)}, lost)
    assert events_of(stream) == [("warning", "state"), ("warning", "link"), ("warning", "camera")]
    run.cycle({"": replace(DRIVING, mission=held, sentence="the pose is old", link=down)}, lost)
    assert events_of(stream) == [("warning", "state")]


def test_a_hold_a_station_a_lost_link_and_a_lost_camera_are_news() -> None:
    run, stream = run_log()
    run.cycle({"": DRIVING}, FINE)
    events_of(stream)
    held = replace(DRIVING.mission, state=State.HOLDING, visited=1)
    down = replace(DRIVING.link, down_reason="the port broke")
    now = replace(DRIVING, mission=held, sentence="the link is down", link=down)
    run.cycle({"": now}, replace(FINE, state="lost", reason="unplugged"))
    assert events_of(stream) == [
        ("warning", "state"),
        ("info", "station"),
        ("warning", "link"),
        ("warning", "camera"),
    ]


@dataclass
class Recording:
    """What `Attendance` asks of a recorder."""

    now: RecordingCounts
    turns: int = 0
    alive: bool = True

    def counts(self) -> RecordingCounts:
        return self.now

    def has_ended(self) -> bool:
        return bool(self.now.failed) or not self.alive


def attendance_of(recording: Recording) -> tuple[Attendance, io.StringIO, list[str]]:
    run, stream = run_log()
    daemon: Any = SimpleNamespace(camera=SimpleNamespace(status=lambda: FINE), troubles={})
    watched: Any = recording
    said: list[str] = []
    watchdog = Watchdog(Notifier(None), None, dict)
    return Attendance(daemon, run, watchdog, watched, said.append), stream, said


class FullDisk(io.StringIO):
    """A stream without room."""

    full = True

    def write(self, text: str) -> int:
        if self.full:
            raise OSError(28, "No space left on device")
        return super().write(text)


def test_the_events_of_several_robots_name_them_and_are_news_of_each() -> None:
    run, stream = run_log()
    run.cycle({"ada": DRIVING, "bob": DRIVING}, FINE)
    stopped = replace(DRIVING.mission, state=State.STOPPED)
    stream.seek(0)
    stream.truncate()
    run.cycle({"ada": DRIVING, "bob": replace(DRIVING, mission=stopped)}, FINE)
    (one,) = (json.loads(line) for line in stream.getvalue().splitlines())
    assert (one["event"], one["level"], one["robot"]) == ("state", "warning", "bob")


def test_a_log_that_cannot_be_written_says_so_and_ends_nothing() -> None:
    stream = FullDisk()
    events = EventLog(stream, "json", now=lambda: NOW)
    events.write("info", "said", reason="lost")
    assert events.trouble == "the log: cannot be written: No space left on device"
    stream.full = False
    events.write("info", "said", reason="kept")
    assert events.trouble == ""
    assert [json.loads(line)["reason"] for line in stream.getvalue().splitlines()] == ["kept"]
    stream.close()
    events.write("info", "said")
    assert "closed file" in events.trouble
    events.close()


def test_a_log_s_file_that_cannot_be_opened_is_a_trouble(tmp_path: Path) -> None:
    events = EventLog.to_file(tmp_path / "nowhere" / "events.jsonl", now=lambda: NOW)
    events.write("info", "said")
    assert "events.jsonl: cannot be written: No such file" in events.trouble
    events.close()


def test_a_trouble_is_said_once_and_so_is_its_end() -> None:
    attendance, stream, said = attendance_of(Recording(RecordingCounts()))
    troubled: Any = replace(DRIVING, troubles=("the journal: no room",))
    well: Any = DRIVING
    for now in (well, troubled, troubled, troubled, well, well):
        attendance.cycle(RunState(0.0, {"": now}), 0.0)
    assert [e for e in events_of(stream) if e[1] == "trouble"] == [
        ("error", "trouble"),
        ("info", "trouble"),
    ]
    assert said == [
        "trouble: the journal: no room",
        "trouble over: the journal: no room",
    ]


def test_a_recording_that_drops_and_one_that_ends_are_told_once() -> None:
    recording = Recording(RecordingCounts())
    attendance, stream, said = attendance_of(recording)
    now: Any = DRIVING
    attendance.cycle(RunState(0.0, {"": now}), 0.0)
    events_of(stream)
    for dropped in (1, 2):
        recording.now = RecordingCounts(dropped=dropped)
        attendance.cycle(RunState(0.0, {"": now}), 0.1)
    assert events_of(stream) == [("warning", "recording")]
    recording.now = RecordingCounts(dropped=2, failed="the disk is full")
    attendance.cycle(RunState(0.0, {"": now}), 0.2)
    attendance.cycle(RunState(0.0, {"": now}), 0.3)
    assert events_of(stream) == [("error", "recording")]
    assert said[-1] == "recording: ended early: the disk is full"
    assert len(said) == 2


def test_a_recorder_that_hangs_or_dies_is_told_once_each_time() -> None:
    recording = Recording(RecordingCounts(waiting=7))
    attendance, _, said = attendance_of(recording)
    now: Any = DRIVING
    for tenth in range(100):
        attendance.cycle(RunState(0.0, {"": now}), 0.1 * tenth)
    assert said == ["recording: hangs: nothing written for 3 s, 7 wait"]
    recording.turns += 1
    attendance.cycle(RunState(0.0, {"": now}), 10.0)
    assert len(said) == 1, "it gets on again"
    attendance.cycle(RunState(0.0, {"": now}), 14.0)
    assert len(said) == 2
    recording.alive = False
    attendance.cycle(RunState(0.0, {"": now}), 14.1)
    attendance.cycle(RunState(0.0, {"": now}), 14.2)
    assert said[2:] == ["recording: ended early: its thread has died"]


def test_every_log_of_a_run_gets_every_event() -> None:
    (one, first), (other, second) = log("json"), log("text")
    RunLog(one, other).write("info", "ready")
    assert "ready" in first.getvalue()
    assert "ready" in second.getvalue()
