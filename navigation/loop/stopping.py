"""Stops and re-arms of robots: past every queue, kept on disk until a person re-arms.

Any thread may call these.
"""

from __future__ import annotations

from collections.abc import Sequence
from threading import Lock

from navigation.journal.kept_stops import KeptStops
from navigation.loop.robot import ControlledRobot
from navigation.mission.mission import MissionError, State


class Stopping:
    """Stops robots; ``kept`` stores stops on disk, if any are stored."""

    def __init__(self, lock: Lock) -> None:
        self._lock = lock
        self.kept: KeptStops | None = None

    @property
    def waits_for_rearm(self) -> bool:
        """True if a stop from before this run has not been lifted."""
        return self.kept is not None and bool(self.kept.held)

    @property
    def trouble(self) -> str:
        """Warning about stops that are not on disk, if any."""
        trouble = "" if self.kept is None else self.kept.trouble
        return f"a restart would not know whether robots are stopped: {trouble}" if trouble else ""

    def end(self) -> None:
        """Write what is left, after the last stop."""
        if self.kept is not None:
            self.kept.close()

    def hold_from_before(
        self, robots: Sequence[ControlledRobot], kept: KeptStops
    ) -> dict[str, str]:
        """Stop the robots held by earlier stops; return the sentences by name."""
        self.kept = kept
        said = dict(kept.held)
        with self._lock:  # stops since orders are taken
            stopped = {one.name: one.pilot.stop_reason for one in robots}
        for name, reason in stopped.items():
            if reason is not None:
                kept.stop([name], reason)
        for robot in robots:
            if robot.name in said:
                robot.link.estop()
                with self._lock:
                    robot.pilot.begin_stopped(said[robot.name])
        return said

    def stop(self, robots: Sequence[ControlledRobot], reason: str) -> str | None:
        """Send a stop to the links past every queue, then latch and store it.

        Returns a sentence if the stop is not on disk.
        """
        for robot in robots:
            robot.link.estop()
        with self._lock:
            for robot in robots:
                robot.pilot.stop(reason)
        if self.kept is None:
            return None
        self.kept.stop([robot.name for robot in robots], reason)
        trouble = self.kept.settled()
        return f"a restart would not know of this stop: {trouble}" if trouble else None

    def stopped_itself(self, robot: ControlledRobot) -> None:
        """Store a stop that the pilot entered; the control loop does not wait."""
        if self.kept is not None:
            self.kept.stop([robot.name], robot.pilot.stopped_by)

    def resume(self, robots: Sequence[ControlledRobot]) -> None:
        """End a pause; re-arm after a stop, and continue at the next call.

        ``MissionError`` if a stop came meanwhile.
        """
        with self._lock:
            stopped = [one for one in robots if one.pilot.mission.state is State.STOPPED]
        if self.kept is not None and stopped:
            self.kept.lift([one.name for one in stopped])
            self.kept.settled()  # a stop left on disk is reported, and is the safer error
        with self._lock:
            if self.kept is not None and any(self.kept.is_kept(one.name) for one in stopped):
                raise MissionError("stopped again meanwhile: re-arm it again")
            for robot in robots:
                robot.pilot.resume()
