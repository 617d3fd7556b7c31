"""Reports on the loop's parts: to the pilot, and as JSON to people and programs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from firmware_protocol.wire.messages import StatusFlag
from navigation.link.link_snapshot import LinkSnapshot, doubt_of_stop
from navigation.mission.cycle import RobotReport
from navigation.mission.mission import STOPPING, MissionProgress, State
from navigation.mission.targets import Target
from vision.camera.latest_frame import CameraStatus
from vision.markers.markers import RobotPose


def robot_report(snapshot: LinkSnapshot) -> RobotReport:
    """The link's report to the pilot."""
    status = snapshot.status
    return RobotReport(
        age_s=snapshot.heard_age_s,
        down_reason=snapshot.down_reason,
        estopped=snapshot.estopped,
        leaving_estop=snapshot.leaving_estop,
        disarmed=snapshot.disarmed,
        mission_id=snapshot.mission_id,
        executed=snapshot.executed,
        no_permit=snapshot.no_permit,
        standing_reason=snapshot.standing_reason,
        fault=snapshot.fault,
        waits=status is not None and bool(status.flags & StatusFlag.UNDERRUN),
        place_m=None if status is None else (status.x_m, status.y_m),
    )


def camera_reason(camera: CameraStatus) -> str:
    """Camera's reason, except its silence, which the pilot reports."""
    return "" if camera.state == "stalled" else camera.reason


def camera_openings(camera: CameraStatus) -> int:
    """Number that changes when the camera is reopened, which restarts the latency's measurement.

    It is constant for several cameras: a robot lost from view with one proves itself, which
    measures the latency, and one that others still see is seen twice at odds.
    """
    return 0 if camera.each else camera.reopened


def to_go_m(pose: RobotPose | None, targets: Sequence[Target], executed: int) -> float | None:
    """Distance left through the targets not executed; None if unknown."""
    if pose is None or not targets:
        return None
    left = targets[min(executed, len(targets)) :]
    points = [(pose.x, pose.y), *((t.x_m, t.y_m) for t in left)]
    return math.fsum(map(math.dist, points, points[1:]))


def describe(
    mission: MissionProgress,
    seen: tuple[RobotPose, float] | None,
    left_m: float | None,
    snapshot: LinkSnapshot,
    camera: CameraStatus,
    latency_s: float | None,
) -> dict[str, Any]:
    """Return mission, robot, link and camera for JSON.

    ``seen``: the robot's last seen pose, and its age. A stop is "stopping" until the robot is known
    to be at rest.
    """
    doubt = doubt_of_stop(snapshot) if mission.state is State.STOPPED else None
    return {
        "state": mission.state.value if doubt is None else STOPPING,
        "reason": mission.reason if doubt is None else f"{mission.reason}; {doubt}",
        "stations": len(mission.stations),
        "visited": mission.visited,
        "pose": None
        if seen is None
        else {
            "x_m": seen[0].x,
            "y_m": seen[0].y,
            "heading_rad": seen[0].heading_rad,
            "age_s": seen[1],
        },
        "to_go_m": left_m,
        "link": snapshot.down_reason or snapshot.state.value,
        "camera": camera.reason or camera.state,
        "frames_s": camera.rate_hz,
        "latency_s": latency_s,
    }
