"""Killing the program of several robots at random moments, in virtual time, and starting another.

As with one robot (`kills`): a kill is an exception out of the clock, nothing is closed or told
afterwards; the robots, their lines and the journals' files stay.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field

import numpy as np

from navigation.config import Config
from navigation.config.several.each_robot import each_robot
from navigation.journal.journal import Journal, owner_of
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RunState
from navigation.mission.mission import State
from navigation.run.give_missions import GiveMissions
from navigation.run.run_report import least_gap
from tests.support.runs.kills import TIME_LIMIT_S, Killed, MortalWorld, stands
from tests.support.runs.troubled_robot import switch_off_and_on

QUESTIONS = 10_000
"""How often the clock is asked in about ten seconds: a kill comes within so many."""
Look = Callable[[Daemon, RunState], None]


@dataclass(frozen=True, slots=True)
class FleetCampaign:
    """What came of all missions under fire, by robot."""

    kills: int
    states: Mapping[str, State]
    sentence: str
    visits: Mapping[str, list[int]]
    """Indices of its own stations at which a robot has stood, in the order of time."""
    least_gap_m: float
    said: list[str] = field(default_factory=list)


def drive_fleet_under_fire(
    config: Config,
    seed: int,
    kills: int,
    power_cycles: float = 0.0,
    look: Look = lambda _daemon, _now: None,
) -> FleetCampaign:
    """Drive all missions while the program is killed up to ``kills`` times.

    ``power_cycles``: the share of kills after which one of the robots too has lost everything.
    ``config`` names the journal.
    """
    rng = np.random.default_rng(seed)
    world = MortalWorld(config)
    first_id, killed = 1, 0
    said: list[str] = []
    while True:
        world.reaper.arm(int(rng.integers(1, QUESTIONS)) if killed < kills else math.inf)
        try:
            with ExitStack() as closed_in_any_case:  # a dead program holds no lock
                daemon, now = _run(config, world, closed_in_any_case, first_id, said.append, look)
            break
        except Killed:
            killed += 1
            first_id += 1000
            world.bury()
            for body in world.bodies.values():
                if rng.random() < power_cycles:
                    switch_off_and_on(body)
            world.wait(float(rng.uniform(0.05, 3.0)))
    gap = least_gap(daemon)
    alone = each_robot(config)
    return FleetCampaign(
        killed,
        {name: one.mission.state for name, one in now.robots.items()},
        now.sentence,
        {name: stands(truth.track(), alone[name]) for name, truth in world.truths.items()},
        math.inf if gap is None else gap[0],
        said,
    )


def _run(
    config: Config,
    world: MortalWorld,
    open_things: ExitStack,
    first_id: int,
    say: Callable[[str], None],
    look: Look,
) -> tuple[Daemon, RunState]:
    daemon = Daemon(config, world, first_mission_id=first_id)
    daemon.__enter__()
    for name, one in each_robot(config).items():
        assert one.recording.journal is not None
        journal = Journal(one.recording.journal, owner_of(one))
        daemon.robots[name].journal = open_things.enter_context(journal)
    missions = GiveMissions(daemon, say)
    while True:
        missions.cycle()
        now = daemon.cycle()
        look(daemon, now)
        if (missions.are_given and now.is_over) or now.time_s > TIME_LIMIT_S:
            return daemon, now
