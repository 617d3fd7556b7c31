"""Poses without pictures: no better than what the real tracker makes of drawn ones, and as late."""

from __future__ import annotations

import math

import numpy as np
import pytest

from navigation.config import Config
from navigation.loop.daemon import Daemon
from navigation.loop.stages import stations_of
from navigation.run.virtual_world import VirtualWorld
from planner.scene import FloatArray
from tests.support.runs.virtual import cycle_until, short_config

pytestmark = pytest.mark.slow


def errors_of(config: Config, *, pictures: bool) -> tuple[FloatArray, float]:
    """Position and heading of each sighting less the truth's (3, n), and how old poses were."""
    world = VirtualWorld(config, pictures=pictures)
    seen: dict[float, tuple[float, float, float]] = {}
    ages: list[float] = []
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))

        def note(_now: object) -> None:
            pose = daemon.robot.pose
            if pose is not None and pose.captured_s not in seen:
                seen[pose.captured_s] = (pose.x, pose.y, pose.heading_rad)
                ages.append(world.clock() - pose.captured_s)

        cycle_until(daemon, lambda now: now.mission.is_over, each=note)
        track = world.truths[""].track()
    at_s = np.array(list(seen))
    x, y, heading = np.array(list(seen.values())).T
    true = [np.interp(at_s, track[:, 0], column) for column in track[:, 1:3].T]
    turned = heading - np.interp(at_s, track[:, 0], np.unwrap(track[:, 3]))
    wrapped = np.arctan2(np.sin(turned), np.cos(turned))
    return np.stack([x - true[0], y - true[1], wrapped]), float(np.median(ages))


@pytest.mark.parametrize("noise_grey", [2.0, 6.0])
def test_poses_without_pictures_are_no_better_and_no_newer_than_the_real_trackers(
    noise_grey: float,
) -> None:
    base = short_config([{"x_m": 0.20, "y_m": 1.00, "heading_deg": 90.0}])
    assert base.simulation is not None
    camera = {**base.simulation.camera.model_dump(), "noise_grey": noise_grey, "latency_s": 0.02}
    config = short_config(
        [{"x_m": 0.20, "y_m": 1.00, "heading_deg": 90.0}],
        simulation={"camera": camera},
        camera={"rate_hz": 15.0},
    )
    drawn, drawn_age_s = errors_of(config, pictures=True)
    told, told_age_s = errors_of(config, pictures=False)
    for one, other in zip(told, drawn, strict=True):
        assert math.sqrt((one**2).mean()) >= math.sqrt((other**2).mean())
    assert np.hypot(told[0], told[1]).max() < 0.002
    assert told_age_s == pytest.approx(drawn_age_s, abs=0.001)


def test_a_run_without_pictures_is_the_same_every_time_and_another_seed_another_run() -> None:
    near = [{"x_m": 0.20, "y_m": 0.60}]
    one, again, other = (
        errors_of(short_config(near, simulation={"seed": seed}), pictures=False)[0]
        for seed in (4, 4, 5)
    )
    assert np.array_equal(one, again)
    assert not np.array_equal(one, other)
