"""A twin in real time: on a new pseudo-terminal or an existing serial port, on simulated wheels.

The host opens :attr:`TwinRobot.port` as it would open a cable to the real robot. The true pose and
the driven track are for the simulated camera and the report.
"""

from __future__ import annotations

import contextlib
import os
import threading
import time
import tty
from collections.abc import Callable
from types import TracebackType

import numpy as np
import serial
from numpy.typing import NDArray

from firmware_protocol.robot.controller import WheelSpeeds
from navigation.link.serial_link import PORT_FAULTS
from navigation.link.serial_port import open_port
from navigation.shared.track import Track
from navigation.simulator.drive_model import Drive, DriveModel, TruePose
from navigation.simulator.line_faults import FaultSpec, FaultyLine
from navigation.simulator.own_time import OwnTime
from navigation.simulator.twins.kinds import TWINS, refuse_frame_faults, wheels_of
from navigation.simulator.twins.twin import ON_FOR_S
from navigation.simulator.virtual_loop import PacedLine

STEP_S = 0.002
TRACK_EVERY = 10
"""Steps to a row of the track: 20 ms."""
READ_BYTES = 4096


class TwinRobot:
    """A robot of ``kind`` (`TWINS`) from outside; a context manager that switches it on and off.

    ``pose`` is (x_m, y_m, heading_rad) at the start; ``rng`` moves the robot and its faults;
    ``port`` is an existing serial port, None makes a pseudo-terminal. PortError where ``port``
    cannot be opened, FaultSpecError for faults that this line cannot have.
    """

    def __init__(
        self,
        kind: str,
        pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
        *,
        rng: np.random.Generator,
        model: DriveModel | None = None,
        faults: FaultSpec | None = None,
        port: str | None = None,
        baud: int | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.twin = TWINS[kind]()
        self._clock = clock
        self._faults = faults or FaultSpec()
        refuse_frame_faults(self._faults)
        model = model or DriveModel(track_m=self.twin.body.track_m)
        self._ticks_per_m = self.twin.body.ticks_per_m
        self._drive = Drive(wheels_of(self.twin, model), TruePose(*pose), rng)
        self._lines = (FaultyLine(self._faults, rng), FaultyLine(self._faults, rng))
        self._to_robot, self._to_host = (PacedLine(baud or self.twin.baud) for _ in range(2))
        self._wheels = WheelSpeeds(0.0, 0.0, powered=False)
        self._zero = (0, 0)
        self._steps = 0
        self._time = OwnTime(STEP_S)
        self._start_s = 0.0
        self._reset_done = self._unplugged = False
        self._unsent = b""
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._lock = threading.Lock()
        self._track = Track()
        self._serial: serial.Serial | None = None
        self._slave = -1
        if port is None:
            self._fd, self._slave = os.openpty()
            tty.setraw(self._slave)
            self.port = os.ttyname(self._slave)
        else:
            self._serial = open_port(port, baud or self.twin.baud)
            self._fd = self._serial.fileno()
            self.port = port
        os.set_blocking(self._fd, False)

    # Life.

    def start(self) -> None:
        """Switch the robot on."""
        self._start_s = self._clock()
        self.twin.boot(self._start_s - ON_FOR_S)
        self._time.begin(self._start_s)
        self._thread = threading.Thread(target=self._run, name="robot's twin", daemon=True)
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

    def __enter__(self) -> TwinRobot:
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

    def track(self) -> NDArray[np.float64]:
        """Where it has been: (n, 4) of time, x_m, y_m, heading_rad, every 20 ms."""
        return self._track.rows()

    @property
    def moving(self) -> bool:
        """Whether a wheel turns faster than 1 mm/s."""
        return self._drive.moving

    # What a person does to it.

    def bump(self, pressed: bool = True) -> None:
        """Touch its bumper, or let go of it."""
        with self._lock:
            self.twin.bump(pressed)

    def lift(self, lifted: bool = True) -> None:
        """Take it off the floor, or put it back."""
        with self._lock:
            self.twin.lift(lifted)

    def unplug(self, unplugged: bool = True) -> None:
        """Cut both directions of its cable, or join them again; its power stays on."""
        with self._lock:
            self._unplugged = unplugged

    # The thread.

    def _run(self) -> None:
        try:
            while not self._stop.is_set():
                now_s = self._clock()
                self._time.limit(now_s)
                while (end_s := self._time.next_step_s(now_s)) is not None:
                    with self._lock:
                        self._exchange(end_s)
                        self._step(end_s)
                    self._time.done(end_s)
                self._stop.wait(self._time.due_in_s(self._clock()))
        finally:
            self._time.end()

    def _frozen(self, now_s: float) -> bool:
        since_s = now_s - self._start_s - self._faults.freeze_at_s
        return 0.0 <= since_s < self._faults.freeze_s

    def _exchange(self, now_s: float) -> None:
        if not self._reset_done and now_s - self._start_s >= self._faults.reset_at_s:
            self._reset_done = True
            self._reset(now_s)
        data = self._read()
        if data and not self._unplugged:
            self._to_robot.put(data, self._clock())  # behind the clock, it has to wait
        arrived = self._lines[0].carry(self._to_robot.take(now_s), now_s)
        if not self._frozen(now_s):
            if arrived:
                self.twin.receive(arrived, now_s)
            while self._to_host.free(now_s):
                data = self.twin.bytes_to_send(now_s)
                if not data:
                    break
                self._to_host.put(data, now_s)
        self._write(self._lines[1].carry(self._to_host.take(now_s), now_s))

    def _reset(self, now_s: float) -> None:
        ticks = self._ticks()
        self._zero = (self._zero[0] + ticks[0], self._zero[1] + ticks[1])
        self.twin.boot(now_s)

    def _read(self) -> bytes:
        try:
            return os.read(self._fd, READ_BYTES)
        except OSError:
            return b""  # nothing came, or the other end has hung up: a robot does not mind

    def _write(self, data: bytes) -> None:
        self._unsent = (self._unsent + data)[-READ_BYTES:]
        if self._unplugged:
            self._unsent = b""
        if self._unsent:
            try:
                self._unsent = self._unsent[os.write(self._fd, self._unsent) :]
            except OSError:
                self._unsent = b""  # nobody reads: a UART does not wait either

    def _ticks(self) -> tuple[int, int]:
        left_m, right_m = self._drive.encoders_m
        left, right = round(left_m * self._ticks_per_m), round(right_m * self._ticks_per_m)
        return left - self._zero[0], right - self._zero[1]

    def _step(self, now_s: float) -> None:
        if not self._frozen(now_s):
            self._wheels = self.twin.step(now_s, *self._ticks())
        self._drive.step(STEP_S, self._wheels)
        self._steps += 1
        if self._steps % TRACK_EVERY == 0:
            self._track.add(now_s, *self._drive.pose)
