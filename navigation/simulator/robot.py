"""A simulated robot in real time: a twin behind a line, on simulated wheels.

A thread steps twin and wheels and carries bytes to and from a pseudo-terminal like a UART: at the
line's pace and with its faults. The host opens :attr:`SimulatedRobot.port` with pyserial, like a
cable.

The fault ``reset`` boots the processor again; ``freeze`` stops it: the motors keep their last
order, and the UART keeps RING_BYTES from the host.
"""

from __future__ import annotations

import contextlib
import math
import os
import select
import struct
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
import serial
from numpy.typing import NDArray

from firmware_protocol.robot.controller import WheelSpeeds
from navigation.link.port_faults import PORT_FAULTS
from navigation.link.serial_port import open_port
from navigation.shared.system import require_linux
from navigation.shared.track import Track
from navigation.simulator.drive_model import Drive, DriveModel, TruePose
from navigation.simulator.line_faults import FaultSpec, FaultyLine
from navigation.simulator.own_time import OwnTime
from navigation.simulator.twins.clearway import ClearwayTwin
from navigation.simulator.twins.kinds import refuse_frame_faults, wheels_of
from navigation.simulator.twins.twin import ON_FOR_S, STEP_S, Twin
from navigation.simulator.virtual_loop import PacedLine

TRACK_EVERY: Final = 10
"""Steps to a row of the track: 20 ms."""
POSES_KEPT: Final = 250
"""Steps of 2 ms whose poses are known: a camera's thread may be late by half a second."""
READ_BYTES: Final = 4096
RING_BYTES: Final = 256
"""Receive buffer of a small processor."""
FASTEST_BAUD: Final = 4_000_000
LONGEST_WAIT_S: Final = 0.1


class SimulatedRobot:
    """A robot on a new pseudo-terminal, or on an existing serial port; a context manager.

    ``pose`` is (x_m, y_m, heading_rad) at the start; ``twin`` is our own robot by default; ``baud``
    paces the line, by default as the twin does (infinity: at once); ``rng`` drives motion and
    faults. PortError if ``port`` cannot be opened, FaultSpecError for faults that this line cannot
    have, NeedsLinuxError on other systems.
    """

    def __init__(
        self,
        pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
        *,
        rng: np.random.Generator,
        twin: Twin | None = None,
        model: DriveModel | None = None,
        faults: FaultSpec | None = None,
        port: str | None = None,
        baud: float | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        require_linux("a simulated robot on a line")
        self.twin: Twin = twin or ClearwayTwin(model=model)
        self.held = threading.Lock()
        """Held during each step, and by any thread that reads or changes the twin."""
        self._clock = clock
        self._faults = faults or FaultSpec()
        if not self.twin.has_frames:
            refuse_frame_faults(self._faults)
        model = model or DriveModel(track_m=self.twin.body.track_m)
        self._drive = Drive(wheels_of(self.twin, model), TruePose(*pose), rng)
        self._lines = (FaultyLine(self._faults, rng), FaultyLine(self._faults, rng))
        baud = baud or self.twin.baud
        self._to_robot, self._to_host = PacedLine(baud), PacedLine(baud)
        self._wheels = WheelSpeeds(0.0, 0.0, powered=False)
        self._zero = (0, 0)
        self._steps = 0
        self._time = OwnTime(STEP_S)
        self._start_s = 0.0
        self._is_reset = self._is_unplugged = False
        self._waiting = self._unsent = b""
        self._unread_since_s = math.inf
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._track = Track()
        self._poses: deque[tuple[float, TruePose]] = deque(maxlen=POSES_KEPT)
        self._serial: serial.Serial | None = None
        self._fd = self._slave = -1
        self.port = self._open(port, baud)

    def _open(self, port: str | None, baud: float) -> str:
        if port is None:
            import tty  # only Unix has it

            self._fd, self._slave = os.openpty()
            tty.setraw(self._slave)
            port = os.ttyname(self._slave)
        else:
            self._serial = open_port(port, round(min(baud, FASTEST_BAUD)))
            self._fd = self._serial.fileno()
        os.set_blocking(self._fd, False)
        return port

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

    def __exit__(self, *_exc: object) -> None:
        self.stop()

    def pose(self) -> TruePose:
        """Present true pose; waits for a robot whose thread is behind."""
        return self.pose_at(self._clock())

    def pose_at(self, at_s: float) -> TruePose:
        """True pose at a moment of the clock, at most ``POSES_KEPT`` steps ago.

        A camera's thread that gets no processor between the exposure and its look at the robot
        must not see a later place. Waits for a robot whose thread is behind.
        """
        self._time.wait_for(at_s)
        with self.held:
            for time_s, pose in reversed(self._poses):
                if time_s <= at_s:
                    return pose
            return self._poses[0][1] if self._poses else self._drive.pose

    @property
    def moving(self) -> bool:
        """True if a wheel turns faster than 1 mm/s."""
        return self._drive.moving

    def track(self) -> NDArray[np.float64]:
        """True track: (n, 4) of time, x_m, y_m, heading_rad, every 20 ms."""
        return self._track.rows()

    def late_since_s(self) -> float:
        """Time since which the robot has due steps or the host unread bytes; infinity while off."""
        return min(self._time.since_s, self._unread_since_s)

    def bump(self, pressed: bool = True) -> None:
        """Touch or release its bumper, or its emergency stop."""
        with self.held:
            self.twin.bump(pressed)

    def lift(self, lifted: bool = True) -> None:
        """Take it off the floor, or put it back."""
        with self.held:
            self.twin.lift(lifted)

    def unplug(self, unplugged: bool = True) -> None:
        """Cut both directions of its cable, or join them; its power stays on."""
        with self.held:
            self._is_unplugged = unplugged

    def _run(self) -> None:
        try:
            while not self._stop.is_set():
                wait_until_due([self], self.turn())
        finally:
            self.switched_off()

    def switched_on(self) -> None:
        """Switch on, driven by its own thread or by a caller of :meth:`turn`."""
        self._start_s = self._clock()
        self.twin.boot(self._start_s - ON_FOR_S)
        self._time.begin(self._start_s)

    def switched_off(self) -> None:
        """Switch off."""
        self._time.end()
        self._unread_since_s = math.inf

    def fileno(self) -> int:
        """Descriptor at which the host's bytes arrive."""
        return self._fd

    def turn(self) -> float:
        """Do all due steps and exchange bytes; return the seconds until the next step."""
        now_s = self._clock()
        self._time.limit(now_s)
        while (end_s := self._time.next_step_s(now_s)) is not None:
            with self.held:
                self._exchange(end_s)
                self._step(end_s)
            self._time.done(end_s)
        with self.held:
            self._exchange(now_s)
        return self._time.due_in_s(self._clock())

    def _is_frozen(self, now_s: float) -> bool:
        since_s = now_s - self._start_s - self._faults.freeze_at_s
        return 0.0 <= since_s < self._faults.freeze_s

    def _meet_reset(self, now_s: float) -> None:
        if not self._is_reset and now_s - self._start_s >= self._faults.reset_at_s:
            self._is_reset = True
            left, right = self._ticks()
            self._zero = (self._zero[0] + left, self._zero[1] + right)
            self._waiting = b""
            self._wheels = WheelSpeeds(0.0, 0.0, powered=False)
            self.twin.boot(now_s)

    def _exchange(self, now_s: float) -> None:
        self._meet_reset(now_s)
        data = self._read()
        if data and not self._is_unplugged:
            self._to_robot.put(data, self._clock())  # behind the clock, so it has to wait
        self._waiting += self._lines[0].carry(self._to_robot.take(now_s), now_s)
        if self._is_frozen(now_s):
            self._waiting = self._waiting[:RING_BYTES]
        else:
            self._serve(now_s)
        self._write(self._lines[1].carry(self._to_host.take(now_s), now_s))
        self._look_whether_the_host_reads(now_s)

    def _serve(self, now_s: float) -> None:
        if self._waiting:
            self.twin.receive(self._waiting, now_s)
            self._waiting = b""
        while self._to_host.free(now_s):
            data = self.twin.bytes_to_send(now_s)
            if not data:
                break
            self._to_host.put(data, now_s)

    def _read(self) -> bytes:
        try:
            return os.read(self._fd, READ_BYTES)
        except OSError:
            return b""  # no bytes, or the other end hung up: a robot ignores both

    def _write(self, data: bytes) -> None:
        self._unsent = (self._unsent + data)[-READ_BYTES:]
        if self._is_unplugged:
            self._unsent = b""
        if self._unsent:
            try:
                self._unsent = self._unsent[os.write(self._fd, self._unsent) :]
            except OSError:
                self._unsent = b""  # no reader: a UART does not wait either

    def _look_whether_the_host_reads(self, now_s: float) -> None:
        if not self._waits_in_the_line():
            self._unread_since_s = math.inf
        elif self._unread_since_s == math.inf:
            self._unread_since_s = now_s

    def _waits_in_the_line(self) -> bool:
        if self._slave < 0:
            return False
        import fcntl  # only Unix has them
        import termios

        (count,) = struct.unpack("i", fcntl.ioctl(self._slave, termios.FIONREAD, b"\0" * 4))
        return bool(count)

    def _ticks(self) -> tuple[int, int]:
        per_m = self.twin.body.ticks_per_m
        left_m, right_m = self._drive.encoders_m
        return round(left_m * per_m) - self._zero[0], round(right_m * per_m) - self._zero[1]

    def _step(self, now_s: float) -> None:
        if not self._is_frozen(now_s):
            self._wheels = self.twin.step(now_s, *self._ticks())
        self._drive.step(STEP_S, self._wheels)
        self._poses.append((now_s, self._drive.pose))
        self._steps += 1
        if self._steps % TRACK_EVERY == 0:
            self._track.add(now_s, *self._drive.pose)


def wait_until_due(robots: Sequence[SimulatedRobot], wait_s: float) -> None:
    """Wait until bytes arrive for a robot, at most ``wait_s``."""
    wait_s = min(wait_s, LONGEST_WAIT_S)
    try:
        select.select(robots, [], [], wait_s)
    except (*PORT_FAULTS, ValueError):  # a closed line is not a file
        time.sleep(wait_s)  # the error came at once, and the caller would not pause
