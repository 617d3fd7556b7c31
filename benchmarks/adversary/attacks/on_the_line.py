"""Attacks on the serial line, by the man in the middle."""

from __future__ import annotations

import random
import time
from collections.abc import Callable

from benchmarks.adversary.attacks.attack import Act, Attack
from benchmarks.adversary.rig import Rig
from benchmarks.adversary.stage.line import Frames, is_permit
from firmware_protocol.host.connection import HostConnection
from firmware_protocol.wire.framing import Sender, WireFrame
from firmware_protocol.wire.messages import MessageType

WATCH_S = 6.0
GROWS_S_S = 0.25
"""Seconds of delay a second: a lease every 80 ms arrives every 100 ms."""
STANDS_S = 3.2
"""The lease, braking and disarming."""


def _damage(spec: str) -> Act:
    def act(rig: Rig) -> None:
        rig.line.to_robot.damage(spec)
        rig.line.to_host.damage(spec)
        rig.watch_mission(WATCH_S)

    return act


def _delay(to_robot_s: float, to_host_s: float) -> Act:
    """From one moment to the next; what is on its way stays on its way."""

    def act(rig: Rig) -> None:
        rig.line.to_robot.delay_s = to_robot_s
        rig.line.to_host.delay_s = to_host_s
        rig.watch_mission(WATCH_S)

    return act


def _growing_delay(to_robot_s: float, to_host_s: float) -> Act:
    """Slowly, so that leases never cease to arrive."""

    def act(rig: Rig) -> None:
        whole_s = max(to_robot_s, to_host_s) / GROWS_S_S
        began_s = time.monotonic()
        while (share := (time.monotonic() - began_s) / whole_s) < 1.0 and rig.watch(0.02):
            rig.line.to_robot.delay_s = share * to_robot_s
            rig.line.to_host.delay_s = share * to_host_s
        rig.watch(1.0)

    return act


def _late_from_the_start(rig: Rig) -> None:
    rig.line.to_robot.delay_s = 1.0


def _watch(rig: Rig) -> None:
    rig.watch_mission(WATCH_S)


def _stall_and_burst(rig: Rig) -> None:
    """What was held back for a second arrives at once, again and again."""
    for _ in range(4):
        rig.line.to_robot.hold = True
        rig.watch(1.0)
        rig.line.to_robot.hold = False
        rig.watch(0.5)


def _late_burst(rig: Rig) -> None:
    """Leases are held back, the program is told to pause, and only then they arrive."""
    rig.line.to_robot.hold = True
    rig.watch(0.3)
    rig.order(order="pause")
    rig.watch(1.5)
    rig.line.to_robot.hold = False
    rig.watch(2.0)


def _replay(rig: Rig, record: list[tuple[float, bytes]], with_hello: bool) -> None:
    """Send a recording to the robot again, as it was; without its HELLOs where so."""
    frames = Frames(Sender.HOST)
    began_s = record[0][0]
    for at_s, data in record:
        for raw, frame in frames.feed(data):
            if with_hello or frame is None or frame.kind != MessageType.HELLO:
                rig.line.inject(raw, at_s - began_s)


def _session_replayed(with_hello: bool) -> Act:
    def act(rig: Rig) -> None:
        """The program is cut off, the robot stands; then it hears the session again."""
        rig.watch(1.5)
        record = list(rig.line.to_robot.record)
        rig.line.to_robot.cut = True
        rig.watch(STANDS_S)
        start_s = max(record[0][0], record[-1][0] - 5.0) if not with_hello else record[0][0]
        _replay(rig, [one for one in record if one[0] >= start_s], with_hello)
        rig.watch(min(8.0, record[-1][0] - start_s + 1.0))

    return act


def _replayed_over_the_live_one(rig: Rig) -> None:
    """The last seconds are heard again and again while the program is told to pause."""
    rig.watch(2.0)
    record = [one for one in rig.line.to_robot.record if one[0] > time.monotonic() - 1.5]
    rig.order(order="pause")
    rig.line.to_robot.cut = True
    for _ in range(3):
        _replay(rig, record, with_hello=False)
        rig.watch(1.5)


def _kept_alive(rig: Rig) -> None:
    """The program is cut off; its last second is heard again and again."""
    rig.watch(1.0)
    now_s = time.monotonic()
    record = [one for one in rig.line.to_robot.record if one[0] > now_s - 1.0]
    rig.line.to_robot.cut = True
    for _ in range(6):
        _replay(rig, record, with_hello=False)
        rig.watch(1.0)


def _old_permit(rig: Rig) -> None:
    """Poses pass; leases and halts do not, and the last permit comes ten times a second."""
    rig.watch(0.5)
    frames = Frames(Sender.HOST)
    found = [pair for _, data in rig.line.to_robot.record for pair in frames.feed(data)]
    permit = next(raw for raw, frame in reversed(found) if is_permit(frame))
    halts = (MessageType.LEASE, MessageType.PAUSE, MessageType.CLEAR)
    rig.line.to_robot.keep = lambda frame: frame.kind not in halts
    rig.order(order="pause")
    for _ in range(40):
        rig.line.inject(permit)
        rig.watch(0.1)


def _fresh_hello(seed: int) -> bytes:
    guest = HostConnection(random.Random(seed), 115_200)
    now_s = time.monotonic()
    guest.open(now_s)
    return guest.bytes_to_send(now_s)


def _stray_hello(rig: Rig) -> None:
    for number in range(3):
        rig.line.inject(_fresh_hello(rig.seed + number))
        rig.watch(2.5)


def _recorded_hello(rig: Rig) -> None:
    """This program's own first HELLO comes again, after another session has begun."""
    frames = Frames(Sender.HOST)
    found = [pair for _, data in rig.line.to_robot.record for pair in frames.feed(data)]
    hello = next(raw for raw, frame in found if frame and frame.kind == MessageType.HELLO)
    rig.line.inject(hello)
    rig.watch(1.0)
    rig.line.inject(_fresh_hello(rig.seed))
    rig.watch(2.0)
    for _ in range(5):
        rig.line.inject(hello)
        rig.watch(0.8)


class _Guest:
    """A second host on the robot's end: it greets, gives leave, and has no mission."""

    def __init__(self, seed: int, permit: bool) -> None:
        self._host = HostConnection(random.Random(seed), 115_200)
        self._permit = permit
        self._opened = False
        self._leased_s = 0.0

    def __call__(self, data: bytes, now_s: float) -> bytes:
        if not self._opened:
            self._opened = True
            self._host.open(now_s)
        if data:
            self._host.receive_bytes(data, now_s)
        if now_s - self._leased_s > 0.1:
            self._leased_s = now_s
            self._host.lease(now_s, 0.5, self._permit, 0.05, False)
        self._host.tick(now_s)
        return self._host.bytes_to_send(now_s)


def _second_host(rig: Rig) -> None:
    rig.line.guest = _Guest(rig.seed, permit=True)
    rig.watch(WATCH_S)


def _second_program(rig: Rig) -> None:
    """Another `clearway run` on the same port, with a journal and a socket of its own."""
    file = rig.folder / "second.yaml"
    text = rig.config_file.read_text().replace(str(rig.folder / "journal"), str(file) + ".journal")
    file.write_text(text)
    rig.start_another(file)
    rig.watch_mission(9.0)


def _echo(rig: Rig) -> None:
    rig.line.echo = True
    rig.watch_mission(WATCH_S)


def _keep_no(kind: MessageType) -> Callable[[WireFrame], bool]:
    return lambda frame: frame.kind != kind


def _estop_lost(rig: Rig) -> None:
    rig.watch(1.0)
    rig.note_end()
    rig.line.to_robot.keep = _keep_no(MessageType.ESTOP)
    rig.stop()
    rig.watch(2.0)


def _leases_lost(rig: Rig) -> None:
    rig.line.to_robot.keep = _keep_no(MessageType.LEASE)
    rig.watch(4.0)


def _wire_to_robot_cut(rig: Rig) -> None:
    """The robot is heard, and hears nothing."""
    rig.line.to_robot.cut = True
    rig.watch_mission(12.0, however_long=True)


def _deaf(rig: Rig) -> None:
    """The robot hears, and is not heard."""
    rig.line.to_host.cut = True
    rig.watch(4.0)


def _unplugged(rig: Rig) -> None:
    for down_s in (0.2, 1.5):
        rig.line.unplug()
        rig.watch(down_s)
        rig.line.plug()
        rig.watch(3.0)


ATTACKS = (
    Attack("line", "nothing is wrong", lambda rig: rig.watch_mission(WATCH_S)),
    Attack("line", "1 % of the bytes lost", _damage("drop=0.01")),
    Attack("line", "bits flipped in 1 % of the bytes", _damage("flip=0.01")),
    Attack("line", "a third of the frames twice", _damage("dup=0.33")),
    Attack("line", "a third of the frames overtaken", _damage("swap=0.33")),
    Attack("line", "at once 0.1 s late to the robot", _delay(0.1, 0.0)),
    Attack("line", "at once 0.3 s late both ways", _delay(0.3, 0.3)),
    Attack("line", "at once 1 s late to the robot", _delay(1.0, 0.0)),
    Attack("line", "growing to 0.6 s late to the robot", _growing_delay(0.6, 0.0)),
    Attack("line", "growing to 1 s late to the robot", _growing_delay(1.0, 0.0)),
    Attack("line", "growing to 2 s late to the robot", _growing_delay(2.0, 0.0)),
    Attack("line", "growing to 1 s late to the program", _growing_delay(0.0, 1.0)),
    Attack("line", "growing to 1 s late both ways", _growing_delay(1.0, 1.0)),
    Attack("line", "1 s late to the robot from the start", _watch, before=_late_from_the_start),
    Attack("line", "stalls of 1 s, then all at once", _stall_and_burst),
    Attack("line", "leases held back over a pause", _late_burst),
    Attack("line", "the session replayed to a cut-off robot", _session_replayed(True)),
    Attack("line", "its end replayed to a cut-off robot", _session_replayed(False)),
    Attack("line", "the last 1.5 s replayed over a pause", _replayed_over_the_live_one),
    Attack("line", "the last second replayed to a cut-off robot", _kept_alive),
    Attack("line", "an old permit in place of its withdrawal", _old_permit),
    Attack("line", "a stray HELLO, fresh", _stray_hello),
    Attack("line", "a stray HELLO, recorded", _recorded_hello),
    Attack("line", "a second host that gives leave", _second_host),
    Attack("line", "a second program on the port", _second_program),
    Attack("line", "echo", _echo),
    Attack("line", "the emergency stop lost", _estop_lost),
    Attack("line", "every lease lost", _leases_lost),
    Attack("line", "nothing heard of the robot", _deaf),
    Attack("line", "the wire to the robot cut", _wire_to_robot_cut),
    Attack("line", "unplugged for 0.2 and 1.5 s", _unplugged),
)
