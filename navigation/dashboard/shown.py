"""What the dashboard needs of the running program, and the daemon seen that way."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final, Protocol

from navigation.config import Config
from navigation.link.link_snapshot import LinkSnapshot, doubt_of_stop
from navigation.loop.daemon import Daemon
from navigation.loop.daemon_state import DaemonState, RunState
from navigation.loop.people import People
from navigation.mission.mission import Mission
from vision.calibration.calibration import Calibration
from vision.camera.latest_frame import CameraStatus

IT_IS_A_RECORDING: Final = "this is a recording: nothing here drives or stops a robot"
"""The refusal of any order in a recording."""


class Shown(Protocol):
    """A run on the page, and the target of its orders; any thread may call every method."""

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
    def fleet(self) -> RunState | None:
        """Of several robots each, as of the same cycle as `state`; None where there is one."""
        ...

    def camera_status(self) -> CameraStatus:
        """What the camera does."""
        ...

    def last_wire_s(self) -> float | None:
        """The newest time from capture to wire; None before the first."""
        ...

    @property
    def people(self) -> People | None:
        """The target of orders; None for a recording."""
        ...


class ShownDaemon:
    """A daemon as `Shown`."""

    def __init__(self, daemon: Daemon) -> None:
        self._daemon = daemon
        self._summary: tuple[RunState, DaemonState] | None = None
        self.config: Config = daemon.config
        self.calibration: Calibration = daemon.world.calibration

    @property
    def fleet(self) -> RunState | None:
        """Of several robots each, as of the cycle that `state` was asked for last."""
        return None if self._summary is None else self._summary[0]

    @property
    def state(self) -> DaemonState | None:
        """What the last cycle ended with, of several robots a summary."""
        now = self._daemon.state
        if now is None:
            return None
        if "" in now.robots:
            return now.only
        if self._summary is None or self._summary[0] is not now:
            self._summary = now, summary_of(now)
        return self._summary[1]

    def camera_status(self) -> CameraStatus:
        """What the camera does."""
        return self._daemon.camera.status()

    def last_wire_s(self) -> float | None:
        """The slowest of all robots' newest times from capture to wire."""
        each = (one.link.capture_to_wire_s for one in self._daemon.robots.values())
        return max((times_s[-1] for times_s in each if times_s), default=None)

    @property
    def people(self) -> People:
        """The target of orders: the daemon's."""
        return self._daemon.people


def summary_of(fleet: RunState) -> DaemonState:
    """All robots as one state, without a place, stations or a path of its own.

    The link is that which needs looking after most.
    """
    each = list(fleet.robots.values())
    # the one of which least is known, above all whether it stands after a stop
    link = max((one.link for one in each), key=_unknown)
    paused = all(one.mission.paused for one in each)
    return replace(
        each[0],
        mission=Mission(state=fleet.state, reason=fleet.sentence, paused=paused),
        sentence=fleet.sentence,
        pose=None,
        link=link,
        to_go_m=None,
        clearance_m=None,
        path=None,
    )


def _unknown(link: LinkSnapshot) -> tuple[bool, bool, float]:
    return doubt_of_stop(link) is not None, link.down_reason is not None, _age_s(link)


def _age_s(link: LinkSnapshot) -> float:
    return math.inf if math.isnan(link.heard_age_s) else float(link.heard_age_s)
