"""Several robots through the whole running program, in virtual time and judged by ground truth."""

import math
from collections.abc import Callable
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import pytest

from navigation.config import Config, load_config
from navigation.fleet.request import FleetAnswer, FleetRequest
from navigation.loop.daemon import Daemon
from navigation.loop.people import People
from navigation.loop.run_state import RunState
from navigation.loop.traffic.fleet_planner import FleetPlanner
from navigation.mission.mission import MissionError, Station
from navigation.mission.mission import State as MissionState
from navigation.run.virtual_link import VirtualLink
from navigation.run.virtual_run import run_virtually
from navigation.run.virtual_world import VirtualTimes
from tests.support.runs.light_camera import in_small_pictures
from tests.support.runs.troubled_world import TroubledWorld
from tests.support.runs.virtual import alcove

CONFIGS = Path(__file__).parents[3] / "configs"
ALCOVE = alcove()
SMALL = in_small_pictures(ALCOVE)


def open_hall(*names: str, base: Config = ALCOVE, **simulation: object) -> Config:
    """The alcove's robots, as many as there are names, in an arena without obstacles."""
    starts = {"a": (0.3, 0.3, 0.0), "b": (2.1, 0.3, 180.0), "c": (1.2, 1.5, -90.0)}
    goals = {"a": (2.1, 0.9), "b": (0.3, 0.9), "c": (1.2, 0.3)}
    config = base.model_dump(mode="json", exclude_none=True)
    config["robots"] = [{"name": name, "marker_id": i + 1} for i, name in enumerate(names)]
    config["mission"]["robots"] = [
        {"name": name, "stations": [dict(zip(("x_m", "y_m"), goals[name], strict=True))]}
        for name in names
    ]
    config["simulation"]["arena_text"] = (
        "#@ clearway.scene/1\n#@ units m\nL 3 (0.02,0.02) (0.02,0.06) (0.06,0.02)\n"
    )
    config["simulation"]["starts"] = [
        {"name": n, **dict(zip(("x_m", "y_m", "heading_deg"), starts[n], strict=True))}
        for n in names
    ]
    config["simulation"] |= simulation
    return Config.model_validate(config, context={"folder": CONFIGS}, strict=False)


def test_two_robots_meet_in_a_corridor_and_one_gives_way_in_the_niche() -> None:
    """With pictures: that each robot's marker is told from the other's, side by side."""
    report = run_virtually(SMALL)
    assert report.state == "done"
    assert {one.state for one in report.robots.values()} == {"done"}
    assert report.least_gap_m is not None
    assert report.least_gap_m > 0.005
    assert report.min_clearance_m is not None
    assert report.min_clearance_m > ALCOVE.robot.radius_m
    assert all((one.goal_error_m or 1.0) < 0.01 for one in report.robots.values())


def test_a_robot_that_dies_is_driven_around() -> None:
    def meet(world: TroubledWorld, since_s: float) -> None:
        world.bodies["c"].off = since_s > 3.5

    report = run_virtually(
        open_hall("a", "b", "c", time_limit_s=80.0),
        meet=meet,
        pictures=False,
        make_world=TroubledWorld,
    )
    assert (report.robots["a"].state, report.robots["b"].state) == ("done", "done")
    assert report.robots["c"].state == "failed"
    assert report.least_gap_m is not None
    assert report.least_gap_m > 0.0


def swap_ports(daemon: Daemon) -> None:
    """Plug each of two robots into the other's port."""
    one, other = (daemon.robots[name].link for name in "ab")
    assert isinstance(one, VirtualLink)
    assert isinstance(other, VirtualLink)
    one.loop.host, other.loop.host = other.loop.host, one.loop.host
    one.loop, other.loop = other.loop, one.loop


@pytest.mark.parametrize("since_s", [1.0, 3.5, 5.5])
def test_two_robots_that_are_swapped_on_their_ports_drive_nowhere(since_s: float) -> None:
    """Once they drove 0.17 m along the other's path before camera and wheels parted."""
    before: dict[str, tuple[float, float]] = {}

    def meet(world: TroubledWorld, now_s: float) -> None:
        for body in world.bodies.values():
            body.troubles.cable_out = since_s < now_s < since_s + 2.1

    def look(daemon: Daemon, now: RunState) -> bool:
        if now.time_s < since_s + 2.0:
            return False
        places = {name: truth.track()[-1][1:3] for name, truth in daemon.world.truths.items()}
        if not before:
            swap_ports(daemon)
            before.update(places)
        for name, place in before.items():
            assert math.dist(place, places[name]) < 0.03
        return now.time_s > since_s + 12.0

    base = load_config(CONFIGS / "alcove.yaml", {})  # with all its pictures
    report = run_virtually(
        open_hall("a", "b", base=base),
        look=look,
        meet=meet,
        pictures=False,
        make_world=TroubledWorld,
    )
    assert {one.state for one in report.robots.values()} == {"stopped"}


@pytest.mark.parametrize("since_s", [2.0, 3.0, 3.5])
def test_a_robot_that_runs_away_touches_nobody(since_s: float) -> None:
    """From 3.4, 2.1 and 1.5 s before it would hit one that stands, or drives as promised."""

    def meet(world: TroubledWorld, now_s: float) -> None:
        world.bodies["c"].frozen = now_s > since_s

    report = run_virtually(
        open_hall("a", "b", "c", time_limit_s=80.0),
        meet=meet,
        pictures=False,
        make_world=TroubledWorld,
    )
    assert (report.robots["a"].state, report.robots["b"].state) == ("done", "done")
    assert report.robots["c"].state in ("stopped", "failed")
    assert report.least_gap_m is not None
    assert report.least_gap_m > 0.0


def once(at_s: float, order: Callable[[People], None]) -> Callable[[Daemon, RunState], bool]:
    """A look at each cycle that gives one order at its time."""
    given = []

    def look(daemon: Daemon, now: RunState) -> bool:
        if now.time_s > at_s and not given:
            given.append(at_s)
            order(daemon.people)
        return False

    return look


def test_stop_stops_all() -> None:
    look = once(2.5, lambda people: people.stop("everybody stops"))
    report = run_virtually(open_hall("a", "b", time_limit_s=10.0), look=look, pictures=False)
    assert {one.state for one in report.robots.values()} == {"stopped"}
    assert all("everybody stops" in one.reason for one in report.robots.values())


def test_one_that_is_stopped_alone_is_driven_around_by_the_other() -> None:
    look = once(2.5, lambda people: people.stop("just this one", "b"))
    report = run_virtually(open_hall("a", "b", time_limit_s=60.0), look=look, pictures=False)
    assert (report.robots["a"].state, report.robots["b"].state) == ("done", "stopped")
    assert report.least_gap_m is not None
    assert report.least_gap_m > 0.0


def test_a_new_goal_while_another_drives_brings_both_to_their_goals() -> None:
    look = once(3.0, lambda people: people.give((Station(0.3, 1.5), Station(0.6, 0.3)), "b"))
    report = run_virtually(open_hall("a", "b", time_limit_s=80.0), look=look, pictures=False)
    assert report.state == "done"
    assert report.robots["b"].stations_visited == 2
    assert report.least_gap_m is not None
    assert report.least_gap_m > 0.0


def test_a_planner_that_fails_while_a_goal_is_planned_plans_for_all_once_it_is_restarted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    answer, failed = FleetPlanner.answer, list[FleetRequest]()

    def fragile(planner: FleetPlanner, request: FleetRequest) -> FleetAnswer:
        if request.driving and not failed:
            failed.append(request)
            raise ZeroDivisionError
        return answer(planner, request)

    def look(daemon: Daemon, now: RunState) -> bool:
        if now.time_s > 2.0 and daemon.robots["b"].pilot.mission.state is MissionState.IDLE:
            daemon.people.give((Station(0.3, 0.9),), "b")
        return False

    monkeypatch.setattr(FleetPlanner, "answer", fragile)
    config = open_hall("a", "b").model_dump()
    config["mission"]["robots"] = config["mission"]["robots"][:1]
    report = run_virtually(Config.model_validate(config), look=look, pictures=False)
    assert failed
    assert report.state == "done", report.reason


def test_a_robot_that_skips_its_only_station_is_driven_around_where_it_comes_to_rest() -> None:
    look = once(2.5, lambda people: people.skip("b"))
    report = run_virtually(open_hall("a", "b", time_limit_s=60.0), look=look, pictures=False)
    assert (report.robots["a"].state, report.robots["b"].state) == ("done", "done")
    assert (report.robots["a"].stations_visited, report.robots["b"].stations_visited) == (1, 0)
    assert "was skipped" in report.robots["b"].reason
    assert report.least_gap_m is not None
    assert report.least_gap_m > 0.0


def test_a_robot_that_skips_a_station_goes_on_to_the_next_one() -> None:
    def order(people: People) -> None:
        people.give((Station(0.3, 1.5), Station(0.6, 0.3)), "b")
        people.skip("b")
        with pytest.raises(MissionError, match="several robots"):
            people.skip()

    report = run_virtually(
        open_hall("a", "b", time_limit_s=80.0), look=once(3.0, order), pictures=False
    )
    assert report.state == "done"
    assert (report.robots["b"].stations, report.robots["b"].stations_visited) == (1, 1)
    assert report.least_gap_m is not None
    assert report.least_gap_m > 0.0


def test_a_hidden_marker_keeps_its_place_and_its_robot_drives_on_when_it_is_seen() -> None:
    def meet(world: TroubledWorld, since_s: float) -> None:
        world.bodies["b"].troubles.marker_hidden = 3.0 < since_s < 7.0

    report = run_virtually(
        open_hall("a", "b", time_limit_s=80.0),
        meet=meet,
        pictures=False,
        make_world=TroubledWorld,
    )
    assert report.state == "done"
    assert report.least_gap_m is not None
    assert report.least_gap_m > 0.0


@pytest.mark.parametrize("pictures", [False, True])
def test_a_second_marker_of_one_robot_stops_it_and_the_other_keeps_clear(pictures: bool) -> None:
    ended: dict[str, MissionState] = {}
    sentence = ""

    def meet(world: TroubledWorld, since_s: float) -> None:
        world.bodies["b"].troubles.double_at = (0.3, 1.5, 0.0) if since_s > 3.0 else None

    def look(_daemon: Daemon, now: RunState) -> bool:
        nonlocal sentence
        ended.update({name: one.mission.state for name, one in now.robots.items()})
        if ended["b"] is MissionState.STOPPED and not sentence:
            assert now.time_s < 3.7
            sentence = now.robots["b"].sentence
        return now.time_s > 12.0

    base = in_small_pictures(load_config(CONFIGS / "alcove.yaml", {}))  # with all its pictures
    report = run_virtually(
        open_hall("a", "b", base=base, time_limit_s=80.0),
        meet=meet,
        look=look,
        pictures=pictures,
        make_world=TroubledWorld,
    )
    assert "marker" in sentence
    assert "is seen at" in sentence
    assert ended["b"] is MissionState.STOPPED
    assert report.least_gap_m is not None
    assert report.least_gap_m > 0.0


def test_tasks_are_given_once_all_are_seen_and_driven_to_the_end() -> None:
    config = open_hall("a", "b", time_limit_s=60.0)
    tasks = [one.stations[0].model_copy(update={"y_m": 0.6}) for one in config.mission.robots]
    mission = config.mission.model_copy(update={"robots": ()})
    report = run_virtually(
        config.model_copy(update={"mission": mission, "tasks": tasks}), pictures=False
    )
    assert report.state == "done"
    assert {one.stations_visited for one in report.robots.values()} == {1}


def test_two_runs_are_the_same() -> None:
    config = open_hall("a", "b", time_limit_s=4.0)
    first, second = (run_virtually(config, pictures=False) for _ in range(2))
    assert first.as_json() == second.as_json()


def test_a_computer_that_is_too_slow_for_any_plan_makes_no_other_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    config = open_hall("a", "b", time_limit_s=4.0)
    first = run_virtually(config, pictures=False)
    busy = SimpleNamespace(monotonic=count(0.0, 10.0).__next__)
    monkeypatch.setattr("planner.shared.search_clock.time", busy)
    assert run_virtually(config, pictures=False).as_json() == first.as_json()


def test_a_search_in_virtual_time_ends_at_its_limit_of_work_and_says_so() -> None:
    config = open_hall("a", "b", time_limit_s=4.0)
    report = run_virtually(config, VirtualTimes(search_s=4.0), pictures=False)
    assert "no plan was found within 3 s" in report.reason


@pytest.mark.parametrize("name", ["fleet", "crossing", "alcove"])
def test_every_fleet_that_is_shipped_has_a_robot_a_goal_and_a_start_each(name: str) -> None:
    config = load_config(CONFIGS / f"{name}.yaml", {})
    names = {one.name for one in config.robots}
    assert names == {one.name for one in config.mission.robots}
    assert config.simulation is not None
    assert names == {one.name for one in config.simulation.starts}


def test_a_knocked_camera_holds_all_robots_until_it_is_back() -> None:
    """With pictures: that fixed points have moved in them."""
    knock = {"from_s": 3.0, "until_s": 6.0, "tilt_deg": (0.3, 0.0)}
    values = SMALL.model_dump()
    values["simulation"]["camera"]["knocks"] = [knock]
    config = Config.model_validate(values)
    held: list[set[bool]] = []

    def look(daemon: Daemon, now: RunState) -> bool:
        if 4.5 < daemon.world.clock() < 5.9:
            reasons = [seat.pilot.mission.reason for seat in daemon.robots.values()]
            held.append({"the camera has moved" in reason for reason in reasons})
            states = {seat.pilot.mission.state for seat in daemon.robots.values()}
            assert states == {MissionState.HOLDING}
        return now.time_s > 15.0

    report = run_virtually(config, look=look)
    assert held
    assert all(each == {True} for each in held)
    assert report.least_gap_m is not None
    assert report.least_gap_m > 0.0
    assert all("the camera has moved" not in one.reason for one in report.robots.values())
