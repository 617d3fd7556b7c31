"""Host, line, robot and floor in virtual time: no threads, no port, no waiting.

The host's end, a line paced to its baud rate with faults both ways, the robot's end, its controller
at 100 steps a second, and the moving robot.
"""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.events import Event
from firmware_protocol.robot.connection import Identity, RobotConnection
from firmware_protocol.robot.controller import RobotController, WheelSpeeds
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.messages import ResetCause
from navigation.simulator.drive_model import Drive, DriveModel, TruePose
from navigation.simulator.line_faults import FaultSpec, FaultyLine

TICK_S = 0.001
CONTROL_TICKS = 10
"""To one control cycle: 10 ms."""
TTY_BYTES = 4095
"""Bytes that Linux keeps for a program that reads none."""


class PacedLine:
    """A line on which a byte takes ten bits' time; none if ``baud`` is infinite."""

    def __init__(self, baud: float) -> None:
        self._byte_s = 10.0 / baud
        self._bytes: deque[tuple[float, bytes]] = deque()
        self.free_s = 0.0
        """Time from which the sender may put the next byte."""
        self.arrives_s = math.inf
        """Arrival of the next bytes; infinity if none are on their way."""

    def free(self, now_s: float) -> bool:
        """True if the sender may put the next byte."""
        return now_s >= self.free_s

    def put(self, data: bytes, now_s: float) -> None:
        """Send bytes after those under way."""
        start = max(now_s, self.free_s)
        self.free_s = start + len(data) * self._byte_s
        for at in range(0, len(data), 8):
            part = data[at : at + 8]
            self._bytes.append((start + (at + len(part)) * self._byte_s, part))
        self.arrives_s = self._bytes[0][0] if self._bytes else math.inf

    def take(self, now_s: float) -> bytes:
        """Bytes that have arrived."""
        if now_s < self.arrives_s:
            return b""
        out = bytearray()
        while self._bytes and self._bytes[0][0] <= now_s:
            out += self._bytes.popleft()[1]
        self.arrives_s = self._bytes[0][0] if self._bytes else math.inf
        return bytes(out)


@dataclass(slots=True)
class Knobs:
    """Settings that a scenario may switch while the loop runs."""

    cable: bool = True
    to_robot: bool = True
    """Passage of the host's bytes through the cable; the robot's always pass."""
    frozen: bool = False
    host_frozen: bool = False
    """The host's program does nothing; its kernel keeps the first `TTY_BYTES` that arrive."""


def python_robot(identity: Identity, settings: DriveSettings) -> RobotConnection:
    """The robot's end in Python."""
    return RobotConnection(identity, RobotController(settings))


@dataclass(slots=True)
class VirtualLoop:
    """The whole loop; :meth:`run` it, and look at ``host``, ``robot``, ``drive``, ``track``.

    ``make_robot`` may give another robot with the face of ``RobotConnection``. Neither end is asked
    before it is due; one that is taken from the loop may get an order, and is due at once.
    """

    seed: int = 0
    faults: FaultSpec = field(default_factory=FaultSpec)
    model: DriveModel = field(default_factory=DriveModel)
    settings: DriveSettings = field(default_factory=DriveSettings)
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)
    baud: int = 115_200
    start_s: float = 0.0
    robot_clock_offset_s: float = 0.0
    robot_clock_drift: float = 0.0
    make_robot: Callable[[Identity, DriveSettings], RobotConnection] = python_robot
    now_s: float = field(init=False)
    drive: Drive = field(init=False)
    knobs: Knobs = field(default_factory=Knobs, init=False)
    events: list[Event] = field(default_factory=list, init=False)
    track: list[tuple[float, float, float, float]] = field(default_factory=list, init=False)
    wheels: WheelSpeeds = field(init=False)
    to_robot: PacedLine = field(init=False)
    to_host: PacedLine = field(init=False)
    _host: HostConnection = field(init=False)
    _host_due_s: float = field(default=-math.inf, init=False)
    _robot: RobotConnection = field(init=False)
    _robot_due_s: float = field(default=-math.inf, init=False)
    _unread: bytearray = field(default_factory=bytearray, init=False)
    _rng: np.random.Generator = field(init=False)
    _faulty: tuple[FaultyLine, FaultyLine] = field(init=False)
    _ticks: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self.now_s = self.start_s
        self._rng = np.random.default_rng(self.seed)
        self.to_robot, self.to_host = PacedLine(self.baud), PacedLine(self.baud)
        self._faulty = (FaultyLine(self.faults, self._rng), FaultyLine(self.faults, self._rng))
        self.drive = Drive(self.model, TruePose(*self.start), self._rng)
        self.boot(ResetCause.POWER_ON)
        self.host = HostConnection(random.Random(self.seed), self.baud)
        self.host.open(self.now_s)

    def boot(self, cause: ResetCause) -> None:
        """Start the robot's processor with nothing left from earlier."""
        boot_id = int(self._rng.integers(1, 1 << 32))
        self.robot = self.make_robot(Identity(boot_id, reset_cause=cause), self.settings)
        self.wheels = WheelSpeeds(0.0, 0.0, powered=False)

    @property
    def host(self) -> HostConnection:
        """The host's end."""
        self._host_due_s = -math.inf
        return self._host

    @host.setter
    def host(self, host: HostConnection) -> None:
        self._host, self._host_due_s = host, -math.inf

    @property
    def robot(self) -> RobotConnection:
        """The robot's end."""
        self._robot_due_s = -math.inf
        return self._robot

    @robot.setter
    def robot(self, robot: RobotConnection) -> None:
        self._robot, self._robot_due_s = robot, -math.inf

    @property
    def robot_s(self) -> float:
        """The robot's own clock."""
        passed_s = self.now_s - self.start_s
        return passed_s * (1.0 + self.robot_clock_drift) + self.robot_clock_offset_s

    def tick(self) -> None:
        """Simulate one millisecond."""
        self._ticks += 1
        self.now_s = now_s = self.now_s + TICK_S
        knobs, cycle_ends = self.knobs, self._ticks % CONTROL_TICKS == 0
        if self.to_robot.arrives_s <= now_s or self._faulty[0].held:
            self._bytes_to_robot(now_s)
        if knobs.frozen:
            self._robot_due_s = -math.inf
        elif cycle_ends or self._robot_due_s <= now_s:
            self._robot_turn(now_s, cycle_ends)
        if self.to_host.arrives_s <= now_s or self._faulty[1].held:
            self._bytes_to_host(now_s)
        if not knobs.host_frozen:
            self._host_reads(now_s)
            if self._host_due_s <= now_s:
                self._host_turn(now_s)
        self.drive.step(TICK_S, self.wheels)
        if cycle_ends:
            self.track.append((now_s, *self.drive.pose))

    def _bytes_to_robot(self, now_s: float) -> bytes:
        knobs = self.knobs
        arrived = self._faulty[0].carry(self.to_robot.take(now_s), now_s)
        if arrived and knobs.cable and knobs.to_robot and not knobs.frozen:
            self.robot.receive_bytes(arrived, self.robot_s)  # which makes it due
        return arrived

    def _robot_turn(self, now_s: float, cycle_ends: bool) -> None:
        """Send the robot's next frame, or let it watch its lease, if that is due; run its cycle."""
        robot, robot_s = self._robot, self.robot_s
        if self._robot_due_s <= now_s:
            if not self.to_host.free(now_s):
                robot.controller.tick(robot_s)
            elif frame := robot.next_frame(robot_s):
                self.to_host.put(frame, now_s)
        if cycle_ends:
            robot.controller.step(robot_s, *self.drive.encoders_m)
        self.wheels = robot.controller.wheels
        quiet_s = robot.quiet_s() / (1.0 + self.robot_clock_drift)
        self._robot_due_s = max(self.to_host.free_s, now_s + quiet_s)

    def _bytes_to_host(self, now_s: float) -> None:
        arrived = self._faulty[1].carry(self.to_host.take(now_s), now_s)
        if arrived and self.knobs.cable:
            self._unread += arrived[: TTY_BYTES - len(self._unread)]

    def _host_reads(self, now_s: float) -> None:
        if not self._unread:
            return
        unread, self._unread = bytes(self._unread), bytearray()
        self._host.receive_bytes(unread, now_s)
        if 0 in unread:  # the end of a frame: nothing else makes the host answer
            self._host_due_s = now_s

    def _host_turn(self, now_s: float) -> None:
        """Send the host's next frame, and take its news."""
        host = self._host
        host.tick(now_s)
        data = host.bytes_to_send(now_s)
        if data:
            self.to_robot.put(data, now_s)
        self._host_due_s = now_s if data else host.deadline_s(now_s)
        while (event := host.next_event()) is not None:
            self.events.append(event)
