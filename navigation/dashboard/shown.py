"""The running program as the dashboard sees it: a daemon, or a recording."""

from __future__ import annotations

from typing import Final, Protocol

from navigation.config import Config
from navigation.loop.people import People
from navigation.loop.run_state import RunState
from planner.zones.zone import Zone
from vision.calibration.calibration import Calibration
from vision.camera.latest_frame import CameraStatus

IT_IS_A_RECORDING: Final = "this is a recording: nothing here drives or stops a robot"


class ShownZones(Protocol):
    """The zones of a run; any thread may read them."""

    def zones(self) -> tuple[Zone, ...]:
        """Return all of them."""

    @property
    def revision(self) -> int:
        """Number that changes with the zones."""


class Shown(Protocol):
    """A run on the page, and the target of its orders; any thread may call every method."""

    @property
    def config(self) -> Config:
        """Configuration of the run."""

    @property
    def calibration(self) -> Calibration:
        """Mapping from pixels to the floor."""

    @property
    def state(self) -> RunState | None:
        """State at the end of the last cycle, a new object each time; None before the first."""

    def camera_status(self) -> CameraStatus:
        """The camera's state, rate and counts."""

    @property
    def zones(self) -> ShownZones:
        """The zones in force, or of the moment shown."""

    @property
    def people(self) -> People | None:
        """The target of orders; None for a recording."""
