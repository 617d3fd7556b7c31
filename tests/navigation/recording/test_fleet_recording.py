"""The recording of several robots: channels by name, and the same result the second time."""

from __future__ import annotations

from pathlib import Path

import pytest
from mcap.reader import make_reader

from navigation.fleet.request import FleetRequest
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RunState
from navigation.recording.compare import ComparisonTolerances
from navigation.recording.reader import read_recording
from navigation.recording.tape import read_tape
from navigation.run.replay import replay
from tests.support.pictures import call
from tests.support.runs.recordings import EVERY, record_alcove

EXACT = ComparisonTolerances(1e-9, 1e-9, 1e-9, 1e-9, 1e-9)
SECONDS = 1.5


@pytest.fixture(scope="module")
def alcove(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two robots have been planned together and have set off; every picture, without loss."""
    folder = tmp_path_factory.mktemp("alcove")
    (file,) = record_alcove(folder, lambda _daemon, now: now.time_s > SECONDS, **EVERY)
    return file


def test_each_robot_has_channels_of_its_own_name(alcove: Path) -> None:
    topics, sources = set(), set()
    with alcove.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            topics.add(channel.topic)
            if channel.topic == "/log":
                sources.update(name for name in (b"left", b"right") if name in message.data)
    for name in ("left", "right"):
        assert {f"/robot/{name}/pose", f"/robot/{name}/plan", f"/clearway/link/{name}"} <= topics
    assert not {"/plan", "/clearway/link", "/clearway/plans", "/robot/1/pose"} & topics
    assert sources == {b"left", b"right"}


def test_request_promises_and_gates_are_read_back(alcove: Path) -> None:
    recording = read_recording(alcove)
    (plan,) = recording.plans
    assert isinstance(plan.request, FleetRequest)
    assert [one.name for one in plan.request.travellers] == ["left", "right"]
    robots = plan.answer["robots"]
    assert {name: one["status"] for name, one in robots.items()} == {"left": "ok", "right": "ok"}
    waits = {gate["other"] for one in robots.values() for gate in one["gates"]}
    assert waits, "in a corridor with one niche somebody gives way"


def test_a_file_begins_with_every_robot_s_promise_and_who_waits(tmp_path: Path) -> None:
    waited_s = list[float]()

    def waited(_daemon: Daemon, now: RunState) -> bool:
        waited_s.extend([now.time_s] if now.waits else [])
        return bool(waited_s) and now.time_s > waited_s[0] + SECONDS

    files = record_alcove(tmp_path, waited, file_mb=1.0, **EVERY)
    # the writer is behind: a file may have room for what still holds only
    *_, first, last = (read_tape(file) for file in files if read_recording(file).frames)
    assert last.waits_at(last.begin_s) == first.waits_at(first.end_s) != ({}, {})
    for name in ("left", "right"):
        plan, before = last.plan_at(last.begin_s, name), first.plan_at(first.end_s, name)
        assert plan is not None
        assert before is not None
        assert plan.answer["path"] == before.answer["path"]
        assert last.said_at(last.begin_s, name)
    assert replay(last.recording).is_equal


def test_without_loss_it_replays_to_the_same_numbers(alcove: Path) -> None:
    result = replay(read_recording(alcove), EXACT)
    assert result.differences == []
    assert (result.scenes, result.plans, result.near_ties) == (1, 1, 0)
    assert result.poses >= 2 * 25


def test_the_command_replays_it(alcove: Path) -> None:
    told = call("replay", alcove)
    assert told.code == 0, told
    assert "1 plans" in told.out


def test_a_path_and_an_order_that_differ_are_told_with_the_robot_s_name(alcove: Path) -> None:
    recording = read_recording(alcove)
    (plan,) = recording.plans
    plan.answer["robots"]["right"]["path"][3][0] += 0.2
    (difference,) = replay(recording).differences
    assert "plan 1 of right leaves the recorded one" in difference.sentence

    recording = read_recording(alcove)
    (plan,) = recording.plans
    robots = plan.answer["robots"]
    name = next(name for name, one in robots.items() if one["gates"])
    robots[name]["gates"] = []
    (difference,) = replay(recording).differences
    assert f"plan 1 of {name} gives way to" in difference.sentence
    assert difference.sentence.endswith("the recorded one to nobody")
