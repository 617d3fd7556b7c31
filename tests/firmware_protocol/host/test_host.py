"""The host's end against a scripted robot."""

import random
from itertools import pairwise

import pytest

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.events import (
    CommandEnded,
    EstopConfirmed,
    LinkChanged,
    MissionDone,
    MissionVoid,
    RobotRebooted,
)
from firmware_protocol.host.state import TRANSITIONS, LinkState
from firmware_protocol.wire.errors import LocalError
from firmware_protocol.wire.framing import FrameParser, Sender
from firmware_protocol.wire.messages import (
    ESTOP_FRAME,
    CommandResult,
    MessageType,
    RobotState,
    Waypoint,
)
from firmware_protocol.wire.mission import Mission
from tests.firmware_protocol.host.table import TICK_S, Table, line


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
    assert table.control.pose.x_m == pytest.approx(2.0)


def test_a_pose_carries_its_age_at_the_time_of_sending() -> None:
    table = Table(baud=None)
    table.run(0.2)
    table.host.pose_fix(1.0, 0.0, 0.0, table.now_s - 0.05)
    table.tick()
    assert table.control.robot.pose_age_ms() == 1e3 * (0.05 + TICK_S)
