"""Camera and wheels of a robot whose way is known: what they agree on, and where they part."""

from __future__ import annotations

import math

import numpy as np
import pytest

from navigation.witness import Evidence, Witness
from tests.support.robots.moving_robot import LIMITS, MovingRobot, Sight, status
from vision.markers.markers import RobotPose

Place = tuple[float, float, float]


def partings(robot: MovingRobot, **how: object) -> list[tuple[float, str]]:
    found = robot.evidence_with(Witness(LIMITS), **how)  # type: ignore[arg-type]
    return [(at_s, evidence.parted) for at_s, evidence in found if evidence.parted is not None]


def last(robot: MovingRobot, **how: object) -> Evidence:
    *_, (_, evidence) = robot.evidence_with(Witness(LIMITS), **how)  # type: ignore[arg-type]
    return evidence


@pytest.mark.parametrize("latency_s", [0.0, 0.03, 0.1, 0.15, 0.25, 0.6, 1.5])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_latency_is_found_from_the_motion(latency_s: float, seed: int) -> None:
    evidence = last(MovingRobot(seed=seed), latency_s=latency_s)
    assert evidence.latency_s is not None
    assert abs(evidence.latency_s - latency_s) <= max(0.015, evidence.latency_error_s)
    assert evidence.latency_error_s <= 0.06


@pytest.mark.parametrize("metre", [0.92, 1.08])
@pytest.mark.parametrize("bend_rad_m", [-0.3, 0.3])
@pytest.mark.parametrize("latency_s", [0.0, 0.14])
def test_a_well_behaved_robot_is_never_doubted(
    metre: float, bend_rad_m: float, latency_s: float
) -> None:
    """Wheels as wrong as tyres make them, any latency that needs no slower driving."""
    robot = MovingRobot(seconds=40.0, metre=metre, bend_rad_m=bend_rad_m)
    assert partings(robot, latency_s=latency_s) == []


def test_a_robot_that_stands_says_nothing_of_the_latency() -> None:
    evidence = last(MovingRobot(motion=lambda _t: (0.0, 0.0), seconds=5.0))
    assert evidence.latency_s is None
    assert evidence.agreed_m == 0.0


def test_a_frozen_picture_says_nothing_of_the_latency() -> None:
    assert last(MovingRobot(), sight=lambda _t, _p: (0.0, 0.0, 0.0)).latency_s is None


def frozen(time_s: float, pose: Place) -> Place:
    return pose if time_s < 10.0 else (0.9, 0.0, 0.0)


def jumped(time_s: float, pose: Place) -> Place:
    return pose if time_s < 10.5 else (pose[0] + 0.05, pose[1], pose[2])


def turned(time_s: float, pose: Place) -> Place:
    return pose if time_s < 10.5 else (pose[0], pose[1], pose[2] + math.pi)


def drifting(time_s: float, pose: Place) -> Place:
    return pose[0], pose[1] + 0.02 * max(0.0, time_s - 8.0), pose[2]


def half_as_large(_time_s: float, pose: Place) -> Place:
    return 0.5 * pose[0], 0.5 * pose[1], pose[2]


def mirrored(_time_s: float, pose: Place) -> Place:
    return pose[0], -pose[1], -pose[2]


@pytest.mark.parametrize(
    ("sight", "from_s", "within_s"),
    [
        # the robot sets off at 9 s, turns at 13 s
        (frozen, 10.0, 0.3),
        (jumped, 10.5, 0.1),
        (turned, 10.5, 0.1),
        (drifting, 8.0, 2.6),
        (half_as_large, 1.0, 1.2),
        (mirrored, 5.0, 0.6),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_what_the_camera_makes_up_is_found_soon(
    sight: Sight, from_s: float, within_s: float
) -> None:
    found = partings(MovingRobot(), sight=sight)
    assert found, "never found"
    assert from_s <= found[0][0] <= from_s + within_s
    assert "the camera saw the robot" in found[0][1]


@pytest.mark.parametrize("seed", range(5))
def test_a_frozen_picture_lets_the_robot_get_no_farther_than_a_hand(seed: int) -> None:
    """At 0.3 m/s, with the latency known: the slack, its error, two reports."""
    robot = MovingRobot(seed=seed)
    (found_s, _), *_ = partings(robot, sight=frozen)
    assert math.dist(robot.pose(found_s)[:2], robot.pose(10.0)[:2]) < 0.06


def test_what_both_agree_on_counts_and_slip_does_not_grow() -> None:
    evidence = last(MovingRobot(seconds=40.0, metre=1.05))
    robot_m = 5 * 0.3 * 2.4
    assert evidence.agreed_m == pytest.approx(robot_m / 1.05, rel=0.03)
    assert math.hypot(*evidence.slip_m) < 0.1
    assert evidence.camera_rad == pytest.approx(evidence.wheels_rad, abs=0.2)


def test_slip_keeps_what_a_robot_was_carried_while_nobody_looked() -> None:
    def hidden(time_s: float, pose: Place) -> Place | None:
        if 4.5 < time_s < 4.9:
            return None
        return pose if time_s < 4.9 else (pose[0] + 0.4, pose[1] - 0.3, pose[2] + 1.0)

    evidence = last(MovingRobot(seconds=7.9), sight=hidden)
    assert math.hypot(*evidence.slip_m) == pytest.approx(0.5, abs=0.03)
    assert evidence.slip_rad == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("latency_s", [0.0, 0.14])
@pytest.mark.parametrize("forgotten_s", [10.05, 10.3, 11.0])
def test_a_camera_that_is_opened_again_makes_no_slip_of_what_it_missed(
    latency_s: float, forgotten_s: float
) -> None:
    """The wheels drive 0.3 m unseen; the robot is seen where they brought it."""
    robot, witness = MovingRobot(), Witness(LIMITS)
    before = after = (0.0, 0.0)
    forgotten = False
    for at_s, evidence in robot.evidence_with(
        witness,
        latency_s=latency_s,
        sight=lambda t, pose: None if 10.0 < t < 11.2 else pose,
    ):
        if at_s >= forgotten_s and not forgotten:
            witness.forget_latency()
            forgotten = True
        before, after = (evidence.slip_m, after) if at_s < 10.0 else (before, evidence.slip_m)
        assert evidence.parted is None
    assert math.dist(before, after) < 0.03


@pytest.mark.parametrize("slept", [False, True])
@pytest.mark.parametrize("minutes", [0.5, 20.0, 36.0, 50.0, 71.0, 72.0, 100.0, 130.0])
def test_a_robot_that_was_not_heard_for_long_is_heard_again(minutes: float, slept: bool) -> None:
    """Its clock comes round after 71.6 minutes, so that a newer time may seem an older one;
    ``slept``: this computer's clock did not run meanwhile."""
    witness = Witness(LIMITS)
    away_s, host_s = 60.0 * minutes, 0.0 if slept else 60.0 * minutes
    for i in range(20):
        witness.report(status(0.05 * i, 0.0, 0.0), 0.05 * i)
    for i in range(20, 60):
        at_s = 0.05 * i
        witness.report(status(away_s + at_s, 0.3, 0.0), host_s + at_s)
        pose = RobotPose(7, 0.0, 0.0, 0.0, host_s + at_s, np.zeros((4, 2)))
        witness.saw(pose, host_s + at_s)
        if witness.evidence().parted is not None:
            return
    pytest.fail("the picture is frozen, and the wheels turn")


def test_a_held_up_report_is_no_late_motion() -> None:
    """Reports of a quarter of a second arrive in one burst: their own clock dates them."""

    def late_s(time_s: float) -> float:
        return (0.25 - time_s % 0.25) if 10.0 < time_s < 12.0 else 0.0

    assert partings(MovingRobot(), late_s=late_s) == []


def test_after_a_gap_in_the_reports_the_comparison_begins_again() -> None:
    """A second without a report while the robot drives: nobody knows, nobody accuses."""

    def late_s(time_s: float) -> float:
        return math.inf if 10.0 < time_s < 11.0 else 0.0

    robot = MovingRobot()
    witness = Witness(LIMITS)
    all_of_it = robot.evidence_with(witness, late_s=lambda t: 1e9 if late_s(t) else 0.0)
    for at_s, evidence in all_of_it:
        if at_s < 19.9:  # before the lost reports come
            assert evidence.parted is None
            assert witness.wheels.stretch == (1 if at_s < 11.0 else 2)


def test_what_the_wheels_reported_before_and_after_a_gap_is_no_slip() -> None:
    """Unseen from 10.4 s to 13 s, the robot drives, stands and drives; two seconds of it, in which
    it stands, are not reported."""

    def motion(time_s: float) -> tuple[float, float]:
        return (0.3 if time_s < 10.6 or time_s > 12.8 else 0.0), 0.0

    def sight(time_s: float, pose: Place) -> Place | None:
        return None if 10.4 < time_s < 13.0 else pose

    robot = MovingRobot(motion=motion, seconds=16.0)
    evidence = last(robot, sight=sight, late_s=lambda t: 1e9 if 10.7 < t < 12.7 else 0.0)
    assert math.hypot(*evidence.slip_m) < 0.02


@pytest.mark.parametrize(
    ("carried_m", "slip_m"), [((0.0, 0.0), 0.0), ((0.5, 0.0), 0.26), ((0.0, 0.15), 0.15)]
)
def test_only_what_a_robot_can_have_driven_unreported_is_no_slip(
    carried_m: tuple[float, float], slip_m: float
) -> None:
    """It drives 0.06 m and brakes, then stands, while reports are lost and nobody looks."""

    def motion(time_s: float) -> tuple[float, float]:
        return (0.3 if time_s < 10.2 else 0.0), 0.0

    def sight(time_s: float, pose: Place) -> Place | None:
        if 10.0 < time_s < 12.0:
            return None
        dx, dy = carried_m if time_s >= 12.0 else (0.0, 0.0)
        return pose[0] + dx, pose[1] + dy, pose[2]

    robot = MovingRobot(motion=motion, seconds=14.0)
    evidence = last(robot, sight=sight, late_s=lambda t: 1e9 if 10.0 < t < 12.0 else 0.0)
    assert math.hypot(*evidence.slip_m) == pytest.approx(slip_m, abs=0.03)


def test_the_pose_is_carried_on_by_the_wheels() -> None:
    robot = MovingRobot(seconds=3.0)
    witness = Witness(LIMITS)
    for _ in robot.evidence_with(witness, noise_m=0.0, noise_rad=0.0):
        pass
    x, y, heading = robot.pose(2.6)
    seen = RobotPose(7, x, y, heading, 2.6, np.zeros((4, 2)))
    carried = witness.carried(seen, 2.98)
    assert math.dist(carried[:2], robot.pose(2.98)[:2]) < 0.004


def test_a_report_that_comes_twice_or_late_changes_nothing() -> None:
    robot, witness = MovingRobot(seconds=4.0), Witness(LIMITS)
    for _ in robot.evidence_with(witness):
        pass
    driven_m = witness.wheels.driven_m
    witness.report(robot.report(1.0), 4.2)
    witness.report(robot.report(3.95), 4.2)
    assert witness.wheels.driven_m == driven_m


def test_another_boot_begins_another_stretch() -> None:
    witness = Witness(LIMITS)
    witness.report(status(100.0, 0.3, 0.0, boot_id=1), 0.0)
    witness.report(status(100.05, 0.3, 0.0, boot_id=1), 0.05)
    witness.report(status(0.0, 0.0, 0.0, boot_id=2), 0.10)
    assert witness.wheels.stretch == 2
    assert witness.wheels.driven_m == pytest.approx(0.015)


def test_the_robots_clock_may_wrap() -> None:
    witness = Witness(LIMITS)
    wrap_s = (1 << 32) / 1e6
    for i in range(20):
        witness.report(status(wrap_s - 0.5 + 0.05 * i, 0.2, 0.0), 0.05 * i)
    assert witness.wheels.stretch == 1
    assert witness.wheels.driven_m == pytest.approx(0.2 * 0.95)
