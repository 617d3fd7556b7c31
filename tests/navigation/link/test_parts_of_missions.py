"""A mission that is released in parts: never driven beyond, and driven to its end all the same."""

import math
from itertools import pairwise

import pytest

from firmware_protocol.wire.messages import Waypoint, WaypointFlag
from firmware_protocol.wire.mission import Mission
from navigation.simulator.line_faults import FaultSpec
from tests.support.runs.scenario_loop import ScenarioLoop

MISSION = 77
PLACES = [(0.05 * i, 0.02 * math.sin(i / 3.0)) for i in range(1, 31)]
"""Every 5 cm, a line that bends a little."""
STEP_OVER_M = 0.015
"""A released waypoint is passed within 5 mm; the rest is the simulated wheels' and poses' error."""


def _waypoints() -> list[Waypoint]:
    line = [Waypoint(x, y, 0.2) for x, y in PLACES]
    x, y = PLACES[-1]
    return [*line[:-1], Waypoint(x, y, 0.2, flags=WaypointFlag.STOP)]


def _loop(faults: str, seed: int) -> ScenarioLoop:
    loop = ScenarioLoop(seed=seed, faults=FaultSpec.parse(faults))
    loop.run(1.0)
    return loop


@pytest.mark.parametrize("released", [1, 4, 7, 20, 29])
def test_a_robot_waits_at_the_last_waypoint_that_it_was_given(released: int) -> None:
    loop = _loop("", 3)
    loop.host.upload(Mission(MISSION, _waypoints()), loop.now_s, True, released)
    loop.run(12.0)
    assert loop.host.status is not None
    assert (loop.host.status.accept_next, loop.host.status.exec_next) == (released, released)
    assert max(x for _, x, _, _ in loop.track) < PLACES[released - 1][0] + STEP_OVER_M


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("faults", ["", "drop=0.001,flip=0.0005"])
def test_whatever_is_released_and_when_the_whole_mission_is_driven(faults: str, seed: int) -> None:
    loop = _loop(faults, seed)
    loop.host.upload(Mission(MISSION, _waypoints()), loop.now_s, True, 0)
    for wait_s, count in ((1.0, 3), (0.2, 4), (2.0, 5), (0.1, 17), (0.5, 18), (3.0, 30)):
        loop.run(wait_s)
        assert loop.host.status is not None
        loop.host.release(MISSION, count)
        loop.host.release(MISSION, count - 2)  # what was released stays released
        loop.host.release(MISSION + 1, 30)  # another's
    upload = loop.host.upload_state
    assert upload is not None
    assert loop.run(20.0, lambda: upload.done)


def test_a_release_ahead_of_the_robot_costs_it_no_stop() -> None:
    whole, parts = _loop("", 1), _loop("", 1)
    whole.host.upload(Mission(MISSION, _waypoints()), whole.now_s, True, None)
    parts.host.upload(Mission(MISSION, _waypoints()), parts.now_s, True, 8)
    took_s = []
    for loop in (whole, parts):
        upload = loop.host.upload_state
        assert upload is not None
        began_s = loop.now_s
        for _ in range(400):
            loop.run(0.05)
            loop.host.release(MISSION, upload.executed + 8)
            if upload.done:
                break
        took_s.append(loop.now_s - began_s)
    assert took_s[1] < 1.03 * took_s[0]


def test_an_empty_release_never_starts_the_robot() -> None:
    loop = _loop("", 2)
    before = loop.drive.pose
    loop.host.upload(Mission(MISSION, _waypoints()), loop.now_s, True, 0)
    loop.run(3.0)
    gone = [math.dist(a[1:3], b[1:3]) for a, b in pairwise(loop.track)]
    assert loop.drive.pose == before
    assert sum(gone) == 0.0
