"""Recording: nothing lost, nothing late, whatever happens to the disk or the program."""

from __future__ import annotations

import shutil
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

from navigation.config import load_config
from navigation.loop.recorder import MOST_PICTURES_WAITING
from navigation.mission.cycle import PlanRequest
from navigation.mission.mission import Station
from navigation.recording import files as recording_files
from navigation.recording.events import PlanAnswered, PlanAsked, Told
from navigation.recording.files import RecordingError
from navigation.recording.reader import read_recording
from navigation.recording.tape import read_tape
from navigation.run.replay import replay
from tests.support.runs.light_camera import in_small_pictures
from tests.support.runs.recordings import (
    BEGAN,
    EVERY,
    GOAL,
    RecordedBench,
    make_recording,
    recording_config,
)
from tests.support.waiting import wait_until


def test_a_recording_holds_foxglove_s_schemas_and_is_stamped_with_the_wall_clock(
    lossless: Path,
) -> None:
    schemas: dict[str, str] = {}
    counts: Counter[str] = Counter()
    times_ns = []
    with lossless.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            schemas[channel.topic] = schema.name
            counts[channel.topic] += 1
            times_ns.append(message.log_time)
    assert schemas["/camera"] == "foxglove.CompressedImage"
    assert schemas["/scene"] == schemas["/roadmap"] == schemas["/plan"] == "foxglove.SceneUpdate"
    assert schemas["/robot/7/pose"] == "foxglove.PoseInFrame"
    assert counts["/camera"] == counts["/clearway/frames"] == 12
    assert counts["/scene"] == counts["/roadmap"] == counts["/plan"] == 1
    began_ns = BEGAN.timestamp() * 1e9
    assert began_ns <= min(times_ns)
    assert max(times_ns) <= began_ns + 1e9


def test_what_was_recorded_is_read_back_without_loss(lossless: Path) -> None:
    recording = read_recording(lossless)
    assert not recording.cut
    assert recording.config.robot.marker_id == 7
    assert len(recording.frames) == 12
    (scene,) = recording.scenes
    assert len(scene.scene.objects) == 7
    (plan,) = recording.plans
    assert plan.answer["status"] == "ok"
    assert plan.request.stations[0].x == 0.20
    times = [time_ns for time_ns, _ in recording.pictures()]
    assert times == sorted(recording.frames)
    for _, picture in recording.pictures():
        assert picture.shape == (480, 640)


def test_a_picture_without_loss_is_the_picture(tmp_path: Path) -> None:
    pictures = []

    def look(bench: RecordedBench) -> None:
        frame = bench.camera.read(1.0)
        assert frame is not None
        pictures.append(frame.image)
        bench.recorder.saw(frame, {}, None)

    (file,) = make_recording(tmp_path, look, **EVERY)
    ((_, picture),) = read_recording(file).pictures()
    np.testing.assert_array_equal(picture, pictures[0])


def test_only_as_many_pictures_a_second_are_recorded_as_configured(tmp_path: Path) -> None:
    (file,) = make_recording(tmp_path, lambda bench: bench.frames(30), picture_rate_hz=10.0)
    recording = read_recording(file)
    assert len(recording.frames) == 30, "what was seen is recorded for every frame"
    assert 9 <= sum(1 for _ in recording.pictures()) <= 11


def test_a_writer_that_lags_drops_pictures_counts_them_and_keeps_every_event(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The writer is held at its first event until sixty frames have come."""
    counts = []
    go_on = threading.Event()
    write = recording_files.RecordingFiles.write

    def held(self: Any, event: Any) -> None:
        assert go_on.wait(30.0)
        write(self, event)

    monkeypatch.setattr(recording_files.RecordingFiles, "write", held)

    def crowd(bench: RecordedBench) -> None:
        frame = bench.camera.read(1.0)
        assert frame is not None
        for _ in range(60):
            bench.now_s += 0.1
            bench.recorder.saw(replace(frame, captured_s=bench.now_s), {}, None)
        counts.append(bench.recorder.counts())
        go_on.set()

    (file,) = make_recording(tmp_path, crowd)
    recording = read_recording(file)
    kept = sum(1 for _ in recording.pictures())
    assert counts[0].dropped == 60 - kept
    assert 0 < kept <= 2 * MOST_PICTURES_WAITING
    assert len(recording.frames) == 60


# Size and rotation.


def test_a_full_file_is_followed_by_another_that_stands_alone(tmp_path: Path) -> None:
    def fill(bench: RecordedBench) -> None:
        for number in range(6):
            bench.frames(6)
            bench.plan(number + 1)

    files = make_recording(tmp_path, fill, file_mb=1.0, **EVERY)
    assert len(files) > 2
    for file in files[1:]:
        recording = read_recording(file)
        assert recording.scenes[0].carried
        if recording.frames:
            assert replay(recording).is_equal
    parts = [read_recording(file) for file in files]
    assert [part.part for part in parts] == list(range(1, len(files) + 1))
    assert sum(len(part.frames) for part in parts) == 36
    assert sum(not plan.carried for part in parts for plan in part.plans) == 6


def test_a_file_begins_with_what_still_holds(tmp_path: Path) -> None:
    """Whoever replays the second file sees the plan, and what the mission was."""

    def drive(bench: RecordedBench) -> None:
        bench.frames(2)
        bench.plan(1)
        bench.plan(2)
        bench.recorder.put(Told(bench.now_s, "info", "driving: to the first station", "mission"))
        bench.recorder.put(Told(bench.now_s, "info", "driving: to the second station", "mission"))
        bench.frames(16)

    files = make_recording(tmp_path, drive, file_mb=1.0, **EVERY)
    assert len(files) > 2
    first, *others = [read_tape(file) for file in files]
    for tape in others:
        plan = tape.plan_at(tape.begin_s)
        assert plan is not None
        assert plan.answer["carried"]
        assert {**plan.answer, "carried": False} == first.plans[""][1].answer
        assert [one.answer["id"] for one in tape.plans[""]] == [2]
        assert tape.said_at(tape.begin_s) == "driving: to the second station"


def test_a_question_is_answered_across_the_end_of_a_file(tmp_path: Path) -> None:
    def ask_and_wait(bench: RecordedBench) -> None:
        bench.frames(2)
        request = PlanRequest(1, bench.start, (Station(*GOAL),), bench.revision)
        bench.recorder.put(PlanAsked(bench.now_s, request))
        bench.frames(16)
        bench.recorder.put(PlanAnswered(bench.now_s, bench.planner.answer(request)))

    files = make_recording(tmp_path, ask_and_wait, file_mb=1.0, **EVERY)
    plans = [read_recording(file).plans for file in files]
    assert len(files) > 2
    assert [len(of_file) for of_file in plans] == [0] * (len(files) - 1) + [1]
    assert not plans[-1][0].carried


def test_the_oldest_files_go_when_the_folder_has_grown_too_large(tmp_path: Path) -> None:
    stranger = tmp_path / "holiday.mcap"
    stranger.write_bytes(b"x" * 3_000_000)
    oldest = tmp_path / "clearway_2001-01-01_00-00-00_001.mcap"
    oldest.write_bytes(b"x" * 3_000_000)
    counts = []

    def fill(bench: RecordedBench) -> None:
        bench.frames(40)
        counts.append(bench.recorder.counts())

    make_recording(tmp_path, fill, file_mb=1.0, limit_mb=4.0, **EVERY)
    ours = list(tmp_path.glob("clearway_*.mcap"))
    assert stranger.exists(), "only recordings are removed"
    assert not oldest.exists()
    assert counts[0].removed >= 2
    assert sum(file.stat().st_size for file in ours) < 6_500_000, "the limit and the one in hand"


def test_the_present_files_outlive_those_that_a_wrong_clock_has_dated_later(
    tmp_path: Path,
) -> None:
    """A computer without a clock of its own begins in the past until the network tells the time."""
    earlier = tmp_path / "clearway_2099-01-01_00-00-00_001.mcap"
    earlier.write_bytes(b"x" * 3_000_000)
    make_recording(tmp_path, lambda bench: bench.frames(12), file_mb=1.0, limit_mb=3.0, **EVERY)
    assert not earlier.exists()
    assert list(tmp_path.glob("clearway_*_001.mcap")), "the beginning of this recording"


def test_a_disk_that_is_nearly_full_ends_the_recording_with_a_reason_and_not_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = shutil.disk_usage(tmp_path)._replace(free=5_000_000)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage)
    summaries = []

    def go_on(bench: RecordedBench) -> None:
        bench.frames(20)
        bench.recorder.put(Told(bench.now_s, "info", "still running", "test"))
        summaries.append(bench.recorder.summary())

    make_recording(tmp_path, go_on)
    assert "5 MB are free: must be at least 100 MB" in summaries[0]


def test_a_recorder_turns_while_it_lives_and_says_when_it_has_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ended = []

    def go_on(bench: RecordedBench) -> None:
        turns = bench.recorder.turns
        assert wait_until(lambda: bench.recorder.turns > turns)  # without anything to write
        ended.append(bench.recorder.has_ended())
        monkeypatch.setattr(bench.recorder, "_write", lambda _: 1 / 0)
        bench.frames(1)
        assert wait_until(bench.recorder.has_ended)
        ended.append(bench.recorder.counts().failed)

    make_recording(tmp_path, go_on)
    assert ended[0] is False
    assert "unexpected ZeroDivisionError" in str(ended[1])


def test_a_folder_that_cannot_be_made_is_said(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(RecordingError, match=r"taken/recordings"):
        make_recording(tmp_path / "taken" / "recordings", lambda _: None)


# Into a file that was named.


def named(folder: Path, each: Callable[[RecordedBench], None], **recording: Any) -> list[str]:
    bench = RecordedBench(in_small_pictures(recording_config(**recording)), folder, "run.mcap")
    with bench.recorder:
        each(bench)
    return sorted(file.name for file in folder.iterdir())


def test_a_named_file_holds_all_and_no_other_is_begun(tmp_path: Path) -> None:
    def each(bench: RecordedBench) -> None:
        assert bench.recorder.path == tmp_path / "run.mcap"
        bench.frames(30)
        bench.plan()

    assert named(tmp_path, each, file_mb=0.1, **EVERY) == ["run.mcap"]
    assert (tmp_path / "run.mcap").stat().st_size > 200_000
    recording = read_recording(tmp_path / "run.mcap")
    assert len(recording.frames) == 30
    assert len(recording.plans) == 1
    assert not recording.cut


def test_a_run_that_begins_again_overwrites_nothing(tmp_path: Path) -> None:
    expected = []
    for name in ("run.mcap", "run_002.mcap", "run_003.mcap"):
        expected.append(name)
        assert named(tmp_path, lambda bench: bench.frames(1)) == expected
        assert all(len(read_recording(tmp_path / one).frames) == 1 for one in expected)


def test_a_named_file_ends_at_the_limit_and_says_so(tmp_path: Path) -> None:
    failed = []

    def each(bench: RecordedBench) -> None:
        for _ in range(200):
            bench.frames(1)
            if bench.recorder.has_ended():
                break
        failed.append(bench.recorder.counts().failed)

    (tmp_path / "clearway_2025-01-01_00-00-00_001.mcap").write_text("another recording")
    assert len(named(tmp_path, each, limit_mb=1.0, **EVERY)) == 2
    assert failed == [f"{tmp_path / 'run.mcap'}: 1 MB: must be less than recording.limit_mb = 1"]
    assert len(read_recording(tmp_path / "run.mcap").frames) > 5


# Killed.

KILLED = """
import sys, time
from pathlib import Path
from tests.support.runs.recordings import RecordedBench, recording_config

bench = RecordedBench(recording_config(), Path(sys.argv[1]))
bench.clock = None
offset_s = bench.now_s - time.monotonic()
bench.recorder._clock = lambda: time.monotonic() + offset_s
with bench.recorder:
    while True:
        bench.frame()
        print(repr(bench.now_s), flush=True)
        # at the camera's pace: what a kill loses is told in seconds
        time.sleep(max(0.0, bench.now_s - offset_s - time.monotonic()))
"""


def test_kill_9_loses_at_most_the_last_second(tmp_path: Path) -> None:
    root = Path(__file__).parents[3]
    with subprocess.Popen(
        [sys.executable, "-c", KILLED, str(tmp_path)], stdout=subprocess.PIPE, text=True, cwd=root
    ) as process:
        assert process.stdout is not None
        seen = [float(process.stdout.readline()) for _ in range(90)]
        process.kill()
        seen += [float(line) for line in process.stdout.read().splitlines()]
    (file,) = tmp_path.glob("*.mcap")
    recording = read_recording(file)
    assert recording.cut
    last_s = max(frame.captured_s for frame in recording.frames.values())
    assert last_s > seen[-1] - 1.0
    result = replay(recording)
    assert result.is_equal
    assert result.pictures > 10


def test_the_settings_of_a_recording_are_off_unless_asked_for() -> None:
    root = Path(__file__).parents[3]
    assert not load_config(root / "configs" / "simulation.yaml", {}).recording.record
