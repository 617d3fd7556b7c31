"""The host's end: against a scripted robot, and as a state machine over a hostile line."""

import random
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.events import (
    CommandEnded,
    EstopConfirmed,
    Event,
    LinkChanged,
    MissionDone,
    MissionVoid,
    RobotRebooted,
)
from firmware_protocol.host.state import TRANSITIONS, LinkState
from firmware_protocol.robot.connection import Identity, RobotConnection
from firmware_protocol.robot.controller import RobotController
from firmware_protocol.wire.errors import LocalError
from firmware_protocol.wire.framing import Frame, FrameParser, Sender, encode_frame
from firmware_protocol.wire.messages import (
    ESTOP_FRAME,
    SCHEMA_HASH,
    CommandResult,
    MessageType,
    RobotState,
    Waypoint,
)
from firmware_protocol.wire.mission import Mission

TICK_S = 0.005


class Table:
    """Host and robot, frame by frame; ``line`` may change what passes."""

    def __init__(self, seed: int = 1, baud: int | None = None) -> None:
        self.host = HostConnection(random.Random(seed), baud)
        self.boot(1)
        self.now_s = 50.0
        self.wheels = [0.0, 0.0]
        self.sent: list[bytes] = []
        self.events: list[Event] = []
        self.cable = True
        self.lease = True
        self.host.open(self.now_s)

    def boot(self, boot_id: int, schema: int = SCHEMA_HASH) -> None:
        self.control = RobotController()
        self.robot = RobotConnection(Identity(boot_id, schema=schema), self.control)

    def to_robot(self, data: bytes) -> list[bytes]:
        return [data]

    def to_host(self, data: bytes) -> list[bytes]:
        return [data]

    def tick(self) -> None:
        self.now_s += TICK_S
        steps = round(self.now_s / TICK_S)
        if self.lease and steps % 20 == 0:
            self.host.lease(self.now_s, 0.5, True, odometry=True)
        self.host.tick(self.now_s)
        while data := self.host.bytes_to_send(self.now_s):
            self.sent.append(data)
            for part in self.to_robot(data) if self.cable else ():
                self.robot.receive_bytes(part, self.now_s)
        if steps % 2 == 0:
            for side in (0, 1):
                self.wheels[side] += 2 * TICK_S * self.control.wheels[side]
            self.control.step(self.now_s, *self.wheels)
        while data := self.robot.next_frame(self.now_s):
            for part in self.to_host(data) if self.cable else ():
                self.host.receive_bytes(part, self.now_s)
        while (event := self.host.next_event()) is not None:
            self.events.append(event)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK_S)):
            self.tick()


def line(number: int = 9, count: int = 40) -> Mission:
    return Mission(number, [Waypoint(0.02 * (i + 1), 0.0, 0.4) for i in range(count)])


def test_a_mission_is_uploaded_driven_and_confirmed() -> None:
    table = Table()
    table.run(0.2)
    table.host.upload(line(), table.now_s)
    table.run(6.0)
    kinds = [type(event).__name__ for event in table.events]
    assert kinds.index("MissionAccepted") < kinds.index("MissionDone")
    assert MissionDone(9) in table.events
    assert table.host.state is LinkState.STREAM
    assert table.control.exec_crc == line().prefix_crc(40)


def test_every_change_of_state_stands_in_the_table() -> None:
    table = Table()
    table.run(0.2)
    table.host.upload(line(), table.now_s)
    table.run(1.0)
    table.cable = False
    table.run(1.0)
    table.cable = True
    table.run(1.0)
    table.boot(2)
    table.run(1.5)
    table.cable = False
    table.run(1.0)
    table.cable = True
    table.boot(3, schema=1)
    table.run(1.0)
    table.host.close()
    table.tick()
    changes = [(e.old, e.new) for e in table.events if isinstance(e, LinkChanged)]
    allowed = {(old, new) for (old, _), new in TRANSITIONS.items()}
    assert set(changes) <= allowed
    assert all(a[1] is b[0] for a, b in pairwise(changes))
    assert {new for _, new in changes} == set(LinkState)


def test_upload_without_start_moves_nothing() -> None:
    table = Table()
    table.run(0.2)
    table.host.upload(line(), table.now_s, start=False)
    table.run(1.0)
    assert table.control.accept_next > 0
    assert table.control.state is RobotState.IDLE


def test_after_a_lost_link_nothing_drives_until_start_is_given_again() -> None:
    table = Table()
    table.run(0.2)
    table.host.upload(line(), table.now_s)
    table.run(1.0)
    assert table.control.state is RobotState.RUN
    table.cable = False
    table.run(1.0)
    assert table.host.state is LinkState.LINK_LOST
    table.cable = True
    table.run(2.0)
    assert table.host.state.is_up
    assert table.control.state is not RobotState.RUN
    table.host.start(table.now_s)
    table.run(5.0)
    assert MissionDone(9) in table.events


def test_a_lost_link_says_for_how_long_nothing_came() -> None:
    table = Table()
    table.run(0.2)
    table.cable = False
    table.run(1.0)
    lost = [e for e in table.events if isinstance(e, LinkChanged) and e.new is LinkState.LINK_LOST]
    assert [e.reason for e in lost] == ["no frame for 0.50 s"]


def test_the_id_of_a_void_mission_is_not_taken_again() -> None:
    table = Table()
    table.run(0.2)
    table.host.upload(line(), table.now_s)
    table.run(1.0)
    table.boot(2)
    table.run(1.5)
    assert any(isinstance(e, MissionVoid) for e in table.events)
    with pytest.raises(LocalError, match="mission 9 became void: a new one needs a new id"):
        table.host.upload(line(), table.now_s)
    assert table.control.mission == 0


def test_a_start_in_flight_is_given_up_with_the_link() -> None:
    table = Table()
    table.run(0.2)
    table.cable = False
    table.host.upload(line(), table.now_s)
    table.run(1.0)
    ended = [e for e in table.events if isinstance(e, CommandEnded)]
    assert ended
    assert all(e.result is CommandResult.NONE for e in ended)
    table.cable = True
    table.run(1.0)
    assert table.control.state is not RobotState.RUN


def test_a_reboot_voids_the_mission_and_waits_for_another() -> None:
    table = Table()
    table.run(0.2)
    table.host.upload(line(), table.now_s)
    table.run(1.0)
    table.boot(2)
    table.run(1.5)
    assert table.host.state is LinkState.REBOOTED
    assert any(isinstance(e, RobotRebooted) and e.boot_id == 2 for e in table.events)
    assert any(isinstance(e, MissionVoid) for e in table.events)
    assert table.control.mission == 0
    table.host.upload(line(10), table.now_s)
    table.run(6.0)
    assert MissionDone(10) in table.events


def test_a_robot_with_other_waypoints_under_the_same_id_is_found_out() -> None:
    table = Table()
    table.run(0.2)
    table.host.upload(line(9), table.now_s, start=False)
    table.run(0.5)
    other = Mission(9, [Waypoint(0.03 * (i + 1), 0.0, 0.4) for i in range(40)])
    table.host.upload(other, table.now_s)
    table.run(0.5)
    void = [e for e in table.events if isinstance(e, MissionVoid)]
    assert len(void) == 1
    assert "not those of the mission" in void[0].reason
    assert table.control.state is not RobotState.RUN


def test_an_emergency_stop_is_repeated_until_confirmed() -> None:
    table = Table()
    table.run(0.2)
    table.cable = False
    table.host.estop()
    table.sent.clear()
    table.run(0.2)
    assert 8 <= table.sent.count(ESTOP_FRAME) <= 11
    assert table.host.estop_pending
    table.cable = True
    table.run(1.5)
    assert not table.host.estop_pending
    assert EstopConfirmed() in table.events
    table.sent.clear()
    table.run(0.5)
    assert ESTOP_FRAME not in table.sent


def test_an_emergency_stop_is_the_very_next_frame() -> None:
    table = Table(baud=115_200)
    table.run(0.3)
    table.host.upload(line(count=400), table.now_s)
    table.run(0.3)
    table.host.estop()
    assert table.host.bytes_to_send(table.now_s) == ESTOP_FRAME


@pytest.mark.parametrize("baud", [9600, 115_200, 1_000_000])
def test_output_keeps_to_the_baud_rate_with_at_most_a_frame_ahead(baud: int) -> None:
    table = Table(baud=baud)
    table.lease = False
    table.run(0.5)
    table.host.upload(line(count=2000), table.now_s, start=False)
    began_s, queued_s = table.now_s, 0.0
    sent = 0
    while table.now_s < began_s + 1.0:
        table.now_s += 0.0005
        table.host.tick(table.now_s)
        data = table.host.bytes_to_send(table.now_s)
        sent += len(data)
        queued_s = max(queued_s - 0.0005, 0.0) + 10.0 * len(data) / baud
        assert queued_s <= 10.0 * 127 / baud + 0.0015
        table.robot.receive_bytes(data, table.now_s)
        while reply := table.robot.next_frame(table.now_s):
            table.host.receive_bytes(reply, table.now_s)
    assert sent <= 0.1 * baud * 1.01 + 127


def test_reasons_for_a_link_that_is_down_are_told_apart() -> None:
    host = HostConnection(random.Random(1))
    assert host.why_down(0.0) == "the port is not open"
    host.open(0.0)
    assert "no byte" in str(host.why_down(2.0))
    host.receive_bytes(b"\x55\xaa\x00" * 50, 2.0)
    assert "baud" in str(host.why_down(2.0))
    host = HostConnection(random.Random(1))
    host.open(0.0)
    host.receive_bytes(host.bytes_to_send(0.0), 0.1)
    assert "echoes" in str(host.why_down(0.2))
    host.close("the cable was cut")
    assert host.why_down(1.0) == "the cable was cut"


def test_start_without_a_mission_is_our_own_mistake() -> None:
    with pytest.raises(LocalError):
        HostConnection(random.Random(1)).start(0.0)


def test_a_port_that_is_open_is_not_opened_again() -> None:
    table = Table()
    table.run(0.5)
    session, events = table.robot.session, len(table.events)
    with pytest.raises(LocalError, match=r"OPEN .* cannot happen to a link in STREAM"):
        table.host.open(table.now_s)
    table.run(0.5)
    assert table.host.state is LinkState.STREAM
    assert table.robot.session == session, "nothing was changed by it"
    assert not any(isinstance(event, LinkChanged) for event in table.events[events:])


def test_a_port_may_be_closed_twice_and_opened_after_that() -> None:
    host = HostConnection(random.Random(1))
    host.close()
    host.open(0.0)
    host.close()
    host.close("again")
    assert host.why_down(0.0) == "again"
    host.open(1.0)
    assert host.state is LinkState.HELLO


def test_a_newer_pose_replaces_one_that_was_not_sent() -> None:
    table = Table()
    table.run(0.2)
    table.host.pose_fix(1.0, 0.0, 0.0, table.now_s)
    table.host.pose_fix(2.0, 0.0, 0.0, table.now_s)
    table.sent.clear()
    table.tick()
    parser = FrameParser(Sender.HOST)
    frames = [f for data in table.sent for f in parser.feed(data)]
    assert [f.kind for f in frames].count(MessageType.POSE) == 1
    assert table.control.estimate.pose.x_m == pytest.approx(2.0)


def test_a_pose_carries_its_age_at_the_time_of_sending() -> None:
    table = Table(baud=None)
    table.run(0.2)
    table.host.pose_fix(1.0, 0.0, 0.0, table.now_s - 0.05)
    table.tick()
    assert table.control.pose_age_s(table.now_s) == pytest.approx(0.05 + TICK_S, abs=2e-4)


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
    frame = Frame(kind, session, payload, 0, acknowledged, credit, nak=nak)
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
        if table.host.estopped or table.host.estop_pending:
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
