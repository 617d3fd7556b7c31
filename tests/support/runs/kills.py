"""Killing the daemon at random moments of its work, in virtual time, and starting another.

A kill is an exception that no part of the program catches, raised out of the clock that
everything asks: between any two steps. Nothing is closed or told afterwards, and what was under
way in the planner is lost; the robot, its line and the journal's file stay.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from navigation.config import Config
from navigation.journal.journal import Journal, owner_of
from navigation.loop.daemon import Daemon
from navigation.mission.mission import State
from navigation.run.give_missions import GiveMissions
from navigation.run.virtual_world import VirtualWorld
from planner.scene import FloatArray
from tests.support.runs.troubled_robot import switch_off_and_on

TIME_LIMIT_S = 600.0
NEAR_M = 0.02
STAND_S = 0.3
QUESTIONS = 2500
"""How often the clock is asked in about four seconds: a kill comes within so many."""


class Killed(BaseException):
    """The process is gone."""


class Reaper:
    """Kills at its ``kill_at``-th question."""

    kill_at = math.inf
    asked = 0

    def ask(self) -> None:
        """One question more: answered, or the end of who asks."""
        self.asked += 1
        if self.asked >= self.kill_at:
            self.kill_at = math.inf
            raise Killed

    def arm(self, kill_at: float) -> None:
        """Count from here."""
        self.asked, self.kill_at = 0, kill_at


class MortalWorld(VirtualWorld):
    """A world whose clock kills."""

    def __init__(self, config: Config) -> None:
        self.reaper = Reaper()
        super().__init__(config, pictures=False)

    def clock(self) -> float:
        """Virtual seconds, or death."""
        self.reaper.ask()
        return super().clock()

    def bury(self) -> None:
        """Nothing that the dead program had under way happens any more."""
        self._due.clear()


@dataclass(frozen=True, slots=True)
class Campaign:
    """What came of a mission under fire."""

    kills: int
    state: State
    reason: str
    visits: list[int]
    """Indices of the stations at which the robot has stood, in the order of time."""
    least_clearance_m: float


def drive_under_fire(
    config: Config, journal: Path, seed: int, kills: int, power_cycles: float = 0.0
) -> Campaign:
    """Drive the configured mission while the program is killed up to ``kills`` times.

    ``power_cycles``: the share of kills after which the robot too has lost everything.
    """
    rng = np.random.default_rng(seed)
    world = MortalWorld(config)
    first_id, killed = 1, 0
    while True:
        world.reaper.arm(int(rng.integers(1, QUESTIONS)) if killed < kills else math.inf)
        try:
            # closed in any case, as the system does: a dead program holds no lock
            with Journal(journal, owner_of(config)) as with_journal:
                end = _run(config, world, with_journal, first_id)
            break
        except Killed:
            killed += 1
            first_id += 1000
            world.bury()
            if rng.random() < power_cycles:
                switch_off_and_on(world.body)
            world.wait(float(rng.uniform(0.05, 3.0)))
    track = world.truths[""].track()
    return Campaign(killed, *end, stands(track, config), world.truths[""].track_clearance(track))


def _run(config: Config, world: MortalWorld, journal: Journal, first_id: int) -> tuple[State, str]:
    daemon = Daemon(config, world, first_mission_id=first_id, journals={"": journal})
    daemon.__enter__()
    missions = GiveMissions(daemon, lambda _line: None)
    while True:
        missions.cycle()
        now = daemon.cycle()
        if (missions.are_given and now.is_over) or now.time_s > TIME_LIMIT_S:
            return now.state, now.sentence


def stands(track: FloatArray, config: Config) -> list[int]:
    """At which stations a track (n, 4) comes to a stand, each stay once, in order."""
    found: list[int] = []
    still_s, here = 0.0, -1
    if not config.mission.stations:
        return found
    for before, now in pairwise(track):
        gaps = [math.dist(now[1:3], (s.x_m, s.y_m)) for s in config.mission.stations]
        near = int(np.argmin(gaps)) if min(gaps) < NEAR_M else -1
        moved = math.dist(before[1:3], now[1:3]) > 1e-5
        still_s = 0.0 if moved or near < 0 else still_s + float(now[0] - before[0])
        if near < 0:
            here = -1
        elif still_s > STAND_S and here != near:
            here = near
            found.append(near)
    return found
