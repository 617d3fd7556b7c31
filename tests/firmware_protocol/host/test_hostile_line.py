"""The host's end as a state machine over a hostile line."""

import random

from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from firmware_protocol.host.events import (
    MissionDone,
)
from firmware_protocol.wire.framing import Sender, WireFrame, encode_frame
from firmware_protocol.wire.messages import (
    RobotState,
)
from tests.firmware_protocol.host.table import Table, line


@settings(max_examples=30, deadline=None)
@given(st.lists(st.binary(max_size=200), max_size=20))
def test_any_bytes_from_the_line_do_no_harm(parts: list[bytes]) -> None:
    table = Table()
    table.run(0.2)
    for part in parts:
        table.host.receive_bytes(part, table.now_s)
        table.tick()
    table.host.upload(line(count=5), table.now_s)
    table.run(2.5)
    assert MissionDone(9) in table.events


@given(
    kind=st.sampled_from([0x81, 0x90, 0x91, 0xA2, 0x10, 0x55]),
    payload=st.binary(max_size=112),
    acknowledged=st.integers(0, 255),
    credit=st.integers(0, 255),
    nak=st.booleans(),
)
@settings(max_examples=80, deadline=None)
def test_any_whole_frame_of_the_session_is_survived(
    kind: int, payload: bytes, acknowledged: int, credit: int, nak: bool
) -> None:
    table = Table()
    table.run(0.2)
    table.host.upload(line(), table.now_s)
    table.run(0.05)
    session = table.robot.session
    assert session is not None
    frame = WireFrame(kind, session, payload, 0, acknowledged, credit, nak=nak)
    table.host.receive_bytes(encode_frame(frame, Sender.ROBOT), table.now_s)
    table.run(0.3)
    assert table.control.exec_crc == line().prefix_crc(table.control.exec_next)


class HostileLine(RuleBasedStateMachine):
    """Frames are lost, doubled, swapped and damaged, cables pulled, robots reset, users hasty."""

    @initialize(seed=st.integers(0, 1000))
    def begin(self, seed: int) -> None:
        self.table = Table(seed)
        self.rng = random.Random(seed)
        self.kept: list[bytes] = []
        self.rate = 0.0
        self.mission = line(1)
        self.boots = 1
        self.started = False
        self.table.to_robot = self.damage  # type: ignore[method-assign]
        self.table.to_host = self.damage  # type: ignore[method-assign]
        self.table.run(0.2)

    def damage(self, data: bytes) -> list[bytes]:
        if self.rng.random() >= self.rate:
            kept, self.kept = self.kept, []
            return [data, *kept]
        match self.rng.randrange(4):
            case 0:
                return []
            case 1:
                return [data, data]
            case 2:
                self.kept.append(data)
                return []
        at = self.rng.randrange(len(data))
        return [data[:at] + bytes([data[at] ^ 1 << self.rng.randrange(8)]) + data[at + 1 :]]

    @rule(rate=st.sampled_from([0.0, 0.02, 0.2, 0.5]))
    def weather(self, rate: float) -> None:
        self.rate = rate

    @rule()
    def new_mission(self) -> None:
        self.mission = line(self.mission.id + 1, 10 + self.mission.id % 40)
        self.started = True
        self.table.host.upload(self.mission, self.table.now_s)

    @rule()
    def start(self) -> None:
        if self.table.host.upload_state is not None:
            self.started = True
            self.table.host.start(self.table.now_s)

    @rule()
    def pause(self) -> None:
        self.table.host.pause()

    @rule()
    def clear(self) -> None:
        self.table.host.clear()

    @rule()
    def estop(self) -> None:
        self.table.host.estop()

    @rule()
    def reset_estop(self) -> None:
        self.table.host.reset_estop(self.table.now_s)

    @rule()
    def reset_robot(self) -> None:
        self.boots += 1
        self.table.boot(self.boots)

    @rule(cable=st.booleans())
    def pull(self, cable: bool) -> None:
        self.table.cable = cable

    @rule(seconds=st.sampled_from([0.02, 0.1, 0.4, 1.0, 3.0]))
    def wait(self, seconds: float) -> None:
        self.table.run(seconds)

    @invariant()
    def what_was_executed_is_what_was_sent(self) -> None:
        if not hasattr(self, "table"):
            return
        control = self.table.control
        if control.mission == self.mission.id:
            assert control.prefix_crc == self.mission.prefix_crc(control.accept_next)
            assert control.exec_crc == self.mission.prefix_crc(control.exec_next)
        if control.state is RobotState.RUN:
            assert self.started

    def teardown(self) -> None:
        """In fair weather, whatever happened before, a new mission is driven to its end."""
        if not hasattr(self, "table"):
            return
        table = self.table
        self.rate, table.cable, table.lease = 0.0, True, True
        table.run(2.0)
        status = table.host.status
        estopped = status is not None and status.state is RobotState.ESTOP
        if estopped or table.host.estop_pending:
            table.run(0.5)
            table.host.reset_estop(table.now_s)
            table.run(1.0)
        assert table.host.state.is_up, table.host.why_down(table.now_s)
        last = line(self.mission.id + 1, 12)
        table.host.upload(last, table.now_s)
        table.run(12.0)
        assert MissionDone(last.id) in table.events, (table.control.state, table.control.reason)


HostileLine.TestCase.settings = settings(max_examples=15, stateful_step_count=25, deadline=None)
TestHostileLine = HostileLine.TestCase
