"""Sessions that need an answer now, and times that age on the line: single rules, one by one.

Whole drives over a line that strays and delays are in ``tests/support/wire/hostile_scenarios.py``.
"""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.host.events import LinkChanged, StrayHello
from firmware_protocol.host.freshest import ERROR_MAX_S, Freshest
from firmware_protocol.host.line.clock_sync import WRAP_US, ClockEstimate
from firmware_protocol.host.state import LinkState
from firmware_protocol.robot.clearway.link import REJECTED
from firmware_protocol.robot.clearway.robot import NO_POSE_MS
from firmware_protocol.wire.framing import Sender, WireFrame, encode_frame
from firmware_protocol.wire.messages import (
    ESTOP_FRAME,
    SCHEMA_HASH,
    Clear,
    CommandResult,
    Confirm,
    Hello,
    Lease,
    LeaseFlag,
    MessageType,
    PoseFix,
    ResetEstop,
    RobotState,
    StatusFlag,
    StopReason,
    Waypoints,
)
from navigation.link.link_snapshot import snapshot_of
from tests.firmware_protocol.host.table import Table, line
from tests.firmware_protocol.robot.board import Board, far
from tests.support.robots.inside import counted, nonce_of

DRIVE = LeaseFlag.PERMIT | LeaseFlag.ODOMETRY


def say(table: Table, session: int) -> None:
    """Somebody's HELLO, to the robot."""
    frame = WireFrame(MessageType.HELLO, session, Hello(SCHEMA_HASH).pack())
    table.robot.receive_bytes(encode_frame(frame, Sender.HOST), table.now_s)


def test_a_hello_opens_nothing_until_its_challenge_is_given_back() -> None:
    board = Board()
    board.run(far())
    board.send(Hello(SCHEMA_HASH), session=6)
    assert (board.robot.session, board.control.state) == (5, RobotState.RUN)
    board.send(Confirm(nonce_of(board.robot) ^ 1), session=6)
    board.send(Confirm(nonce_of(board.robot)), session=7)
    assert (board.robot.session, board.control.state) == (5, RobotState.RUN)
    assert board.robot.session_errors == 2
    board.send(Confirm(nonce_of(board.robot)), session=6)
    assert (board.robot.session, board.control.state) == (6, RobotState.HOLD)


def test_the_same_session_asked_for_again_has_another_challenge() -> None:
    board, nonces = Board(), set()
    for _ in range(50):
        board.hello(3)
        board.hello(4)
        nonces.add(nonce_of(board.robot))
        board.pass_time(0.01)
    assert len(nonces) == 50


def test_the_boot_id_alone_opens_no_session() -> None:
    """It is told in every HELLO_ACK, and the first challenge is made from it."""
    board = Board()
    board.send(Confirm(77), session=0)
    board.send(Confirm(77), session=3)
    assert board.robot.session is None


def test_a_lease_runs_from_when_it_was_given() -> None:
    board = Board()
    board.run(far())
    given_us = board.clock_us
    board.pass_time(0.4)
    board.send(Lease(0.5, DRIVE, 0.0, given_us))
    assert board.control.robot.lease_left_ms() == pytest.approx(100, abs=2)
    board.pass_time(0.11)
    assert board.control.reason is StopReason.LEASE_LAPSED


@pytest.mark.parametrize("age_s", [0.5, 0.6, 2.0, 2148.0, 4200.0, -0.021, -1.0])
def test_a_lease_of_another_time_is_refused_and_counted(age_s: float) -> None:
    board = Board()
    board.hello(3)
    board.send(Lease(0.5, DRIVE, 0.0, round(board.clock_us - age_s * 1e6) % WRAP_US))
    assert board.control.robot.lease_left_ms() == 0
    assert counted(board.robot, REJECTED) == 1


def test_a_permit_that_comes_after_its_withdrawal_is_refused() -> None:
    board = Board()
    board.run(far())
    board.pass_time(0.05)
    board.send(Lease(0.5, LeaseFlag.NONE, 0.0, board.clock_us))
    board.send(Lease(0.5, DRIVE, 0.0, board.clock_us - 30_000))
    assert board.control.reason is StopReason.NO_PERMIT
    assert not board.status().flags & StatusFlag.PERMIT


@pytest.mark.parametrize("age_s", [0.5, 2.0, 2148.0, -0.03])
def test_a_pose_of_another_time_is_refused_and_counted(age_s: float) -> None:
    board = Board()
    board.hello(3)
    board.pass_time(0.5)
    board.send(PoseFix(1.0, 0.0, 0.0, round(board.clock_us - age_s * 1e6) % WRAP_US))
    assert board.control.robot.pose_age_ms() == NO_POSE_MS
    assert counted(board.robot, REJECTED) == 1


def test_a_pose_just_ahead_of_the_clock_is_of_now() -> None:
    board = Board()
    board.hello(3)
    board.send(PoseFix(1.0, 0.0, 0.0, board.clock_us + 15_000))
    assert board.control.robot.pose_age_ms() == 0


def test_an_emergency_stop_pressed_during_the_re_arm_needs_a_session_of_its_own() -> None:
    board = Board()
    board.run(far())
    board.robot.receive_bytes(ESTOP_FRAME, board.now_s)
    board.hello(6)
    board.control.emergency_stop(StopReason.ESTOP_LOCAL)
    board.send(ResetEstop(1))
    assert board.status().result is CommandResult.SAME_SESSION
    assert board.control.state is RobotState.ESTOP


# The clock.


@given(
    there=st.lists(st.floats(0.0, 0.3), min_size=1, max_size=40),
    back=st.floats(0.0, 0.3),
    offset_s=st.floats(-5000.0, 5000.0),
    drift=st.floats(-5e-4, 5e-4),
)
def test_the_clock_is_never_more_wrong_than_it_says(
    there: list[float], back: float, offset_s: float, drift: float
) -> None:
    clock, now_s = ClockEstimate(), 100.0
    for number, delay_s in enumerate(there):
        sent_s, now_s = now_s, now_s + delay_s + back
        at_s = sent_s + delay_s
        us = round((at_s + offset_s + drift * at_s) * 1e6) % WRAP_US
        clock.add(sent_s, us, us, now_s)
        wrong_s = (clock.robot_us(now_s) / 1e6 - now_s - offset_s - drift * now_s) % (WRAP_US / 1e6)
        wrong_s = min(wrong_s, WRAP_US / 1e6 - wrong_s)
        assert wrong_s <= clock.error_s(now_s) + 2e-6, number
        assert clock.jumps == 0
        now_s += 1.0


def exchange(clock: ClockEstimate, now_s: float, offset_s: float) -> None:
    us = round((now_s + 0.002 + offset_s) * 1e6) % WRAP_US
    clock.add(now_s, us, us, now_s + 0.004)


def test_a_clock_that_jumps_is_found_and_what_was_known_forgotten() -> None:
    clock = ClockEstimate()
    for second in range(10):
        exchange(clock, float(second), 7.0)
    assert not clock.is_in_doubt(round((10.0 + 7.0 - 0.01) * 1e6), 10.0)
    assert clock.is_in_doubt(round((10.0 + 6.9 - 0.01) * 1e6), 10.0)
    assert clock.is_in_doubt(round((10.0 + 7.1) * 1e6), 10.0)
    exchange(clock, 10.0, 6.9)
    assert clock.jumps == 1
    assert clock.offset_s(10.0) == pytest.approx(6.9, abs=1e-4)


@pytest.mark.parametrize("trip_s", [0.0, 0.0002, 0.003, 0.0041])
def test_a_line_faster_than_its_rate_says_still_tells_the_clock(trip_s: float) -> None:
    """A USB port's rate is a number that nobody keeps: bytes come before they could."""
    clock = ClockEstimate()
    for second in range(10):
        us = round((second + trip_s / 2.0 + 7.0) * 1e6)
        clock.add(float(second), us, us, second + trip_s, wire_s=(0.0016, 0.0023))
        assert clock.ready
        wrong_s = abs(clock.offset_s(second + 1.0) - 7.0)
        assert wrong_s <= clock.error_s(second + 1.0) + 2e-6 <= 0.006
        assert wrong_s <= 0.0005
    assert clock.jumps == 0


def test_an_answer_before_its_question_is_left_out() -> None:
    clock = ClockEstimate()
    clock.add(1.0, 7_000_000, 7_010_000, 1.004, wire_s=(0.0016, 0.0023))
    assert not clock.ready


def test_a_host_that_slept_for_an_hour_knows_the_clock_again() -> None:
    clock = ClockEstimate()
    for second in [*range(5), 3600, 3601, 9000, 9001]:
        exchange(clock, float(second), 4290.0)
        assert clock.offset_s(float(second)) % (WRAP_US / 1e6) == pytest.approx(4290.0, abs=1e-3)


def test_when_a_status_was_taken_is_known_in_host_seconds() -> None:
    clock = ClockEstimate()
    exchange(clock, 50.0, WRAP_US / 1e6 - 50.1)
    for age_s in (0.0, 0.05, 0.3):
        taken_us = round((50.2 - age_s + WRAP_US / 1e6 - 50.1) * 1e6) % WRAP_US
        assert clock.host_s(taken_us, 50.2) == pytest.approx(50.2 - age_s, abs=1e-4)


def test_nothing_that_moves_is_sent_before_the_clock_is_known_well() -> None:
    clock, fresh = ClockEstimate(), Freshest()
    lease = Lease(0.5, DRIVE, 0.02)
    fresh.give_lease(lease, 10.0)
    assert fresh.take(10.0, clock) is None
    us = round(14.0e6)
    clock.add(9.0, us, us, 9.0 + 2.5 * ERROR_MAX_S)
    assert fresh.take(10.0, clock) is None
    clock.add(10.0, us + 1_000_000, us + 1_000_000, 10.004)
    sent = fresh.take(10.1, clock)
    assert isinstance(sent, Lease)
    error_s = clock.error_s(10.1)
    assert sent.issued_us == clock.robot_us(10.0 - error_s)
    fresh.give_lease(lease, 10.0)
    assert fresh.take(10.5, clock) is None, "it has run out"
    assert fresh.stale == 1


# The host.


def test_a_stray_hello_is_told_and_changes_nothing() -> None:
    table = Table()
    table.run(0.2)
    table.host.upload(line(), table.now_s)
    table.run(0.5)
    session = table.robot.session
    for stray in range(100, 110):
        say(table, stray)
        table.run(0.05)
    assert table.robot.session == session
    assert table.control.state is RobotState.RUN
    assert table.host.counters.stray_hellos == 10
    assert 1 <= sum(isinstance(event, StrayHello) for event in table.events) <= 2
    assert table.host.counters.links_lost == 0


def test_a_robot_of_another_schema_is_named_and_asked_again() -> None:
    table = Table()
    table.boot(1, schema=0x1234)
    table.run(1.0)
    assert table.host.state is LinkState.REFUSED
    shown = snapshot_of(table.host, table.now_s, port_fault="closed", estop_waits=False)
    assert "0x00001234" in str(shown.down_reason)
    assert f"{SCHEMA_HASH:#010x}" in str(shown.down_reason)
    assert "update the robot's firmware or this program" in str(shown.down_reason)
    table.run(20.0)
    assert table.host.state is LinkState.REFUSED, "it is asked again, and still refused"
    refusals = [e for e in table.events if isinstance(e, LinkChanged)]
    assert len(refusals) == 2, "and told once"
    table.boot(2)
    table.run(3.5)
    assert table.host.state.is_up


def test_a_refused_robot_that_has_gone_is_no_longer_the_reason() -> None:
    table = Table()
    table.boot(1, schema=0x1234)
    table.run(1.0)
    table.cable = False
    table.run(12.0)
    assert table.host.state is LinkState.HELLO
    assert "no byte" in str(table.host.why_down(table.now_s))


def test_old_and_new_emergency_stops_are_told_apart() -> None:
    table = Table()
    table.run(0.2)
    table.host.estop()
    table.run(0.2)
    assert table.host.status.state is RobotState.ESTOP
    assert not table.host.leaving_estop
    table.host.reset_estop(table.now_s)
    assert table.host.leaving_estop
    while table.host.leaving_estop:
        table.tick()
    assert table.host.status.state is not RobotState.ESTOP
    table.control.emergency_stop(StopReason.ESTOP_LOCAL)
    table.run(0.03)
    assert table.host.status.state is RobotState.ESTOP
    assert not table.host.leaving_estop


def test_a_status_has_a_time_and_its_bound() -> None:
    table = Table()
    table.run(1.0)
    shown = snapshot_of(table.host, table.now_s, port_fault="", estop_waits=False)
    assert shown.status_taken_s == pytest.approx(table.host.status_s, abs=0.006)
    assert shown.clock_error_s is not None
    assert shown.clock_error_s < ERROR_MAX_S


def test_frames_of_a_recording_are_void_although_their_session_is_asked_for() -> None:
    board, mission = Board(), far()
    board.hello(3)
    board.send(Hello(SCHEMA_HASH), session=8)
    board.send(Clear(1, 9), session=8)
    board.send(Waypoints(9, 0, mission.records), session=8)
    board.send(Lease(0.5, DRIVE, 0.0, board.clock_us), session=8)
    assert (board.control.mission, board.control.accept_next) == (0, 0)
    assert board.control.robot.lease_left_ms() == 0
