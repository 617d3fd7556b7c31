"""What a finished run comes to: the report, and the folder that it leaves behind.

Clearance, tracking and goal errors come from the simulation's truth where there is one, else
from what the camera saw. Units: metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import datetime
from itertools import pairwise
from pathlib import Path

import numpy as np

from navigation.draw import DrawError, OtherRobot, save_picture
from navigation.loop.daemon import Daemon
from navigation.loop.daemon_state import DrivenPlan
from navigation.loop.robot import Robot
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from navigation.run.report import (
    FrameCounts,
    Latency,
    LinkCounts,
    Report,
    percentiles_ms,
    rms_and_max,
    tracking_error,
)
from navigation.shared.track import driven_pieces, with_breaks
from navigation.shared.whole_file import UnwrittenFileError
from navigation.simulator.truth import Truth
from planner.borders.polyline import arc_lengths, points_at
from planner.roadmap.roadmap import Roadmap
from planner.scene import FloatArray

REACH_SHARE, REACH_M = 1.1, 0.02
"""How far along its plan a robot may have come, as a share of the length it drove, and more."""
ANYTHING_M_S = 10.0
"""How fast other robots drive nobody knows: their tracks break only where they were not seen."""
STRETCH_STEP_M = 0.005
"""Driven stretches of replaced plans are drawn with a point this often."""


def summarise(daemon: Daemon, robot: Robot, state: State, reason: str, duration_s: float) -> Report:
    """One robot's report, from everything that the daemon kept."""
    track = driven_track(daemon, robot)
    pieces = driven_pieces(track, robot.config.robot.speed_m_s)
    snapshot, camera = robot.link.snapshot(), daemon.camera.status()
    mission = robot.pilot.mission
    truth = daemon.world.truths.get(robot.name)
    goal_m, goal_deg = _goal_error(robot, track)
    return Report(
        state=state.value if state in (State.DONE, State.FAILED) else State.STOPPED.value,
        reason=reason,
        stations=len(mission.stations),
        stations_visited=mission.visited,
        waypoints_sent=robot.pilot.waypoints_sent,
        waypoints_executed=robot.pilot.waypoints_executed,
        replans=robot.pilot.replans,
        min_clearance_m=_least_clearance_m(truth, daemon.roadmap, pieces),
        track_jumps=max(0, len(pieces) - 1),
        tracking_error_m=rms_and_max(_tracking(robot, track)),
        goal_error_m=goal_m,
        goal_error_deg=goal_deg,
        duration_s=duration_s,
        link=LinkCounts(
            frames=snapshot.sent.frames_sent,
            bytes=snapshot.sent.bytes_sent,
            retransmits=snapshot.sent.retransmits,
            crc_errors=snapshot.received.crc_errors,
            rtt_ms=None if snapshot.rtt_s is None else snapshot.rtt_s * 1e3,
        ),
        frames=FrameCounts(camera.captured, camera.dropped, daemon.processed),
        latency_ms=Latency(percentiles_ms(list(robot.link.capture_to_wire_s))),
        ground_truth=truth is not None,
    )


def driven_track(daemon: Daemon, robot: Robot) -> FloatArray:
    """(n, 4) of seconds, x_m, y_m, heading_rad: the truth where simulated, else the sightings."""
    truth = daemon.world.truths.get(robot.name)
    return robot.sightings.rows() if truth is None else truth.track()


def make_run_folder(runs_dir: Path, now: datetime) -> Path:
    """A new folder named after the time; a second run in one second gets a number."""
    name = now.strftime("%Y-%m-%d_%H-%M-%S")
    for number in range(1, 1000):
        folder = runs_dir / (name if number == 1 else f"{name}_{number}")
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            continue
        return folder
    raise FileExistsError(f"{runs_dir / name}: a thousand runs began in this second")


def prepare_picture(daemon: Daemon) -> None:
    """Have the roadmap's graph made, which the picture wants: 0.2 s the first time."""
    if daemon.roadmap is not None:
        _ = daemon.roadmap.graph


def write_run(folder: Path, daemon: Daemon, report: Report) -> list[str]:
    """``report.json``, and ``track.svg`` where a scene was seen; why one could not be written."""
    troubles = write_report(folder, report)
    try:
        _write_picture(folder / "track.svg", daemon, report)
    except DrawError as error:
        troubles.append(str(error))
    return troubles


def write_report(folder: Path, report: Report) -> list[str]:
    """``report.json``; why it could not be written."""
    try:
        report.write(folder / "report.json")
    except UnwrittenFileError as error:
        return [str(error)]
    return []


def _write_picture(file: Path, daemon: Daemon, report: Report) -> None:
    if daemon.scene is None:
        return
    robot = daemon.robot
    track = driven_track(daemon, robot)
    stations = [
        (s.x, s.y) if s.heading_rad is None else (s.x, s.y, s.heading_rad)
        for s in stations_of(daemon.config)
    ]
    fastest_m_s = daemon.config.robot.speed_m_s
    first = [tuple(track[0, 1:4])] if len(track) else []
    plans = list(robot.plans)
    save_picture(
        file,
        daemon.scene,
        daemon.roadmap,
        plans[-1].path if plans else None,
        track=with_breaks(driven_pieces(track, fastest_m_s))[:, 1:3],
        earlier=driven_stretches(plans, track, fastest_m_s),
        others=[
            OtherRobot(
                f"robot {one.marker_id}",
                one.radius_m,
                with_breaks(
                    driven_pieces(daemon.others.tracks[one.marker_id].rows(), ANYTHING_M_S)
                )[:, 1:],
            )
            for one in daemon.config.other_robots
        ],
        stations=[*first, *stations],
        title=f"Clearway: {report.state}",
    )


def driven_stretches(
    plans: Sequence[DrivenPlan], track: FloatArray, fastest_m_s: float
) -> list[FloatArray]:
    """Of every plan but the last the points (n, 2) up to where the robot was when it was replaced.

    ``track`` (k, 4) of seconds, x_m, y_m, heading_rad. A plan that crosses itself ends at the
    pass that the length driven can have reached.
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


def _least_clearance_m(
    truth: Truth | None, roadmap: Roadmap | None, pieces: Sequence[FloatArray]
) -> float | None:
    if truth is not None:
        return min((truth.track_clearance(piece) for piece in pieces), default=None)
    if roadmap is None:
        return None
    ways = (roadmap.path_clearance(piece[:, 1:3]) for piece in pieces)
    return min((way.distance for way in ways), default=None)


def _tracking(robot: Robot, track: FloatArray) -> FloatArray:
    """Each position's distance from the plan that was driven at its time."""
    errors = []
    plans = list(robot.plans)
    ends = [*(plan.since_s for plan in plans[1:]), math.inf]
    for plan, end_s in zip(plans, ends, strict=False):
        rows = track[(track[:, 0] >= plan.since_s) & (track[:, 0] < end_s)]
        errors.append(tracking_error(rows[:, 1:3], plan.path.points))
    return np.concatenate(errors) if errors else np.empty(0)


def _goal_error(robot: Robot, track: FloatArray) -> tuple[float | None, float | None]:
    stations = robot.pilot.mission.stations
    if not stations or not len(track):
        return None, None
    goal, (_, x, y, heading) = stations[-1], track[-1]
    off_deg = None
    if goal.heading_rad is not None:
        off_deg = abs(math.degrees(math.remainder(heading - goal.heading_rad, math.tau)))
    return math.dist((x, y), (goal.x, goal.y)), off_deg
