"""A camera that is lost while the robot drives, and opened again, in virtual time.

The robot brakes blind meanwhile: what its wheels did then is neither slip nor forgotten.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from navigation.loop.daemon import Daemon
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from tests.support.runs.troubled_world import TroubledWorld
from tests.support.runs.virtual import cycle_until, set_trouble, short_config

pytestmark = pytest.mark.slow

FAR = [{"x_m": 0.20, "y_m": 1.60}]
OVER = (State.DONE, State.FAILED, State.STOPPED)


def lose_the_camera(
    how: str, away_s: float, meanwhile: Callable[[TroubledWorld, tuple[float, float, float]], None]
) -> tuple[TroubledWorld, State, str, int]:
    """Drive fast, lose the camera for so long, do something: the end, and how often it was opened.

    ``meanwhile`` is done once the robot stands, with where it was seen last.
    """
    config = short_config(FAR, camera={"rate_hz": 30.0})  # it is lost at full speed
    world = TroubledWorld(config, pictures=False)
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        now = cycle_until(
            daemon, lambda now: now.evidence.driven_m > 0.4 and not now.evidence.wheels_stand
        )
        assert now.evidence.latency_s is not None, "dated by what was measured"
        seen_last = world.body.pose()
        lost_s = world.clock()
        set_trouble(world, how, True)
        cycle_until(daemon, lambda _: world.clock() > lost_s + away_s)
        meanwhile(world, seen_last)
        set_trouble(world, how, False)
        end = cycle_until(daemon, lambda now: now.mission.state in OVER)
        return world, end.mission.state, end.sentence, daemon.camera.status().reopened


@pytest.mark.parametrize(
    ("how", "away_s"),
    [
        ("camera_lost", 0.2),
        ("camera_lost", 0.6),
        ("camera_lost", 3.0),
        ("camera_silent", 1.2),
        ("camera_silent", 3.0),
        ("camera_frozen", 1.2),
        ("camera_frozen", 2.0),
    ],
)
def test_the_way_braked_blind_is_no_slip(how: str, away_s: float) -> None:
    world, state, sentence, reopened = lose_the_camera(how, away_s, lambda _world, _pose: None)
    assert reopened >= 1
    assert state is State.DONE, sentence
    assert math.dist(world.body.pose()[:2], (0.20, 1.60)) < 0.01


@pytest.mark.parametrize("how", ["camera_lost", "camera_silent", "camera_frozen"])
def test_a_robot_that_is_put_back_where_it_was_seen_last_needs_a_person(how: str) -> None:
    """Its wheels have braked over 0.13 m: the camera must see that, or a person look."""

    def put_back(world: TroubledWorld, seen_last: tuple[float, float, float]) -> None:
        assert math.dist(world.body.pose()[:2], seen_last[:2]) > 0.12
        world.body.troubles.carried_to = seen_last

    _, state, sentence, reopened = lose_the_camera(how, 2.0, put_back)
    assert reopened >= 1
    assert state is State.STOPPED
    assert "the camera sees the robot 0.1" in sentence
    assert "from where its wheels brought it" in sentence
