"""Greeting, state and previews of the running program for viewers, as JSON data.

Metres, radians, seconds; ages and latencies in milliseconds. Nothing is infinite or NaN: unseen
things are null.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from navigation.config import Config
from navigation.dashboard.admission.seat import Seat
from navigation.dashboard.messages.geometry import path_facts
from navigation.dashboard.messages.picture import TopView
from navigation.dashboard.orders import cannot
from navigation.draw.shapes import RAMP_STEPS
from navigation.link.link_snapshot import LinkSnapshot, doubt_of_stop
from navigation.loop.run_state import RobotSnapshot, StageTimes
from navigation.mission.cycle import PlanAnswer
from navigation.mission.mission import State
from navigation.witness import Evidence
from planner.path import NoPath
from vision.camera.latest_frame import CameraStatus
from vision.markers.markers import RobotPose


def greeting(config: Config, view: TopView) -> dict[str, Any]:
    """Facts that do not change during a run."""
    window = view.window
    return {
        "type": "hello",
        "arena_m": list(config.arena.bounds_m),
        "window_m": [window.x_min, window.y_min, window.x_max, window.y_max],
        "picture_px": list(view.size_px),
        "robot": _robot(config),
        "others": [{"marker_id": o.marker_id, "radius_m": o.radius_m} for o in config.other_robots],
        "margin_m": config.planning.margin_m,
        "camera": {"source": config.camera.source, "rate_hz": config.camera.rate_hz},
        "cameras": [one.name for one in config.cameras],
        "port": config.serial.port,
        "hold_s": config.dashboard.hold_s,
        "ramp_steps": RAMP_STEPS,
    }


def robots_greeting(configs: Mapping[str, Config]) -> list[dict[str, Any]]:
    """Facts of each of several robots, in the order of the configuration."""
    return [{"name": name, "port": one.serial.port, **_robot(one)} for name, one in configs.items()]


def _robot(config: Config) -> dict[str, Any]:
    return {
        "marker_id": config.robot.marker_id,
        "radius_m": config.robot.radius_m,
        "speed_m_s": config.robot.speed_m_s,
    }


def state_message(
    state: RobotSnapshot,
    view: TopView,
    camera: CameraStatus,
    seat: Seat,
    *,
    others: Iterable[RobotPose],
    now_s: float,
    loop_age_s: float,
    viewers: int,
) -> dict[str, Any]:
    """The present state; ``others`` are the other robots' last seen poses."""
    return {
        "type": "state",
        "time_s": round(state.time_s, 2),
        "loop_ms": _ms(loop_age_s),
        **robot_facts(state, view, now_s),
        "others": [_pose(other, view, now_s) for other in others],
        "seat": _seat(seat, now_s),
        "viewers": viewers,
        "camera": _camera(camera, state.evidence),
        "times": _times(state.times),
    }


def robot_facts(state: RobotSnapshot, view: TopView, now_s: float) -> dict[str, Any]:
    """Mission, place and link of one robot."""
    mission, stopped = state.mission, state.mission.state is State.STOPPED
    return {
        "paused": mission.paused,
        "mission": {
            "state": mission.state.value,
            "sentence": state.sentence,
            "reasons": list(state.verdict.reasons),
            "stations": [
                {"x_m": s.x, "y_m": s.y, "heading_rad": s.heading_rad, "dwell_s": s.dwell_s}
                for s in mission.stations
            ],
            "visited": mission.visited,
            "trust": state.trust.value,
        },
        "cannot": cannot(mission),
        "pose": None if state.pose is None else _pose(state.pose, view, now_s),
        "to_go_m": state.to_go_m,
        "clearance_m": state.clearance_m,
        "link": {**_link(state.link), "stop_doubt": doubt_of_stop(state.link) if stopped else None},
    }


def no_path_facts(answer: NoPath) -> dict[str, Any]:
    """Reason why there is no path, and where the widest one is too narrow."""
    gap = answer.bottleneck
    return {
        "reason": answer.reason,
        "bottleneck": None if gap is None else {"x_m": gap.x, "y_m": gap.y, "width_m": gap.width},
        "widest_radius_m": answer.widest_radius,
        "remarks": list(answer.remarks),
    }


def preview_facts(answer: PlanAnswer) -> dict[str, Any]:
    """The path with its figures, or why there is none."""
    path = answer.path
    if isinstance(path, NoPath):
        return {"ok": False, **no_path_facts(path)}
    facts: Mapping[str, Any] = path_facts(path)
    duration_s = None if answer.trajectory is None else answer.trajectory.duration_s
    points = [[round(float(x), 4), round(float(y), 4)] for x, y in path.points]
    return {"ok": True, **facts, "duration_s": duration_s, "points": points}


def _pose(pose: RobotPose, view: TopView, now_s: float) -> dict[str, Any]:
    seen_x, seen_y = view.seen_m(pose)
    return {
        "id": pose.id,
        "x_m": round(pose.x, 4),
        "y_m": round(pose.y, 4),
        "seen_m": [round(seen_x, 4), round(seen_y, 4)],
        "heading_rad": round(pose.heading_rad, 4),
        "speed_m_s": round(math.hypot(pose.vx, pose.vy), 4),
        "age_ms": _ms(now_s - pose.captured_s),
    }


def _seat(seat: Seat, now_s: float) -> dict[str, Any] | None:
    holder = seat.holder
    if holder is None:
        return None
    return {"id": holder.public, "name": holder.name, "free_in_s": round(seat.free_in_s(now_s))}


def _camera(camera: CameraStatus, evidence: Evidence) -> dict[str, Any]:
    return {
        "state": camera.state,
        "reason": camera.reason,
        "rate_hz": round(camera.rate_hz, 1),
        "captured": camera.captured,
        "dropped": camera.dropped,
        "reopened": camera.reopened,
        "age_ms": None if camera.age_s is None else _ms(camera.age_s),
        "latency_ms": None if evidence.latency_s is None else _ms(evidence.latency_s),
        "each": [
            {
                "name": name,
                "state": one.state,
                "reason": one.reason,
                "rate_hz": round(one.rate_hz, 1),
            }
            for name, one in camera.each
        ],
    }


def _link(link: LinkSnapshot) -> dict[str, Any]:
    return {
        "state": link.state.value,
        "reason": link.down_reason,
        "heard_ms": _ms(link.heard_age_s),
        "round_trip_ms": None if link.rtt_s is None else _ms(link.rtt_s),
        "sent_frames": link.sent.frames_sent,
        "received_frames": link.received.frames,
        "retransmits": link.sent.retransmits,
        "crc_errors": link.received.crc_errors,
        "links_lost": link.sent.links_lost,
        "taken_back": link.sent.taken_back,
        "stray_hellos": link.sent.stray_hellos,
        "clock_jumps": link.sent.clock_jumps,
        "stale": link.sent.stale,
        "moving": link.moving,
        "estopped": link.estopped,
        "estop_pending": link.estop_pending,
        "robot": link.standing_reason,
        "executed": link.executed,
        "accepted": link.accepted,
    }


def _times(times: StageTimes) -> Mapping[str, float | None]:
    parts = {"look": times.look_s, "roadmap": times.roadmap_s, "plan": times.plan_s}
    return {f"{name}_ms": None if value is None else _ms(value) for name, value in parts.items()}


def _ms(seconds: float) -> float | None:
    return round(seconds * 1e3, 2) if math.isfinite(seconds) else None
