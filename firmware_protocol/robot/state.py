"""What the robot may do, as a table: ``TRANSITIONS[state, event]``.

A pair that is not in the table cannot be, whatever a host sends. ESTOP is latched;
nothing but START leads to RUN, so the robot never resumes by itself.
"""

from __future__ import annotations

from enum import Enum
from typing import Final

from firmware_protocol.wire.errors import LocalError
from firmware_protocol.wire.messages import RobotState


class RobotEvent(Enum):
    """What can happen to the robot's state."""

    SESSION = "a host opened a session"
    START = "START was accepted"
    HALT = "a stop under control: pause, lease, permit, pose, path"
    CLEAR = "the queue was dropped"
    DONE = "the waypoint with END was executed"
    DISARM = "no lease for too long"
    ESTOP = "emergency stop"
    RESET = "RESET_ESTOP was accepted"


TRANSITIONS: Final[dict[tuple[RobotState, RobotEvent], RobotState]] = {
    (RobotState.BOOT, RobotEvent.SESSION): RobotState.IDLE,
    (RobotState.IDLE, RobotEvent.SESSION): RobotState.IDLE,
    (RobotState.RUN, RobotEvent.SESSION): RobotState.HOLD,
    (RobotState.HOLD, RobotEvent.SESSION): RobotState.HOLD,
    (RobotState.ESTOP, RobotEvent.SESSION): RobotState.ESTOP,
    (RobotState.IDLE, RobotEvent.START): RobotState.RUN,
    (RobotState.HOLD, RobotEvent.START): RobotState.RUN,
    (RobotState.IDLE, RobotEvent.HALT): RobotState.IDLE,
    (RobotState.RUN, RobotEvent.HALT): RobotState.HOLD,
    (RobotState.HOLD, RobotEvent.HALT): RobotState.HOLD,
    (RobotState.ESTOP, RobotEvent.HALT): RobotState.ESTOP,
    (RobotState.IDLE, RobotEvent.CLEAR): RobotState.IDLE,
    (RobotState.RUN, RobotEvent.CLEAR): RobotState.IDLE,
    (RobotState.HOLD, RobotEvent.CLEAR): RobotState.IDLE,
    (RobotState.RUN, RobotEvent.DONE): RobotState.IDLE,
    (RobotState.RUN, RobotEvent.DISARM): RobotState.IDLE,
    (RobotState.HOLD, RobotEvent.DISARM): RobotState.IDLE,
    (RobotState.BOOT, RobotEvent.ESTOP): RobotState.ESTOP,
    (RobotState.IDLE, RobotEvent.ESTOP): RobotState.ESTOP,
    (RobotState.RUN, RobotEvent.ESTOP): RobotState.ESTOP,
    (RobotState.HOLD, RobotEvent.ESTOP): RobotState.ESTOP,
    (RobotState.ESTOP, RobotEvent.ESTOP): RobotState.ESTOP,
    (RobotState.ESTOP, RobotEvent.RESET): RobotState.IDLE,
}


def state_after(state: RobotState, event: RobotEvent) -> RobotState:
    """What the robot becomes; LocalError for an event that cannot happen to it."""
    if (state, event) not in TRANSITIONS:
        raise LocalError(f"{event.name} ({event.value}) cannot happen to a robot in {state.name}")
    return TRANSITIONS[state, event]
