"""The picture that a run of several robots leaves behind: each robot's track in its own colour."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from navigation.draw import DrivenRobot, save_picture
from navigation.loop.fleet.fleet_daemon import FleetDaemon
from navigation.run.fleet.fleet_report import FleetReport
from navigation.shared.track import driven_pieces, with_breaks
from navigation.simulator.truth import Truth


def write_picture(
    file: Path, daemon: FleetDaemon, truths: Mapping[str, Truth], report: FleetReport
) -> None:
    """Write it where a scene was seen; ``DrawError`` where that cannot be done.

    ``truths`` of the simulated robots; tracks of others are where the camera saw them. Without the
    roadmap, whose colours are those of clearances.
    """
    if daemon.scene is None:
        return
    driven = []
    for name, seat in daemon.seats.items():
        track = truths[name].track() if name in truths else seat.sightings.rows()
        pieces = driven_pieces(track, seat.config.robot.speed_m_s)
        stations = seat.pilot.mission.stations
        driven.append(
            DrivenRobot(
                name,
                seat.config.robot.radius_m,
                with_breaks(pieces)[:, 1:],
                [(station.x, station.y) for station in stations],
            )
        )
    title = f"Clearway: {report.state}"
    save_picture(file, daemon.scene, driven=driven, title=title)
