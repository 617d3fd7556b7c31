"""What a run tells the machine it runs on, after each cycle: log, watchdog, troubles recording.

It decides nothing and opens nothing; every sentence is told once, when it becomes true.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from navigation.logs import RunLog
from navigation.sd_notify import Watchdog

if TYPE_CHECKING:
    from navigation.daemon import Daemon, DaemonState
    from navigation.recorder import Recorder


class Attendance:
    """Looks at a daemon after each of its cycles; `cycle`."""

    def __init__(
        self, daemon: Daemon, log: RunLog, watchdog: Watchdog, recorder: Recorder | None
    ) -> None:
        self._daemon, self._log = daemon, log
        self._watchdog, self._recorder = watchdog, recorder
        self._hanging: tuple[str, ...] = ()
        self._said_drops = False
        self._said_end = False

    def cycle(self, now: DaemonState, time_s: float) -> None:
        """After a cycle that ended with ``now`` at ``time_s`` of the run's clock."""
        self._log.cycle(now, self._daemon.camera.status())
        self._watchdog.tick(time_s)
        if self._watchdog.hanging != self._hanging:
            self._hanging = self._watchdog.hanging
            self._log.write("error", "watchdog", stages=", ".join(self._hanging) or "none")
        self._look_at_the_recording()

    def _look_at_the_recording(self) -> None:
        if self._recorder is None:
            return
        counts = self._recorder.counts()
        if counts.dropped and not self._said_drops:
            self._said_drops = True
            reason = "the writer lags: pictures are dropped and counted"
            self._log.write("warning", "recording", reason=reason)
        if counts.failed and not self._said_end:
            self._said_end = True
            self._log.write("error", "recording", reason=f"ended early: {counts.failed}")
