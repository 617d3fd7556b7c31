"""A stop is in force through every restart, of one robot and of several, until a re-arm."""

from __future__ import annotations

from pathlib import Path

import pytest

from navigation.journal.journal import Journal, owner_of
from navigation.journal.kept_stops import KeptStops
from navigation.loop.daemon import Daemon
from navigation.mission.mission import MissionProgress, State
from navigation.run.give_missions import GiveMissions
from navigation.run.virtual_world import VirtualWorld
from tests.support.runs.troubled_robot import switch_off_and_on
from tests.support.runs.virtual import cycle_until, is_driving, short_config

GOAL = [{"x_m": 0.9, "y_m": 0.3}]


def begin(daemon: Daemon, folder: Path, **other: object) -> None:
    """What the runner does, in virtual time."""
    given: dict[str, object] = {"socket": folder / "c.sock", "configuration": folder / "a.yaml"}
    stops = KeptStops(folder / "stops", ports={"": ("/dev/ttyA",)}, **(given | other))  # type: ignore[arg-type]
    daemon.stopping.hold_from_before([daemon.robot], stops)
    GiveMissions(daemon, print)


@pytest.mark.parametrize("power_cut", [False, True], ids=["robot runs on", "robot lost power too"])
@pytest.mark.parametrize("again", ["socket", "configuration", "neither"])
def test_a_stop_is_in_force_after_a_kill_and_a_restart(
    tmp_path: Path, again: str, power_cut: bool
) -> None:
    config = short_config(GOAL)
    world = VirtualWorld(config, pictures=False)
    first = Daemon(config, world, first_mission_id=1)
    first.__enter__()
    begin(first, tmp_path)
    cycle_until(first, is_driving)
    assert first.people.stop("a person") is None
    # killed here: not one cycle more
    if power_cut:
        switch_off_and_on(world.body)
    world.wait(2.0)
    other = {name: tmp_path / "other" for name in ("socket", "configuration") if name != again}
    second = Daemon(config, world, first_mission_id=1000)
    second.__enter__()
    begin(second, tmp_path, **other)
    was = world.truths[""].track()[-1][1:3]
    end_s = world.clock() + 8.0
    while world.clock() < end_s:
        now = second.cycle().only
        assert now.mission.state is State.STOPPED
    assert "a person" in now.sentence
    assert abs(world.truths[""].track()[-1][1:3] - was).max() < 1e-3
    second.people.resume()
    for _ in range(50):
        now = second.cycle().only
    assert now.mission.state is State.IDLE
    assert abs(world.truths[""].track()[-1][1:3] - was).max() < 1e-3
    second.people.resume()
    cycle_until(second, is_driving)
    third = Daemon(config, VirtualWorld(config, pictures=False), first_mission_id=2000)
    begin(third, tmp_path)
    assert third.robot.pilot.mission.state is State.PLANNING


def test_a_robot_that_was_rearmed_waits_in_the_next_run_too_for_the_word_to_go_on(
    tmp_path: Path,
) -> None:
    config = short_config(GOAL)
    world, owner = VirtualWorld(config, pictures=False), owner_of(config)
    with Journal(tmp_path / "journal", owner) as journal:
        first = Daemon(config, world, first_mission_id=1, journals={"": journal})
        first.__enter__()
        begin(first, tmp_path)
        cycle_until(first, is_driving)
        assert first.people.stop("a person") is None
        cycle_until(first, lambda now: now.mission.state is State.STOPPED)
        first.people.resume()
        for _ in range(50):
            first.cycle()
    # killed here
    switch_off_and_on(world.body)
    world.wait(2.0)
    with Journal(tmp_path / "journal", owner) as journal:
        second = Daemon(config, world, first_mission_id=1000, journals={"": journal})
        second.__enter__()
        begin(second, tmp_path)
        was = world.truths[""].track()[-1][1:3]
        end_s = world.clock() + 8.0
        while world.clock() < end_s:
            second.cycle()
        assert abs(world.truths[""].track()[-1][1:3] - was).max() < 1e-3
        second.people.resume()
        cycle_until(second, is_driving)


def test_a_stop_of_the_pilot_s_own_is_kept_too(tmp_path: Path) -> None:
    config = short_config(GOAL)
    with Daemon(config, VirtualWorld(config, pictures=False), first_mission_id=1) as daemon:
        begin(daemon, tmp_path)
        cycle_until(daemon, is_driving)
        daemon.robot.pilot.stop("camera and wheels parted")
        cycle_until(daemon, lambda now: now.mission.state is State.STOPPED)
        assert daemon.stopping.kept is not None
        daemon.stopping.kept.settled()
    with Daemon(config, VirtualWorld(config, pictures=False), first_mission_id=1) as daemon:
        begin(daemon, tmp_path)
        assert daemon.robot.pilot.mission.state is State.STOPPED
        assert isinstance(daemon.robot.pilot.mission, MissionProgress)


def test_a_stop_that_came_before_the_stops_were_read_is_kept(tmp_path: Path) -> None:
    config = short_config(GOAL)
    with Daemon(config, VirtualWorld(config, pictures=False), first_mission_id=1) as daemon:
        daemon.people.stop("in the first moment")
        begin(daemon, tmp_path)
        assert daemon.stopping.kept is not None
        assert daemon.stopping.kept.settled() == ""
    stops = KeptStops(tmp_path / "stops", tmp_path / "c.sock", None, {"": ()})
    assert "in the first moment" in stops.held[""]
