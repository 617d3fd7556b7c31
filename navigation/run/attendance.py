"""News of a run after each cycle: log, watchdog, troubles, recording.

Each sentence is said once, when it becomes true.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Final

from firmware_protocol.host.state import LinkState
from navigation.machine.logs import Level, RunLog
from navigation.machine.sd_notify import Watchdog
from navigation.run.trouble_lines import TroubleLines, troubles_of

if TYPE_CHECKING:
    from navigation.loop.daemon import Daemon
    from navigation.loop.recorder import Recorder
    from navigation.loop.run_state import RobotSnapshot, RunState
    from vision.camera.latest_frame import CameraStatus


RECORDER_SILENT_S: Final = 3.0
"""A recorder's thread that has not turned for this time hangs."""


class Attendance:
    """Observer of a daemon's cycles; ``say`` gets lines for the terminal."""

    def __init__(
        self,
        daemon: Daemon,
        log: RunLog,
        watchdog: Watchdog,
        recorder: Recorder | None,
        say: Callable[[str], None],
    ) -> None:
        self._daemon, self._log = daemon, log
        self._watchdog, self._recorder = watchdog, recorder
        self._say = say
        self._hanging: tuple[str, ...] = ()
        self._said_drops = False
        self._said_end = False
        self._said_silence = False
        self._troubles = TroubleLines(log, say)
        self._waits_for: dict[str, bool] = {}
        self._waits_for_camera = False
        self._recorder_turns = -1
        self._recorder_turned_s = 0.0

    def cycle(self, now: RunState, time_s: float) -> None:
        """Report a cycle that ended with ``now`` at the monotonic ``time_s``."""
        camera = self._daemon.camera.status()
        self._log.cycle(now.robots, camera)
        for name, one in now.robots.items():
            self._look_at_robot(name, one)
        self._look_at_camera(camera)
        self._daemon.troubles["log"] = self._log.trouble
        self._troubles.cycle(troubles_of(now))
        self._watchdog.tick(time_s)
        if self._watchdog.hanging != self._hanging:
            self._hanging = self._watchdog.hanging
            self._log.write("error", "watchdog", stages=", ".join(self._hanging) or "none")
        if self._recorder is not None and not self._said_end:
            self._look_at_the_recording(self._recorder, time_s)

    def _look_at_robot(self, name: str, now: RobotSnapshot) -> None:
        waits = now.link.state is LinkState.CLOSED
        if waits != self._waits_for.get(name, False):
            self._waits_for[name] = waits
            reason = now.link.down_reason
            waiting = f"waiting for {name}" if name else "waiting for the robot"
            is_open = f"{name or 'the robot'}'s serial port is open"
            self._say(f"{waiting}: {reason}" if waits else is_open)

    def _look_at_camera(self, camera: CameraStatus) -> None:
        if camera.state == ("running" if self._waits_for_camera else "lost"):
            self._waits_for_camera = not self._waits_for_camera
            self._say(
                f"waiting for the camera: {camera.reason}"
                if self._waits_for_camera
                else "the camera gives pictures"
            )

    def _look_at_the_recording(self, recorder: Recorder, time_s: float) -> None:
        counts = recorder.counts()
        if counts.dropped and not self._said_drops:
            self._said_drops = True
            self._tell("warning", "the writer lags: pictures are dropped and counted")
        if recorder.has_ended():
            self._said_end = True
            self._tell("error", f"ended early: {counts.failed or 'its thread has died'}")
            return
        if recorder.turns != self._recorder_turns:
            self._recorder_turns, self._recorder_turned_s = recorder.turns, time_s
            self._said_silence = False
        elif time_s - self._recorder_turned_s > RECORDER_SILENT_S and not self._said_silence:
            self._said_silence = True
            silent_s = time_s - self._recorder_turned_s
            waiting = counts.waiting
            self._tell("error", f"hangs: nothing written for {silent_s:.0f} s, {waiting} wait")

    def _tell(self, level: Level, reason: str) -> None:
        self._log.write(level, "recording", reason=reason)
        self._say(f"recording: {reason}")
