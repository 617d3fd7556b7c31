"""A robot whose cable is pulled out, or whose processor restarts, at full speed, virtually.

Nobody reports what its wheels do until it stands. It may be another robot, and proves itself.
"""

from __future__ import annotations

import math

import pytest

from firmware_protocol.host.events import LinkChanged
from firmware_protocol.host.state import LinkState
from navigation.loop.daemon import Daemon
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from tests.support.runs.troubled_robot import switch_off_and_on
from tests.support.runs.troubled_world import TroubledWorld
from tests.support.runs.virtual import cycle_until, short_config

FAR = [{"x_m": 0.20, "y_m": 1.60}]
GONE = LinkChanged(LinkState.STREAM, LinkState.CLOSED, "the port broke")


@pytest.mark.parametrize("how", ["pulled out", "restarted", "pulled out and restarted"])
def test_what_it_braked_over_unreported_is_no_sign_that_it_was_carried(how: str) -> None:
    config = short_config(FAR, camera={"rate_hz": 30.0})
    world = TroubledWorld(config, pictures=False)
    states: list[State] = []
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        cycle_until(
            daemon, lambda now: now.evidence.driven_m > 0.4 and not now.evidence.wheels_stand
        )
        began_s, body = world.clock(), world.body
        if "pulled" in how:
            body.troubles.port_broken = True
            body.loop.events.append(GONE)
        if "restarted" in how:
            switch_off_and_on(body)
        cycle_until(daemon, lambda _: world.clock() > began_s + 3.0)
        body.troubles.port_broken = False
        end = cycle_until(
            daemon,
            lambda now: now.mission.is_over or now.mission.state is State.STOPPED,
            each=lambda now: states.append(now.mission.state),
        )
    assert end.mission.state is State.DONE, end.sentence
    assert State.PROVING in states
    assert math.dist(world.body.pose()[:2], (0.20, 1.60)) < 0.01
