"""A stop from before the run holds the robot that it names, or all of them."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from navigation.journal.journal import Journal, owner_of
from navigation.journal.kept_stops import KeptStops
from navigation.journal.stop_latch import Latch, write_latch
from navigation.loop.daemon import Daemon
from navigation.mission.mission import State
from navigation.run.give_missions import GiveMissions
from navigation.run.virtual_world import VirtualWorld
from tests.navigation.loop.test_fleet_kill import STARTS, hall

LOOKED_AT_S = 12.0
"""Both robots drive well before."""
STOOD_M = 1e-3


class Run:
    """Two robots with missions; begins as the runner begins, in virtual time."""

    def __init__(self, folder: Path) -> None:
        config = hall(folder / "journal", "ab")
        self.world = VirtualWorld(config, pictures=False)
        self.daemon = Daemon(config, self.world, first_mission_id=1)
        self.daemon.__enter__()
        seats = self.daemon.robots
        self.journals = [
            Journal(folder / f"{name}.journal", owner_of(seat.config))
            for name, seat in seats.items()
        ]
        for seat, journal in zip(seats.values(), self.journals, strict=True):
            seat.journal = journal
            journal.__enter__()
        stops = KeptStops(folder / "stops", folder / "c.sock", None, dict.fromkeys(seats, ()))
        self.daemon.stopping.hold_from_before(list(seats.values()), stops)
        self.missions = GiveMissions(self.daemon, print)

    def die(self) -> None:
        """Killed: a dead program holds no lock."""
        for journal in self.journals:
            journal.__exit__()

    def cycle_for(self, seconds: float) -> None:
        end_s = self.world.clock() + seconds
        while self.world.clock() < end_s:
            self.missions.cycle()
            self.daemon.cycle()

    def moved_m(self, name: str) -> float:
        """How far the robot was at most from where it stood in the beginning."""
        track = self.world.truths[name].track()
        return max(math.dist(row[1:3], STARTS[name]) for row in track)


def stop_before(folder: Path, robot: str) -> None:
    """What `clearway stop` does while no program runs."""
    latch = Latch(robot, "a person", "2026-11-25", str(folder / "c.sock"))
    write_latch(folder / "stops", latch)


@pytest.mark.parametrize(("stopped", "held"), [("b", "b"), ("", "ab"), ("unknown", "ab")])
def test_a_stop_holds_the_robot_that_it_names_or_all(
    tmp_path: Path, stopped: str, held: str
) -> None:
    stop_before(tmp_path, stopped)
    run = Run(tmp_path)
    run.cycle_for(LOOKED_AT_S)
    for name in "ab":
        state = run.daemon.robots[name].pilot.mission.state
        assert (state is State.STOPPED) == (name in held)
        assert (run.moved_m(name) < STOOD_M) == (name in held)


def test_robots_that_were_all_stopped_are_rearmed_one_by_one(tmp_path: Path) -> None:
    stop_before(tmp_path, "")
    run = Run(tmp_path)
    run.cycle_for(1.0)
    people = run.daemon.people
    people.resume("a")
    run.cycle_for(1.0)
    people.resume("a")
    run.cycle_for(LOOKED_AT_S)
    assert run.moved_m("a") > 0.1
    assert run.moved_m("b") < STOOD_M
    run.die()
    again = Run(tmp_path)
    again.cycle_for(LOOKED_AT_S)
    assert again.moved_m("b") < STOOD_M


def test_robots_that_were_rearmed_wait_in_the_next_run_too_for_the_word_to_go_on(
    tmp_path: Path,
) -> None:
    run = Run(tmp_path)
    run.cycle_for(3.0)
    people = run.daemon.people
    people.stop("a person")
    run.cycle_for(1.0)
    people.resume()
    run.cycle_for(1.0)
    run.die()
    again = Run(tmp_path)
    again.cycle_for(6.0)
    assert again.moved_m("a") < STOOD_M
    assert again.moved_m("b") < STOOD_M
    again.daemon.people.resume("a")
    again.cycle_for(LOOKED_AT_S)
    assert again.moved_m("a") > 0.1
    assert again.moved_m("b") < STOOD_M
