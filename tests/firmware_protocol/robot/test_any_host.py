"""The robot's end as a state machine, driven by hypothesis with anything a host might do."""

import math

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from firmware_protocol.robot.clearway.waypoints import QUEUE_SIZE
from firmware_protocol.wire.messages import (
    ESTOP_FRAME,
    Ack,
    Challenge,
    Clear,
    HelloAck,
    LeaseFlag,
    Pause,
    PoseFix,
    ResetEstop,
    RobotState,
    Start,
    Status,
    TimeSyncReply,
    Waypoint,
    Waypoints,
)
from firmware_protocol.wire.mission import Mission
from tests.firmware_protocol.robot.board import Board
from tests.support.robots.inside import expected_of


class AnyHost(RuleBasedStateMachine):
    """Whatever a host sends, in whatever order: the promises of the protocol hold."""

    @initialize()
    def boot(self) -> None:
        self.board = Board()
        self.mission = Mission(9, [Waypoint(0.02 * i, 0.0, 0.3) for i in range(60)])
        self.started = False
        self.was = RobotState.BOOT
        self.commands = 0

    def command(self) -> int:
        self.commands = self.commands % 0xFFFF + 1
        return self.commands

    @rule(session=st.integers(1, 9))
    def hello(self, session: int) -> None:
        self.board.hello(session)

    @rule(mission=st.sampled_from([0, 9, 9, 10]))
    def clear(self, mission: int) -> None:
        self.board.send(Clear(self.command(), mission))

    @rule(first=st.integers(0, 59), count=st.integers(1, 6))
    def waypoints(self, first: int, count: int) -> None:
        records = self.mission.records[first : first + count]
        self.board.send(Waypoints(9, first, records))

    @rule(count=st.integers(1, 6))
    def next_waypoints(self, count: int) -> None:
        self.waypoints(min(self.board.control.accept_next, 59), count)

    @rule()
    def start(self) -> None:
        self.started = True
        self.board.send(Start(self.command(), 9, self.board.control.exec_next))

    @rule()
    def pause(self) -> None:
        self.board.send(Pause(self.command()))

    @rule(permit=st.booleans())
    def lease(self, permit: bool) -> None:
        self.board.lease(LeaseFlag.PERMIT | LeaseFlag.ODOMETRY if permit else LeaseFlag.NONE)

    @rule(x=st.floats(-1.0, 1.0), age=st.floats(0.0, 0.5))
    def pose(self, x: float, age: float) -> None:
        self.board.send(PoseFix(x, 0.0, 0.0, self.board.clock_us - round(age * 1e6)))

    @rule()
    def estop(self) -> None:
        self.board.robot.receive_bytes(ESTOP_FRAME, self.board.now_s)
        assert self.board.control.state is RobotState.ESTOP

    @rule()
    def reset_estop(self) -> None:
        self.board.send(ResetEstop(self.command()))

    @rule(noise=st.binary(max_size=200))
    def noise(self, noise: bytes) -> None:
        self.board.robot.receive_bytes(noise, self.board.now_s)

    @rule(sequence=st.integers(0, 255))
    def wrong_sequence(self, sequence: int) -> None:
        expected = expected_of(self.board.robot)
        if sequence != expected:
            self.board.send(Clear(1, 11), sequence=sequence)
            assert self.board.control.mission != 11

    @rule(seconds=st.floats(0.01, 1.0))
    def wait(self, seconds: float) -> None:
        self.board.pass_time(seconds)

    @invariant()
    def holds(self) -> None:
        control = self.board.control
        state, was = control.state, self.was
        self.was = state
        assert not (state is RobotState.RUN and was is not RobotState.RUN and not self.started)
        self.started = False
        assert control.exec_next <= control.accept_next <= control.exec_next + QUEUE_SIZE
        assert control.credit == QUEUE_SIZE - (control.accept_next - control.exec_next)
        if control.mission == 9:
            assert control.prefix_crc == self.mission.prefix_crc(control.accept_next)
            assert control.exec_crc == self.mission.prefix_crc(control.exec_next)
        if state is RobotState.ESTOP:
            self.board.pass_time(0.01)
            assert self.board.last == (0.0, 0.0, False)
        assert all(math.isfinite(v) for v in control.pose)
        for message in self.board.answers:
            assert isinstance(message, Status | HelloAck | Challenge | Ack | TimeSyncReply)


AnyHost.TestCase.settings = settings(max_examples=40, stateful_step_count=40, deadline=None)
TestAnyHost = AnyHost.TestCase
