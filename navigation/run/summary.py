"""One robot's report of a finished run, by the simulation's truth, else the camera's sightings.

Metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from navigation.loop.daemon import Daemon
from navigation.loop.robot import ControlledRobot
from navigation.mission.mission import State
from navigation.run.robot_report import (
    FrameCounts,
    Latencies,
    LinkCounts,
    Report,
    percentiles_ms,
    rms_and_max,
    tracking_error,
)
from navigation.shared.track import driven_pieces
from navigation.simulator.truth import Truth
from planner.roadmap.roadmap import Roadmap
from planner.scene import FloatArray


def summarise(
    daemon: Daemon, robot: ControlledRobot, state: State, reason: str, duration_s: float
) -> Report:
    """Make the report from what the daemon kept."""
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
        frames=FrameCounts(camera.captured, camera.dropped, daemon.view.processed),
        latency_ms=Latencies(percentiles_ms(list(robot.link.capture_to_wire_s))),
        ground_truth=truth is not None,
    )


def driven_track(daemon: Daemon, robot: ControlledRobot) -> FloatArray:
    """Track (n, 4) of seconds, x_m, y_m, heading_rad: the truth, or sightings."""
    truth = daemon.world.truths.get(robot.name)
    return robot.sightings.rows() if truth is None else truth.track()


def _least_clearance_m(
    truth: Truth | None, roadmap: Roadmap | None, pieces: Sequence[FloatArray]
) -> float | None:
    if truth is not None:
        return min((truth.track_clearance(piece) for piece in pieces), default=None)
    if roadmap is None:
        return None
    ways = (roadmap.path_clearance(piece[:, 1:3]) for piece in pieces)
    return min((way.distance for way in ways), default=None)


def _tracking(robot: ControlledRobot, track: FloatArray) -> FloatArray:
    errors = []
    plans = list(robot.plans)
    ends = [*(plan.since_s for plan in plans[1:]), math.inf]
    for plan, end_s in zip(plans, ends, strict=False):
        rows = track[(track[:, 0] >= plan.since_s) & (track[:, 0] < end_s)]
        errors.append(tracking_error(rows[:, 1:3], plan.path.points))
    return np.concatenate(errors) if errors else np.empty(0)


def _goal_error(robot: ControlledRobot, track: FloatArray) -> tuple[float | None, float | None]:
    stations = robot.pilot.mission.stations
    if not stations or not len(track):
        return None, None
    goal, (_, x, y, heading) = stations[-1], track[-1]
    off_deg = None
    if goal.heading_rad is not None:
        off_deg = abs(math.degrees(math.remainder(heading - goal.heading_rad, math.tau)))
    return math.dist((x, y), (goal.x, goal.y)), off_deg
