"""The simulated robot with its real firmware: an emulated microcontroller drives the model.

The same face as the simulated robot. A thread runs the emulator in real
time: what the host sends into the pseudo-terminal goes to the emulated UART, which takes it at
its true baud rate; the motor outputs drive the simulated wheels; their travel turns the
emulated encoders. Which settings the robot has is compiled into its firmware. Where the machine
is busy the emulator falls behind and catches up; no byte comes to it before its time.

Of the faults, ``reset`` pulls the processor's reset line; ``freeze`` stops its clock, and with it
its watchdog: the motors keep what they were told, and what the host sends meanwhile is lost.
"""

from __future__ import annotations

import math
import os
import select
import threading
import time
import tty
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.robot.controller import WheelSpeeds
from navigation.simulator.drive_model import Drive, DriveModel, TruePose
from navigation.simulator.emulated_processor import EmulatedProcessor, EmulatorError, Motors
from navigation.simulator.line_faults import FaultSpec, FaultyLine
from navigation.simulator.own_time import OwnTime

STEP_S = 0.002
"""The emulator and the drive model go on by turns of this length."""
TRACK_EVERY = 10
READ_BYTES = 4096


class EmulatedRobot:
    """A robot on a new pseudo-terminal whose processor is ``command``, an emulator.

    ``command`` speaks the protocol of :mod:`emulated_processor`; ``pose`` is (x_m, y_m,
    heading_rad) at the start; ``rng`` moves the robot and its faults. EmulatorError where the
    program cannot be started; when it ends, the robot stands and the line is silent.
    """

    def __init__(
        self,
        command: Sequence[str | Path],
        pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
        *,
        rng: np.random.Generator,
        model: DriveModel | None = None,
        faults: FaultSpec | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._clock = clock
        self._processor = EmulatedProcessor(command)
        self._drive = Drive(model or DriveModel(), TruePose(*pose), rng)
        self._faults = spec = faults or FaultSpec()
        self._lines = (FaultyLine(spec, rng), FaultyLine(spec, rng))
        self._encoders_m = (0.0, 0.0)
        self._steps = 0
        self._time = OwnTime(STEP_S)
        self._arrived: deque[tuple[float, bytes]] = deque()
        self._start_s = math.inf
        self._reset_done = False
        self._track: list[tuple[float, float, float, float]] = []
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._fd, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._fd, False)
        self.port = os.ttyname(self._slave)
        self.motors = Motors(0.0, 0.0, False, 0.0, 0.0)

    @property
    def lost_s(self) -> float:
        """How much of the clock's time the emulator was too slow for."""
        return self._time.lost_s

    def start(self) -> None:
        """Switch the robot on, in a thread of its own."""
        self.begin()
        self._time.begin(self._start_s)
        self._thread = threading.Thread(target=self._run, name="emulated robot", daemon=True)
        self._thread.start()

    def begin(self) -> None:
        """Switch it on for one who calls :meth:`step` himself."""
        self._start_s = self._clock()

    def stop(self) -> None:
        """Switch it off; its end of the line is closed then."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        self._processor.close()
        if self._fd >= 0:
            os.close(self._fd)
            os.close(self._slave)
        self._fd = -1

    def pose(self) -> TruePose:
        """Where the robot is now; for any thread. Waits for an emulator that is behind."""
        self._time.wait_for(self._clock())
        return self._drive.pose

    def track(self) -> NDArray[np.float64]:
        """Where it has been: (n, 4) of time, x_m, y_m, heading_rad, every 20 ms."""
        with self._lock:
            return np.array(self._track, dtype=np.float64).reshape(-1, 4)

    def _run(self) -> None:
        try:
            while not self._stop.is_set():
                now_s = self._clock()
                self._time.limit(now_s)
                while (end_s := self._time.next_step_s(now_s)) is not None:
                    self.step(end_s)
                    self._time.done(end_s)
                self._stop.wait(self._time.due_in_s(self._clock()))
        except EmulatorError:
            return
        finally:
            self._time.end()

    def step(self, now_s: float) -> None:
        """The next STEP_S, which end now; EmulatorError where the program has ended."""
        arrived = self._lines[0].carry(self._arrived_by(now_s), now_s)
        encoders_m = self._drive.encoders_m
        travel = (encoders_m[0] - self._encoders_m[0], encoders_m[1] - self._encoders_m[1])
        self._encoders_m = encoders_m
        data = b""
        if not self._is_frozen(now_s):
            reset = self._is_reset(now_s)
            self.motors, data = self._processor.run(STEP_S, arrived, travel, reset)
        wheels = WheelSpeeds(self.motors.left_m_s, self.motors.right_m_s, self.motors.powered)
        self._drive.step(STEP_S, wheels)
        self._write(self._lines[1].carry(data, now_s))
        self._steps += 1
        if self._steps % TRACK_EVERY == 0:
            with self._lock:
                self._track.append((now_s, *self._drive.pose))

    def _is_frozen(self, now_s: float) -> bool:
        since_s = now_s - self._start_s - self._faults.freeze_at_s
        return 0.0 <= since_s < self._faults.freeze_s

    def _is_reset(self, now_s: float) -> bool:
        """True once, at the time of the fault."""
        due = now_s - self._start_s >= self._faults.reset_at_s and not self._reset_done
        self._reset_done = self._reset_done or due
        return due

    def _arrived_by(self, now_s: float) -> bytes:
        """What came in up to that time of the clock: behind it, the newest has to wait."""
        if data := self._read():
            self._arrived.append((self._clock(), data))
        parts = []
        while self._arrived and self._arrived[0][0] <= now_s:
            parts.append(self._arrived.popleft()[1])
        return b"".join(parts)

    def _read(self) -> bytes:
        if not select.select([self._fd], [], [], 0.0)[0]:
            return b""
        try:
            return os.read(self._fd, READ_BYTES)
        except OSError:
            return b""  # the other end has hung up: a robot does not mind

    def _write(self, data: bytes) -> None:
        if data and select.select([], [self._fd], [], 0.0)[1]:
            try:
                os.write(self._fd, data)
            except OSError:
                return  # nobody reads: a UART does not wait either
