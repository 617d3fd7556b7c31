"""A computer that is too busy: it says so, robots hold, and nobody is said to have carried them."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from navigation.loop.daemon import Daemon
from navigation.loop.punctuality import CALM_S, DOUBTFUL_S, LATE_S, Punctuality
from navigation.loop.run_state import RobotSnapshot
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from tests.support.runs.troubled_world import TroubledWorld
from tests.support.runs.virtual import cycle_until, is_driving, short_config

FAR = [{"x_m": 0.20, "y_m": 1.60}]


@pytest.fixture
def driving() -> Iterator[tuple[TroubledWorld, Daemon]]:
    config = short_config(FAR, camera={"rate_hz": 15.0})
    world = TroubledWorld(config, pictures=False)
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        cycle_until(daemon, is_driving)
        cycle_until(daemon, lambda _: world.body.loop.drive.moving)
        yield world, daemon


def holds(now: RobotSnapshot) -> bool:
    return now.mission.state is State.HOLDING


@pytest.mark.parametrize("who", ["the control loop", "a thread", "the link's thread"])
def test_a_late_thread_holds_the_robot_which_goes_on_by_itself(
    who: str, driving: tuple[TroubledWorld, Daemon], monkeypatch: pytest.MonkeyPatch
) -> None:
    world, daemon = driving
    late = iter([0.4])
    if who == "the control loop":
        world.wait(0.4 + 0.05)
    else:
        one = world if who == "a thread" else daemon.robot.link
        monkeypatch.setattr(type(one), "late_s", lambda _: next(late, 0.0))
    now = cycle_until(daemon, holds, 0.2)
    assert now.sentence.startswith(f"this computer is too busy: {who} was late by 0.4 s (load ")
    began_s = world.clock()
    now = cycle_until(daemon, is_driving, 10.0)
    assert world.clock() - began_s >= CALM_S - 0.1
    now = cycle_until(daemon, lambda now: now.mission.is_over)
    assert now.mission.state is State.DONE, now.sentence


def test_no_report_is_lost_on_a_loop_that_is_late(driving: tuple[TroubledWorld, Daemon]) -> None:
    """Once the newest report only was looked at, and a turn between two of them was lost."""
    world, daemon = driving
    wheels, stretch = daemon.robot.witness.wheels, daemon.robot.witness.wheels.stretch
    before_m = wheels.driven_m
    true_m = world.truths[""].track()[:, 1:3]
    world.wait(0.4)
    daemon.cycle()
    assert wheels.stretch == stretch, "what the wheels did meanwhile is known"
    rows = world.truths[""].track()[len(true_m) - 1 :, 1:3]
    driven_m = float(abs(rows[-1] - rows[0]).max())
    assert wheels.driven_m - before_m == pytest.approx(driven_m, abs=0.015)


def test_a_robot_that_is_carried_while_the_computer_is_late_waits_for_a_person(
    driving: tuple[TroubledWorld, Daemon],
) -> None:
    world, daemon = driving
    pose = world.body.pose()
    world.body.troubles.carried_to = (pose.x_m, pose.y_m + 0.3, pose.heading_rad)
    world.wait(0.6)
    now = cycle_until(daemon, lambda now: now.mission.state is State.STOPPED, 10.0)
    assert "it was carried or is stuck" in now.sentence


def test_a_picture_that_freezes_while_the_computer_is_late_moves_nothing_far(
    driving: tuple[TroubledWorld, Daemon],
) -> None:
    world, daemon = driving
    world.cameras[None].camera_frozen = world.cameras[None].frozen_noise = True
    places = []
    for _ in range(60):
        daemon.cycle()
        world.wait(0.4)
        places.append(world.body.pose()[:2])
    assert max(abs(x - places[0][0]) + abs(y - places[0][1]) for x, y in places) < 0.15
    assert not is_driving(daemon.cycle().only)


def test_what_is_on_time_says_nothing() -> None:
    punctuality = Punctuality(lambda: (9.06, 5.0, 1.0))
    punctuality.note("a thread", DOUBTFUL_S * 0.9, 10.0)
    assert punctuality.hold(10.0) is None
    assert punctuality.doubt(10.0) is None


def test_a_little_late_is_a_doubt_and_much_a_hold_until_all_is_calm() -> None:
    punctuality = Punctuality(lambda: (9.06, 5.0, 1.0))
    punctuality.note("a thread", (DOUBTFUL_S + LATE_S) / 2.0, 10.0)
    assert punctuality.hold(10.0) is None
    assert punctuality.doubt(10.0) is not None
    punctuality.note("the control loop", 0.52, 11.0)
    punctuality.note("a thread", 0.0, 11.0)
    said = punctuality.hold(11.0)
    assert said is not None
    assert "the control loop was late by 0.5 s (load 9.1 on " in said
    assert punctuality.hold(11.0 + CALM_S * 0.9) == punctuality.doubt(11.0) == said
    assert punctuality.hold(11.0 + CALM_S) is None
    assert punctuality.doubt(11.0 + CALM_S) is None


def test_a_computer_that_slept_is_not_called_busy_alone() -> None:
    punctuality = Punctuality(lambda: (0.06, 5.0, 1.0))
    punctuality.note("a thread", 7200.0, 10.0)
    said = punctuality.hold(10.0)
    assert said is not None
    assert said.startswith("this program did not run for 7200 s: it was stopped, or this computer")
