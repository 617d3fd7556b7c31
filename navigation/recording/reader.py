"""Reader of recordings, whole or cut off by a kill: everything flushed is readable.

A file is read from its beginning, never by its index, which a cut file lacks. Times are the run's
clock, seconds.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np

from navigation.config import Config
from navigation.config.checks import bounds_have_an_inside
from navigation.config.errors import key_name
from navigation.config.several.fleet_checks import names_markers_and_ports_differ
from navigation.fleet.request import Request
from navigation.recording import json_bodies as bodies
from navigation.recording.events import SceneSeen, ZonesChanged
from navigation.recording.files import RecordingError
from navigation.recording.live_bodies import MOST_M, MOST_S, bounded
from navigation.recording.messages import Messages
from navigation.recording.zone_bodies import zones_of
from planner.formats.scene_text import read_scene_text
from planner.scene import SceneError
from planner.zones.zone import Zone
from vision.calibration.calibration import Calibration
from vision.calibration.calibration_file import parse_calibration
from vision.camera.camera import Image
from vision.camera.picture_size import oversize

CAMERA: Final = "/camera"
_DATA_FIELD: Final = 2
"""`data` in foxglove.CompressedImage."""
BAD_BODY: Final = (
    *(ValueError, LookupError, TypeError, AttributeError, ArithmeticError),
    *(SceneError, RecursionError),
)
"""Damaged JSON, or other things or larger numbers than the recorder writes."""
MOST_CHARACTERS: Final = 300
"""Longest reason of another library that is repeated."""
_VARINT_BITS: Final = 64


@dataclass(frozen=True, slots=True)
class SeenFrame:
    """Poses that the run saw in one picture; ``poses`` by marker id: x_m, y_m, heading_rad."""

    captured_s: float
    poses: dict[int, tuple[float, float, float]]


@dataclass(frozen=True, slots=True)
class Planned:
    """A request and its answer, as in `json_bodies.plan_message`."""

    request: Request
    answer: dict[str, Any]

    @property
    def carried(self) -> bool:
        """True if it was planned in an earlier file and still holds."""
        return bool(self.answer.get("carried", False))


@dataclass(slots=True)
class Recording:
    """A recording without its pictures; ``cut`` if its end is missing, as after a kill."""

    path: Path
    config: Config
    calibration: Calibration
    version: str
    part: int
    frames: dict[int, SeenFrame] = field(default_factory=dict)
    """By the picture's time in the file, nanoseconds."""
    scenes: list[SceneSeen] = field(default_factory=list)
    plans: list[Planned] = field(default_factory=list)
    zones: list[ZonesChanged] = field(default_factory=list)
    """Changes of zones in order, from those that held at the beginning."""
    log: list[str] = field(default_factory=list)
    cut: bool = False

    def zones_at(self, time_s: float) -> tuple[Zone, ...]:
        """Zones in force at a time; none before the first."""
        at = bisect_right(self.zones, time_s, key=lambda one: one.time_s)
        return self.zones[at - 1].zones if at else ()

    def zones_in(self, revision: int) -> tuple[Zone, ...]:
        """Zones in force in a revision of the scene."""
        at = bisect_right(self.zones, revision, key=lambda one: one.revision)
        return self.zones[at - 1].zones if at else ()

    def scene_in(self, revision: int) -> SceneSeen | None:
        """Scene of a revision, which a change of zones raises too; None if not recorded."""
        at = bisect_right(self.scenes, revision, key=lambda one: one.revision)
        return self.scenes[at - 1] if at else None

    def pictures(self) -> Iterator[tuple[int, Image]]:
        """Yield time in the file (nanoseconds) and picture, in order."""
        for _, topic, message in Messages(self.path):
            if topic == CAMERA:
                yield message.log_time, decoded_picture(message.data, self.path)


def read_recording(path: Path) -> Recording:
    """Read a recording; `RecordingError` if it is invalid or has no configuration."""
    recording: Recording | None = None
    asked: dict[tuple[str, int], Request] = {}
    """By topic of the answer, and id."""
    messages = Messages(path)
    for _, topic, message in messages:
        if topic not in bodies.TOPICS:
            continue
        try:
            body = bodies.read_body(message.data)
            if recording is None:
                recording = _begin(path, topic, body)
            elif topic == bodies.FRAMES:
                recording.frames[message.log_time] = _frame(body)
            elif topic == bodies.SCENES:
                recording.scenes.append(_scene(body))
            elif topic == bodies.ZONES:
                recording.zones.append(zones_of(body))
            elif topic in bodies.ANSWERS:
                request = bodies.request_of(topic, body)
                asked[bodies.ANSWERS[topic], request.id] = request
            elif (topic, body.get("id")) in asked:
                recording.plans.append(Planned(asked.pop((topic, body["id"])), body))
        except BAD_BODY as error:
            raise unreadable(path, topic, error) from None
    if recording is None:
        raise RecordingError(f"{path}: holds no configuration: not a recording of a run")
    recording.cut = messages.cut
    return recording


def unreadable(path: Path, topic: str, error: Exception) -> RecordingError:
    """Error for a message."""
    why = " ".join(f"{type(error).__name__}: {error}".split())[:MOST_CHARACTERS]
    return RecordingError(f"{path}: a message of {topic} cannot be read: {why}")


def _begin(path: Path, topic: str, body: dict[str, Any]) -> Recording:
    if topic != bodies.CONFIGURATION or body.get("schema") != bodies.SCHEMA:
        raise ValueError(f"must begin with a configuration of schema {bodies.SCHEMA}")
    config = Config.model_validate(body["config"])
    # of all checks those that a replay relies on: another version's recording may break others
    for where, sentence in (
        *bounds_have_an_inside(config.arena),
        *names_markers_and_ports_differ(config.robots, config.serial, config.other_robots),
    ):
        raise ValueError(f"{key_name(where)}: {sentence}")
    return Recording(
        path,
        config,
        parse_calibration(body["calibration"], f"{path}: calibration"),
        str(body["version"]),
        int(body["part"]),
    )


def _frame(body: dict[str, Any]) -> SeenFrame:
    poses = {
        int(pose["id"]): (
            bounded(pose["x_m"], MOST_M),
            bounded(pose["y_m"], MOST_M),
            bounded(pose["heading_rad"], MOST_M),
        )
        for pose in body["poses"]
    }
    return SeenFrame(bounded(body["captured_s"], MOST_S), poses)


def _scene(body: dict[str, Any]) -> SceneSeen:
    return SceneSeen(
        bounded(body["captured_s"], MOST_S),
        int(body["revision"]),
        read_scene_text(body["scene"], "recorded scene"),
        bool(body["carried"]),
    )


def decoded_picture(message: bytes, path: Path) -> Image:
    """Decode the picture in a message of Foxglove's; `RecordingError` if there is none."""
    data = bytes_field(message, _DATA_FIELD)
    large = oversize(data)
    if large:
        raise RecordingError(f"{path}: {large}")
    try:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) if data else None
    except cv2.error:
        image = None
    if image is None or image.dtype != np.uint8:
        raise RecordingError(f"{path}: a picture in it cannot be decoded")
    return np.asarray(image, dtype=np.uint8)


def bytes_field(message: bytes, wanted: int) -> bytes:
    """Return a bytes field of a protobuf message; empty if absent.

    Protobuf's wire: a varint of number and type; then a varint (0), 8 bytes (1), a length and bytes
    (2), or 4 bytes (5).
    """
    at = 0
    while at < len(message):
        key, at = _varint(message, at)
        kind = key & 7
        if kind == 2:
            length, at = _varint(message, at)
            if key >> 3 == wanted:
                return message[at : at + length]
            at += length
        elif kind == 0:
            _, at = _varint(message, at)
        else:
            at += 8 if kind == 1 else 4
    return b""


def _varint(message: bytes, at: int) -> tuple[int, int]:
    value = shift = 0
    while at < len(message) and shift < _VARINT_BITS:
        byte = message[at]
        value |= (byte & 0x7F) << shift
        shift, at = shift + 7, at + 1
        if byte < 0x80:
            break
    return value, at
