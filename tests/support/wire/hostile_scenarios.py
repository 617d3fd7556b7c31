"""A line that strays, repeats and holds back whole frames: scenarios as in ``fault_scenarios``.

Every byte here is sound; only when it comes, and whose it is, is wrong.
"""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Callable

from firmware_protocol.host.events import StrayHello
from firmware_protocol.wire.framing import Sender, WireFrame, encode_frame
from firmware_protocol.wire.messages import (
    SCHEMA_HASH,
    Hello,
    MessageType,
    ResetCause,
    RobotState,
    StopReason,
)
from tests.support.wire.fault_witness import STOP_S, Witness, join_line

PERMIT_S = 0.55
"""No motion is permitted longer than this after the control loop gave its last permit."""
DELAYS_S = (0.2, 0.8, 1.4, 0.25, 2.0, 0.2)
"""Of the permits: those that come before the running lease is over prolong it where they are not
dated, the others are none where the robot holds already."""
OFF_M = 0.03
"""How far the robot's estimate may be off at 0.4 m/s; poses dated wrong by 0.2 s make it 80 mm."""


def hello(session: int) -> bytes:
    """Somebody's HELLO."""
    return encode_frame(
        WireFrame(MessageType.HELLO, session, Hello(SCHEMA_HASH).pack()), Sender.HOST
    )


class SlowLine:
    """Holds every byte back by the ``delay_s`` of its coming; none overtakes another."""

    def __init__(self, carry: Callable[[bytes, float], bytes]) -> None:
        self.delay_s = 0.0
        self._carry = carry
        self._held: deque[tuple[float, bytes]] = deque()

    def __call__(self, data: bytes, now_s: float) -> bytes:
        arrived = self._carry(data, now_s)
        if arrived:
            last_s = self._held[-1][0] if self._held else 0.0
            self._held.append((max(last_s, now_s + self.delay_s), arrived))
        out = b""
        while self._held and self._held[0][0] <= now_s:
            out += self._held.popleft()[1]
        return out


def slow(witness: Witness, way: int) -> SlowLine:
    """Makes one way of the line slow: 0 to the robot, 1 from it."""
    line = witness.loop._faulty[way]
    late = SlowLine(line.carry)
    line.carry = late  # type: ignore[method-assign]
    return late


def recorded(witness: Witness) -> list[tuple[float, bytes]]:
    """What the host says from now on, with its times."""
    said: list[tuple[float, bytes]] = []
    put = witness.loop.to_robot.put

    def recording(data: bytes, now_s: float) -> None:
        said.append((now_s, data))
        put(data, now_s)

    witness.loop.to_robot.put = recording  # type: ignore[method-assign]
    return said


def stray_hellos(seed: int) -> str:
    """HELLOs of sessions that nobody opens, while the robot drives: it drives on."""
    witness, rng = Witness(seed), random.Random(seed)
    witness.begin_and_drive(0.3)
    loop = witness.loop
    session = loop.robot.session
    for _ in range(5):
        witness.inject(hello(rng.randrange(1, 1 << 16)))
        loop.run(0.02 + 0.1 * rng.random())
        assert witness.state is RobotState.RUN
    assert loop.robot.session == session
    assert loop.host.counters.stray_hellos > 0
    assert any(isinstance(event, StrayHello) for event in loop.events)
    assert loop.host.counters.sessions == 1
    return witness.finish()


def stray_hello_while_connecting(seed: int) -> str:
    witness, rng = Witness(seed), random.Random(seed)
    loop = witness.loop
    for _ in range(8):
        loop.run(0.004 + 0.004 * rng.random())
        witness.inject(hello(rng.randrange(1, 1 << 16)))
    witness.connect(3.0)
    witness.begin()
    return witness.finish()


def whole_session_replayed(seed: int) -> str:
    """HELLO to START and all leases, as they were recorded, into a robot that waits.

    With the host idle, without one, and after a reset.
    """
    witness = Witness(seed)
    loop = witness.loop
    said = recorded(witness)
    witness.begin_and_drive(0.5)
    witness.finish()
    said = list(said)
    if seed % 3 == 2:
        witness.boot(ResetCause.EXTERNAL)
    else:  # the recorded session is an old one
        loop.knobs.cable = False
        loop.run(1.0)
        loop.knobs.cable = True
        witness.connect()
    if seed % 3 != 0:
        loop.host.close()
        loop.knobs.lease = loop.knobs.camera = False
    loop.run(0.3)
    before, executed = loop.drive.pose, list(witness.executed)
    session = loop.robot.session
    began_s, first_s = loop.now_s, said[0][0]
    for at_s, data in said:
        while loop.now_s - began_s < at_s - first_s:
            loop.tick()
        loop.robot.receive_bytes(data, loop.robot_s)
        assert witness.state is not RobotState.RUN, witness.describe()
    loop.run(0.5)
    # of the AVR the session is known by its last frame, which may be the answer to a HELLO
    assert witness.told_s or loop.robot.session == session, "a recording has opened a session"
    assert math.dist(before[:2], loop.drive.pose[:2]) < 1e-3, "a recording has moved the robot"
    assert witness.executed == executed
    if seed % 3 == 0:
        assert loop.host.state.is_up
        return "executed"
    return "refused and said so"


def host_that_confirmed_falls_silent(seed: int) -> str:
    """Another host takes the robot and hangs: the first keeps still, then takes it back."""
    witness = Witness(seed)
    loop = witness.loop
    witness.begin_and_drive(0.3)
    carry = loop._faulty[1].carry
    first, second = join_line(loop, 7000 + seed)
    witness.connect()
    witness.judge_standing(STOP_S + 2.0)
    assert second.state.is_up
    assert first.why_down(loop.now_s) == "another host has taken the robot over"
    loop.host, loop._faulty[1].carry = first, carry  # type: ignore[method-assign]
    witness.connect(5.0)
    assert first.counters.taken_back == 1
    witness.judge_standing(0.5)
    return witness.finish()


def permits_held_back(seed: int) -> str:
    """The control loop hangs while its last permits lie on the line: they are not obeyed."""
    witness = Witness(seed)
    loop = witness.loop
    line = slow(witness, 0)
    witness.begin_and_drive(0.5)
    line.delay_s = DELAYS_S[seed % len(DELAYS_S)]
    loop.run(0.1 + seed % 3 * 0.1)
    loop.knobs.lease = False
    last_s = loop.now_s
    loop.run(PERMIT_S + witness.told_s)
    for _ in range(300):
        assert witness.state is not RobotState.RUN, loop.now_s - last_s
        loop.run(0.01)
    line.delay_s = 0.0
    loop.run(0.3)
    loop.knobs.lease = True
    witness.judge_standing(1.0)
    return witness.finish()


def poses_held_back(seed: int) -> str:
    """0.2 s on the way to the robot: poses say when they were taken, and fit what it did since."""
    witness = Witness(seed, count=60)
    loop = witness.loop
    line = slow(witness, 0)
    witness.begin_and_drive(0.5)
    line.delay_s = 0.15 + seed % 3 * 0.05
    worst_m = 0.0
    for _ in range(100):
        loop.run(0.01)
        status = loop.host.status
        taken = None if status is None else loop.host.clock.host_s(status.time_us, loop.now_s)
        if status is not None and taken is not None:
            x, y = pose_at(witness, taken)
            worst_m = max(worst_m, math.dist((status.x_m, status.y_m), (x, y)))
    assert worst_m < OFF_M, f"the robot believes to be {worst_m * 1e3:.0f} mm beside itself"
    line.delay_s = 0.0
    return witness.finish()


def pose_at(witness: Witness, at_s: float) -> tuple[float, float]:
    """Where the robot was; its track has a place every 10 ms."""
    _, x, y, _ = min(witness.loop.track[-60:], key=lambda place: abs(place[0] - at_s))
    return x, y


def line_too_slow_for_a_permit(seed: int) -> str:
    """0.2 s each way from the first byte on: nobody knows the clock well enough; it says so."""
    witness = Witness(seed)
    for way in (0, 1):
        slow(witness, way).delay_s = 0.2
    loop = witness.loop
    witness.connect()
    loop.run(1.5)
    loop.host.upload(witness.mission, loop.now_s)
    loop.run(3.0)
    assert witness.state is RobotState.IDLE
    assert "ms are needed" in str(loop.host.why_no_permit(loop.now_s))
    return "refused and said so"


def estop_pressed_during_the_rearm(seed: int) -> str:
    """The button on the robot, pressed after the reset was ordered: the robot stays in its stop."""
    witness = Witness(seed)
    loop = witness.loop
    witness.begin_and_drive(0.3)
    loop.host.estop()
    loop.run(0.3)
    loop.host.reset_estop(loop.now_s)
    loop.run(0.005 * (seed % 3))
    opened = loop.run(1.0, lambda: loop.host.state.is_up)
    assert opened
    pressed = getattr(loop.robot.controller, "emergency_stop", None)
    if pressed is None or not loop.host.leaving_estop:  # no button, or it has left already
        return "stopped and said so"
    pressed(StopReason.ESTOP_LOCAL)
    loop.run(0.5)
    assert witness.state is RobotState.ESTOP
    assert not loop.host.leaving_estop, "the robot has answered: this is a stop"
    return "stopped and said so"


HOSTILE: dict[str, Callable[[int], str]] = {
    "stray HELLOs": stray_hellos,
    "stray HELLOs while connecting": stray_hello_while_connecting,
    "whole old session replayed": whole_session_replayed,
    "second host hangs": host_that_confirmed_falls_silent,
    "permits held back by the line": permits_held_back,
    "poses held back by the line": poses_held_back,
    "line too slow for a permit": line_too_slow_for_a_permit,
    "e-stop pressed during the re-arm": estop_pressed_during_the_rearm,
}
