"""Events of a recording, made in the loops and written by the recorder.

They carry objects that do not change. Times are the run's clock, seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from navigation.fleet.request import Answer, Request
from planner.roadmap.roadmap import Roadmap
from planner.scene import Scene
from planner.zones.zone import Zone
from vision.camera.camera import Frame
from vision.markers.markers import RobotPose

Level: TypeAlias = Literal["debug", "info", "warning", "error"]


@dataclass(frozen=True, slots=True)
class PictureTaken:
    """A picture that the eye analysed."""

    frame: Frame

    @property
    def time_s(self) -> float:
        """Time of its capture."""
        return self.frame.captured_s


@dataclass(frozen=True, slots=True)
class RobotsSeen:
    """Poses in a picture, and the new scene's revision or None."""

    time_s: float
    poses: tuple[RobotPose, ...]
    revision: int | None


@dataclass(frozen=True, slots=True)
class SceneSeen:
    """A new scene; ``carried`` from an earlier file."""

    time_s: float
    revision: int
    scene: Scene
    carried: bool = False


@dataclass(frozen=True, slots=True)
class RoadmapBuilt:
    """The roadmap of a scene, without zones, and the zones in force."""

    time_s: float
    revision: int
    roadmap: Roadmap
    zones: tuple[Zone, ...] = ()


@dataclass(frozen=True, slots=True)
class PlanAsked:
    """A request to the planner, for one robot or several."""

    time_s: float
    request: Request


@dataclass(frozen=True, slots=True)
class PlanAnswered:
    """An answer of the planner; ``carried`` from an earlier file."""

    time_s: float
    answer: Answer
    carried: bool = False


@dataclass(frozen=True, slots=True)
class ZonesChanged:
    """All zones in force, and the scene's revision, from now on."""

    time_s: float
    revision: int
    zones: tuple[Zone, ...]


@dataclass(frozen=True, slots=True)
class Told:
    """A sentence for people."""

    time_s: float
    level: Level
    sentence: str
    source: str


@dataclass(frozen=True, slots=True)
class Counted:
    """Counters, such as the link's, in JSON's types."""

    time_s: float
    topic: str
    values: Mapping[str, Any]


RecordedEvent: TypeAlias = (
    PictureTaken
    | RobotsSeen
    | SceneSeen
    | RoadmapBuilt
    | PlanAsked
    | PlanAnswered
    | ZonesChanged
    | Told
    | Counted
)
