import math
import os
import select
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.robot.controller import WheelSpeeds
from navigation.link.serial_link import SerialLink
from navigation.link.serial_port import PortError
from navigation.simulator.drive_model import Drive, DriveModel, TruePose
from navigation.simulator.line_faults import FaultSpec, FaultSpecError, FaultyLine
from navigation.simulator.robot import SimulatedRobot
from navigation.simulator.virtual_loop import PacedLine
from tests.support.waiting import wait_until


def drive(model: DriveModel) -> Drive:
    return Drive(model, TruePose(0.0, 0.0, 0.0), np.random.default_rng(1))


def push(body: Drive, left: float, right: float, seconds: float) -> None:
    for _ in range(round(seconds / 0.002)):
        body.step(0.002, WheelSpeeds(left, right, True))


def test_equal_wheels_drive_straight() -> None:
    body = drive(DriveModel(slip=0.0))
    push(body, 0.2, 0.2, 5.0)
    x, y, heading = body.pose
    assert x == pytest.approx(0.2 * (5.0 - body.model.lag_s), abs=0.002)
    assert (y, heading) == (0.0, 0.0)


def test_opposite_wheels_turn_on_the_spot() -> None:
    body = drive(DriveModel(slip=0.0, track_m=0.1))
    push(body, -0.05, 0.05, 1.05)
    assert math.hypot(*body.pose[:2]) < 1e-9
    assert body.pose.heading_rad == pytest.approx(1.0, abs=0.01)


def test_a_larger_wheel_bends_the_way_as_geometry_says() -> None:
    body = drive(DriveModel(slip=0.0, right_scale=1.03))
    push(body, 0.2, 0.2, 1.05)
    assert body.pose.heading_rad == pytest.approx(0.2 * 0.03 / 0.12, rel=0.02)


def test_encoders_count_whole_ticks_of_the_nominal_wheel() -> None:
    body = drive(DriveModel(left_scale=1.1, ticks_per_m=1000.0))
    push(body, 0.2, 0.2, 1.0)
    left, right = body.encoders_m
    assert left == right
    assert (left * 1000.0) % 1.0 == pytest.approx(0.0, abs=1e-6)


def test_a_wheel_in_its_dead_zone_stands_and_one_at_rest_has_to_break_loose() -> None:
    model = DriveModel(dead_zone_m_s=0.01, stiction=0.5, slip=0.0)
    for order, driven in ((0.0099, 0.0), (0.0149, 0.0), (0.0151, 0.0151), (-0.0151, -0.0151)):
        body = drive(model)
        push(body, order, order, 2.05)
        assert body.pose.x_m == pytest.approx(2.0 * driven, abs=1e-4)
    push(body, -0.0101, -0.0101, 1.0)  # it turns already
    assert body.moving
    push(body, -0.0099, -0.0099, 1.0)
    assert not body.moving


def test_orders_in_steps_are_rounded_towards_zero() -> None:
    model = DriveModel(dead_zone_m_s=0.0, step_m_s=0.1)
    driven = [model.driven(order, at_rest=False) for order in (0.3, 0.29, -0.29, 0.09)]
    assert driven == pytest.approx([0.3, 0.2, -0.2, 0.0])


def test_motors_without_power_come_to_rest() -> None:
    body = drive(DriveModel())
    push(body, 0.3, 0.3, 1.0)
    assert body.moving
    for _ in range(400):
        body.step(0.002, WheelSpeeds(0.3, 0.3, powered=False))
    assert not body.moving


def test_steps_of_changing_length_move_a_robot_as_far_as_equal_ones() -> None:
    equal, mixed = drive(DriveModel(slip=0.0)), drive(DriveModel(slip=0.0))
    for _ in range(200):
        for body, steps_s in ((equal, (0.004, 0.004)), (mixed, (0.002, 0.006))):
            for step_s in steps_s:
                body.step(step_s, WheelSpeeds(0.2, 0.25, True))
    assert mixed.pose == pytest.approx(equal.pose, abs=0.002)
    assert equal.pose.x_m > 0.2


def test_a_robot_that_is_put_down_stays_there_until_its_wheels_turn() -> None:
    body = drive(DriveModel())
    body.put_down(TruePose(1.0, 2.0, 1.5 * math.pi))
    assert body.pose == pytest.approx((1.0, 2.0, -0.5 * math.pi))
    there = body.pose
    push(body, 0.0, 0.0, 0.1)
    assert body.pose == there
    push(body, 0.2, 0.2, 1.0)
    assert body.pose.y_m < 1.9


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("drop=2", "probability"),
        ("drop=x", "not a number"),
        ("drop=nan", "probability"),
        ("drop", "NAME=VALUE"),
        ("fire=1", "unknown"),
        ("stall=1", "SECONDS@SECONDS"),
        ("stall=0@1", "> 0"),
        ("reset=-1", "> 0"),
        ("drop=0.1,drop=0.2", "twice"),
    ],
)
def test_a_wrong_fault_specification_is_one_clear_sentence(text: str, what: str) -> None:
    with pytest.raises(FaultSpecError, match=what):
        FaultSpec.parse(text)


def test_a_fault_specification_is_read() -> None:
    spec = FaultSpec.parse(" drop=0.001, stall=0.1@5,,freeze=0.2@3,reset=7 ")
    assert (spec.drop, spec.stall_s, spec.stall_every_s) == (0.001, 0.1, 5.0)
    assert (spec.freeze_s, spec.freeze_at_s, spec.reset_at_s) == (0.2, 3.0, 7.0)
    assert FaultSpec.parse("") == FaultSpec()


@given(st.lists(st.binary(max_size=40), max_size=10))
def test_a_good_line_changes_nothing(parts: list[bytes]) -> None:
    line = FaultyLine(FaultSpec(), np.random.default_rng(0))
    assert b"".join(line.carry(part, 0.0) for part in parts) == b"".join(parts)


def test_a_bad_line_damages_as_often_as_asked() -> None:
    data = bytes(200_000)
    rng = np.random.default_rng(0)
    assert len(FaultyLine(FaultSpec(drop=0.01), rng).carry(data, 0.0)) == pytest.approx(
        198_000, abs=300
    )
    flipped = FaultyLine(FaultSpec(flip=0.01), rng).carry(data, 0.0)
    assert sum(map(bool, flipped)) == pytest.approx(2000, abs=300)
    assert all(value.bit_count() <= 1 for value in flipped)
    assert len(FaultyLine(FaultSpec(noise=0.01), rng).carry(data, 0.0)) > 201_500


def test_frames_are_doubled_and_swapped_whole() -> None:
    rng = np.random.default_rng(0)
    line = FaultyLine(FaultSpec(dup=1.0), rng)
    assert line.carry(b"\0ab\0\0c", 0.0) + line.carry(b"d\0", 0.0) == b"\0ab\0" * 2 + b"\0cd\0" * 2
    line = FaultyLine(FaultSpec(swap=1.0), rng)
    assert line.carry(b"\0ab\0\0cd\0", 0.0) == b"\0cd\0\0ab\0"


def test_a_stall_delivers_everything_afterwards() -> None:
    line = FaultyLine(FaultSpec.parse("stall=1@10"), np.random.default_rng(0))
    assert line.carry(b"a", 0.5) == b""
    assert line.carry(b"b", 0.9) == b""
    assert line.held
    assert line.carry(b"", 1.1) == b"ab"
    assert not line.held


def test_a_paced_line_takes_ten_bits_a_byte() -> None:
    line = PacedLine(115_200)
    line.put(bytes(1152), 0.0)
    assert len(line.take(0.05)) == pytest.approx(576, abs=8)
    assert not line.free(0.0999)
    assert len(line.take(0.1)) + 576 == pytest.approx(1152, abs=8)
    assert line.free(0.1)


def test_a_paced_line_says_when_its_next_bytes_arrive() -> None:
    line = PacedLine(10_000)
    assert line.arrives_s == math.inf
    line.put(bytes(12), 1.0)
    for arrives_s in (1.008, 1.012):
        assert line.arrives_s == pytest.approx(arrives_s)
        assert line.take(line.arrives_s - 1e-6) == b""
        assert line.take(line.arrives_s) != b""
    assert line.arrives_s == math.inf


def test_a_late_look_at_a_robot_sees_it_where_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    now_s = [1000.0]
    robot = SimulatedRobot(rng=np.random.default_rng(1), clock=lambda: now_s[0])
    forward = lambda *_: WheelSpeeds(0.2, 0.2, powered=True)  # noqa: E731
    monkeypatch.setattr(robot.twin, "step", forward)
    at_s = {}
    try:
        robot.switched_on()
        for _ in range(500):
            now_s[0] += 0.002
            robot.turn()
            at_s[now_s[0]] = robot.pose()
        for time_s in (1000.8, 1000.9, now_s[0]):
            near_s = min(at_s, key=lambda one: abs(one - time_s))
            assert robot.pose_at(near_s) == at_s[near_s]
        assert robot.pose_at(1000.9).x_m == pytest.approx(robot.pose().x_m - 0.02, abs=0.002)
        assert robot.pose_at(1000.1) == at_s[min(at_s, key=lambda one: abs(one - 1000.502))]
    finally:
        robot.stop()


def test_a_robot_sits_on_an_existing_port() -> None:
    """The other way round: the host makes the line, the robot opens it."""
    a, b = os.openpty()
    try:
        with pytest.raises(PortError):
            SimulatedRobot(rng=np.random.default_rng(0), port="/dev/tty_that_is_not_there")
        with SimulatedRobot(rng=np.random.default_rng(0), port=os.ttyname(b)) as robot:
            assert robot.port == os.ttyname(b)
    finally:
        os.close(a)
        os.close(b)


def test_a_robot_that_resets_is_noticed() -> None:
    faults = FaultSpec.parse("reset=0.5")
    with (
        SimulatedRobot(rng=np.random.default_rng(0), faults=faults) as robot,
        SerialLink(robot.port) as link,
    ):
        assert wait_until(lambda: link.snapshot().sent.reboots > 0)
        assert link.snapshot().sent.reboots == 1


def robot_command(*options: str) -> subprocess.Popen[bytes]:
    # a runner under nohup, or in the background, ignores these, and so would what it starts
    heeded = "import signal; [signal.signal(n, signal.SIG_DFL) for n in (1, 2, 15)]; "
    heeded += "signal.signal(2, signal.default_int_handler); "
    program = heeded + "from navigation.cli.main import main; main()"
    return subprocess.Popen(
        [sys.executable, "-uc", program, "robot", *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        bufsize=0,  # or a line may wait in a buffer, where select does not see it
    )


def next_line(process: subprocess.Popen[bytes]) -> str:
    assert process.stdout is not None
    if not select.select([process.stdout], [], [], 30.0)[0]:
        pytest.fail("the command says nothing")
    return process.stdout.readline().decode().strip()


def test_the_command_prints_the_port_and_ends_with_ctrl_c() -> None:
    process = robot_command("--start=0.5,0.25,90")
    try:
        port = next_line(process)
        assert "BOOT: it has just booted" in next_line(process)
        with SerialLink(port) as link:
            assert wait_until(lambda: link.snapshot().down_reason is None)
            assert "IDLE" in next_line(process)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=10)
        assert process.returncode == 130
    finally:
        process.kill()
        process.communicate()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_the_command_takes_its_link_away(number: signal.Signals, tmp_path: Path) -> None:
    link = tmp_path / "new" / "robot"
    process = robot_command("--link", str(link))
    try:
        port = next_line(process)
        assert wait_until(link.is_symlink)
        assert str(link.readlink()) == port
        next_line(process)
        process.send_signal(number)
        _, errors = process.communicate(timeout=30)
        assert not link.is_symlink()
        assert (process.returncode, errors) == (128 + number, b"")
    finally:
        process.kill()
        process.communicate()


def test_the_command_leaves_a_link_that_another_robot_has_taken(tmp_path: Path) -> None:
    link = tmp_path / "robot"
    process = robot_command("--link", str(link))
    try:
        next_line(process)
        next_line(process)  # the link is there before the robot's state is told
        link.unlink()
        link.symlink_to("/dev/pts/another")
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=30)
        assert str(link.readlink()) == "/dev/pts/another"
    finally:
        process.kill()
        process.communicate()
