"""The simulated robot: the robot's end in Python behind a real pseudo-terminal.

A thread runs the robot's end of the link, its controller at 100 steps a second and the moving
robot in real time. The host opens :attr:`SimulatedRobot.port` with pyserial, as it would open
a cable. The true pose and the driven track are for the simulated camera and the report.
"""

from __future__ import annotations

import contextlib
import fcntl
import math
import os
import random
import select
import struct
import termios
import threading
import time
import tty
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import TracebackType

import numpy as np
import serial
from numpy.typing import NDArray

from firmware_protocol.robot.connection import Identity, RobotConnection
from firmware_protocol.robot.controller import RobotController, WheelSpeeds
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.messages import ResetCause, RobotState, StopReason
from navigation.link.serial_link import PORT_FAULTS
from navigation.link.serial_port import open_port
from navigation.shared.track import Track
from navigation.simulator.drive_model import Drive, DriveModel, TruePose
from navigation.simulator.line_faults import FaultSpec, FaultyLine
from navigation.simulator.own_time import OwnTime
from navigation.simulator.virtual_loop import PacedLine

PHYSICS_S = 0.002
CONTROL_EVERY = 5
"""Physics steps to one control cycle: 10 ms."""
INSTANT_BAUD = 100_000_000


@dataclass(frozen=True, slots=True)
class RobotView:
    """What can be seen of the simulated robot from outside."""

    pose: TruePose
    moving: bool
    state: RobotState
    reason: StopReason
    mission: int
    executed: int
    exec_crc: int


class SimulatedRobot:
    """A robot on a new pseudo-terminal, or on an existing serial port; a context manager.

    ``pose`` is (x_m, y_m, heading_rad) at the start; ``baud`` paces the line, None lets bytes
    pass at once; ``rng`` moves the robot and its faults, ``boot_ids`` gives each boot its
    number. PortError where ``port`` cannot be opened.
    """

    def __init__(
        self,
        pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
        *,
        rng: np.random.Generator,
        model: DriveModel | None = None,
        settings: DriveSettings | None = None,
        faults: FaultSpec | None = None,
        port: str | None = None,
        baud: int | None = 115_200,
        boot_ids: random.Random | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._clock = clock
        self._settings = settings or DriveSettings()
        self._boot_ids = boot_ids or random.SystemRandom()
        self._faults = faults or FaultSpec()
        self._drive = Drive(model or DriveModel(), TruePose(*pose), rng)
        self._lines = (FaultyLine(self._faults, rng), FaultyLine(self._faults, rng))
        self._to_robot = PacedLine(baud or INSTANT_BAUD)
        self._to_host = PacedLine(baud or INSTANT_BAUD)
        self._wheels = WheelSpeeds(0.0, 0.0, powered=False)
        self._steps = 0
        self._time = OwnTime(PHYSICS_S)
        self._unsent = b""
        self._unread_since_s = math.inf
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._track = Track()
        self._serial: serial.Serial | None = None
        self._slave = -1
        if port is None:
            self._fd, self._slave = os.openpty()
            tty.setraw(self._slave)
            self.port = os.ttyname(self._slave)
        else:
            self._serial = open_port(port, baud or 115_200)
            self._fd = self._serial.fileno()
            self.port = port
        os.set_blocking(self._fd, False)
        self._boot(ResetCause.POWER_ON)
        self._view = self._look()

    def _boot(self, cause: ResetCause) -> None:
        controller = RobotController(self._settings)
        identity = Identity(self._boot_ids.randrange(1, 1 << 32), reset_cause=cause)
        self._robot = RobotConnection(identity, controller)
        self._wheels = WheelSpeeds(0.0, 0.0, powered=False)

    # Life.

    def start(self) -> None:
        """Switch the robot on, in a thread of its own."""
        self.switched_on()
        self._thread = threading.Thread(target=self._run, name="simulated robot", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Switch it off and close its end of the line."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        if self._serial is not None:
            with contextlib.suppress(*PORT_FAULTS):
                self._serial.close()
            self._serial = None
        elif self._fd >= 0:
            os.close(self._fd)
            os.close(self._slave)
        self._fd = -1

    def __enter__(self) -> SimulatedRobot:
        self.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    # What is true, for any thread.

    def pose(self) -> TruePose:
        """Where the robot is now; waits for a robot whose thread is behind."""
        self._time.wait_for(self._clock())
        return self._drive.pose

    def late_since_s(self) -> float:
        """What is later than this the robot has still to do, or the host to read; infinity while
        it is off."""
        return min(self._time.since_s, self._unread_since_s)

    def view(self) -> RobotView:
        """Pose, state and progress now."""
        return self._view

    def track(self) -> NDArray[np.float64]:
        """Where it has been: (n, 4) of time, x_m, y_m, heading_rad, every 20 ms."""
        return self._track.rows()

    def press_estop(self) -> None:
        """Press the emergency stop on the robot itself."""
        self._robot.controller.emergency_stop(StopReason.ESTOP_LOCAL)

    # The thread.

    def _run(self) -> None:
        try:
            while not self._stop.is_set():
                wait_until_due([self], self.turn())
        finally:
            self.switched_off()

    def switched_on(self) -> None:
        """It is driven from now on: by its own thread, or by who calls :meth:`turn`."""
        self._start_s = self._clock()
        self._time.begin(self._start_s)

    def switched_off(self) -> None:
        """Nobody drives it any more."""
        self._time.end()
        self._unread_since_s = math.inf

    def fileno(self) -> int:
        """What the host's bytes arrive at."""
        return self._fd

    def turn(self) -> float:
        """Make all steps that are due, and exchange bytes; how long until the next, seconds."""
        now_s = self._clock()
        self._time.limit(now_s)
        while (end_s := self._time.next_step_s(now_s)) is not None:
            self._exchange(end_s)
            self._step(end_s)
            self._time.done(end_s)
        self._exchange(now_s)
        self._view = self._look()
        return self._time.due_in_s(self._clock())

    def _meet_scheduled_faults(self, now_s: float) -> None:
        if now_s - self._start_s >= self._faults.reset_at_s and not self._reset_done:
            self._reset_done = True
            self._boot(ResetCause.EXTERNAL)

    _reset_done = False
    _start_s = 0.0

    def _frozen(self, now_s: float) -> bool:
        since_s = now_s - self._start_s - self._faults.freeze_at_s
        return 0.0 <= since_s < self._faults.freeze_s

    def _exchange(self, now_s: float) -> None:
        self._meet_scheduled_faults(now_s)
        if self._frozen(now_s):
            return
        try:
            data = os.read(self._fd, 4096)
        except BlockingIOError:
            data = b""
        except OSError:
            return  # the other end has hung up: a robot does not mind
        if data:
            self._to_robot.put(data, self._clock())  # behind the clock, it has to wait
        arrived = self._lines[0].carry(self._to_robot.take(now_s), now_s)
        if arrived:
            self._robot.receive_bytes(arrived, now_s)
        self._robot.controller.tick(now_s)
        while self._to_host.free(now_s):
            frame = self._robot.next_frame(now_s)
            if not frame:
                break
            self._to_host.put(frame, now_s)
        self._unsent += self._lines[1].carry(self._to_host.take(now_s), now_s)
        if self._unsent:
            try:
                self._unsent = self._unsent[os.write(self._fd, self._unsent) :]
            except BlockingIOError:
                self._unsent = b""  # nobody reads: a UART does not wait either
            except OSError:
                self._unsent = b""
        self._look_whether_the_host_reads(now_s)

    def _look_whether_the_host_reads(self, now_s: float) -> None:
        if not self._waits_in_the_line():
            self._unread_since_s = math.inf
        elif self._unread_since_s == math.inf:
            self._unread_since_s = now_s

    def _waits_in_the_line(self) -> bool:
        """True if bytes lie in the pseudo-terminal that the host has not read."""
        if self._slave < 0:
            return False
        (count,) = struct.unpack("i", fcntl.ioctl(self._slave, termios.FIONREAD, b"\0" * 4))
        return bool(count)

    def _step(self, now_s: float) -> None:
        self._steps += 1
        if self._steps % CONTROL_EVERY == 0 and not self._frozen(now_s):
            self._robot.controller.step(now_s, *self._drive.encoders_m)
        if not self._frozen(now_s):
            self._wheels = self._robot.controller.wheels
        self._drive.step(PHYSICS_S, self._wheels)
        if self._steps % (2 * CONTROL_EVERY) == 0:
            self._track.add(now_s, *self._drive.pose)

    def _look(self) -> RobotView:
        control = self._robot.controller
        return RobotView(
            pose=self._drive.pose,
            moving=self._drive.moving,
            state=control.state,
            reason=control.reason,
            mission=control.mission,
            executed=control.exec_next,
            exec_crc=control.exec_crc,
        )


def wait_until_due(robots: Sequence[SimulatedRobot], wait_s: float) -> None:
    """Until bytes arrive for one of the robots, or so long."""
    try:
        select.select(robots, [], [], wait_s)
    except (*PORT_FAULTS, ValueError):  # a line that was closed is no file any more
        time.sleep(wait_s)  # nothing is left to wait on but the next step
