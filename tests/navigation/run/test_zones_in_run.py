"""Zones drawn while robots drive, in whole runs in virtual time, judged by the truth."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.zones.judge import depth_m, violations
from navigation.config import Config
from navigation.config.zones import ZoneSection
from navigation.control import ControlError, send_order
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RunState
from navigation.loop.traffic.coordinated import Coordinated
from navigation.mission.mission import State, Station
from navigation.run.run_report import RunReport
from navigation.run.virtual_run import run_virtually
from navigation.run.virtual_world import VirtualWorld
from planner.scene import FloatArray
from tests.navigation.config.test_zones import write_mask
from tests.support.runs import boundaries
from tests.support.runs.boundaries import several_robots
from tests.support.runs.virtual import short_config
from tests.support.runs.whole_run import run_whole


def one_robot() -> Config:
    """A robot that crosses the arena."""
    return short_config([{"x_m": 2.20, "y_m": 1.60}])


def two_robots() -> Config:
    """Two robots that do, the second far from the first."""
    values = several_robots().model_dump()
    goals = {"a": (2.20, 1.60), "b": (0.20, 1.40)}
    values["mission"]["robots"] = [
        {"name": name, "stations": [{"x_m": x, "y_m": y}]} for name, (x, y) in goals.items()
    ]
    values["simulation"]["starts"][1].update(x_m=2.20, y_m=0.30)
    return Config.model_validate(values)


BOTH = pytest.mark.parametrize("make", [one_robot, two_robots], ids=["one", "several"])
NEAR = pytest.mark.parametrize(
    "make", [boundaries.one_robot, several_robots], ids=["one", "several"]
)
"""With goals nearby, where no obstacle is on the path."""


def zone(kind: str, **keys: Any) -> ZoneSection:
    return ZoneSection.model_validate({"name": "desk", "kind": kind, **keys})


def test_a_run_takes_a_mask_beside_its_configuration_and_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    refused = []
    for folder in (tmp_path / "configs", tmp_path / "others"):
        folder.mkdir()
        write_mask(folder)

    def order(folder: str) -> dict[str, Any]:
        mask = {"name": "old", "kind": "wait", "mask": str(tmp_path / folder / "mask.yaml")}
        return {"order": "zone_put", "zone": mask}

    def elsewhere(_: VirtualWorld) -> None:
        with pytest.raises(ControlError) as error:
            send_order(tmp_path / "control.sock", order("others"))
        refused.append(str(error.value))

    monkeypatch.chdir(tmp_path)
    ran = run_whole(
        one_robot(), tmp_path, monkeypatch, {0.3: order("configs"), 0.6: elsewhere},
        file=Path("configs/run.yaml"),
    )  # fmt: skip
    assert [one["name"] for one in ran.report["zones"]] == ["old"]
    (sentence,) = refused
    assert sentence.endswith(f"must be in the configuration's folder, {tmp_path / 'configs'}")


class Played:
    """A run with things done at given seconds, and what was said and driven.

    It ends with its missions, or once ``is_seen`` says so.
    """

    def __init__(
        self,
        config: Config,
        at: dict[float, Callable[[Daemon], None]],
        is_seen: Callable[[], bool] = lambda: False,
    ) -> None:
        self.said: list[str] = []
        self.done_s: dict[float, float] = {}
        self.worlds: list[VirtualWorld] = []

        def look(daemon: Daemon, now: RunState) -> bool:
            for when_s, act in at.items():
                if when_s not in self.done_s and now.time_s >= when_s:
                    act(daemon)
                    self.done_s[when_s] = daemon.world.clock()
            for one in daemon.robots.values():
                line = f"{one.pilot.mission.state.value}: {one.pilot.mission.reason}"
                if line not in self.said:
                    self.said.append(line)
            return is_seen()

        def make(*args: Any, **how: Any) -> VirtualWorld:
            self.worlds.append(VirtualWorld(*args, **how))
            return self.worlds[0]

        self.report: RunReport = run_virtually(config, look=look, pictures=False, make_world=make)

    @property
    def tracks(self) -> dict[str, FloatArray]:
        return {name: one.track() for name, one in self.worlds[0].truths.items()}

    def heard(self, words: str) -> bool:
        return any(words in line for line in self.said)


@cache
def middle_of_the_path(make: Callable[[], Config]) -> tuple[float, float, float]:
    """Where the first robot is half way through a run without zones, and when."""
    played = Played(make(), {})
    assert played.report.state == "done", played.report.reason
    track = next(iter(played.tracks.values()))
    gone = np.cumsum(np.hypot(*np.diff(track[:, 1:3], axis=0).T))
    half = int(np.searchsorted(gone, 0.5 * gone[-1]))
    return float(track[half, 1]), float(track[half, 2]), float(track[half, 0] - track[0, 0])


@BOTH
def test_a_keep_out_zone_drawn_ahead_is_driven_around(make: Callable[[], Config]) -> None:
    x, y, half_s = middle_of_the_path(make)
    desk = zone("keep_out", circle=(x, y, 0.06))
    played = Played(make(), {0.4 * half_s: lambda daemon: daemon.zones.put(desk)})
    assert played.report.state == "done", played.report.reason
    assert played.heard("the path leads through keep-out zone 'desk': planning again")
    since_s = next(iter(played.done_s.values())) + 1.0
    config = make()
    for name, track in played.tracks.items():
        assert not violations(desk, name, config.robot.radius_m, track, since_s)


@BOTH
def test_a_robot_that_a_zone_is_drawn_over_leaves_it_by_the_shortest_path(
    make: Callable[[], Config],
) -> None:
    x, y, half_s = middle_of_the_path(make)
    desk = zone("keep_out", circle=(x, y, 0.12))
    played = Played(make(), {half_s: lambda daemon: daemon.zones.put(desk)})
    assert played.report.state == "done", played.report.reason
    assert played.heard("begins in keep-out zone 'desk': planning again")
    assert played.heard("leaves keep-out zone 'desk' by the shortest path out")
    config = make()
    since_s = next(iter(played.done_s.values())) + 1.0
    for name, track in played.tracks.items():
        assert not violations(desk, name, config.robot.radius_m, track, since_s)


@NEAR
def test_a_goal_in_a_zone_holds_its_robot_until_the_zone_is_gone(
    make: Callable[[], Config],
) -> None:
    config = make()
    station = (config.mission.stations or config.mission.robots[0].stations)[-1]
    for kind, name in (("keep_out", "keep-out zone"), ("wait", "no-waiting zone")):
        desk = zone(kind, circle=(station.x_m, station.y_m, 0.05))
        played = Played(
            make(),
            {
                0.0: lambda daemon, desk=desk: daemon.zones.put(desk),  # type: ignore[misc]
                4.0: lambda daemon: daemon.zones.remove("desk"),
            },
        )
        assert played.heard(f"is in {name} 'desk'")
        assert played.report.state == "done", played.report.reason


def test_no_robot_waits_at_a_station_on_the_way_that_a_no_waiting_zone_is_drawn_over() -> None:
    x, y, half_s = middle_of_the_path(one_robot)
    config = short_config([{"x_m": x, "y_m": y, "dwell_s": 3.0}, {"x_m": 2.20, "y_m": 1.60}])
    desk = zone("wait", circle=(x, y, 0.05))
    played = Played(
        config,
        {
            0.3 * half_s: lambda daemon: daemon.zones.put(desk),
            half_s + 4.0: lambda daemon: daemon.zones.remove("desk"),
        },
    )
    assert played.heard("the path has a station in no-waiting zone 'desk': planning again")
    assert played.report.state == "done", played.report.reason
    (track,) = played.tracks.values()
    drawn_s, removed_s = played.done_s.values()
    near = np.hypot(track[:, 1] - x, track[:, 2] - y) < config.robot.radius_m + 0.05
    assert not (near & (track[:, 0] > drawn_s) & (track[:, 0] < removed_s)).any()


@BOTH
def test_a_slow_zone_drawn_over_a_path_slows_the_robot(make: Callable[[], Config]) -> None:
    x, _, half_s = middle_of_the_path(make)
    strip = ((x - 0.1, -1.0), (x + 0.1, -1.0), (x + 0.1, 3.0), (x - 0.1, 3.0))
    desk = zone("slow", polygon=strip, speed_m_s=0.06)
    played = Played(make(), {0.3 * half_s: lambda daemon: daemon.zones.put(desk)})
    assert played.report.state == "done", played.report.reason
    assert played.heard("is faster than slow zone 'desk' allows: planning again")
    since_s = next(iter(played.done_s.values())) + 1.0
    config = make()
    for name, track in played.tracks.items():
        assert not violations(desk, name, config.robot.radius_m, track, since_s)
        assert (depth_m(desk, track[:, 1:3]) > 0.0).any()


@BOTH
def test_a_robot_that_is_paused_before_its_last_place_drives_on_as_slowly(
    make: Callable[[], Config],
) -> None:
    slow = zone("slow", circle=(0.20, 0.30, 0.3), speed_m_s=0.05)
    values = make().model_dump()
    goal = [{"x_m": 0.20, "y_m": 0.40}]
    if values["robots"]:
        values["mission"]["robots"][0]["stations"] = goal
    else:
        values["mission"]["stations"] = goal
    config = Config.model_validate(values | {"zones": [slow.model_dump()]})
    paused: list[float] = []
    resumed: list[float] = []
    worlds: list[VirtualWorld] = []

    def look(daemon: Daemon, now: RunState) -> bool:
        one = next(iter(daemon.robots.values()))
        plan, mission = one.pilot.plan, one.pilot.mission
        if not paused and len(plan.targets) > 1 and plan.executed == len(plan.targets) - 1:
            daemon.people.pause(one.name or None)
            paused.append(now.time_s)
        if paused and not resumed and now.time_s > paused[0] + 1.0:
            daemon.people.resume(one.name or None)
            resumed.append(daemon.world.clock())
        return bool(resumed) and mission.state is State.DONE

    def made(*args: Any, **how: Any) -> VirtualWorld:
        worlds.append(VirtualWorld(*args, **how))
        return worlds[0]

    run_virtually(config, look=look, pictures=False, make_world=made)
    name, truth = next(iter(worlds[0].truths.items()))
    assert not violations(slow, name, config.robot.radius_m, truth.track(), resumed[0])


@BOTH
def test_a_zone_over_a_robot_at_rest_moves_nobody(make: Callable[[], Config]) -> None:
    config = make()
    update = {"stations": (), "robots": ()}
    idle = config.model_copy(update={"mission": config.mission.model_copy(update=update)})
    simulation = idle.simulation
    assert simulation is not None
    start = simulation.starts[0] if simulation.starts else simulation.start
    assert start is not None
    desk = zone("keep_out", circle=(start.x_m, start.y_m, 0.1))
    zones: list[int] = []

    def look(daemon: Daemon, now: RunState) -> bool:
        if now.time_s > 1.0 and not daemon.zones.sections:
            daemon.zones.put(desk)
        zones.append(len(daemon.zones.sections))
        return now.time_s > 4.0

    worlds: list[VirtualWorld] = []

    def made(*args: Any, **how: Any) -> VirtualWorld:
        worlds.append(VirtualWorld(*args, **how))
        return worlds[0]

    run_virtually(idle, look=look, pictures=False, make_world=made, linger_s=10.0)
    assert zones[-1] == 1
    for truth in worlds[0].truths.values():
        track = truth.track()
        assert not len(track) or math.dist(track[0, 1:3], track[-1, 1:3]) < 1e-6


@BOTH
def test_orders_into_a_zone_are_refused_by_its_name(make: Callable[[], Config]) -> None:
    from navigation.mission.mission import MissionError

    refused: list[str] = []

    def give(daemon: Daemon) -> None:
        daemon.zones.put(zone("keep_out", circle=(1.2, 0.9, 0.2)))

    def order(daemon: Daemon) -> None:
        name = next(iter(daemon.robots))
        with pytest.raises(MissionError) as told:
            daemon.people.give((Station(1.2, 0.9),), name or None)
        refused.append(str(told.value))

    Played(make(), {1.0: give, 2.0: order}, lambda: bool(refused))
    assert refused == ["station 1 at (1.2, 0.9) is in keep-out zone 'desk'"]


@BOTH
def test_a_stop_acts_at_once_in_a_no_waiting_zone(make: Callable[[], Config]) -> None:
    """And the robot stays where it is: no zone outweighs a stop."""
    x, y, half_s = middle_of_the_path(make)
    door = zone("wait", circle=(x, y, 0.2))

    def stop(daemon: Daemon) -> None:
        daemon.people.stop("a person in the door")

    played = Played(make(), {0.3: lambda daemon: daemon.zones.put(door), half_s: stop})
    assert played.report.state == "stopped"
    first = next(iter(played.tracks.values()))
    stopped_s = played.done_s[half_s]
    assert depth_m(door, first[:, 1:3]).max() > 0.0
    after = first[first[:, 0] > stopped_s + 0.6]
    assert not len(after) or math.dist(after[0, 1:3], after[-1, 1:3]) < 0.001


def test_a_plan_older_than_a_zone_gives_no_driving_robot_another_gate() -> None:
    """A robot would have waited in a no-waiting zone until the next scene came."""
    stale: list[Any] = []
    held: list[Any] = []

    def draw_while_planned(daemon: Daemon) -> None:
        traffic, plans = daemon.traffic, daemon._planner
        assert isinstance(traffic, Coordinated)
        coordinator, answers = traffic._coordinator, plans._on_answer

        def late(answer: Any) -> None:
            plans._on_answer = answers
            daemon.zones.put(zone("wait", circle=(1.2, 0.9, 0.05)))
            stale.extend(answer.driving)
            daemon.world.after(0.5, lambda: answers(answer))
            for i in range(10):
                after_s = 0.5 + 0.02 * i
                daemon.world.after(after_s, lambda: held.append(coordinator.held["a"].promise))

        plans._on_answer = late
        daemon.people.give((Station(0.20, 1.40),), "b")

    values = two_robots().model_dump()
    values["mission"]["robots"] = values["mission"]["robots"][:1]
    played = Played(Config.model_validate(values), {2.0: draw_while_planned})
    assert played.report.state == "done", played.report.reason
    assert [one.name for one in stale] == ["a"]
    assert len(held) == 10
    assert not any(one is stale[0] for one in held)
