"""Several robots as the dashboard takes what it shows: one summary, and each robot beside it.

The summary is that of the whole run: the state and sentence of all together, the picture, the
roadmap, and the link that needs looking after most. Metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from navigation.config import Config
from navigation.control import Commanded
from navigation.link.link_snapshot import LinkSnapshot, doubt_of_stop
from navigation.loop.daemon_state import DaemonState
from navigation.loop.fleet.fleet_daemon import FleetDaemon
from navigation.loop.fleet.fleet_state import FleetState
from navigation.loop.fleet.people import People
from navigation.mission.cycle import PlanAnswer
from navigation.mission.mission import Mission, MissionError, Station
from vision.calibration.calibration import Calibration
from vision.camera.latest_frame import CameraStatus


class ShownFleet:
    """A daemon of several robots as `Shown`; ``people`` takes the orders."""

    def __init__(self, daemon: FleetDaemon, people: People | None = None) -> None:
        self._daemon, self._people = daemon, people or People(daemon)
        self._summary: tuple[FleetState, DaemonState] | None = None
        self.config: Config = daemon.config
        self.calibration: Calibration = daemon.world.calibration

    @property
    def fleet(self) -> FleetState | None:
        """Each robot, as of the cycle that `state` was asked for last."""
        return None if self._summary is None else self._summary[0]

    @property
    def state(self) -> DaemonState | None:
        """The summary of the last cycle."""
        now = self._daemon.state
        if now is None:
            return None
        if self._summary is None or self._summary[0] is not now:
            self._summary = now, summary_of(now)
        return self._summary[1]

    def camera_status(self) -> CameraStatus:
        """What the camera does."""
        return self._daemon.camera.status()

    def last_wire_s(self) -> float | None:
        """The slowest of all robots' newest times from capture to wire."""
        each = (seat.link.capture_to_wire_s for seat in self._daemon.seats.values())
        return max((times_s[-1] for times_s in each if times_s), default=None)

    def preview(self, stations: tuple[Station, ...], robot: str | None = None) -> PlanAnswer:
        """What one robot would drive if it were alone."""
        if robot is None:
            raise MissionError("there are several robots: say which one goes")
        return self._people.preview(stations, robot)

    def of(self, robot: str) -> Commanded:
        """One of the robots; ``MissionError`` where there is none of that name."""
        return self._people.of(robot)

    def give(self, stations: tuple[Station, ...]) -> None:
        """Refused: one of the robots has to be named."""
        self._people.give(stations)

    def stop(self, reason: str) -> None:
        """Emergency stop of all."""
        self._people.stop(reason)

    def pause(self) -> None:
        """Hold all."""
        self._people.pause()

    def resume(self) -> None:
        """End all pauses, re-arm all that were stopped."""
        self._people.resume()

    def replan(self) -> None:
        """Plan again for all."""
        self._people.replan()

    def settle(self) -> None:
        """Return when the orders so far were acted on."""
        self._people.settle()

    def describe(self) -> Mapping[str, Any]:
        """The present state, each robot by name in ``robots``."""
        return self._people.describe()


def summary_of(fleet: FleetState) -> DaemonState:
    """All robots as one state, without a place, stations or a path of its own."""
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
