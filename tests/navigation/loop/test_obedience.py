"""Robots that drive without permission, told by their speed from those that may drive."""

from __future__ import annotations

import numpy as np

from navigation.loop.traffic.coordinated import BRAKES_S
from tests.navigation.loop.test_at_large import CONFIG, UP, at, seen_at
from vision.markers.markers import RobotPose
from vision.markers.tracking import MarkerTrack, TrackLimits

JITTER_S = 0.01
RATE_HZ = 30.0
SPEED_M_S = CONFIG.robot.speed_m_s
LAPSES_S = CONFIG.safety.lease_s + BRAKES_S


def seen_driving(
    until_s: float, permitted_until_s: float, jitter_s: float, speed_m_s: float = SPEED_M_S
) -> list[bool]:
    """Obedience in each picture of a robot at a constant speed, stamped with a jitter."""
    robot, track = seen_at("clearway", []), MarkerTrack(TrackLimits())
    rng = np.random.default_rng(1)
    obeyed = []
    for now_s in np.arange(0.0, until_s, 1.0 / RATE_HZ):
        stamp_s = now_s + rng.uniform(-jitter_s, jitter_s)
        velocity = track.offer((speed_m_s * now_s, 0.3, 0.0), stamp_s)
        if velocity is None:
            continue
        pose = RobotPose(
            CONFIG.robot.marker_id, speed_m_s * now_s, 0.3, 0.0, stamp_s, np.zeros((4, 2)),
            vx=velocity.vx, vy=velocity.vy,
        )  # fmt: skip
        robot.sees({CONFIG.robot.marker_id: pose}, now_s)
        robot.permitted_s = min(now_s, permitted_until_s)
        obeyed.append(at(robot, now_s, UP).obeys)
    return obeyed


def test_stamps_that_jitter_make_no_robot_that_may_drive_a_runaway() -> None:
    assert all(seen_driving(60.0, 60.0, JITTER_S))


def test_one_that_drives_on_without_a_lease_is_a_runaway_at_once() -> None:
    obeyed = seen_driving(10.0, 5.0, 0.0)
    after_s = 5.0 + LAPSES_S
    first_s = (obeyed.index(False) + 1) / RATE_HZ
    assert after_s <= first_s < after_s + 0.2
    assert not any(obeyed[obeyed.index(False) :])


def test_one_that_drives_far_too_fast_is_a_runaway_with_a_lease_too() -> None:
    obeyed = seen_driving(5.0, 5.0, 0.0, 2.5 * SPEED_M_S)
    assert not any(obeyed[1:])
