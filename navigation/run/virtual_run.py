"""A whole run in virtual time: as fast as the machine goes, and the same every time."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from navigation.config import Config
from navigation.config.known_robots import CLEARWAY
from navigation.loop.daemon import Daemon
from navigation.loop.daemon_state import DaemonState
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from navigation.run.report import Report
from navigation.run.summary import summarise
from navigation.run.virtual_world import VirtualTimes, VirtualWorld

FIRST_MISSION_ID = 1
Look: TypeAlias = Callable[[Daemon, DaemonState], bool]


def run_virtually(
    config: Config,
    times: VirtualTimes | None = None,
    *,
    look: Look | None = None,
    linger_s: float = 0.0,
    pictures: bool = True,
    make_world: Callable[..., VirtualWorld] = VirtualWorld,
) -> Report:
    """Drive the configured mission until it is over or its time limit; the report of the run.

    ``look`` is called after each cycle, and ends the run where it is True. The run ends
    ``linger_s`` after the mission is over. Everything random comes from ``simulation.seed``.
    Without ``pictures`` none is drawn or looked at: the same decisions in a fraction of the time.
    ``make_world`` makes the world from the same arguments as `VirtualWorld`. Raises ValueError
    without a section ``simulation``, for a robot behind a driver, which is a process in real time,
    and without pictures for what only pictures show.
    """
    if config.simulation is None:
        raise ValueError("a run in virtual time needs a section 'simulation'")
    if config.robot.driver != CLEARWAY:
        raise ValueError(f"robot.driver {config.robot.driver} drives in real time only")
    world = make_world(config, times, pictures=pictures)
    with Daemon(config, world, first_mission_id=FIRST_MISSION_ID) as daemon:
        stations = stations_of(config)
        if stations:
            daemon.people.give(stations, any_order=config.mission.order == "best")
        under_way_s = 0.0
        while True:
            now = daemon.cycle().only
            if stations and not now.mission.is_over:
                under_way_s = now.time_s
            over = under_way_s < now.time_s and now.time_s - under_way_s >= linger_s
            if (look is not None and look(daemon, now)) or over:
                state, reason = now.mission.state, now.sentence
                break
            if now.time_s > config.simulation.time_limit_s:
                limit_s = config.simulation.time_limit_s
                state, reason = State.FAILED, f"not done within {limit_s:g} s: {now.sentence}"
                break
        duration_s = world.clock() - daemon.started_s
        return summarise(daemon, daemon.robot, state, reason, duration_s)
