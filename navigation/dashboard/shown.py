"""What the dashboard needs of the running program, and the daemon seen that way."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from navigation.config import Config
from navigation.control import Commanded
from navigation.loop.daemon import Daemon
from navigation.loop.daemon_state import DaemonState
from navigation.loop.fleet.fleet_state import FleetState
from navigation.mission.cycle import PlanAnswer
from navigation.mission.mission import MissionError, Station
from navigation.shared.outside import in_short
from vision.calibration.calibration import Calibration
from vision.camera.latest_frame import CameraStatus


class Shown(Commanded, Protocol):
    """What is shown and takes orders; every method may be called from any thread."""

    @property
    def config(self) -> Config:
        """What runs."""
        ...

    @property
    def calibration(self) -> Calibration:
        """Where pixels lie on the floor."""
        ...

    @property
    def state(self) -> DaemonState | None:
        """What the last cycle ended with; None before the first."""
        ...

    @property
    def fleet(self) -> FleetState | None:
        """Of several robots each, as of the same cycle as `state`; None where there is one."""
        ...

    def camera_status(self) -> CameraStatus:
        """What the camera does."""
        ...

    def last_wire_s(self) -> float | None:
        """The newest time from capture to wire; None before the first."""
        ...

    def preview(self, stations: tuple[Station, ...], robot: str | None = None) -> PlanAnswer:
        """The plan that these stations would lead to; ``MissionError`` where no robot is named so.

        ``robot``: which of several.
        """
        ...


class ShownDaemon:
    """A daemon as `Shown`."""

    fleet = None

    def __init__(self, daemon: Daemon) -> None:
        self._daemon = daemon
        self.config: Config = daemon.config
        self.calibration: Calibration = daemon.world.calibration

    @property
    def state(self) -> DaemonState | None:
        """What the last cycle ended with."""
        return self._daemon.state

    def camera_status(self) -> CameraStatus:
        """What the camera does."""
        return self._daemon.camera.status()

    def last_wire_s(self) -> float | None:
        """The newest time from capture to wire."""
        times_s = self._daemon.link.capture_to_wire_s
        return times_s[-1] if times_s else None

    def preview(self, stations: tuple[Station, ...], robot: str | None = None) -> PlanAnswer:
        """The plan that these stations would lead to."""
        if robot is not None:
            raise MissionError(f"robot {in_short(robot)}: this run has one robot, without a name")
        return self._daemon.preview(stations)

    def give(self, stations: tuple[Station, ...]) -> None:
        """A new mission."""
        self._daemon.give(stations)

    def stop(self, reason: str) -> None:
        """Emergency stop."""
        self._daemon.stop(reason)

    def pause(self) -> None:
        """Hold."""
        self._daemon.pause()

    def resume(self) -> None:
        """End a pause; after a stop re-arm, and the next time go on."""
        self._daemon.resume()

    def replan(self) -> None:
        """Plan anew."""
        self._daemon.replan()

    def settle(self) -> None:
        """Return when the orders so far were acted on."""
        self._daemon.settle()

    def describe(self) -> Mapping[str, Any]:
        """The present state."""
        return self._daemon.describe()
