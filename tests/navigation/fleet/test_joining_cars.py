"""Robots that cannot turn on the spot join those that drive, or are refused and the reason said."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

import planner
from navigation.fleet.joining import join_promises
from navigation.fleet.planning import plan_promises
from navigation.fleet.request import Driving, FleetAnswer, FleetRequest, Traveller
from navigation.mission.mission import Station
from planner.motion.trajectory import default_limits
from planner.path import Limits
from planner.scene import FloatArray
from tests.navigation.fleet.test_fleet_promises import KEEP_M, RADIUS_M, scene_of

TURNING_M = 0.2
CAR = replace(default_limits(RADIUS_M), turns_on_spot=False, turning_radius=TURNING_M)


def joined(heading_rad: float, limits: Limits = CAR) -> tuple[FleetAnswer, FleetAnswer]:
    """One drives; another asks, with this heading, for a path around the block."""
    scene = scene_of()
    roadmap = planner.build_roadmap(scene, RADIUS_M)
    first = Traveller("a", (0.2, 1.3, 0.0), Station(1.7, 1.3), RADIUS_M, CAR)
    before = plan_promises(roadmap, scene, FleetRequest(1, 1, (first,)), KEEP_M)
    second = Traveller("b", (0.2, 0.2, heading_rad), Station(1.1, 1.1), RADIUS_M, limits)
    drives = Driving(before.promises["a"], 1, 6, CAR)
    request = FleetRequest(2, 1, (second,), driving=(drives,))
    return before, join_promises(roadmap, scene, request, KEEP_M)


def tightest_m(points: FloatArray) -> float:
    """The least radius of a circle through three targets that follow each other."""
    a, b, c = points[:-2], points[1:-1], points[2:]
    u, v, w = b - a, c - b, c - a
    area2 = np.abs(u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0])
    sides = np.hypot(*u.T) * np.hypot(*v.T) * np.hypot(*w.T)
    return float(np.min(sides / np.maximum(2.0 * area2, 1e-12)))


def test_the_new_path_has_bends_that_it_can_drive_and_the_other_keeps_its_own() -> None:
    _, turning = joined(0.0, replace(CAR, turns_on_spot=True))
    x, y = turning.promises["b"].points[1] - (0.2, 0.2)
    before, after = joined(math.atan2(y, x))
    assert (after.cannot, after.refused) == ("", {})
    b = after.promises["b"]
    assert tightest_m(b.points) >= 0.9 * TURNING_M
    assert b.trajectory is not None
    (a,) = after.driving
    assert a.points is before.promises["a"].points


def test_one_that_would_have_to_turn_on_the_spot_is_refused_and_the_other_drives_on() -> None:
    _, after = joined(math.pi)
    assert after.cannot == ""
    assert after.promises == {}
    assert after.refused.keys() == {"b"}
    assert "at (0.2, 0.2) the heading must change by" in after.refused["b"]
