"""The whole program frozen while the robot drives (SIGSTOP, a computer that sleeps), virtually.

The robot stops by its lease. What the kernel kept for the program is old when it is read.
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RobotSnapshot
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from tests.support.runs.troubled_world import TroubledWorld
from tests.support.runs.virtual import cycle_until, short_config

FAR = [{"x_m": 0.20, "y_m": 1.60}]


@pytest.fixture
def fast() -> Iterator[tuple[TroubledWorld, Daemon]]:
    """A robot at full speed."""
    config = short_config(FAR, camera={"rate_hz": 30.0})
    world = TroubledWorld(config, pictures=False)
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        cycle_until(
            daemon, lambda now: now.evidence.driven_m > 0.4 and not now.evidence.wheels_stand
        )
        yield world, daemon


def freeze(world: TroubledWorld, seconds: float) -> None:
    """Nothing of the program runs for so long."""
    world.body.loop.knobs.host_frozen = True
    world.wait(seconds)
    world.body.loop.knobs.host_frozen = False


def over(now: RobotSnapshot) -> bool:
    return now.mission.is_over or now.mission.state is State.STOPPED


@pytest.mark.parametrize("lost", [False, True], ids=["reports kept", "all reports lost"])
@pytest.mark.parametrize("seconds", [1.0, 3.0, 30.0, 7200.0])
def test_a_robot_that_braked_meanwhile_was_not_carried(
    fast: tuple[TroubledWorld, Daemon], seconds: float, lost: bool
) -> None:
    world, daemon = fast
    before = world.body.pose()
    world.body.troubles.cable_out = lost
    freeze(world, seconds)
    world.body.troubles.cable_out = False
    assert world.body.pose() != before
    end = cycle_until(daemon, over, 60.0)
    assert end.mission.state is State.DONE, end.sentence


def test_a_robot_that_is_carried_meanwhile_needs_a_person(
    fast: tuple[TroubledWorld, Daemon],
) -> None:
    world, daemon = fast
    freeze(world, 10.0)
    pose = world.body.pose()
    world.body.troubles.carried_to = (pose.x_m + 0.15, pose.y_m, pose.heading_rad)
    freeze(world, 20.0)
    end = cycle_until(daemon, over)
    assert end.mission.state is State.STOPPED
    assert "it was carried or is stuck" in end.sentence
