"""Watch over a driver: its process has the robot while its heart beats, else the daemon has.

- A process hangs if its last beat is older than ``BEAT_MISSED_S``. It is killed, and the daemon at
  once repeats the maker's stop on its own descriptor of the port.
- A new process starts when the robot reports rest, the port is closed, or the robot answers that it
  cannot be driven. It gets the port when it is ready.
- At the end the process has ``LEAVE_S`` to say farewell. The daemon always has the last word, until
  the robot reports rest or ``LAST_WORDS_S`` have passed.

Sans-IO except for the given port and process. Seconds of one monotonic clock, shared by the
processes.
"""

from __future__ import annotations

import math
from typing import Final, Protocol

from navigation.link.drivers.robot_halt import RobotHalt
from navigation.link.drivers.robot_port import RobotPort
from navigation.link.drivers.word_of_robot import Word

BEAT_MISSED_S: Final = 0.2
"""A turn of the driver's loop takes a few milliseconds; it waits 5 ms at most."""
START_S: Final = 30.0
"""Longest start of a process on a busy machine; until its first beat it has no port."""
AGAIN_S: Final = 0.1
"""Pause before a process that has ended is started again."""
LEAVE_S: Final = 1.0
LAST_WORDS_S: Final = 1.0


class Drives(Protocol):
    """The driver's process, or none."""

    @property
    def beat_s(self) -> float:
        """Time of its loop's last beat; -inf before the first."""

    def start(self) -> str | None:
        """Start a new one; return the reason if that fails."""

    def runs(self) -> bool:
        """True while there is one, even one about to end."""

    def how_it_ended(self) -> str:
        """Words for the end of one that does not run."""

    def ask_to_end(self) -> None:
        """Ask it to say farewell."""

    def kill(self) -> None:
        """Stop it at once, whatever it does."""

    def lend(self, descriptor: int) -> bool:
        """Give it the port; True if it was taken."""


class DriverWatch:
    """One robot, its port and its driver's process; call `turn` often."""

    def __init__(self, process: Drives, port: RobotPort, halt: RobotHalt, title: str) -> None:
        self._process, self._port, self._halt = process, port, halt
        self._driver = f"the driver of the {title}"
        self._why = f"{self._driver} is being started"
        self._told = Word(silence=self._why)
        self._runs = self._is_lent = self._was_lent = False
        self._started_s = self._killed_s = -math.inf
        self._halted_s = self._ending_s = math.inf
        self._again_s = -math.inf
        self.restarts = 0

    # Reports of the driver's process.

    def hears(self, word: Word) -> None:
        """Take its sentences about its robot."""
        self._told = word

    def loses_port(self, reason: str, now_s: float) -> None:
        """Note that its lent port has broken."""
        self._is_lent = False
        self._port.lose(reason, now_s)

    # State.

    @property
    def has_port(self) -> bool:
        """True if the daemon itself reads and writes the robot's port now."""
        return not self._is_lent and self._port.fault is None

    def word(self, now_s: float) -> Word:
        """Newest sentences about the robot."""
        if self._is_lent:
            return self._told
        if self._port.fault is not None:
            return Word(self._port.fault)
        return self._halt.word(self._why, now_s)

    def doubt(self, now_s: float) -> str | None:
        """Reason why the driven robot is not known to be at rest; None if it is."""
        if not self._was_lent or (self.has_port and self._halt.stands(now_s)):
            return None
        return self._halt.doubt

    # Time.

    def turn(self, now_s: float) -> None:
        """Do everything that is due."""
        if self._runs:
            self._look_at_process(now_s)
        if not self._is_lent:
            self._stop_robot(now_s)
            self._lend_port()
        if not self._runs and self._may_start(now_s):
            self._start(now_s)

    def end(self, now_s: float) -> None:
        """Begin the end of the program; call `turn` until `is_over`."""
        self._ending_s = now_s
        if self._runs:
            self._process.ask_to_end()

    def is_over(self, now_s: float) -> bool:
        """True if nothing is left to do for the robot at the end."""
        if self._runs or self._ending_s == math.inf:
            return False
        closed = self._port.fault is not None
        waited = now_s - max(self._ending_s, self._killed_s) >= LAST_WORDS_S
        return closed or not self._was_lent or self._halt.stands(now_s) or waited

    # Inside.

    def _look_at_process(self, now_s: float) -> None:
        process = self._process
        if not process.runs():
            self._take_over(f"{self._driver} {process.how_it_ended()}", now_s)
            return
        beat_s, limit_s = process.beat_s, BEAT_MISSED_S
        if beat_s == -math.inf:
            beat_s, limit_s = self._started_s, START_S
        if now_s - beat_s > limit_s:
            why = f"did nothing for {limit_s:g} s and was ended"
        elif now_s - self._ending_s > LEAVE_S:
            why = f"did not end within {LEAVE_S:g} s and was ended"
        else:
            return
        process.kill()
        self._take_over(f"{self._driver} {why}", now_s)

    def _take_over(self, why: str, now_s: float) -> None:
        """Take the robot: nothing queued by the process goes out any more."""
        self._runs, self._why = False, why
        self._killed_s, self._again_s = now_s, now_s + AGAIN_S
        if self._ending_s == math.inf:
            self.restarts += 1
        if self._is_lent:
            self._is_lent = False
            self._port.drop_unsent(now_s)
            self._halt.begin(now_s)

    def _stop_robot(self, now_s: float) -> None:
        port, halt = self._port, self._halt
        if self._ending_s == math.inf and port.open(now_s):
            halt.begin(now_s)
        halt.receive(port.read(now_s), now_s)
        port.write(halt.bytes_to_send(now_s) if port.is_free else b"", now_s)

    def _lend_port(self) -> None:
        descriptor = self._port.fileno()
        ready = self._runs and self._process.beat_s > -math.inf and self._ending_s == math.inf
        if ready and descriptor is not None and self._process.lend(descriptor):
            self._is_lent = self._was_lent = True
            self._told = Word(silence=self._why)

    def _may_start(self, now_s: float) -> bool:
        if self._ending_s < math.inf or now_s < self._again_s or self._process.runs():
            return False
        if not self._was_lent or self._port.fault is not None:
            return True
        return self._halt.stands(now_s) or self._halt.is_held

    def _start(self, now_s: float) -> None:
        refused = self._process.start()
        if refused is not None:
            self._why = f"{self._driver} cannot be started: {refused}"
            self._again_s = now_s + AGAIN_S
            return
        self._runs, self._started_s = True, now_s
        if self.restarts:
            self._why = f"{self._why.partition(';')[0]}; it is started again"
