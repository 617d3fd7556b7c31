"""The man in the middle: everything between the program and the robot passes through here.

The program opens ``link``, a pseudo-terminal of this thread's, and the robot's own is opened
from here. Each direction may damage, delay, hold, drop and add bytes; the frames that pass are
read with the project's own parser, so that the judge knows when the program last gave the robot
leave to drive. Monotonic seconds.
"""

from __future__ import annotations

import contextlib
import os
import select
import threading
import time
import tty
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from firmware_protocol.wire.errors import RemoteError
from firmware_protocol.wire.framing import FrameParser, Sender, WireFrame
from firmware_protocol.wire.messages import Lease, LeaseFlag, Message, PoseFix, read_message
from navigation.simulator.line_faults import FaultSpec, FaultyLine

TURN_S = 0.002
Keep = Callable[[WireFrame], bool]


class Frames:
    """Cuts a byte stream at its delimiters: raw bytes, and the frame where they are one."""

    def __init__(self, sender: Sender) -> None:
        self._parser = FrameParser(sender)
        self._partial = bytearray()

    def feed(self, data: bytes) -> list[tuple[bytes, WireFrame | None]]:
        self._partial += data
        pieces = bytes(self._partial).split(b"\0")
        self._partial = bytearray(pieces.pop())
        found: list[tuple[bytes, WireFrame | None]] = []
        for piece in filter(None, pieces):
            raw = b"\0" + piece + b"\0"
            frames = self._parser.feed(raw)
            found.append((raw, frames[0] if frames else None))
        return found


def message_of(frame: WireFrame | None) -> Message | None:
    """What a frame says; None where it is none or says nothing that is known."""
    if frame is None:
        return None
    try:
        return read_message(frame)
    except RemoteError:
        return None


def is_permit(frame: WireFrame | None) -> bool:
    """Whether a frame of the host's lets the robot drive."""
    message = message_of(frame)
    return isinstance(message, Lease) and bool(message.flags & LeaseFlag.PERMIT)


@dataclass(slots=True)
class Direction:
    """One way of the line, and what is done to it; any thread may change the knobs.

    ``keep`` decides on each whole frame; ``hold`` keeps everything back until it is False.
    """

    sender: Sender
    rng: np.random.Generator
    delay_s: float = 0.0
    cut: bool = False
    hold: bool = False
    keep: Keep | None = None
    record: list[tuple[float, bytes]] = field(default_factory=list)
    """Everything that went in, with its time."""
    _faulty: FaultyLine | None = None
    _entering: Frames = field(init=False)
    _waiting: deque[tuple[float, bytes]] = field(default_factory=deque)

    def __post_init__(self) -> None:
        self._entering = Frames(self.sender)

    def damage(self, spec: str) -> None:
        """As `clearway robot --faults`; an empty text ends it."""
        self._faulty = FaultyLine(FaultSpec.parse(spec), self.rng) if spec else None

    def put(self, data: bytes, now_s: float) -> None:
        self.record.append((now_s, data))
        if self.cut:
            return
        if self.keep is not None:
            frames = self._entering.feed(data)
            data = b"".join(raw for raw, frame in frames if frame is None or self.keep(frame))
        if data:
            self._waiting.append((now_s + self.delay_s, data))

    def take(self, now_s: float) -> bytes:
        """What arrives now."""
        out = bytearray()
        while not self.hold and self._waiting and self._waiting[0][0] <= now_s:
            out += self._waiting.popleft()[1]
        if self._faulty is not None:
            return self._faulty.carry(bytes(out), now_s)
        return bytes(out)


class Line:
    """The thread; a context manager."""

    def __init__(self, link: Path, rng: np.random.Generator) -> None:
        self.link = link
        self.to_robot = Direction(Sender.HOST, rng)
        self.to_host = Direction(Sender.ROBOT, rng)
        self.echo = False
        self.guest: Callable[[bytes, float], bytes] | None = None
        """Somebody else on the robot's end: hears its bytes, and what it says goes to it."""
        self.fixes: list[tuple[float, float, float]] = []
        """Each pose that the program told the robot: when, and x_m, y_m."""
        self._sent: list[tuple[float, bytes]] = []
        """Each permit: when the program sent it."""
        self._next_sent = 0
        self._passed: list[float] = []
        self._entering, self._leaving = Frames(Sender.HOST), Frames(Sender.HOST)
        self._injected: deque[tuple[float, bytes]] = deque()
        self._robot = -1
        self._lock = threading.Lock()
        self._master = self._slave = -1
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="line", daemon=True)

    def __enter__(self) -> Line:
        self.plug()
        self._thread.start()
        return self

    def __exit__(self, *_exc: object) -> None:
        self._over.set()
        self._thread.join()
        self.unplug()
        if self._robot >= 0:
            os.close(self._robot)

    # The cable.

    @property
    def is_attached(self) -> bool:
        """Whether the robot's end is there."""
        return self._robot >= 0

    def attach(self, robot_port: str) -> None:
        """The robot's end: its pseudo-terminal."""
        end = os.open(robot_port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        with self._lock:
            self._robot = end

    def plug(self) -> None:
        """A new pseudo-terminal under the link's name."""
        master, slave = os.openpty()
        tty.setraw(slave)
        os.set_blocking(master, False)
        with self._lock:
            self._master, self._slave = master, slave
        self.link.symlink_to(os.ttyname(slave))

    def unplug(self) -> None:
        """The program's end hangs up and its name goes."""
        self.link.unlink(missing_ok=True)
        with self._lock:
            for one in (self._master, self._slave):
                if one >= 0:
                    os.close(one)
            self._master = self._slave = -1

    def inject(self, data: bytes, delay_s: float = 0.0) -> None:
        """Bytes to the robot that the program never sent."""
        self._injected.append((time.monotonic() + delay_s, data))

    # What the judge asks.

    def permits_s(self) -> list[float]:
        """When the program sent each permit that was let through."""
        if not self._thread.is_alive():
            raise RuntimeError("the man in the middle has died: nothing passed since")
        return list(self._passed)

    # The thread.

    def _run(self) -> None:
        while not self._over.is_set():
            with self._lock:
                ends = [end for end in (self._master, self._robot) if end >= 0]
            with contextlib.suppress(OSError, ValueError):  # unplugged meanwhile
                select.select(ends, [], [], TURN_S)
            now_s = time.monotonic()
            with self._lock:
                self._turn(now_s)

    def _turn(self, now_s: float) -> None:
        from_host, from_robot = _read(self._master), _read(self._robot)
        if from_host:
            self.to_robot.put(from_host, now_s)
            self._note_sent(from_host, now_s)
        if from_robot:
            self.to_host.put(from_robot, now_s)
        arrived = self.to_robot.take(now_s)
        back = self.to_host.take(now_s)
        if arrived:
            self._note_passed(arrived)
        if self.echo:
            arrived, back = arrived + back, back + arrived
        if self.guest is not None:
            arrived += self.guest(from_robot, now_s)
        while self._injected and self._injected[0][0] <= now_s:
            arrived += self._injected.popleft()[1]
        _write(self._robot, arrived)
        _write(self._master, back)

    def _note_sent(self, data: bytes, now_s: float) -> None:
        for raw, frame in self._entering.feed(data):
            if is_permit(frame):
                self._sent.append((now_s, raw))
            fix = message_of(frame)
            if isinstance(fix, PoseFix):
                self.fixes.append((now_s, fix.x_m, fix.y_m))

    def _note_passed(self, data: bytes) -> None:
        """Match the permits that leave with those that came in, in order."""
        for raw, frame in self._leaving.feed(data):
            if not is_permit(frame):
                continue
            for index in range(self._next_sent, len(self._sent)):
                if self._sent[index][1] == raw:
                    self._passed.append(self._sent[index][0])
                    self._next_sent = index + 1
                    break
            # else: it was overtaken by a later one, or comes twice


def _read(end: int) -> bytes:
    if end < 0:
        return b""
    try:
        return os.read(end, 4096)
    except OSError:
        return b""


def _write(end: int, data: bytes) -> None:
    if data and end >= 0:
        with contextlib.suppress(OSError):
            os.write(end, data)
