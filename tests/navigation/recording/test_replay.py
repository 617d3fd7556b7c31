"""Replay: the same result the second time, and every difference told."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from navigation.loop.planning import ArenaPlanner
from navigation.mission.cycle import PlanAnswer, PlanRequest
from navigation.recording.compare import ComparisonTolerances
from navigation.recording.files import RecordingError
from navigation.recording.reader import read_recording
from navigation.run.replay import replay
from planner.path import Path as PlannedPath
from planner.scene import Scene
from tests.support.pictures import call
from tests.support.runs.recordings import make_recording

EXACT = ComparisonTolerances(1e-9, 1e-9, 1e-9, 1e-9, 1e-9)


def test_a_recording_without_loss_replays_to_the_same_numbers(lossless: Path) -> None:
    result = replay(read_recording(lossless), EXACT)
    assert result.differences == []
    assert (result.pictures, result.scenes, result.plans) == (12, 1, 1)
    assert result.poses >= 10


def test_jpeg_pictures_replay_within_the_tolerance_and_not_exactly(jpeg: Path) -> None:
    told = call("replay", jpeg)
    assert told.code == 0, told
    assert "equal" in told.out
    assert not replay(read_recording(jpeg), EXACT).is_equal


def test_another_place_of_the_robot_is_told(lossless: Path) -> None:
    recording = read_recording(lossless)
    time_ns = sorted(recording.frames)[-1]
    x, y, heading = recording.frames[time_ns].poses[7]
    recording.frames[time_ns].poses[7] = (x + 0.004, y, heading)
    (difference,) = replay(recording).differences
    assert difference.kind == "pose"
    assert "robot 7 is 4.0 mm" in difference.sentence


def test_a_robot_that_only_the_recording_saw_is_told_once(tmp_path: Path) -> None:
    (file,) = make_recording(tmp_path, lambda bench: bench.frames(40))
    recording = read_recording(file)
    for frame in recording.frames.values():
        frame.poses[9] = (1.0, 1.0, 0.0)
    (difference,) = replay(recording).differences
    assert "robot 9 is seen in the recording only" in difference.sentence


def test_an_obstacle_more_is_told_and_a_plan_that_goes_elsewhere(lossless: Path) -> None:
    recording = read_recording(lossless)
    seen = recording.scenes[0]
    fewer = Scene("m", seen.scene.bounds, seen.scene.objects[:-1])
    recording.scenes[0] = replace(seen, revision=1, carried=False, scene=fewer)
    recording.plans[0].answer["path"][3][0] += 0.2
    kinds = [difference.kind for difference in replay(recording).differences]
    assert kinds == ["scene", "plan"]


def test_a_scene_seen_before_the_file_began_is_no_difference_where_a_robot_hides_it(
    lossless: Path,
) -> None:
    """A file of a corridor run began with a robot in a niche: its border is in no picture."""
    recording = read_recording(lossless)
    seen = recording.scenes[0]
    fewer = replace(seen.scene, objects=seen.scene.objects[:-1])
    recording.scenes[0] = replace(seen, carried=True, scene=fewer)
    result = replay(recording)
    assert result.differences == []
    assert (result.scenes, result.not_compared, result.plans) == (0, 1, 1)


def test_a_near_tie_is_counted_and_no_difference(
    lossless: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the replay's scene the way is another, in the recorded one it is the recorded.

    A planner that has once taken a way stays with it, in whatever scene it is asked next.
    """
    recording = read_recording(lossless)
    answer = ArenaPlanner.answer
    stays: set[int] = set()

    def wavering(self: ArenaPlanner, request: PlanRequest) -> PlanAnswer:
        honest = answer(self, request)
        if self._scene is recording.scenes[0].scene and id(self) not in stays:
            return honest
        stays.add(id(self))
        assert isinstance(honest.path, PlannedPath)
        points = honest.path.points + np.array([0.0, 0.2])
        return replace(honest, path=replace(honest.path, points=points))

    monkeypatch.setattr(ArenaPlanner, "answer", wavering)
    result = replay(recording)
    assert result.is_equal
    assert (result.plans, result.near_ties) == (1, 1)


def test_differences_end_with_code_1_and_as_json_they_say_all(lossless: Path, jpeg: Path) -> None:
    told = call("replay", lossless, jpeg, "--pose-mm", "1e-6", "--format", "json")
    assert told.code == 1
    one, other = (json.loads(line) for line in told.out.splitlines())
    assert (one["status"], other["status"]) == ("equal", "different")
    assert other["schema"] == "clearway.replay/1"
    assert {d["kind"] for d in other["differences"]} == {"pose"}


@pytest.mark.parametrize(
    ("content", "sentence"),
    [(b"", "not an MCAP recording"), (b"no recording at all", "not an MCAP recording")],
)
def test_a_file_that_is_no_recording_is_said(tmp_path: Path, content: bytes, sentence: str) -> None:
    file = tmp_path / "a.mcap"
    file.write_bytes(content)
    told = call("replay", file)
    assert told.code == 2
    assert sentence in told.err


def test_a_missing_file_is_said(tmp_path: Path) -> None:
    told = call("replay", tmp_path / "none.mcap")
    assert (told.code, told.out) == (2, "")
    assert "none.mcap" in told.err


def test_every_cut_of_a_recording_is_read_up_to_there_or_refused(
    jpeg: Path, tmp_path: Path
) -> None:
    data = jpeg.read_bytes()
    whole = len(read_recording(jpeg).frames)
    rng = np.random.default_rng(5)
    counts = []
    for length in sorted(rng.integers(1, len(data), 60)):
        file = tmp_path / "cut.mcap"
        file.write_bytes(data[:length])
        try:
            recording = read_recording(file)
        except RecordingError:
            counts.append(-1)
            continue
        assert recording.cut
        assert sum(1 for _ in recording.pictures()) <= len(recording.frames) + 1
        counts.append(len(recording.frames))
    assert counts == sorted(counts)
    assert counts[-1] <= whole
