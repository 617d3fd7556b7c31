"""The JSON messages of a recording: what `clearway replay` needs, without loss.

Every message is one object; floats are written so that they read back the same. The scene is
the text of `planner.formats.scene_text`, the calibration that of
`vision.calibration.calibration_file`.
"""

from __future__ import annotations

from typing import Any, Final

from pydantic import TypeAdapter

from navigation.config import Config
from navigation.config.secrecy.secrets import hide_in
from navigation.mission.cycle import PlanRequest
from navigation.recording.events import PlanAnswered, PlanAsked, RobotsSeen, SceneSeen
from planner.formats.scene_text import write_scene_text
from planner.path import NoPath
from vision.camera.sources import without_password

SCHEMA: Final = "clearway.recording/1"
CONFIGURATION: Final = "/clearway/configuration"
FRAMES: Final = "/clearway/frames"
SCENES: Final = "/clearway/scenes"
REQUESTS: Final = "/clearway/requests"
PLANS: Final = "/clearway/plans"
LINK: Final = "/clearway/link"
TOPICS: Final = (CONFIGURATION, FRAMES, SCENES, REQUESTS, PLANS, LINK)
"""Topics of JSON messages; the others are Foxglove's own schemas."""

_REQUEST: TypeAdapter[PlanRequest] = TypeAdapter(PlanRequest)


def configuration_body(
    config: Config, calibration: str, version: str, part: int, anchor_s: float, anchor_ns: int
) -> dict[str, Any]:
    """The first message of every file: with it alone the pictures can be understood.

    ``anchor_s`` on the run's clock was ``anchor_ns`` since 1970, in which messages are stamped.
    Secrets are left out, since recordings are given away: the dashboard's section, and the
    password in a camera's address.
    """
    plain = hide_in(config.model_dump(mode="json", exclude={"dashboard"}))
    plain["camera"]["source"] = _public(config.camera.source)
    for one, entry in zip(plain["cameras"], config.cameras, strict=True):
        one["source"] = None if entry.source is None else _public(entry.source)
    return {
        "schema": SCHEMA,
        "version": version,
        "part": part,
        "anchor_s": anchor_s,
        "anchor_ns": anchor_ns,
        "config": plain,
        "calibration": calibration,
    }


def _public(source: int | str) -> int | str:
    is_address = isinstance(source, str) and "://" in source
    return without_password(str(source)) if is_address else source


def frame_body(seen: RobotsSeen) -> dict[str, Any]:
    """The poses in one picture: metres, radians."""
    poses = [
        {"id": pose.id, "x_m": pose.x, "y_m": pose.y, "heading_rad": pose.heading_rad}
        for pose in seen.poses
    ]
    return {"captured_s": seen.time_s, "poses": poses, "revision": seen.revision}


def scene_body(seen: SceneSeen) -> dict[str, Any]:
    """A scene as text."""
    text = write_scene_text(seen.scene)
    return {
        "captured_s": seen.time_s,
        "revision": seen.revision,
        "carried": seen.carried,
        "scene": text,
    }


def request_body(asked: PlanAsked) -> dict[str, Any]:
    """What the planner was asked, every field of it."""
    return {"time_s": asked.time_s, "request": _REQUEST.dump_python(asked.request, mode="json")}


def request_of(body: dict[str, Any]) -> PlanRequest:
    """The request in a message; pydantic's ValidationError (a ValueError) where it is none."""
    return _REQUEST.validate_python(body["request"])


def plan_body(answered: PlanAnswered) -> dict[str, Any]:
    """What the planner answered: the path, or why there is none; and what the robot is given."""
    answer = answered.answer
    body: dict[str, Any] = {
        "time_s": answered.time_s,
        "id": answer.id,
        "revision": answer.scene_revision,
    }
    if isinstance(answer.path, NoPath):
        return {**body, "status": "unreachable", "reason": answer.path.reason}
    return {
        **body,
        "status": "ok",
        "path": answer.path.points.tolist(),
        "length_m": float(answer.path.length),
        "min_clearance_m": float(answer.path.min_clearance),
        "duration_s": None if answer.trajectory is None else answer.trajectory.duration_s,
        "targets": [
            {"x_m": t.x_m, "y_m": t.y_m, "heading_rad": t.heading_rad, "speed_m_s": t.speed_m_s}
            for t in answer.targets
        ],
    }
