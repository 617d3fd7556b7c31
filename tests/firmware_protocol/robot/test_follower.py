import math
from array import array
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
import pytest

from firmware_protocol.robot.clearway.follower import Follower
from firmware_protocol.robot.clearway.link import REJECTED
from firmware_protocol.robot.clearway.settings import Settings
from firmware_protocol.robot.clearway.waypoints import WaypointQueue
from firmware_protocol.robot.controller import WheelSpeeds
from firmware_protocol.wire.messages import (
    Clear,
    Lease,
    LeaseFlag,
    PoseFix,
    RobotState,
    Start,
    StopReason,
    Waypoint,
    WaypointFlag,
    Waypoints,
)
from firmware_protocol.wire.mission import Mission
from navigation.simulator.drive_model import Drive, DriveModel, TruePose
from tests.firmware_protocol.robot.board import Board
from tests.support.robots.inside import counted

DT_S = 0.01
DELAY_STEPS = 4
CAMERA_STEPS = 3


def clock_us(now_s: float) -> int:
    """The robot's clock as the wire has it."""
    return round(now_s * 1e6) % (1 << 32)


@dataclass
class Run:
    """A drive: the robot's end on a table, the moving robot and the camera's delay."""

    start: tuple[float, float, float] = (0.0, 0.0, 0.0)
    model: DriveModel = field(default_factory=DriveModel)
    seed: int = 1
    blind: bool = False
    noise: float = 1.0

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.seed)
        self.board = Board()
        self.control, self.send = self.board.control, self.board.send
        self.drive = Drive(self.model, TruePose(*self.start), self.rng)
        self.board.hello(5)
        self.steps = 0
        self.wheels = WheelSpeeds(0.0, 0.0, False)
        self.poses: list[TruePose] = []
        self.idle(0.3)

    def idle(self, seconds: float) -> None:
        for _ in range(round(seconds / DT_S)):
            self.step()

    @property
    def now_s(self) -> float:
        return self.board.now_s

    def see(self, x: float, y: float, heading: float, age_s: float) -> bool:
        """A camera pose; False if the robot did not use it."""
        refused = counted(self.board.robot, REJECTED)
        self.send(PoseFix(x, y, heading, clock_us(self.now_s - age_s)))
        return counted(self.board.robot, REJECTED) == refused

    def begin(self, mission: Mission, count: int) -> None:
        """Give the first waypoints of a mission, and start it."""
        self.send(Clear(1, mission.id))
        self.send(Waypoints(mission.id, 0, mission.records[:count]))
        self.send(Start(2, mission.id, 0))
        assert self.control.state is RobotState.RUN

    def step(self) -> None:
        self.steps += 1
        self.board.now_s += DT_S
        for _ in range(5):
            self.drive.step(DT_S / 5, self.wheels)
        self.poses.append(self.drive.pose)
        if self.steps % CAMERA_STEPS == 0 and len(self.poses) > DELAY_STEPS and not self.blind:
            x, y, heading = self.poses[-1 - DELAY_STEPS]
            e = self.rng.standard_normal(3) * self.noise
            age_s = DELAY_STEPS * DT_S
            self.see(x + 0.0008 * e[0], y + 0.0008 * e[1], heading + 0.006 * e[2], age_s)
        flags = LeaseFlag.PERMIT | (LeaseFlag.ODOMETRY if self.blind else LeaseFlag.NONE)
        self.send(Lease(0.5, flags, 0.04, clock_us(self.now_s)))
        self.wheels = self.control.step(self.now_s, *self.drive.encoders_m)

    def follow(self, waypoints: Sequence[Waypoint], patience_s: float = 60.0) -> list[TruePose]:
        mission = Mission(self.control.mission + 1, waypoints)
        self.send(Clear(1, mission.id))
        sent, began = 0, len(self.poses)
        for _ in range(round(patience_s / DT_S)):
            while sent < len(mission) and self.control.credit > 0:
                self.send(Waypoints(mission.id, sent, mission.records[sent:][:1]))
                sent += 1
            if self.control.state is RobotState.IDLE and not self.control.done:
                self.send(Start(2, mission.id, 0))
                assert self.control.state is RobotState.RUN
            self.step()
            if self.control.state is not RobotState.RUN:
                break
        if self.control.done:
            assert self.control.exec_crc == mission.prefix_crc(len(mission))
        return self.poses[began:]


def line(points: Sequence[tuple[float, float]], speed: float = 0.3) -> list[Waypoint]:
    return [Waypoint(x, y, speed) for x, y in points]


def distance_to_line(pose: TruePose, points: Sequence[tuple[float, float]]) -> float:
    p, q = np.asarray(points), np.asarray(pose[:2])
    d = np.diff(p, axis=0)
    t = np.clip(((q - p[:-1]) * d).sum(1) / (d * d).sum(1), 0.0, 1.0)
    return float(np.hypot(*(p[:-1] + t[:, None] * d - q).T).min())


def rms_error(track: Sequence[TruePose], points: Sequence[tuple[float, float]]) -> float:
    return math.sqrt(sum(distance_to_line(p, points) ** 2 for p in track) / len(track))


def bends(spacing: float = 0.05) -> list[tuple[float, float]]:
    count = round(2.0 / spacing)
    return [
        (2.0 * i / count, 0.2 * (1 - math.cos(2.0 * i / count * 3.5))) for i in range(count + 1)
    ]


@pytest.mark.parametrize(("left", "right"), [(1.0, 1.0), (1.03, 1.03), (0.97, 1.0), (1.0, 0.97)])
def test_tracking_error_stays_below_10_mm_with_wrong_wheels(left: float, right: float) -> None:
    for seed in range(2):
        run = Run(model=DriveModel(left_scale=left, right_scale=right, slip=0.02), seed=seed)
        waypoints = line(bends())
        waypoints[-1] = Waypoint(*bends()[-1], 0.0, heading_rad=1.0)
        track = run.follow(waypoints)
        assert run.control.done
        assert rms_error(track, bends()) < 0.010
        x, y, heading = run.drive.pose
        assert math.dist((x, y), bends()[-1]) < 0.005
        assert abs(math.remainder(heading - 1.0, math.tau)) < math.radians(1.0)


def test_the_drive_takes_the_speed_of_its_waypoints() -> None:
    points = [(0.05 * i, 0.0) for i in range(41)]
    run = Run()
    track = run.follow(line(points, 0.3))
    assert len(track) * DT_S < 2.0 / 0.3 + 2.5
    speeds = [math.dist(a[:2], b[:2]) / DT_S for a, b in pairwise(track)]
    assert max(speeds) < 0.33


def test_a_slow_waypoint_is_passed_slowly() -> None:
    points = [(0.05 * i, 0.0) for i in range(41)]
    waypoints = line(points, 0.4)
    waypoints[20] = Waypoint(*points[20], 0.1)
    run = Run()
    track = run.follow(waypoints)
    at = min(range(len(track)), key=lambda i: abs(track[i].x_m - points[20][0]))
    speed = math.dist(track[at - 5][:2], track[at][:2]) / (5 * DT_S)
    assert speed < 0.16


@pytest.mark.parametrize("heading", [None, 0.0, 3.1, -2.0])
def test_the_robot_stops_where_and_as_it_was_told(heading: float | None) -> None:
    run = Run(model=DriveModel(left_scale=1.03, right_scale=1.0, slip=0.02))
    run.follow([Waypoint(0.4, 0.1, 0.3), Waypoint(0.8, 0.0, 0.0, heading)])
    x, y, at = run.drive.pose
    assert math.dist((x, y), (0.8, 0.0)) < 0.005
    if heading is not None:
        assert abs(math.remainder(at - heading, math.tau)) < math.radians(1.0)


def test_a_target_behind_is_reached_by_turning_first() -> None:
    run = Run()
    track = run.follow([Waypoint(-0.6, 0.0, 0.3)])
    assert run.control.done
    assert rms_error(track, [(0.0, 0.0), (-0.6, 0.0)]) < 0.006


@pytest.mark.parametrize("target", [(0.0, 0.0), (0.006, 0.0), (0.0, 0.012), (-0.015, -0.008)])
def test_a_target_nearly_underfoot_is_reached(target: tuple[float, float]) -> None:
    run = Run()
    run.follow([Waypoint(*target, 0.2, heading_rad=0.5)])
    assert run.control.done
    assert math.dist(run.drive.pose[:2], target) < 0.005


def test_sharp_corners_are_taken_standing() -> None:
    corners = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5), (0.0, 0.0)]
    run = Run()
    track = run.follow(line(corners))
    assert run.control.done
    assert max(distance_to_line(p, corners) for p in track) < 0.012


def test_a_hairpin_is_followed() -> None:
    points = [(0.0, 0.0), (0.6, 0.0), (0.1, 0.03)]
    run = Run()
    track = run.follow(line(points))
    assert run.control.done
    assert max(distance_to_line(p, points) for p in track) < 0.015


def test_turning_the_arena_turns_the_track() -> None:
    """Without noise and slip the track is the same in every frame of reference."""
    model = DriveModel(slip=0.0)
    points = [(0.0, 0.0), (0.3, 0.05), (0.6, 0.0)]
    plain = Run(model=model, noise=0.0).follow(line(points))
    turn, shift = 2.2, (1.5, -0.7)
    c, s = math.cos(turn), math.sin(turn)

    def moved(x: float, y: float) -> tuple[float, float]:
        return shift[0] + c * x - s * y, shift[1] + s * x + c * y

    run = Run(start=(*moved(0.0, 0.0), turn), model=model, noise=0.0)
    track = run.follow(line([moved(x, y) for x, y in points]))
    assert len(track) == pytest.approx(len(plain), abs=3)
    for a, b in zip(plain, track, strict=False):
        assert math.dist(moved(a.x_m, a.y_m), b[:2]) < 0.003


def test_a_dwell_lasts_as_long_as_asked() -> None:
    there = Waypoint(0.2, 0.0, 0.2, dwell_s=1.5, flags=WaypointFlag.STOP)
    at_once = replace(there, dwell_s=0.0)
    still = DriveModel(slip=0.0)
    fast = Run(model=still, noise=0.0).follow([at_once, Waypoint(0.4, 0.0, 0.2)])
    slow = Run(model=still, noise=0.0).follow([there, Waypoint(0.4, 0.0, 0.2)])
    assert (len(slow) - len(fast)) * DT_S == pytest.approx(1.5, abs=0.05)


def cycles_to_settle(travel_um: Sequence[int]) -> int | None:
    """Until the stop underfoot counts as reached while the wheels do this in each cycle."""
    queue, pose = WaypointQueue(), array("i", (0, 0, 0, 0))
    queue.add(bytearray(Mission(1, [Waypoint(0.0, 0.0, 0.3)]).records[0]), 0)
    follower = Follower(Settings(), queue, pose)
    follower.begin()
    follower.dt_us = 10_000
    for cycle, ahead_um in enumerate(travel_um):
        if follower.step(ahead_um):
            return cycle
    return None


def test_a_robot_settles_below_4_mm_s_and_one_late_step_of_its_encoders_is_no_movement() -> None:
    assert cycles_to_settle([0] * 100) == 25
    assert cycles_to_settle([0] * 10 + [250] + [0] * 89) == 25
    assert cycles_to_settle([30] * 100) == 25
    assert cycles_to_settle([45] * 100) is None
    assert cycles_to_settle([-45] * 100) is None


def test_the_robot_waits_where_the_queue_runs_dry_and_goes_on() -> None:
    run = Run()
    mission = Mission(1, line([(0.2, 0.0), (0.4, 0.0), (0.8, 0.0)]))
    run.begin(mission, 2)
    run.idle(5.0)
    assert run.control.state is RobotState.RUN
    assert not run.drive.moving
    assert abs(run.drive.pose.x_m - 0.4) < 0.01
    run.send(Waypoints(1, 2, mission.records[2:]))
    run.idle(4.0)
    assert run.control.done


def test_a_robot_pushed_off_its_path_holds() -> None:
    run = Run()
    run.begin(Mission(1, line([(1.5, 0.0)])), 1)
    run.idle(1.5)
    x, y, heading = run.drive.pose
    run.drive.pose = TruePose(x, y + 0.3, heading)
    run.poses.clear()
    run.idle(2.0)
    assert run.control.reason is StopReason.OFF_PATH
    assert not run.drive.moving


def test_a_robot_against_a_wall_gives_up() -> None:
    run = Run(model=DriveModel(max_wheel_m_s=0.0))
    run.follow([Waypoint(1.0, 0.0, 0.3)])
    assert run.control.reason is StopReason.STUCK
    assert len(run.poses) * DT_S < 4.0


def test_odometry_alone_reaches_the_target_nearly() -> None:
    run = Run(blind=True, model=DriveModel(slip=0.0))
    run.follow([Waypoint(0.5, 0.0, 0.3), Waypoint(0.5, 0.5, 0.0)])
    assert run.control.done
    assert math.dist(run.drive.pose[:2], (0.5, 0.5)) < 0.01


def test_a_robot_moved_by_hand_is_believed_after_a_few_fixes() -> None:
    run = Run()
    run.drive.pose = TruePose(1.0, 1.0, 2.0)
    run.poses.clear()
    run.idle(0.5)
    assert math.dist(run.control.pose[:2], (1.0, 1.0)) < 0.003
    assert counted(run.board.robot, REJECTED) > 0


def test_one_wrong_fix_is_not_believed() -> None:
    run = Run()
    assert not run.see(1.0, 1.0, 0.0, 0.04)
    assert math.hypot(*run.control.pose[:2]) < 0.01


def test_a_fix_older_than_the_memory_is_not_used() -> None:
    run = Run()
    run.idle(1.0)
    assert not run.see(0.0, 0.0, 0.0, 0.4)


def test_a_robot_whose_encoders_count_backwards_holds() -> None:
    """Found on the emulated board: it drove away backwards in its own belief, for ever."""
    run = Run(blind=True)
    control = run.control
    run.begin(Mission(1, line([(0.0, 0.0), (1.5, 0.0)])), 2)
    for _ in range(300):
        run.board.now_s += DT_S
        for _ in range(5):
            run.drive.step(DT_S / 5, run.wheels)
        left, right = run.drive.encoders_m
        flags = LeaseFlag.PERMIT | LeaseFlag.ODOMETRY
        run.send(Lease(0.5, flags, 0.0, clock_us(run.now_s)))
        run.wheels = control.step(run.now_s, -left, -right)
    assert control.reason is StopReason.OFF_PATH
    assert run.drive.pose.x_m < 0.7
