"""The same runs with drawn pictures and without: the same decisions, for the same reasons."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field

import pytest

from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RobotSnapshot
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from tests.support.runs.troubled_world import TroubledWorld
from tests.support.runs.virtual import cycle_until, is_driving, set_trouble, short_config

pytestmark = pytest.mark.slow

GOAL = (0.20, 1.60)
FAR = [{"x_m": GOAL[0], "y_m": GOAL[1]}]
HIGH_CAMERA = {
    "position_m": (1.155, 0.975, 2.9), "focal_px": 617.5, "centre_offset_px": (2.6, -1.9)
}  # fmt: skip
BUCKET = {"record": "C (0.10,1.16) 0.08", "from_s": 3.0}
"""It closes the way while the robot is on it."""
RATES_HZ = {"frozen with a clock": 30.0}
"""Rates of the camera where it is not 15.

With fewer pictures the run without them has to prove itself where the drawn one plans again.
"""
BROKEN_S = 1.5
APART_M = 0.01
"""Two runs' places may differ by so much when they are broken: a picture's drive."""
DRIVEN_APART_M = 0.06
"""And what they drive in the seconds afterwards: a fifth of a second's drive, as plans that are
made anew differ by where exactly the robot was seen."""


@dataclass(slots=True)
class Told:
    """What a run decided: its states, the first reason in each of them, and how it ended."""

    states: list[State] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)
    scenes: list[int] = field(default_factory=list)
    broken_at: tuple[float, float] = (0.0, 0.0)
    driven_m: float = 0.0
    """After it was broken."""


def break_and_heal(
    name: str, broken: object, healed: object
) -> Callable[[TroubledWorld, bool], None]:
    """A trouble that is there for a while."""
    return lambda world, is_broken: set_trouble(world, name, broken if is_broken else healed)


def freeze_with_a_clock(world: TroubledWorld, is_broken: bool) -> None:
    """Every picture is another one, and all show what was long ago."""
    world.cameras[None].camera_frozen = world.cameras[None].clock_in_the_corner = is_broken


def freeze_with_noise(world: TroubledWorld, is_broken: bool) -> None:
    """As if only the sensor were alive."""
    world.cameras[None].camera_frozen = world.cameras[None].frozen_noise = is_broken


def carry(
    to: Callable[[float, float], tuple[float, float]],
) -> Callable[[TroubledWorld, bool], None]:
    """Take the robot and put it elsewhere, once."""

    def take(world: TroubledWorld, is_broken: bool) -> None:
        x, y, heading = world.body.pose()
        if is_broken:
            world.body.troubles.carried_to = (*to(x, y), heading)

    return take


FAULTS: dict[str, Callable[[TroubledWorld, bool], None]] = {
    "nothing": lambda _world, _is_broken: None,
    "marker hidden": break_and_heal("marker_hidden", True, False),
    "camera lost": break_and_heal("camera_lost", True, False),
    "camera silent": break_and_heal("camera_silent", True, False),
    "camera frozen": break_and_heal("camera_frozen", True, False),
    "frozen with a clock": freeze_with_a_clock,
    "frozen with noise": freeze_with_noise,
    "looping": break_and_heal("looping", True, False),
    "another robot's marker": break_and_heal("marker_at", (1.2, 0.5, 0.3), None),
    "seen elsewhere": break_and_heal("marker_shift_m", (0.5, 0.0), (0.0, 0.0)),
    "marker turned": break_and_heal("marker_turned", True, False),
    "second marker": break_and_heal("double_at", (1.2, 0.5, 0.3), None),
    "late": break_and_heal("stream_latency_s", 0.15, 0.0),
    "stamped in the future": break_and_heal("future_s", 3600.0, 0.0),
    "stuck": break_and_heal("stuck", True, False),
    "motors dead": break_and_heal("motors_dead", True, False),
    "cable out": break_and_heal("cable_out", True, False),
    "carried off the path": carry(lambda x, y: (x + 0.07, y)),
    "carried into an obstacle": carry(lambda _x, _y: (0.42, 1.05)),
    "carried outside": carry(lambda _x, _y: (-0.05, 0.9)),
}


def run(name: str, *, pictures: bool, bucket: bool) -> Told:
    """Break it after 20 cycles of driving, heal it, and look for some seconds more."""
    simulation = {"camera": HIGH_CAMERA, "obstacles": (BUCKET,) if bucket else ()}
    camera = {"rate_hz": RATES_HZ.get(name, 15.0)}
    config, fault = short_config(FAR, simulation=simulation, camera=camera), FAULTS[name]
    world, told = TroubledWorld(config, pictures=pictures), Told()
    with Daemon(config, world, first_mission_id=7) as daemon:
        last: list[tuple[float, float]] = []

        def note(now: RobotSnapshot) -> None:
            x, y, _ = world.body.pose()
            if last:
                told.driven_m += math.dist(last.pop(), (x, y))
            last.append((x, y))
            if now.mission.state not in told.states[-1:]:
                told.states.append(now.mission.state)
                told.reasons.append(re.sub(r"-?[\d.]+", "#", now.sentence))
            if daemon.scene is not None and len(daemon.scene.objects) not in told.scenes[-1:]:
                told.scenes.append(len(daemon.scene.objects))

        daemon.people.give(stations_of(config))
        cycle_until(daemon, is_driving)
        for _ in range(20):
            daemon.cycle()
        told.broken_at = world.body.pose()[:2]
        fault(world, True)
        broken_s = world.clock()
        cycle_until(daemon, lambda _: world.clock() > broken_s + BROKEN_S, 3.0, note)
        fault(world, False)
        cycle_until(
            daemon,
            lambda now: now.mission.is_over or world.clock() > broken_s + 6.0,
            20.0,
            note,
        )
    return told


@pytest.mark.parametrize("name", FAULTS)
def test_a_run_decides_the_same_without_pictures_as_with_them(name: str) -> None:
    drawn = run(name, pictures=True, bucket=False)
    told = run(name, pictures=False, bucket=False)
    assert told.states == drawn.states
    assert told.reasons == drawn.reasons
    assert math.dist(told.broken_at, drawn.broken_at) < APART_M
    assert told.driven_m == pytest.approx(drawn.driven_m, abs=DRIVEN_APART_M)


def test_an_obstacle_that_comes_is_seen_and_driven_around_as_with_pictures() -> None:
    drawn = run("nothing", pictures=True, bucket=True)
    told = run("nothing", pictures=False, bucket=True)
    assert (told.states, told.reasons) == (drawn.states, drawn.reasons)
    assert told.scenes == drawn.scenes == [7, 8]
