"""A robot is not sent where the newest scene shows that it does not fit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from navigation.loop.daemon import Daemon
from navigation.mission.mission import State
from navigation.orders.carry_out import carry_out
from navigation.run.virtual_world import VirtualWorld
from tests.support.runs.virtual import cycle_until, short_config

RADIUS_M = 0.09


@pytest.fixture
def daemon() -> Iterator[Daemon]:
    config = short_config([{"x_m": 0.20, "y_m": 1.60}], robot={"radius_m": RADIUS_M})
    world = VirtualWorld(config, pictures=False)
    with Daemon(config, world, first_mission_id=7) as daemon:
        yield daemon


def go(daemon: Daemon, *places: tuple[float, float]) -> dict[str, Any]:
    stations = [{"x_m": x, "y_m": y} for x, y in places]
    return carry_out({"order": "go", "stations": stations}, daemon.people)


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ((220.0, 160.0), "at (220, 160) m: outside the arena, x 0..2.4, y 0..1.8"),
        ((0.42, 1.05), "at (0.42, 1.05) m: lies in an obstacle"),
        ((0.05, 0.9), "at (0.05, 0.9) m: the nearest obstacle is 0.050 m away, the robot's radius"),
    ],
)
def test_a_place_where_the_robot_does_not_fit_is_refused_and_changes_nothing(
    daemon: Daemon, place: tuple[float, float], said: str
) -> None:
    cycle_until(daemon, lambda _: daemon.roadmap is not None)
    assert go(daemon, (0.2, 0.9))["ok"]
    stations = daemon.robots[""].pilot.mission.stations
    answer = go(daemon, (0.2, 1.2), place)
    assert not answer["ok"]
    assert answer["error"].startswith(f"station 2 {said}")
    assert daemon.robots[""].pilot.mission.stations == stations
    ended = cycle_until(daemon, lambda now: now.mission.is_over)
    assert ended.mission.state is State.DONE


def test_before_a_scene_was_seen_nothing_is_known_of_a_place(daemon: Daemon) -> None:
    assert go(daemon, (0.42, 1.05))["ok"]
    cycle_until(daemon, lambda now: "goal" in now.sentence)
    assert daemon.robots[""].pilot.mission.state is not State.DRIVING
