"""The picture that a run of several robots leaves behind: each robot's track in its own colour."""

from __future__ import annotations

from pathlib import Path

from navigation.draw import DrivenRobot, save_picture
from navigation.loop.daemon import Daemon
from navigation.run.fleet.fleet_report import FleetReport
from navigation.run.summary import driven_track
from navigation.shared.track import driven_pieces, with_breaks


def write_picture(file: Path, daemon: Daemon, report: FleetReport) -> None:
    """Write it where a scene was seen; ``DrawError`` where that cannot be done.

    Tracks of robots that are not simulated are where the camera saw them. Without the roadmap,
    whose colours are those of clearances.
    """
    if daemon.scene is None:
        return
    driven = []
    for name, seat in daemon.robots.items():
        track = driven_track(daemon, seat)
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
