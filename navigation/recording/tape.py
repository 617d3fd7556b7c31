"""A recording at any moment: sightings, plans, sentences and the newest picture.

The file is read once, in order; of its pictures only the places are kept. Times are the run's
clock, seconds; wall times seconds since 1970.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, TypeVar

from mcap.records import Message

from navigation.mission.cycle import PlanRequest
from navigation.mission.mission import Station
from navigation.recording import json_bodies as bodies
from navigation.recording.events import SceneSeen
from navigation.recording.files import RecordingError
from navigation.recording.live_bodies import (
    MOST_M,
    MOST_S,
    TapedLink,
    Waits,
    bounded,
    link_of,
    waits_of,
)
from navigation.recording.messages import Messages, messages_at
from navigation.recording.reader import (
    BAD_BODY,
    CAMERA,
    Planned,
    Recording,
    SeenFrame,
    bytes_field,
    decoded_picture,
    read_recording,
    unreadable,
)
from vision.camera.camera import Image

T = TypeVar("T")
LOG: Final = "/log"
_SENTENCE_FIELD, _SOURCE_FIELD = 3, 4
"""`message` and `name` in foxglove.Log."""
MISSION: Final = "mission"
"""Source of a single robot's mission in the log."""


@dataclass(frozen=True, slots=True)
class TapedPicture:
    """A picture's time and number, and its chunk's place in the file."""

    captured_s: float
    stamp_ns: int
    offset: int
    channel: int
    number: int


@dataclass(frozen=True, slots=True)
class TapedPlan:
    """A robot's plan, as in `json_bodies.plan_message`, and its stations."""

    time_s: float
    stations: tuple[Station, ...]
    answer: dict[str, Any]


@dataclass(slots=True)
class Tape:
    """A recording in ascending order of time; robots by name, which is empty for a single one."""

    recording: Recording
    wall_offset_s: float
    """Wall time minus the run's clock."""
    frames: list[SeenFrame]
    pictures: list[TapedPicture] = field(default_factory=list)
    plans: dict[str, list[TapedPlan]] = field(default_factory=lambda: defaultdict(list))
    said: dict[str, list[tuple[float, str]]] = field(default_factory=lambda: defaultdict(list))
    """States and reasons of the mission: ``state: sentence``."""
    links: dict[str, list[tuple[float, TapedLink]]] = field(
        default_factory=lambda: defaultdict(list)
    )
    waits: list[tuple[float, Waits]] = field(default_factory=list)

    @property
    def begin_s(self) -> float:
        """First moment."""
        return self.frames[0].captured_s

    @property
    def end_s(self) -> float:
        """Last moment."""
        return self.frames[-1].captured_s

    def frame_at(self, time_s: float) -> SeenFrame:
        """Last sighting by then; the first one for an earlier time."""
        return self.frames[max(0, self.count_until(time_s) - 1)]

    def count_until(self, time_s: float) -> int:
        """Number of pictures analysed."""
        return bisect_right(self.frames, time_s, key=lambda seen: seen.captured_s)

    def seen_between(self, begin_s: float, end_s: float, every_s: float) -> Iterator[float]:
        """Yield times of sightings, at least ``every_s`` apart."""
        last_s = -math.inf
        for seen in self.frames[self.count_until(begin_s) : self.count_until(end_s)]:
            if seen.captured_s - last_s >= every_s:
                last_s = seen.captured_s
                yield last_s

    def told_until(self, time_s: float, most: int) -> list[float]:
        """Newest ``most`` times of a mission's sentences."""
        return sorted({at_s for said in self.said.values() for at_s, _ in said if at_s <= time_s})[
            -most:
        ]

    def scene_at(self, time_s: float) -> SceneSeen | None:
        """Newest scene."""
        scenes = self.recording.scenes
        at = bisect_right(scenes, time_s, key=lambda scene: scene.time_s)
        if at == 0 and scenes and scenes[0].carried:
            return scenes[0]
        return scenes[at - 1] if at else None

    def plan_at(self, time_s: float, robot: str = "") -> TapedPlan | None:
        """Newest plan of a robot, or the message that there is none."""
        plans = self.plans.get(robot, [])
        at = bisect_right(plans, time_s, key=lambda plan: plan.time_s)
        return plans[at - 1] if at else None

    def said_at(self, time_s: float, robot: str = "") -> str | None:
        """``state: sentence`` of a robot's mission."""
        return _newest(self.said.get(robot, []), time_s)

    def link_at(self, time_s: float, robot: str = "") -> TapedLink | None:
        """Newest counters of a robot's link."""
        return _newest(self.links.get(robot, []), time_s)

    def waits_at(self, time_s: float) -> Waits:
        """Sentences and robots awaited; empty if none was recorded."""
        return _newest(self.waits, time_s) or ({}, {})

    def picture_at(self, time_s: float) -> TapedPicture | None:
        """Newest picture."""
        at = bisect_right(self.pictures, time_s, key=lambda one: one.captured_s)
        return self.pictures[at - 1] if at else None

    def image(self, picture: TapedPicture) -> Image:
        """Read and decode a picture; `RecordingError` on failure."""
        path = self.recording.path
        for message in messages_at(path, picture.offset):
            if (message.channel_id, message.log_time) == (picture.channel, picture.stamp_ns):
                return decoded_picture(message.data, path)
        raise RecordingError(f"{path}: a picture in it is not where it was")


def read_tape(path: Path) -> Tape:
    """Read a recording; `RecordingError` if it is invalid or has no sighting."""
    recording = read_recording(path)
    if not recording.frames:
        raise RecordingError(f"{path}: nothing was seen in it")
    stamps = sorted(recording.frames)
    frames = sorted(recording.frames.values(), key=lambda seen: seen.captured_s)
    first = recording.frames[stamps[0]]
    tape = Tape(recording, stamps[0] / 1e9 - first.captured_s, frames)
    for offset, topic, message in Messages(path):
        try:
            _take(tape, offset, topic, message)
        except BAD_BODY as error:
            raise unreadable(path, topic, error) from None
    moments: list[list[Any]] = [*tape.said.values(), *tape.links.values(), tape.waits]
    for one_kind in moments:
        one_kind.sort(key=lambda one: one[0])
    tape.pictures.sort(key=lambda one: one.captured_s)
    recording.scenes.sort(key=lambda scene: scene.time_s)
    try:
        for planned in sorted(recording.plans, key=lambda plan: float(plan.answer["time_s"])):
            for name, plan in _plans_in(planned):
                tape.plans[name].append(plan)
    except BAD_BODY as error:
        raise unreadable(path, bodies.PLANS, error) from None
    return tape


def _take(tape: Tape, offset: int, topic: str, message: Message) -> None:
    time_s = message.log_time / 1e9 - tape.wall_offset_s
    if topic == CAMERA:
        seen = tape.recording.frames.get(message.log_time)
        if seen is not None:  # else the file was cut between a picture and the result for it
            number = len(tape.pictures)
            place = (offset, message.channel_id, number)
            tape.pictures.append(TapedPicture(seen.captured_s, message.log_time, *place))
    elif topic == LOG:
        source = bytes_field(message.data, _SOURCE_FIELD).decode(errors="replace")
        sentence = bytes_field(message.data, _SENTENCE_FIELD).decode(errors="replace")
        alone = source == MISSION and not tape.recording.config.robots
        tape.said["" if alone else source].append((time_s, sentence))
    elif topic == bodies.LINK or topic.startswith(f"{bodies.LINK}/"):
        name = topic.removeprefix(bodies.LINK).removeprefix("/")
        tape.links[name].append((time_s, link_of(bodies.read_body(message.data))))
    elif topic == bodies.FLEET_WAITS:
        tape.waits.append((time_s, waits_of(bodies.read_body(message.data))))


def _plans_in(planned: Planned) -> Iterator[tuple[str, TapedPlan]]:
    request, answer = planned.request, planned.answer
    time_s = bounded(answer["time_s"], MOST_S)
    if isinstance(request, PlanRequest):
        yield "", TapedPlan(time_s, request.stations, _shown(answer))
        return
    goals = {one.name: one.station for one in (*request.travellers, *request.idle)}
    for name, mine in answer["robots"].items():
        yield name, TapedPlan(time_s, (goals[name],) if name in goals else (), _shown(mine))


def _shown(answer: dict[str, Any]) -> dict[str, Any]:
    """Return the answer; ValueError, TypeError or LookupError if its path cannot be shown."""
    if answer.get("status") == "ok":
        for x, y in answer["path"]:
            bounded(x, MOST_M), bounded(y, MOST_M)
        bounded(answer["length_m"], MOST_M)
        bounded(answer["min_clearance_m"], MOST_M)
    return answer


def _newest(moments: list[tuple[float, T]], time_s: float) -> T | None:
    at = bisect_right(moments, time_s, key=lambda one: one[0])
    return moments[at - 1][1] if at else None
