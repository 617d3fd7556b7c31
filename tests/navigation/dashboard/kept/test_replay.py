"""A recording on the page: any moment of it, steered by those who look, driving nothing."""

import math
import socket
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navigation.config.dashboard import DashboardSection
from navigation.dashboard import Dashboard
from navigation.dashboard.replay.player import SPEEDS, Player
from navigation.dashboard.replay.replay_hub import ReplayHub
from navigation.dashboard.replay.replayed_run import ReplayedRun
from navigation.dashboard.shown import IT_IS_A_RECORDING
from navigation.mission.mission import State
from navigation.recording.events import Told
from navigation.recording.files import RecordingError
from navigation.recording.reader import read_recording
from navigation.recording.tape import Tape, read_tape
from tests.navigation.dashboard.site import Site
from tests.support.pictures import call
from tests.support.runs.recordings import EVERY, RecordedBench, make_recording
from tests.support.waiting import wait_until

STEP_M = 0.005
FRAMES = 40


def drive(bench: RecordedBench) -> None:
    """See the scene, plan, then move on a little with every picture, and arrive."""
    bench.frames(4)
    bench.plan()
    bench.recorder.put(Told(bench.now_s, "info", "driving: driving to station 1 of 1", "mission"))
    for _ in range(FRAMES):
        x, y, _ = bench.start
        bench.start = (x, y + STEP_M, math.pi / 2)
        bench.frames(1)
    bench.recorder.put(Told(bench.now_s, "info", "done: the robot is there", "mission"))
    bench.frames(2)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    (path,) = make_recording(tmp_path_factory.mktemp("tape"), drive, **EVERY)
    return path


@pytest.fixture(scope="module")
def tape(file: Path) -> Tape:
    return read_tape(file)


def replayed(tape: Tape) -> tuple[ReplayedRun, list[float]]:
    """A run that waits at its beginning, and the clock that it has."""
    now_s = [500.0]
    player = Player(tape.end_s - tape.begin_s, playing=False)
    return ReplayedRun(tape, player, DashboardSection(port=0), lambda: now_s[0]), now_s


@pytest.fixture
def run(tape: Tape) -> Iterator[ReplayedRun]:
    run, _ = replayed(tape)
    yield run
    run.close()


def test_the_command_closes_its_replay_where_no_page_can_be_opened(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    closed: list[ReplayedRun] = []
    monkeypatch.setattr(ReplayedRun, "close", lambda run: closed.append(run))
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert call("dashboard", file, "--no-browser", "--port", port).code == 1
    assert len(closed) == 1


def test_every_picture_is_found_by_its_place_in_the_file(tape: Tape, file: Path) -> None:
    whole = list(read_recording(file).pictures())
    assert len(tape.pictures) == len(whole) > FRAMES
    for at in (len(whole) - 1, 0, 17):
        assert tape.pictures[at].stamp_ns == whole[at][0]
        np.testing.assert_array_equal(tape.image(tape.pictures[at]), whole[at][1])


def test_a_moment_is_what_was_recorded_then(tape: Tape, run: ReplayedRun) -> None:
    begin = run.at(0.0).only
    assert (begin.mission.state, begin.mission.stations) == (State.IDLE, ())
    assert wait_until(lambda: run.at(0.7).only.roadmap is not None)
    middle = run.at(0.7).only
    assert (middle.mission.state, middle.mission.reason) == (
        State.DRIVING,
        "driving to station 1 of 1",
    )
    seen = tape.frame_at(tape.begin_s + 0.7)
    assert middle.pose is not None
    assert (middle.pose.x, middle.pose.y) == seen.poses[middle.pose.id][:2]
    assert middle.pose.vy == pytest.approx(STEP_M * 30.0, rel=0.3)
    assert middle.path is not None
    assert middle.path.length == tape.recording.plans[0].answer["length_m"]
    assert middle.to_go_m is not None
    assert 0.0 < middle.to_go_m < middle.path.length
    seen_so_far = [run.camera_at(place_s).captured for place_s in (0.0, 0.7)]
    assert seen_so_far == [1, tape.count_until(tape.begin_s + 0.7)]
    assert run.camera_at(0.7).rate_hz == pytest.approx(30.0, rel=0.2)
    end = run.at(tape.end_s - tape.begin_s).only
    assert (end.mission.state, end.path) == (State.DONE, None)


def test_what_is_shown_is_as_old_as_it_was(tape: Tape) -> None:
    run, now_s = replayed(tape)
    run.player.seek(now_s[0], 0.71)
    ages = []
    for _ in range(3):
        state = run.state.only
        assert state.pose is not None
        ages.append(now_s[0] - state.pose.captured_s)
        now_s[0] += 40.0
    seen_s = tape.frame_at(tape.begin_s + 0.71).captured_s
    assert ages == pytest.approx([tape.begin_s + 0.71 - seen_s] * 3, abs=1e-6)
    assert run.wall_clock() == pytest.approx(tape.begin_s + 0.71 + tape.wall_offset_s)
    run.close()


def test_a_file_without_its_end_is_shown_up_to_there(file: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(file.read_bytes()[: int(0.6 * file.stat().st_size)])
    tape = read_tape(cut)
    assert tape.recording.cut
    assert 5 < len(tape.pictures) < FRAMES
    assert tape.image(tape.pictures[-1]).size > 0


def test_what_is_no_recording_is_refused(tmp_path: Path) -> None:
    (tmp_path / "no.mcap").write_bytes(b"something else")
    with pytest.raises(RecordingError, match="not an MCAP recording"):
        read_tape(tmp_path / "no.mcap")
    (empty,) = make_recording(tmp_path / "empty", lambda bench: None)
    with pytest.raises(RecordingError, match="nothing was seen"):
        read_tape(empty)


ORDERS = st.one_of(
    st.tuples(st.just("wait"), st.floats(0.0, 9.0)),
    st.tuples(st.just("seek"), st.floats(-5.0, 40.0)),
    st.tuples(st.just("speed"), st.sampled_from(SPEEDS)),
    st.tuples(st.sampled_from(["play", "pause"]), st.just(0.0)),
)


@given(st.lists(ORDERS, max_size=30))
def test_the_player_is_where_a_sum_of_small_steps_is(orders: list[tuple[str, float]]) -> None:
    player, now_s = Player(20.0), 100.0
    player.seek(now_s, 0.0)
    place_s, playing, speed = 0.0, True, 1.0
    for order, value in orders:
        if order == "wait":
            now_s += value
            place_s = min(20.0, place_s + value * speed) if playing else place_s
        elif order == "seek":
            player.seek(now_s, value)
            place_s = min(20.0, max(0.0, value))
        elif order == "speed":
            player.set_speed(now_s, value)
            speed = value
        elif order == "play":
            player.play(now_s)
            place_s, playing = (0.0 if place_s >= 20.0 else place_s), True
        else:
            player.pause(now_s)
            playing = False
        assert player.place_s(now_s) == pytest.approx(place_s, abs=1e-9)


class ReplaySite(Site):
    """The page of a recording."""

    def __init__(self, run: ReplayedRun) -> None:
        self.said: list[str] = []
        clock = run._clock
        self.dashboard = Dashboard(
            run, say=self.said.append, hub=lambda: ReplayHub(run, clock=clock), clock=clock
        )


@pytest.fixture
def site(tape: Tape) -> Iterator[ReplaySite]:
    player = Player(tape.end_s - tape.begin_s, playing=False)
    run = ReplayedRun(tape, player, DashboardSection(port=0), time.monotonic)
    with ReplaySite(run) as site:
        yield site
    run.close()


def test_pages_are_steered_and_begin_again_after_a_jump(site: ReplaySite, tape: Tape) -> None:
    with site.live() as page:
        hello = page.hear("hello")
        assert hello["role"] == "nobody"
        assert hello["replay"]["file"] == tape.recording.path.name
        assert hello["replay"]["duration_s"] == pytest.approx(tape.end_s - tape.begin_s)
        page.join()
        page.send(type="replay", id=5, do="seek", value=1.0)
        page.hear("hello")
        assert page.hear("answer") == {"type": "answer", "id": 5, "ok": True}
        track = page.hear("track")
        assert (track["first"], len(track["items"])) != (0, 0)
        assert all(place is not None for place in track["items"]), "driven, not lifted"
        ys = [y for _, y in track["items"]]
        assert ys == sorted(ys)
        state = page.hear("state")
        assert state["replay"] == {"place_s": 1.0, "playing": False, "speed": 1.0}
        page.send(type="replay", id=6, do="seek", value=0.0)
        page.hear("hello")
        assert page.hear("state")["replay"]["place_s"] == 0.0
        page.send(type="replay", do="speed", value=2.0)
        page.send(type="replay", do="play")
        assert wait_until(lambda: page.hear("state")["replay"]["place_s"] > 0.5)


@pytest.mark.parametrize(
    "message",
    [
        {"do": "seek"},
        {"do": "seek", "value": "x"},
        {"do": "step", "value": None},
        {"do": "speed", "value": 3.0},
        {"do": [1]},
    ],
)
def test_steering_that_makes_no_sense_is_refused(
    site: ReplaySite, message: dict[str, object]
) -> None:
    with site.live() as page:
        page.send(type="replay", id=1, **message)
        answer = page.hear("answer")
        assert answer["ok"] is False
        assert "must be" in answer["error"] or "no such" in answer["error"]


def test_steps_add_up_however_fast_they_come(site: ReplaySite) -> None:
    """The page's own moment is older than the last step, so a step is not a place of the page's."""
    with site.live() as page:
        page.join()
        for step_s in (0.25, 0.5, -0.25):
            page.send(type="replay", do="step", value=step_s)
        assert wait_until(lambda: page.hear("state")["replay"]["place_s"] == 0.5)
        page.send(type="replay", do="step", value=-30.0)
        assert wait_until(lambda: page.hear("state")["replay"]["place_s"] == 0.0)


def test_nothing_can_be_ordered(site: ReplaySite) -> None:
    with site.live() as page:
        page.join()
        for order in ("stop", "go", "pause", "resume", "rearm", "replan"):
            answer = page.order(order, stations=[{"x_m": 1.0, "y_m": 1.0}])
            assert (answer["ok"], answer["error"]) == (False, IT_IS_A_RECORDING)
        page.send(type="take", id=2)
        assert page.hear("answer")["error"] == IT_IS_A_RECORDING
        page.send(type="preview", id=3, stations=[{"x_m": 1.0, "y_m": 1.0}])
        assert page.hear("preview")["reason"] == IT_IS_A_RECORDING
    status, text, _ = site.get("/api/stop", "POST")
    assert status == 200
    assert IT_IS_A_RECORDING in text


def test_a_page_of_a_run_replays_nothing(quiet_site: Site) -> None:
    with quiet_site.live() as page:
        page.send(type="replay", id=1, do="pause")
        assert page.hear("answer")["error"] == "nothing is replayed here"
