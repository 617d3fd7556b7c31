"""The robot's states, as a table: ``TRANSITIONS[event][state]`` is the state after an event.

A pair marked NEVER cannot occur, whatever a host sends. ESTOP is latched; only START leads to RUN,
so the robot never resumes by itself.
"""

STATES = ("BOOT", "IDLE", "RUN", "HOLD", "ESTOP")
BOOT, IDLE, RUN, HOLD, ESTOP = 0, 1, 2, 3, 4

EVENTS = (
    "SESSION: a host opened a session",
    "START: START was accepted",
    "HALT: a stop under control: pause, lease, permit, pose, path",
    "CLEAR: the queue was dropped",
    "DONE: the waypoint with END was executed",
    "DISARM: no lease for too long",
    "ESTOP: emergency stop",
    "RESET: RESET_ESTOP was accepted",
)
SESSION, START, HALT, CLEAR, DONE, DISARM, STOP, RESET = 0, 1, 2, 3, 4, 5, 6, 7

NEVER = 255
TRANSITIONS = (  # from BOOT, IDLE, RUN, HOLD, ESTOP
    bytes((IDLE, IDLE, HOLD, HOLD, ESTOP)),
    bytes((NEVER, RUN, NEVER, RUN, NEVER)),
    bytes((NEVER, IDLE, HOLD, HOLD, ESTOP)),
    bytes((NEVER, IDLE, IDLE, IDLE, NEVER)),
    bytes((NEVER, NEVER, IDLE, NEVER, NEVER)),
    bytes((NEVER, NEVER, IDLE, IDLE, NEVER)),
    bytes((ESTOP, ESTOP, ESTOP, ESTOP, ESTOP)),
    bytes((NEVER, NEVER, NEVER, NEVER, IDLE)),
)


def state_after(state: int, event: int) -> int:
    """State after an event; ``ValueError`` for one that cannot happen."""
    after = TRANSITIONS[event][state]
    if after == NEVER:
        raise ValueError(EVENTS[event] + ": cannot happen to a robot in " + STATES[state])
    return after
