"""What a recording holds: one class an event, made in the loops and written by the recorder.

An event carries objects that nobody changes any more, so that making one costs nothing; what
it is as bytes is decided in the recorder's thread. Times are the run's clock, seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from navigation.fleet.request import Answer, Request
from planner.roadmap.roadmap import Roadmap
from planner.scene import Scene
from vision.camera.camera import Frame
from vision.markers.markers import RobotPose

Level: TypeAlias = Literal["debug", "info", "warning", "error"]


@dataclass(frozen=True, slots=True)
class PictureTaken:
    """A picture that the eye looked at."""

    frame: Frame

    @property
    def time_s(self) -> float:
        """When it was captured."""
        return self.frame.captured_s


@dataclass(frozen=True, slots=True)
class RobotsSeen:
    """What the eye saw in a picture: the poses, and the new scene's revision or None."""

    time_s: float
    poses: tuple[RobotPose, ...]
    revision: int | None


@dataclass(frozen=True, slots=True)
class SceneSeen:
    """A new scene and its revision; ``carried``: seen in an earlier file of the recording."""

    time_s: float
    revision: int
    scene: Scene
    carried: bool = False


@dataclass(frozen=True, slots=True)
class RoadmapBuilt:
    """The roadmap of a scene."""

    time_s: float
    revision: int
    roadmap: Roadmap


@dataclass(frozen=True, slots=True)
class PlanAsked:
    """The planner was asked: for one robot, or for all of several that want to move."""

    time_s: float
    request: Request


@dataclass(frozen=True, slots=True)
class PlanAnswered:
    """The planner's answer; ``carried``: given in an earlier file of the recording."""

    time_s: float
    answer: Answer
    carried: bool = False


@dataclass(frozen=True, slots=True)
class Told:
    """A sentence for people."""

    time_s: float
    level: Level
    sentence: str
    source: str


@dataclass(frozen=True, slots=True)
class Counted:
    """Counters, of the link for instance, as JSON takes them."""

    time_s: float
    topic: str
    values: Mapping[str, Any]


RecordedEvent: TypeAlias = (
    PictureTaken | RobotsSeen | SceneSeen | RoadmapBuilt | PlanAsked | PlanAnswered | Told | Counted
)
