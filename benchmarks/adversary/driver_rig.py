"""A run whose robot is behind a maker's driver, a process that the program starts and watches.

Such a robot hears no permits: it has to stand soon after its driver's last sign of life, which
comes every few milliseconds until the signal that takes the driver away. Seconds are monotonic.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import time
from pathlib import Path

import numpy as np

from benchmarks.adversary.bars import (
    END_LIMIT_S,
    LAG_S,
    Outcome,
    judge_driver,
    speeds,
    stood_after_s,
    way_to_rest_m,
)
from benchmarks.adversary.processes import ProcessError, children, lives
from benchmarks.adversary.rig import Needs, Rig
from benchmarks.adversary.scene import Errand
from planner.scene import FloatArray
from tests.support.waiting import wait_until

SPEED_SHARE = 0.8
"""Share of its configured speed that the robot has reached when its driver is attacked."""
RESTS_WITHIN_S = 0.1
"""A robot that is said to be stopped: the last millimetre, and the judge's own sampling."""
GONE_WITHIN_S = 2.0
PATIENCE_S = 60.0
"""With what has to come before an attack on a busy computer; nothing is measured by it."""


class DriverRig(Rig):
    """A `Rig` for attacks whose needs name a driver."""

    def __init__(self, folder: Path, errand: Errand, needs: Needs, seed: int) -> None:
        super().__init__(folder, errand, needs, seed)
        self.ended = False
        """The program was ended by SIGTERM, in place of an order to stop."""
        self._hurt_s: float | None = None
        self._watched: set[int] = set()
        """Processes that have to be gone at the end."""
        self._things.callback(self._end_watched)

    def driver(self) -> int | None:
        """The driver's process; None between one that was ended and the next."""
        mine = children(self.daemon.popen.pid)
        return next((pid for pid, words in mine.items() if "spawn_main" in words), None)

    def at_speed(self) -> None:
        """Wait until the robot drives fast and straight on."""
        fast_m_s = SPEED_SHARE * self.config.robot.speed_m_s
        if not wait_until(lambda: self._speed_m_s() >= fast_m_s, PATIENCE_S):
            raise ProcessError(f"the robot never had its speed: {self.status()}")

    def hurt(self, number: signal.Signals) -> None:
        """Send a signal to the driver while the robot drives; the first is what counts."""
        pid = self._driver_at_speed()
        self._hurt_s = time.monotonic()
        os.kill(pid, number)
        self._watched.add(pid)

    def _driver_at_speed(self) -> int:
        """The process that drives a robot fast; a loaded computer may have ended one before it."""
        until_s = time.monotonic() + PATIENCE_S
        while time.monotonic() < until_s:
            self.at_speed()
            pid = self.driver()
            if pid is not None:
                return pid
        raise ProcessError("the robot never drove fast with a driver that lives")

    def end_program(self) -> None:
        """End it by SIGTERM, as a service manager does."""
        program = self.daemon
        self._watched.update(children(program.popen.pid))
        self.ended, self.stop_ordered_s = True, time.monotonic()
        program.signal(signal.SIGTERM)
        with contextlib.suppress(subprocess.TimeoutExpired):
            program.popen.wait(2.0 * END_LIMIT_S)
            self.stop_s = time.monotonic() - self.stop_ordered_s
        self.end = "ended", f"the program ended with code {program.popen.returncode}"

    def judge(self, outcome: Outcome, rows: FloatArray) -> None:
        """The driver's bar in place of the permit's; truth of the answer; nothing left running."""
        assert self._hurt_s is not None
        times, speed = speeds(rows)
        fastest = float(speed[(times > self._hurt_s - 0.3) & (times < self._hurt_s + 0.1)].max())
        outcome.drove_s = max(0.0, way_to_rest_m(rows, self._hurt_s) / fastest - LAG_S)
        told_s = next((at_s for at_s, state in self.said if state == "stopped"), None)
        if told_s is not None and (moved_s := stood_after_s(rows, told_s)) > RESTS_WITHIN_S:
            outcome.failures.append(f'drove for {moved_s:.2f} s after the answer "stopped"')
        if not wait_until(lambda: not any(map(lives, self._watched)), GONE_WITHIN_S):
            outcome.failures.append("a driver that hangs is still there")
        judge_driver(outcome, self.ended)

    def _speed_m_s(self) -> float:
        """Over the last tenth of a second."""
        rows = self.truth.rows()
        last = rows[rows[:, 0] > rows[-1, 0] - 0.1] if len(rows) else rows
        if len(last) < 2:
            return 0.0
        return float(np.hypot(*(last[-1, 1:3] - last[0, 1:3])) / (last[-1, 0] - last[0, 0]))

    def _end_watched(self) -> None:
        """One that sleeps does not notice that its program has ended."""
        for pid in filter(lives, self._watched):
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
