"""Files of recorded events, in MCAP: a new one when one is full, the oldest removed.

A file that a person named is not followed by another: it ends at the limit.

Rules
- Every file is complete: it begins with the configuration and what still holds.
- Only pictures are compressed, in their own format. `flush` closes a chunk, which survives a kill.
- Only files with a recording's name are counted and removed, never the one being written.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import foxglove
from foxglove.channels import (
    CompressedImageChannel,
    LogChannel,
    PoseInFrameChannel,
    SceneUpdateChannel,
)
from foxglove.mcap import MCAPWriteOptions

from navigation.config.recording import RecordingSection
from navigation.fleet.request import Answer, FleetAnswer
from navigation.recording import foxglove as messages
from navigation.recording import json_bodies as bodies
from navigation.recording.events import (
    Counted,
    PictureTaken,
    PlanAnswered,
    PlanAsked,
    RecordedEvent,
    RoadmapBuilt,
    RobotsSeen,
    SceneSeen,
    Told,
    ZonesChanged,
)
from navigation.recording.names import PREFIX, SUFFIX
from navigation.recording.standing import CurrentEvents
from navigation.recording.zone_bodies import zones_body
from planner.path import NoPath
from planner.scene import FloatArray
from planner.zones.zone import zones_for
from planner.zones.zoned_roadmap import with_zones

BYTES_PER_MB: Final = 1_000_000
LEAST_FREE_MB: Final = 100.0
"""A recording ends before it fills the disk that the journal needs too."""


class RecordingError(ValueError):
    """A recording cannot be written or read."""


class RecordingFiles:
    """Files of one recording, written by one thread.

    ``header(part)`` gives the configuration's message for file ``part``, from 1; ``stamp_ns`` turns
    the run's clock into nanoseconds since 1970. ``names`` by marker id name robots' channels.
    ``file`` is the only file in ``folder``; without it files are named by time.
    """

    def __init__(
        self,
        folder: Path,
        settings: RecordingSection,
        began: datetime,
        header: Callable[[int], dict[str, Any]],
        stamp_ns: Callable[[float], int],
        names: Mapping[int, str] = MappingProxyType({}),
        file: str | None = None,
    ) -> None:
        self.folder, self.settings = folder, settings
        self._file = None if file is None else folder / file
        self.files = 0
        self.removed = 0
        stem = f"{PREFIX}{began:%Y-%m-%d_%H-%M-%S}" if self._file is None else self._file.stem
        self._stem = stem
        self._header, self._stamp_ns = header, stamp_ns
        self._context = foxglove.Context()
        self._names = names
        self._json: dict[str, foxglove.Channel] = {}
        self._pictures = CompressedImageChannel("/camera", context=self._context)
        self._scenes = SceneUpdateChannel("/scene", context=self._context)
        self._roadmaps = SceneUpdateChannel("/roadmap", context=self._context)
        self._zones: SceneUpdateChannel | None = None
        self._paths: dict[str, SceneUpdateChannel] = {}
        self._log = LogChannel("/log", context=self._context)
        self._poses: dict[int, PoseInFrameChannel] = {}
        self._standing = CurrentEvents()
        self.path = self._new_path()
        self._open(stamp_ns)

    def _new_path(self) -> Path:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise RecordingError(f"{self.folder}: {error.strerror or error}") from None
        if self._file is not None and not self._file.exists():
            return self._file
        # a run that begins again with a changed configuration finds the file that it was given
        number = self.files + (1 if self._file is None else 2)
        while True:
            path = self.folder / f"{self._stem}_{number:03d}{SUFFIX}"
            if not path.exists():
                return path
            number += 1

    def _open(self, stamp_ns: Callable[[float], int]) -> None:
        # without seeking, chunks are written whole, so a killed file ends in whole ones
        options = MCAPWriteOptions(compression=None, profile="clearway", disable_seeking=True)
        try:
            self._writer = foxglove.open_mcap(
                self.path, context=self._context, writer_options=options
            )
        except (OSError, RuntimeError) as error:
            raise RecordingError(f"{self.path}: {error}") from None
        self.files += 1
        header = self._header(self.files)
        configuration = self._json_channel(bodies.CONFIGURATION)
        configuration.log(header, log_time=stamp_ns(header["anchor_s"]))
        for event in self._standing.carried():
            self._write(event)

    def write(self, event: RecordedEvent) -> None:
        """Write one event: for viewers if they know its kind, and as JSON for replay."""
        self._standing.take(event)
        self._write(event)

    def _write(self, event: RecordedEvent) -> None:
        time_ns = self._stamp_ns(event.time_s)
        match event:
            case PictureTaken(frame):
                form, quality = self.settings.picture_format, self.settings.jpeg_quality
                image = messages.image_message(frame, time_ns, form, quality)
                self._pictures.log(image, log_time=time_ns)
            case RobotsSeen():
                self._write_json(bodies.FRAMES, bodies.frame_body(event), time_ns)
                for pose in event.poses:
                    channel = self._pose_channel(pose.id)
                    channel.log(messages.pose_message(pose, time_ns), log_time=time_ns)
            case SceneSeen():
                self._write_json(bodies.SCENES, bodies.scene_body(event), time_ns)
                self._scenes.log(messages.scene_message(event.scene, time_ns), log_time=time_ns)
            case RoadmapBuilt():
                zoned = with_zones(event.roadmap, zones_for(event.zones, ""))
                update = messages.roadmap_message(zoned.closed, time_ns)
                self._roadmaps.log(update, log_time=time_ns)
            case ZonesChanged(zones=zones):
                self._write_json(bodies.ZONES, zones_body(event), time_ns)
                if self._zones is None:  # made where it is needed: few runs have zones
                    self._zones = SceneUpdateChannel("/zones", context=self._context)
                self._zones.log(messages.zones_message(zones, time_ns), log_time=time_ns)
            case PlanAsked():
                self._write_json(*bodies.request_message(event), time_ns)
            case PlanAnswered(answer=answer):
                self._write_json(*bodies.plan_message(event), time_ns)
                self._write_paths(answer, time_ns)
            case Told(_, level, sentence, source):
                log = messages.log_message(level, sentence, source, time_ns)
                self._log.log(log, log_time=time_ns)
            case Counted(_, topic, values):
                self._write_json(topic, dict(values), time_ns)

    def _write_json(self, topic: str, body: dict[str, Any], time_ns: int) -> None:
        text = json.dumps(body, allow_nan=False, default=asdict)
        self._json_channel(topic).log(text.encode(), log_time=time_ns)

    def _write_paths(self, answer: Answer, time_ns: int) -> None:
        if isinstance(answer, FleetAnswer):
            for name in self._names.values():
                promise = answer.promises.get(name)
                points = None if promise is None else promise.points
                self._write_path(f"/robot/{name}/plan", points, time_ns)
        else:
            points = None if isinstance(answer.path, NoPath) else answer.path.points
            self._write_path("/plan", points, time_ns)

    def _write_path(self, topic: str, points: FloatArray | None, time_ns: int) -> None:
        if topic not in self._paths:
            self._paths[topic] = SceneUpdateChannel(topic, context=self._context)
        self._paths[topic].log(messages.path_message(points, time_ns), log_time=time_ns)

    def _json_channel(self, topic: str) -> foxglove.Channel:
        if topic not in self._json:
            schema = {"type": "object"}
            self._json[topic] = foxglove.Channel(topic, schema=schema, context=self._context)
        return self._json[topic]

    def _pose_channel(self, robot_id: int) -> PoseInFrameChannel:
        if robot_id not in self._poses:
            topic = f"/robot/{self._names.get(robot_id, robot_id)}/pose"
            self._poses[robot_id] = PoseInFrameChannel(topic, context=self._context)
        return self._poses[robot_id]

    def flush(self) -> None:
        """Pass everything to the operating system; begin a new file if this one is full.

        ``RecordingError`` if the disk is nearly full, writing fails, or a named file is full.
        """
        try:
            self._writer.flush()
            size = self.path.stat().st_size
            free = shutil.disk_usage(self.folder).free
        except (OSError, RuntimeError) as error:
            raise RecordingError(f"{self.path}: {error}") from None
        if free < LEAST_FREE_MB * BYTES_PER_MB:
            raise RecordingError(
                f"{self.folder}: {free / BYTES_PER_MB:.0f} MB are free: must be at least "
                f"{LEAST_FREE_MB:g} MB to record"
            )
        if self._file is not None:
            if size >= self.settings.limit_mb * BYTES_PER_MB:
                self._writer.close()
                raise RecordingError(
                    f"{self.path}: {size / BYTES_PER_MB:.0f} MB: must be less than "
                    f"recording.limit_mb = {self.settings.limit_mb:g}"
                )
        elif size >= self.settings.file_mb * BYTES_PER_MB:
            self._writer.close()
            self.path = self._new_path()
            self._open(self._stamp_ns)
            self._remove_oldest()

    def _remove_oldest(self) -> None:
        # the present ones last, whatever the computer's clock has called the others
        files = sorted(recordings_in(self.folder), key=self._is_present)
        sizes = {file: file.stat().st_size for file in files}
        total = sum(sizes.values())
        for file in files:
            if total <= self.settings.limit_mb * BYTES_PER_MB or file == self.path:
                return
            file.unlink(missing_ok=True)
            self.removed += 1
            total -= sizes[file]

    def _is_present(self, file: Path) -> bool:
        return file.stem.startswith(f"{self._stem}_")

    def close(self) -> None:
        """Write the index and close the file."""
        try:
            self._writer.close()
        except (OSError, RuntimeError) as error:
            raise RecordingError(f"{self.path}: {error}") from None


def recordings_in(folder: Path) -> list[Path]:
    """Recordings in a folder, oldest first."""
    return sorted(folder.glob(f"{PREFIX}*{SUFFIX}"), key=lambda file: file.stem)
