from pathlib import Path

import pytest

from firmware_protocol.host.state import TRANSITIONS as HOST
from firmware_protocol.host.state import LinkEvent, LinkState
from firmware_protocol.host.state import state_after as link_state_after
from firmware_protocol.robot.clearway import states
from firmware_protocol.wire.errors import LocalError
from firmware_protocol.wire.messages import ESTOP_FRAME, STOP_SENTENCES, RobotState, StopReason

ROBOT = {
    (RobotState(state), event): RobotState(after)
    for event, row in enumerate(states.TRANSITIONS)
    for state, after in enumerate(row)
    if after != states.NEVER
}


def test_the_robot_and_its_line_have_the_same_states() -> None:
    assert [state.name for state in RobotState] == list(states.STATES)
    assert len(states.TRANSITIONS) == len(states.EVENTS)


def test_only_start_leads_to_run() -> None:
    into_run = {event for (_, event), new in ROBOT.items() if new is RobotState.RUN}
    assert into_run == {states.START}


def test_every_state_can_be_stopped_and_only_a_reset_leaves_the_stop() -> None:
    for state in RobotState:
        assert ROBOT[state, states.STOP] is RobotState.ESTOP
    leaving = {e for (s, e), new in ROBOT.items() if s is RobotState.ESTOP and new is not s}
    assert leaving == {states.RESET}


def test_a_new_session_never_leaves_the_robot_running() -> None:
    assert all(
        new is not RobotState.RUN for (_, event), new in ROBOT.items() if event == states.SESSION
    )


def test_every_state_of_the_link_can_be_reached_and_closed() -> None:
    reached = {LinkState.CLOSED}
    for _ in LinkState:
        reached |= {new for (old, _), new in HOST.items() if old in reached}
    assert reached == set(LinkState)
    assert all(HOST[state, LinkEvent.CLOSE] is LinkState.CLOSED for state in LinkState)


def test_every_state_that_is_up_can_be_lost() -> None:
    for state in LinkState:
        if state.is_up:
            assert HOST[state, LinkEvent.SILENCE] is LinkState.LINK_LOST


def test_every_reason_to_stand_has_a_sentence() -> None:
    assert set(STOP_SENTENCES) == set(StopReason)


def test_an_event_that_cannot_happen_is_our_own_mistake() -> None:
    with pytest.raises(LocalError, match=r"OPEN \(the port was opened\) cannot happen .* in DRAIN"):
        link_state_after(LinkState.DRAIN, LinkEvent.OPEN)
    with pytest.raises(ValueError, match=r"CLEAR: .* cannot happen to a robot in BOOT"):
        states.state_after(states.BOOT, states.CLEAR)


def test_what_a_robot_can_be_told_in_a_session_never_raises() -> None:
    """A host may pause in every state; START, CLEAR and RESET are answered before the table."""
    for state in set(RobotState) - {RobotState.BOOT}:
        assert (state, states.HALT) in ROBOT


def test_the_document_lists_the_tables() -> None:
    text = (Path(__file__).parents[2] / "docs" / "protocol.md").read_text()
    host = [f"| {s.name} | {e.name}: {e.value} | {new.name} |" for (s, e), new in HOST.items()]
    robot = [f"| {s.name} | {states.EVENTS[e]} | {new.name} |" for (s, e), new in ROBOT.items()]
    assert "\n".join(host) in text
    assert "\n".join(robot) in text
    assert ESTOP_FRAME.hex(" ") in text
