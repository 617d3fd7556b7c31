"""The robot's end, rule by rule."""

from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.robot.clearway.link import DUPLICATES, GAPS
from firmware_protocol.robot.clearway.waypoints import QUEUE_SIZE
from firmware_protocol.wire.messages import (
    ESTOP_FRAME,
    SCHEMA_HASH,
    Clear,
    CommandResult,
    Hello,
    HelloAck,
    Lease,
    LeaseFlag,
    MessageType,
    Pause,
    ResetEstop,
    RobotState,
    Start,
    Status,
    StopReason,
    TimeSync,
    TimeSyncReply,
    Waypoints,
    read_message,
)
from firmware_protocol.wire.mission import mission_seed
from tests.firmware_protocol.robot.board import Board, far
from tests.support.robots.inside import counted, expected_of


def test_a_robot_says_nothing_before_it_is_asked() -> None:
    board = Board()
    board.pass_time(1.0)
    assert board.answers == []
    assert board.control.state is RobotState.BOOT


def test_hello_is_answered_with_who_and_where() -> None:
    board = Board()
    board.hello(3)
    ack = board.answer(HelloAck)
    assert isinstance(ack, HelloAck)
    assert (ack.boot_id, ack.state, ack.mission) == (77, RobotState.IDLE, 0)
    assert ack.prefix_crc == mission_seed(0)


def test_another_schema_is_answered_but_opens_nothing() -> None:
    board = Board()
    board.session = 3
    board.send(Hello(1))
    assert isinstance(board.answer(HelloAck), HelloAck)
    assert board.control.state is RobotState.BOOT
    assert board.robot.session is None


def test_frames_of_another_session_are_counted_and_void() -> None:
    board = Board()
    board.hello(3)
    board.send(Clear(1, 4), session=2)
    assert board.control.mission == 0
    assert board.status().counters.session_errors == 1


def test_a_late_hello_does_not_bring_an_old_session_back() -> None:
    board = Board()
    board.hello(3)
    board.hello(4)
    board.send(Hello(SCHEMA_HASH), session=3)
    assert board.robot.session == 4


def test_a_repeated_hello_changes_nothing() -> None:
    board = Board()
    board.run(far())
    board.send(Hello(SCHEMA_HASH))
    assert board.control.state is RobotState.RUN


def test_a_gap_is_complained_about_and_the_frame_not_taken() -> None:
    board = Board()
    board.hello(3)
    board.pass_time(0.02)
    board.send(Clear(1, 4), sequence=1)
    frames = board.parser.feed(board.robot.next_frame(board.now_s))
    assert [(f.kind, f.nak, f.acknowledged) for f in frames] == [(MessageType.ACK, True, 0)]
    assert board.control.mission == 0


@given(st.integers(0, 255), st.integers(1, 127))
def test_what_was_taken_is_a_duplicate_and_what_is_ahead_a_gap(start: int, step: int) -> None:
    board = Board()
    board.hello(3)
    board.robot.link.frames.expected = start
    board.send(Clear(1, 4), sequence=(start - step) % 256)
    board.send(Clear(1, 4), sequence=(start + step) % 256)
    assert [counted(board.robot, counter) for counter in (DUPLICATES, GAPS)] == [1, 1]
    assert board.control.mission == 0
    board.send(Clear(1, 4), sequence=start)
    assert board.control.mission == 4
    assert expected_of(board.robot) == (start + 1) % 256


def test_complaints_come_no_more_often_than_every_3_ms() -> None:
    board = Board()
    board.hello(3)
    board.pass_time(0.02)
    naks = 0
    for _ in range(100):
        board.robot.receive_bytes(b"\x09\x09\x00", board.now_s)
        frame = board.robot.next_frame(board.now_s)
        naks += any(f.nak for f in board.parser.feed(frame))
        board.now_s += 0.0005
    assert naks <= 18


def test_a_doubled_frame_is_acknowledged_and_not_taken_again() -> None:
    board, mission = Board(), far(3)
    board.hello(3)
    board.send(Clear(1, mission.id))
    for _ in range(3):
        board.send(Waypoints(mission.id, 0, mission.records), sequence=1)
    assert board.control.accept_next == 3
    status = board.status()
    assert status.counters.duplicates == 2
    assert status.prefix_crc == mission.prefix_crc(3)


def test_waypoints_are_taken_once_by_index_whatever_the_sequence_says() -> None:
    board, mission = Board(), far(6)
    board.hello(3)
    board.send(Clear(1, mission.id))
    for first in (0, 0, 2, 4, 1):
        board.send(Waypoints(mission.id, first, mission.records[first : first + 2]))
    assert board.control.accept_next == 6
    assert board.control.prefix_crc == mission.prefix_crc(6)


def test_a_later_index_and_another_mission_are_not_taken() -> None:
    board, mission = Board(), far(6)
    board.hello(3)
    board.send(Clear(1, mission.id))
    board.send(Waypoints(mission.id, 3, mission.records[3:]))
    board.send(Waypoints(mission.id + 1, 0, mission.records))
    assert board.control.accept_next == 0


def test_a_full_queue_refuses_and_takes_later() -> None:
    board, mission = Board(), far(40)
    board.hello(3)
    board.send(Clear(1, mission.id))
    for first in range(0, 36, 6):
        board.send(Waypoints(mission.id, first, mission.records[first : first + 6]))
    assert board.control.accept_next == QUEUE_SIZE
    assert board.control.credit == 0
    # the sixth frame did not fit: it is not acknowledged and may come again
    assert expected_of(board.robot) == 6


def test_start_says_what_is_missing() -> None:
    board, mission = Board(), far()
    board.hello(3)
    board.send(Clear(1, mission.id))
    board.send(Waypoints(mission.id, 0, mission.records))

    def start(number: int, mission_id: int, index: int) -> CommandResult:
        board.send(Start(number, mission_id, index))
        return board.status().result

    assert start(2, mission.id, 0) is CommandResult.NO_LEASE
    board.lease(LeaseFlag.NONE)
    assert start(3, mission.id, 0) is CommandResult.NO_LEASE
    board.lease(LeaseFlag.PERMIT)
    assert start(4, mission.id, 0) is CommandResult.NO_POSE
    board.lease()
    assert start(5, mission.id + 1, 0) is CommandResult.WRONG_MISSION
    assert start(6, mission.id, 1) is CommandResult.WRONG_INDEX
    assert start(7, mission.id, 0) is CommandResult.DONE
    assert board.control.state is RobotState.RUN


def test_the_dead_man_strikes_within_10_ms_of_its_limit() -> None:
    board = Board()
    board.run(far())
    began_s = board.now_s
    while board.control.state is RobotState.RUN:
        board.pass_time(0.01)
    assert 0.5 - 1e-9 <= board.now_s - began_s <= 0.51 + 1e-9
    assert board.control.reason is StopReason.LEASE_LAPSED
    assert board.control.accept_next > board.control.exec_next, "the queue is kept"


def test_a_stop_is_told_at_once_and_other_news_in_their_turn() -> None:
    def states(now_s: float) -> list[RobotState]:
        said = []
        while frame := board.robot.next_frame(now_s):
            told = [read_message(f) for f in board.parser.feed(frame)]
            said += [m.state for m in told if isinstance(m, Status)]
        return said

    board = Board()
    board.run(far())
    assert states(board.now_s) == [RobotState.RUN]
    board.send(Start(3, 9, 0))
    assert states(board.now_s + 0.002) == [], "a command's result waits for 10 ms"
    board.send(Pause(4))
    assert states(board.now_s + 0.003) == [RobotState.HOLD], "a stop does not"
    assert states(board.now_s + 0.004) == [], "and is told once"


def test_session_zero_is_none() -> None:
    board = Board()
    board.send(Hello(SCHEMA_HASH), session=0)
    assert board.robot.session is None
    assert board.robot.session_errors == 1


def test_no_lease_is_longer_than_half_a_second() -> None:
    board = Board()
    board.run(far())
    board.send(Lease(60.0, LeaseFlag.PERMIT | LeaseFlag.ODOMETRY, 0.0, board.clock_us))
    board.pass_time(0.55)
    assert board.control.reason is StopReason.LEASE_LAPSED


def test_a_lease_after_the_lapse_does_not_resume() -> None:
    board = Board()
    board.run(far())
    board.pass_time(0.6)
    for _ in range(20):
        board.lease()
        board.pass_time(0.1)
    assert board.control.state is RobotState.HOLD
    assert board.last == (0.0, 0.0, True)


def test_the_robot_disarms_after_two_silent_seconds() -> None:
    board = Board()
    board.run(far())
    board.pass_time(1.9)
    assert board.control.state is RobotState.HOLD
    board.pass_time(0.2)
    assert board.control.state is RobotState.IDLE
    assert board.control.reason is StopReason.DISARMED
    assert not board.last.powered


def test_emergency_stop_is_immediate_and_latched() -> None:
    board = Board()
    board.run(far())
    board.pass_time(0.3)
    assert board.last.left_m_s > 0.0
    board.robot.receive_bytes(ESTOP_FRAME, board.now_s)
    board.pass_time(0.01)
    assert board.last == (0.0, 0.0, False)
    board.lease()
    board.send(Start(3, 9, board.control.exec_next))
    board.send(Clear(4, 10))
    assert board.status().result is CommandResult.WRONG_STATE
    assert board.control.state is RobotState.ESTOP


def test_emergency_stop_is_left_in_a_fresh_session_only() -> None:
    board = Board()
    board.run(far())
    board.robot.receive_bytes(ESTOP_FRAME, board.now_s)
    board.send(ResetEstop(3))
    assert board.status().result is CommandResult.SAME_SESSION
    board.hello(6)
    assert board.control.state is RobotState.ESTOP
    board.send(ResetEstop(1))
    assert board.control.state is RobotState.IDLE
    assert board.control.mission == 0


def test_clear_while_driving_slows_down_and_forgets() -> None:
    board = Board()
    board.run(far())
    board.pass_time(0.4)
    before = board.last.left_m_s
    board.send(Clear(3, 10))
    board.pass_time(0.01)
    assert board.control.state is RobotState.IDLE
    assert 0.0 < board.last.left_m_s < before
    assert (board.control.mission, board.control.accept_next, board.control.credit) == (10, 0, 32)


def test_the_robots_clock_answers_in_microseconds() -> None:
    board = Board()
    board.hello(3)
    board.send(TimeSync(4_000_000_000))
    reply = board.answer(TimeSyncReply)
    assert isinstance(reply, TimeSyncReply)
    assert reply.host_sent_us == 4_000_000_000
    assert 0 <= reply.robot_sent_us - reply.robot_received_us <= 20_000
