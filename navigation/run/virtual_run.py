"""A whole run in virtual time: as fast as the machine allows, and always the same."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from navigation.config import Config
from navigation.config.known_robots import CLEARWAY
from navigation.config.several.each_robot import robots_of
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RunState
from navigation.mission.mission import State
from navigation.run.give_missions import GiveMissions
from navigation.run.run_report import RunReport, summarise_run
from navigation.run.virtual_world import VirtualTimes, VirtualWorld

if TYPE_CHECKING:
    from navigation.loop.recorder import Recorder

FIRST_MISSION_ID = 1
Look: TypeAlias = Callable[[Daemon, RunState], bool]


def run_virtually(
    config: Config,
    times: VirtualTimes | None = None,
    *,
    meet: Callable[[VirtualWorld, float], None] | None = None,
    look: Look | None = None,
    linger_s: float = 0.0,
    record: Path | None = None,
    bodies: Mapping[str, Config] | None = None,
    pictures: bool = True,
    make_world: Callable[..., VirtualWorld] = VirtualWorld,
) -> RunReport:
    """Drive the configured missions until all are over or the time limit; return the report.

    ``meet`` is called every millisecond with the world and the time since the start. ``look`` is
    called after each cycle and ends the run by returning True. The run ends ``linger_s`` after all
    missions. ``bodies`` are the simulated robots' true configurations. All randomness comes from
    ``simulation.seed``. Without ``pictures`` none is drawn or analysed. Raises ValueError without a
    section ``simulation``, for a robot behind a driver, and without pictures for anything that only
    pictures show.
    """
    if config.simulation is None:
        raise ValueError("a run in virtual time needs a section 'simulation'")
    for one in robots_of(config).values():
        if one.robot.driver != CLEARWAY:
            raise ValueError(f"robot.driver {one.robot.driver} drives in real time only")
    world = make_world(config, times, bodies, pictures=pictures)
    if meet is not None:
        world.meet = lambda since_s: meet(world, since_s)
    with ExitStack() as open_things:
        recorder = None
        if record is not None:
            recorder = open_things.enter_context(_recorder(config, world, record))
        daemon = open_things.enter_context(
            Daemon(config, world, first_mission_id=FIRST_MISSION_ID, recorder=recorder)
        )
        missions = GiveMissions(daemon, lambda _line: None)
        under_way_s = 0.0
        while True:
            missions.cycle()
            now = daemon.cycle()
            if not (missions.are_given and now.is_over):
                under_way_s = now.time_s
            over = under_way_s < now.time_s and now.time_s - under_way_s >= linger_s
            if (look is not None and look(daemon, now)) or over:
                state, reason = now.state, now.sentence
                break
            if now.time_s > config.simulation.time_limit_s:
                limit_s = config.simulation.time_limit_s
                state, reason = State.FAILED, f"not done within {limit_s:g} s: {now.sentence}"
                break
        duration_s = world.clock() - daemon.started_s
        return summarise_run(daemon, state, reason, duration_s)


def _recorder(config: Config, world: VirtualWorld, folder: Path) -> Recorder:
    """Recorder whose virtual seconds count from 1970: always the same stamps."""
    from navigation.loop.recorder import Recorder  # only a run that records needs its libraries

    began = datetime.fromtimestamp(world.clock(), UTC)
    return Recorder(config, world.calibration, folder, clock=world.clock, began=began)
