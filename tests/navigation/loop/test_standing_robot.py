"""A robot that stands is not said to drive: within 3 s one sentence, and no flutter after it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import groupby, pairwise
from typing import Any

import pytest

from navigation.config import Config
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RobotSnapshot
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from navigation.run.virtual_run import run_virtually
from navigation.simulator.virtual_loop import PacedLine
from tests.navigation.run.test_fleet_runs import open_hall
from tests.support.runs.troubled_world import TroubledWorld
from tests.support.runs.virtual import cycle_until, is_driving, set_trouble, short_config

pytestmark = pytest.mark.slow

FAR = [{"x_m": 0.20, "y_m": 1.60}]
SAID_WITHIN_S = 3.0
WATCHED_S = 25.0
DEAF = "the robot does not hear what it is sent"
MOTIONLESS = "neither its wheels nor the camera report a motion"
CAUSES = {"wire_to_robot_cut": DEAF, "motors_dead": MOTIONLESS}


def driving_robot(config: Config) -> Iterator[tuple[TroubledWorld, Daemon]]:
    world = TroubledWorld(config, pictures=False)
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        cycle_until(daemon, is_driving)
        cycle_until(daemon, lambda _: world.body.loop.drive.moving)
        yield world, daemon


@pytest.fixture
def driving() -> Iterator[tuple[TroubledWorld, Daemon]]:
    yield from driving_robot(short_config(FAR))


def said_after(world: TroubledWorld, daemon: Daemon, seconds: float) -> list[tuple[float, Any]]:
    """Each cycle from now on: when, and the state."""
    began_s, said = world.clock(), []
    cycle_until(
        daemon,
        lambda _: world.clock() - began_s > seconds,
        seconds + 1.0,
        each=lambda now: said.append((world.clock() - began_s, now)),
    )
    return said


def stretches(said: list[tuple[float, RobotSnapshot]]) -> list[tuple[State, float, float, str]]:
    """Each state in turn: from when to when, and its last sentence."""
    found = []
    for state, group in groupby(said, key=lambda pair: pair[1].mission.state):
        rows = list(group)
        found.append((state, rows[0][0], rows[-1][0], rows[-1][1].sentence))
    return found


@pytest.mark.parametrize("trouble", CAUSES)
def test_within_3_s_it_is_said_once_and_the_robot_is_not_said_to_drive_again(
    trouble: str, driving: tuple[TroubledWorld, Daemon]
) -> None:
    world, daemon = driving
    set_trouble(world, trouble, True)
    found = stretches(said_after(world, daemon, WATCHED_S))
    assert [state for state, *_ in found].count(State.DRIVING) == 1, found
    _, _, driven_s, _ = found[0]
    assert driven_s < SAID_WITHIN_S
    state, _, _, sentence = found[1]
    assert state is State.HOLDING
    assert CAUSES[trouble] in sentence
    assert all(CAUSES[trouble] in words for state, *_, words in found if state is State.HOLDING)


@pytest.mark.parametrize("trouble", CAUSES)
def test_the_mission_goes_on_once_the_cause_is_gone(
    trouble: str, driving: tuple[TroubledWorld, Daemon]
) -> None:
    world, daemon = driving
    set_trouble(world, trouble, True)
    said_after(world, daemon, 6.0)
    set_trouble(world, trouble, False)
    ended = cycle_until(daemon, lambda now: now.mission.is_over, 60.0)
    assert ended.mission.state is State.DONE, ended.sentence
    assert math.dist(world.body.pose()[:2], (0.20, 1.60)) < 0.01


def test_a_robot_that_cannot_turn_on_the_spot_is_tried_again_more_and_more_seldom() -> None:
    ahead = {"start": {"x_m": 0.20, "y_m": 0.20, "heading_deg": 90.0}}
    config = short_config(FAR, robot={"turns_on_spot": False}, simulation=ahead)
    for world, daemon in driving_robot(config):
        world.body.troubles.motors_dead = True
        found = stretches(said_after(world, daemon, WATCHED_S))
        drives = [to_s - from_s for state, from_s, to_s, _ in found if state is State.DRIVING]
        assert max(drives) < SAID_WITHIN_S
        holds = [to_s - from_s for _, from_s, to_s, words in found if MOTIONLESS in words]
        holds = holds[:-1]  # the last is cut off by the end
        assert len(holds) >= 2
        assert all(after > 1.5 * before for before, after in pairwise(holds)), holds


class LateLine(PacedLine):
    """A line whose bytes may arrive late."""

    late_s = 0.0

    def put(self, data: bytes, now_s: float) -> None:
        super().put(data, now_s + self.late_s)

    def free(self, now_s: float) -> bool:
        return super().free(now_s + self.late_s)


@pytest.mark.parametrize("late_s", [0.6, 1.0, 2.0])
@pytest.mark.parametrize("from_the_start", [True, False])
def test_a_robot_that_hears_late_is_not_said_to_drive_in_try_after_try(
    late_s: float, from_the_start: bool
) -> None:
    config = short_config(FAR, safety={"give_up_s": 15.0})
    world = TroubledWorld(config, pictures=False)
    loop = world.body.loop
    loop.to_robot = line = LateLine(loop.baud)
    told_s = longest_s = 0.0
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        if not from_the_start:
            cycle_until(daemon, is_driving)
        line.late_s = late_s
        before_s = world.clock()

        def note(now: RobotSnapshot) -> None:
            nonlocal told_s, longest_s, before_s
            told_s += (world.clock() - before_s) * (now.mission.state is State.DRIVING)
            if loop.drive.moving:
                told_s = 0.0
            longest_s, before_s = max(longest_s, told_s), world.clock()

        ended = cycle_until(daemon, lambda now: now.mission.is_over, 60.0, each=note)
    assert longest_s < SAID_WITHIN_S
    assert ended.mission.state is State.FAILED
    assert "without progress" in ended.sentence


@pytest.mark.parametrize("dwell_s", [6.0])
def test_a_robot_that_stays_at_a_station_as_ordered_is_not_taken_for_motionless(
    dwell_s: float,
) -> None:
    stations = [{"x_m": 0.20, "y_m": 0.60, "dwell_s": dwell_s}, {"x_m": 0.20, "y_m": 0.90}]
    for _, daemon in driving_robot(short_config(stations)):
        holds: list[str] = []

        def note(now: RobotSnapshot, holds: list[str] = holds) -> None:
            if now.mission.state is State.HOLDING:
                holds.append(now.sentence)

        ended = cycle_until(daemon, lambda now: now.mission.is_over, 60.0, each=note)
        assert ended.mission.state is State.DONE
        assert holds == []


def dead_motors(world: TroubledWorld) -> None:
    world.bodies["a"].troubles.motors_dead = True


def cut_wire(world: TroubledWorld) -> None:
    world.bodies["a"].troubles.wire_to_robot_cut = True


@pytest.mark.parametrize(("break_it", "words"), [(dead_motors, MOTIONLESS), (cut_wire, DEAF)])
def test_of_several_robots_each_says_so_for_itself(
    break_it: Callable[[TroubledWorld], None], words: str
) -> None:
    rows: list[tuple[float, State, str]] = []

    def meet(world: TroubledWorld, since_s: float) -> None:
        if since_s > 3.0:
            break_it(world)

    def look(_daemon: object, now: Any) -> bool:
        one = now.robots["a"]
        rows.append((now.time_s, one.mission.state, one.mission.reason))
        return bool(now.time_s > 12.0)

    run_virtually(
        open_hall("a", "b", time_limit_s=20.0),
        meet=meet,
        look=look,
        pictures=False,
        make_world=TroubledWorld,
    )
    after = [row for row in rows if row[0] > 3.0 + SAID_WITHIN_S]
    assert after
    assert all(state is not State.DRIVING for _, state, _ in after)
    assert any(words in sentence for _, state, sentence in after if state is State.HOLDING)
    assert all(words not in sentence for time_s, _, sentence in rows if time_s < 3.0)
