"""JSON messages of a recording, which `clearway replay` reads without loss.

Floats read back the same. Scene and calibration are texts in their own formats.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np
from pydantic import TypeAdapter

from navigation.config import Config
from navigation.config.secrecy.secrets import hide_in
from navigation.fleet.request import (
    Driving,
    FleetAnswer,
    FleetRequest,
    Gate,
    Promise,
    Request,
    Taken,
    Traveller,
)
from navigation.mission.cycle import PlanRequest
from navigation.mission.mission import Station
from navigation.mission.targets import Target
from navigation.recording.events import (
    PlanAnswered,
    PlanAsked,
    RobotsSeen,
    SceneSeen,
)
from planner.formats.scene_text import write_scene_text
from planner.path import Limits, NoPath, Path, Trajectory
from vision.camera.sources import without_password

SCHEMA: Final = "clearway.recording/1"
CONFIGURATION: Final = "/clearway/configuration"
ZONES: Final = "/clearway/zones"
FRAMES: Final = "/clearway/frames"
SCENES: Final = "/clearway/scenes"
REQUESTS: Final = "/clearway/requests"
PLANS: Final = "/clearway/plans"
LINK: Final = "/clearway/link"
FLEET_REQUESTS: Final = "/clearway/fleet/requests"
FLEET_PLANS: Final = "/clearway/fleet/plans"
FLEET_WAITS: Final = "/clearway/fleet/waits"
TOPICS: Final = (
    CONFIGURATION, ZONES, FRAMES, SCENES, REQUESTS, PLANS, FLEET_REQUESTS, FLEET_PLANS, FLEET_WAITS,
    LINK,
)  # fmt: skip
"""Topics of JSON messages, besides ``LINK/NAME`` of several robots."""
ANSWERS: Final = {REQUESTS: PLANS, FLEET_REQUESTS: FLEET_PLANS}
"""Topics of requests, and of their answers."""

_REQUEST: TypeAdapter[PlanRequest] = TypeAdapter(PlanRequest)


@dataclass(frozen=True, slots=True)
class _Promised:
    name: str
    station: Station
    points: tuple[tuple[float, float], ...]
    gates: tuple[Gate, ...]
    radius_m: float
    margin_m: float
    executed: int
    sent: int
    limits: Limits

    @classmethod
    def of(cls, one: Driving) -> _Promised:
        promise = one.promise
        return cls(
            promise.name,
            promise.station,
            tuple((float(x), float(y)) for x, y in promise.points),
            promise.gates,
            promise.radius_m,
            promise.margin_m,
            one.executed,
            one.sent,
            one.limits,
        )

    @property
    def driving(self) -> Driving:
        """The planner's form; its clearances were never recorded."""
        points = np.array(self.points)
        unknown = np.full(len(points), np.nan)
        path = Path(
            points, unknown, math.nan, math.nan, self.points[0], self.radius_m,
            (0, len(points) - 1), (None, None),
        )  # fmt: skip
        promise = Promise(
            self.name, self.station, points, (), self.gates, path, None, self.radius_m,
            self.margin_m,
        )  # fmt: skip
        return Driving(promise, self.executed, self.sent, self.limits)


@dataclass(frozen=True, slots=True)
class _FleetRequest:
    id: int
    scene_revision: int
    travellers: tuple[Traveller, ...]
    taken: tuple[Taken, ...] = ()
    driving: tuple[_Promised, ...] = ()
    idle: tuple[Traveller, ...] = ()


_FLEET_REQUEST: TypeAdapter[_FleetRequest] = TypeAdapter(_FleetRequest)


def read_body(data: bytes) -> Any:
    """Read a message's JSON; ``ValueError`` if damaged or not finite."""
    return json.loads(data, parse_float=_finite, parse_constant=_finite)


def _finite(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"a number is {text[:20]}: must be finite")
    return number


def configuration_body(
    config: Config, calibration: str, version: str, part: int, anchor_s: float, anchor_ns: int
) -> dict[str, Any]:
    """First message of every file.

    ``anchor_s`` on the run's clock was ``anchor_ns`` since 1970, the messages' time base. Since
    recordings are given away, secrets are left out: the dashboard's section, and the password in a
    camera's address. Zones are events of their own.
    """
    plain = hide_in(config.model_dump(mode="json", exclude={"dashboard", "zones"}))
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
    """Poses in one picture: metres, radians."""
    poses = [
        {"id": pose.id, "x_m": pose.x, "y_m": pose.y, "heading_rad": pose.heading_rad}
        for pose in seen.poses
    ]
    return {"captured_s": seen.time_s, "poses": poses, "revision": seen.revision}


def scene_body(seen: SceneSeen) -> dict[str, Any]:
    """A scene as text."""
    return {
        "captured_s": seen.time_s,
        "revision": seen.revision,
        "carried": seen.carried,
        "scene": write_scene_text(seen.scene),
    }


def request_message(asked: PlanAsked) -> tuple[str, dict[str, Any]]:
    """Return the topic, and every field of a request to the planner."""
    request = asked.request
    if isinstance(request, FleetRequest):
        topic, plain = FLEET_REQUESTS, _FLEET_REQUEST.dump_python(_plain(request), mode="json")
    else:
        topic, plain = REQUESTS, _REQUEST.dump_python(request, mode="json")
    return topic, {"time_s": asked.time_s, "request": plain}


def _plain(one: FleetRequest) -> _FleetRequest:
    driving = tuple(map(_Promised.of, one.driving))
    return _FleetRequest(one.id, one.scene_revision, one.travellers, one.taken, driving, one.idle)


def request_of(topic: str, body: dict[str, Any]) -> Request:
    """Read the request in a message; pydantic's ValidationError, a ValueError, if invalid."""
    if topic == REQUESTS:
        return _REQUEST.validate_python(body["request"])
    plain = _FLEET_REQUEST.validate_python(body["request"])
    driving = tuple(one.driving for one in plain.driving)
    return FleetRequest(
        plain.id, plain.scene_revision, plain.travellers, plain.taken, driving, plain.idle
    )


def plan_message(answered: PlanAnswered) -> tuple[str, dict[str, Any]]:
    """Return the topic and the planner's answer: path and targets, or the reason for none.

    Several robots' promises are by name, with their gates.
    """
    answer = answered.answer
    body: dict[str, Any] = {
        "time_s": answered.time_s,
        "id": answer.id,
        "revision": answer.scene_revision,
        "carried": answered.carried,
    }
    if isinstance(answer, FleetAnswer):
        robots = {name: _promise(promise) for name, promise in answer.promises.items()}
        robots |= {name: _unreachable(reason) for name, reason in answer.refused.items()}
        return FLEET_PLANS, {**body, "robots": robots}
    if isinstance(answer.path, NoPath):
        return PLANS, {**body, **_unreachable(answer.path.reason)}
    return PLANS, {**body, **_way(answer.path, answer.trajectory, answer.targets)}


def _unreachable(reason: str) -> dict[str, Any]:
    return {"status": "unreachable", "reason": reason}


def _way(path: Path, trajectory: Trajectory | None, targets: Sequence[Target]) -> dict[str, Any]:
    return {
        "status": "ok",
        "path": path.points.tolist(),
        "length_m": float(path.length),
        "min_clearance_m": float(path.min_clearance),
        "duration_s": None if trajectory is None else trajectory.duration_s,
        "targets": [
            {"x_m": t.x_m, "y_m": t.y_m, "heading_rad": t.heading_rad, "speed_m_s": t.speed_m_s}
            for t in targets
        ],
    }


def _promise(promise: Promise) -> dict[str, Any]:
    way = _way(promise.path, promise.trajectory, promise.targets)
    return {**way, "gates": [asdict(gate) for gate in promise.gates]}
