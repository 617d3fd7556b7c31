"""A recording of several robots on the page: each of them at any moment, and who waits for whom."""

import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from navigation.config.dashboard import DashboardSection
from navigation.dashboard.replay.player import Player
from navigation.dashboard.replay.replayed_run import ReplayedRun
from navigation.dashboard.shown import IT_IS_A_RECORDING
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RunState
from navigation.recording.tape import Tape, read_tape
from tests.navigation.dashboard.kept.test_replay import ReplaySite
from tests.support.runs.recordings import record_alcove
from tests.support.waiting import wait_until

pytestmark = pytest.mark.slow
LEFT, RIGHT = "left", "right"
AFTER_S = 1.0
CLOSE_S = 1e-6
"""Stamps in the file are whole nanoseconds."""


class Lived:
    """What the run published and when, by its clock, and when somebody waited first."""

    def __init__(self) -> None:
        self.states: dict[float, RunState] = {}
        self.waited_s: float | None = None

    def look(self, daemon: Daemon, now: RunState) -> bool:
        clock_s = daemon.started_s + now.time_s
        self.states[clock_s] = now
        if self.waited_s is None and now.waits_for:
            self.waited_s = clock_s
        return self.waited_s is not None and clock_s > self.waited_s + AFTER_S


@pytest.fixture(scope="module")
def lived() -> Lived:
    return Lived()


@pytest.fixture(scope="module")
def tape(lived: Lived, tmp_path_factory: pytest.TempPathFactory) -> Tape:
    """From the start until a second after one of the two has begun to wait for the other."""
    (file,) = record_alcove(tmp_path_factory.mktemp("alcove"), lived.look)
    return read_tape(file)


@pytest.fixture
def run(tape: Tape) -> Iterator[ReplayedRun]:
    player = Player(tape.end_s - tape.begin_s, playing=False)
    run = ReplayedRun(tape, player, DashboardSection(port=0), time.monotonic)
    assert wait_until(lambda: run.at(0.5).together.roadmap is not None)
    yield run
    run.close()


def test_at_every_moment_each_robot_is_where_it_was_and_waits_for_whom_it_did(
    tape: Tape, lived: Lived, run: ReplayedRun
) -> None:
    assert len(lived.states) > 100
    for clock_s, was in lived.states.items():
        if not tape.begin_s < clock_s <= tape.end_s:
            continue
        fleet = run.at(clock_s - tape.begin_s + CLOSE_S, in_short=True)
        assert (fleet.waits, fleet.waits_for) == (was.waits, was.waits_for)
        for name, one in was.robots.items():
            replayed = fleet.robots[name]
            assert (replayed.mission.state, replayed.sentence) == (one.mission.state, one.sentence)
            was_down, is_down = one.link.down_reason, replayed.link.down_reason
            assert (is_down is None) is (was_down is None), "said when it changes"
            if one.pose is not None:
                assert replayed.pose is not None
                assert (replayed.pose.id, replayed.pose.x) == (one.pose.id, one.pose.x)


def test_each_robot_has_its_own_plan_goal_and_clearance(
    tape: Tape, lived: Lived, run: ReplayedRun
) -> None:
    was = list(lived.states.values())[-1]
    fleet = run.at(tape.end_s - tape.begin_s)
    assert (fleet.together.path, fleet.together.pose) == (None, None)
    for name, one in was.robots.items():
        replayed = fleet.robots[name]
        assert one.path is not None
        assert replayed.path is not None
        np.testing.assert_array_equal(replayed.path.points, one.path.points)
        assert replayed.mission.stations == one.mission.stations
        assert replayed.clearance_m == pytest.approx(one.clearance_m, abs=1e-3)
        assert (replayed.link.state, replayed.link.down_reason) == (one.link.state, None)
        assert replayed.to_go_m is not None
        assert 0.0 < replayed.to_go_m < one.path.length


def test_a_recording_without_waits_says_of_nobody_that_it_waits(tape: Tape) -> None:
    """Those of older programs: what the robots said of themselves is there all the same."""
    older = replace(tape, waits=[])
    player = Player(tape.end_s - tape.begin_s, playing=False)
    run = ReplayedRun(older, player, DashboardSection(port=0), time.monotonic)
    fleet = run.at(tape.end_s - tape.begin_s)
    run.close()
    assert (fleet.waits, fleet.waits_for) == ({}, {})
    assert any("which has to pass first" in one.sentence for one in fleet.robots.values())


def test_the_page_is_greeted_with_all_robots_and_told_who_waits_after_a_jump(
    run: ReplayedRun, tape: Tape, lived: Lived
) -> None:
    assert lived.waited_s is not None
    with ReplaySite(run) as site, site.live() as page:
        hello = page.hear("hello")
        assert [one["name"] for one in hello["robots"]] == [LEFT, RIGHT]
        assert "replay" in hello
        page.send(type="replay", id=1, do="seek", value=lived.waited_s - tape.begin_s + 0.1)
        page.hear("hello")
        tracks = {(track := page.hear("track"))["robot"]: track for _ in range(2)}
        for track in tracks.values():
            assert len(track["items"]) > 5
            assert None not in track["items"], "driven, not lifted"
        state = page.hear("state")
        waits = {one["name"]: one["waits_for"] for one in state["robots"]}
        assert sorted(waits.values(), key=str) in ([None, LEFT], [None, RIGHT])
        assert all(one["pose"] is not None for one in state["robots"])


def test_nothing_can_be_ordered_of_one_of_them_either(run: ReplayedRun) -> None:
    with ReplaySite(run) as site, site.live() as page:
        page.join()
        for order in ("stop", "go", "pause", "resume", "rearm", "replan"):
            answer = page.order(order, robot=LEFT, stations=[{"x_m": 1.0, "y_m": 0.9}])
            assert (answer["ok"], answer["error"]) == (False, IT_IS_A_RECORDING)
        status, text, _ = site.get("/api/stop?robot=left", "POST")
    assert status == 200
    assert IT_IS_A_RECORDING in text
