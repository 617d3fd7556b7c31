"""From timed waypoints to what the robot is given: turns merged, stops and stays kept."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.wire.messages import WaypointFlag
from navigation.mission.targets import (
    LONGEST_DWELL_S,
    Target,
    targets_of,
    to_wire,
    within_caps,
)
from planner.path import Path, TimedWaypoint, Trajectory
from planner.scene import Bounds, Scene
from planner.zones.areas import CircleArea
from planner.zones.rules import rules_for
from planner.zones.zone import Zone


def path_with(headings: tuple[float | None, ...]) -> Path:
    points = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])
    stations = tuple(range(len(headings)))
    return Path(points, np.ones(3), 2.0, 1.0, (0.0, 0.0), 0.1, stations, headings)


TURNING = Trajectory(
    (
        TimedWaypoint(0.0, 0.0, 0.0, 0.0, 0.0, station=0),
        TimedWaypoint(0.5, 0.0, 0.0, 0.3, 2.0),
        TimedWaypoint(1.0, 0.0, 0.0, 0.0, 4.0, station=1, dwell_s=60.0),
        TimedWaypoint(1.0, 0.0, 1.5, 0.0, 65.0),
        TimedWaypoint(1.0, 1.0, 1.5, 0.0, 69.0, station=2),
        TimedWaypoint(1.0, 1.0, 3.0, 0.0, 71.0),
    ),
    71.0,
)


def test_turns_on_the_spot_become_part_of_the_stop() -> None:
    targets = targets_of(path_with((None, None, 3.0)), TURNING)
    assert (targets[0].x_m, targets[0].y_m) == (0.5, 0.0)
    assert len({(t.x_m, t.y_m) for t in targets}) == 3
    assert [t.stops for t in targets if t.x_m == 0.5] == [False]
    assert targets[-1].heading_rad == 3.0
    assert [t.heading_rad for t in targets[:-1]] == [None] * (len(targets) - 1)


def test_a_long_stay_is_split_and_its_station_counted_at_the_end_of_it() -> None:
    targets = targets_of(path_with((None, None, None)), TURNING)
    stay = [t for t in targets if (t.x_m, t.y_m) == (1.0, 0.0)]
    assert sum(t.dwell_s for t in stay) == pytest.approx(60.0)
    assert all(t.dwell_s <= LONGEST_DWELL_S for t in stay)
    assert [t.station for t in stay] == [None, None, 1]


def test_a_robot_that_is_there_already_still_gets_its_target() -> None:
    here = Trajectory((TimedWaypoint(1.0, 1.0, 0.5, 0.0, 0.0, station=1),), 0.0)
    (target,) = targets_of(path_with((None, 0.5)), here)
    assert (target.x_m, target.heading_rad, target.stops) == (1.0, 0.5, True)


@given(st.floats(0.0, 200.0))
def test_every_stay_fits_on_the_wire_and_none_is_cut(dwell_s: float) -> None:
    stay = Trajectory(
        (
            TimedWaypoint(0.0, 0.0, 0.0, 0.0, 0.0, station=0),
            TimedWaypoint(1.0, 0.0, 0.0, 0.0, 4.0, station=1, dwell_s=dwell_s),
        ),
        4.0 + dwell_s,
    )
    wire = to_wire(targets_of(path_with((None, None)), stay))
    assert sum(w.dwell_s for w in wire) == pytest.approx(dwell_s)
    assert all(w.flags & WaypointFlag.STOP and len(w.pack()) == 16 for w in wire)


def test_between_two_stops_in_a_slow_zone_the_zones_speed_counts() -> None:
    """Both ends of such a piece are 0, which on the wire is the robot's own highest speed."""
    slow = Zone("slow", "slow", CircleArea((0.0, 0.0), 0.3), speed=0.05)
    scene = Scene("m", Bounds(-9.0, -9.0, 9.0, 9.0), ())
    stop = Target(0.1, 0.0, 0.0, True)
    after, far = Target(1.0, 0.0, 0.2, False), Target(2.0, 0.0, 0.0, True)
    found = within_caps((0.0, 0.0), (stop, after, far), rules_for([slow], scene, 0.1))
    assert [(one.speed_m_s, one.stops) for one in found] == [
        (0.05, True), (0.05, False), (0.0, True),
    ]  # fmt: skip
    assert to_wire(found)[0].flags is WaypointFlag.STOP
    plain = within_caps((0.0, 0.0), (stop, after, far), rules_for([], scene, 0.1))
    assert plain == (stop, after, far)
