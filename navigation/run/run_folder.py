"""The folder that a run leaves: its report, and a picture of the tracks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import datetime
from itertools import pairwise
from pathlib import Path

import numpy as np

from navigation.draw import DrawError, DrawnRobot, OtherRobot, save_picture
from navigation.loop.daemon import Daemon
from navigation.loop.robot import ControlledRobot
from navigation.loop.run_state import DrivenPlan
from navigation.loop.stages import stations_of
from navigation.run.run_report import RunReport
from navigation.run.summary import driven_track
from navigation.shared.track import driven_pieces, with_breaks
from navigation.shared.whole_file import UnwrittenFileError
from planner.borders.polyline import arc_lengths, points_at
from planner.scene import FloatArray
from planner.zones.zone import zones_for
from planner.zones.zoned_roadmap import with_zones

REACH_SHARE, REACH_M = 1.1, 0.02
"""Reach of a robot along its plan: a share of its driven length, and metres more."""
ANYTHING_M_S = 10.0
"""Tracks of other robots, whose speed is unknown, break only where they were not seen."""
STRETCH_STEP_M = 0.005
"""Distance of points along the driven stretches of replaced plans."""


def make_run_folder(runs_dir: Path, now: datetime) -> Path:
    """Make a folder named after the time, numbered if the name is taken."""
    name = now.strftime("%Y-%m-%d_%H-%M-%S")
    for number in range(1, 1000):
        folder = runs_dir / (name if number == 1 else f"{name}_{number}")
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            continue
        return folder
    raise FileExistsError(f"{runs_dir / name}: a thousand runs began in this second")


def write_report(folder: Path, report: RunReport) -> list[str]:
    """Write ``report.json``; return the error, if any."""
    try:
        report.write(folder / "report.json")
    except UnwrittenFileError as error:
        return [str(error)]
    return []


def write_run(folder: Path, daemon: Daemon, report: RunReport) -> list[str]:
    """Write ``report.json``, and ``track.svg`` if a scene was seen; return the errors."""
    troubles = write_report(folder, report)
    try:
        write_picture(folder / "track.svg", daemon, report)
    except DrawError as error:
        troubles.append(str(error))
    return troubles


def prepare_picture(daemon: Daemon) -> None:
    """Make the roadmap's graph for the picture: 0.2 s the first time."""
    if daemon.roadmap is not None:
        _ = daemon.roadmap.graph


def write_picture(file: Path, daemon: Daemon, report: RunReport) -> None:
    """Draw zones, roadmap, plans and tracks if a scene was seen; ``DrawError`` on failure.

    The roadmap is that of the search, around keep-out zones for all robots. The track of a real
    robot is the camera's. Each robot has its colour.
    """
    if daemon.scene is None:
        return
    others = [
        OtherRobot(
            f"robot {one.marker_id}",
            one.radius_m,
            with_breaks(
                driven_pieces(daemon.view.others.tracks[one.marker_id].rows(), ANYTHING_M_S)
            )[:, 1:],
        )
        for one in daemon.config.other_robots
    ]
    title, zones = f"Clearway: {report.state}", daemon.zones.zones()
    roadmap = None
    if daemon.roadmap is not None:
        roadmap = with_zones(daemon.roadmap, zones_for(zones, "")).closed
    if "" not in daemon.robots:
        driven = [_driven(name, robot, daemon) for name, robot in daemon.robots.items()]
        save_picture(
            file,
            daemon.scene,
            roadmap,
            driven=driven,
            others=others,
            zones=zones,
            title=title,
        )
        return
    robot = daemon.robot
    track = driven_track(daemon, robot)
    stations = [
        (s.x, s.y) if s.heading_rad is None else (s.x, s.y, s.heading_rad)
        for s in stations_of(daemon.config)
    ]
    fastest_m_s = robot.config.robot.speed_m_s
    first = [tuple(track[0, 1:4])] if len(track) else []
    plans = list(robot.plans)
    save_picture(
        file,
        daemon.scene,
        roadmap,
        plans[-1].path if plans else None,
        track=with_breaks(driven_pieces(track, fastest_m_s))[:, 1:3],
        earlier=driven_stretches(plans, track, fastest_m_s),
        others=others,
        stations=[*first, *stations],
        zones=zones,
        title=title,
    )


def _driven(name: str, robot: ControlledRobot, daemon: Daemon) -> DrawnRobot:
    body = robot.config.robot
    pieces = driven_pieces(driven_track(daemon, robot), body.speed_m_s)
    stations = robot.pilot.mission.stations
    return DrawnRobot(
        name,
        body.radius_m,
        with_breaks(pieces)[:, 1:],
        [(station.x, station.y) for station in stations],
        robot.plans[-1].path.points if robot.plans else np.empty((0, 2)),
    )


def driven_stretches(
    plans: Sequence[DrivenPlan], track: FloatArray, fastest_m_s: float
) -> list[FloatArray]:
    """Driven points (n, 2) of every plan but the last, up to its replacement.

    ``track`` (k, 4) of seconds, x_m, y_m, heading_rad. Where a plan crosses itself, the driven
    length decides.
    """
    stretches = []
    for plan, following in pairwise(plans):
        rows = track[(track[:, 0] >= plan.since_s) & (track[:, 0] <= following.since_s)]
        if len(rows) < 2:
            continue
        lengths = arc_lengths(plan.path.points)
        driven_m = sum(arc_lengths(p[:, 1:3])[-1] for p in driven_pieces(rows, fastest_m_s))
        reach = min(REACH_SHARE * driven_m + REACH_M, lengths[-1])
        at = np.linspace(0.0, reach, math.ceil(reach / STRETCH_STEP_M) + 1)
        along = points_at(plan.path.points, lengths, at)
        stretches.append(along[: int(np.hypot(*(along - rows[-1, 1:3]).T).argmin()) + 1])
    return stretches
