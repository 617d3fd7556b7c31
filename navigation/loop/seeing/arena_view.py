"""The control loop's knowledge of the arena: newest picture and scene, and doubts."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from navigation.config import Config
from navigation.loop.seeing.eye import Glimpse
from navigation.loop.seeing.other_robots import OtherRobots
from navigation.loop.seeing.scene_doubt import SceneDoubt
from navigation.loop.seeing.vision_stage import VisionStage
from navigation.recording.events import SceneSeen
from planner.scene import Scene
from vision.camera.camera import Frame
from vision.markers.markers import RobotPose

if TYPE_CHECKING:
    from navigation.loop.recorder import Recorder


class ArenaView:
    """View of the arena, fed with every frame taken."""

    def __init__(
        self,
        config: Config,
        vision: VisionStage,
        clock: Callable[[], float],
        recorder: Recorder | None,
    ) -> None:
        self.vision = vision
        self.scene: Scene | None = None
        self.revision = 0
        """Number of the newest scene; 0 before the first."""
        self.frame: Frame | None = None
        """Newest picture, with its exposure time."""
        self.frame_s = -math.inf
        """Time of the newest picture, as the camera says."""
        self.glimpse = Glimpse(-math.inf, {}, None, None)
        self.others = OtherRobots({one.marker_id: one.radius_m for one in config.other_robots})
        self.doubt = SceneDoubt(floor_markers=bool(config.arena.floor_markers))
        self.processed = 0
        self.troubles: dict[str, str] = {}
        """Troubles by subject."""
        self._clock, self._recorder = clock, recorder
        self._measurable_revision = 0

    def see(self, frame: Frame, tell: Callable[[Mapping[int, RobotPose]], None]) -> bool:
        """Look at a frame and pass its poses on first; True if it shows a new scene."""
        if self.vision.failure() is not None:
            return False
        self.frame_s = min(frame.captured_s, self._clock())
        seen = self.vision.look(frame, tell)
        if seen is None:
            return False
        frame, glimpse = seen
        self.processed += 1
        held, self.frame, self.glimpse = self.glimpse.hold, frame, glimpse
        self.others.see(glimpse.poses)
        self.troubles |= {**glimpse.troubles, **self.doubt.look(glimpse)}
        if glimpse.scene is not None:
            self.revision += 1
            self.scene = glimpse.scene
        if held and not glimpse.hold:
            self._measurable_revision = self.revision  # the planner may not know it yet
        if self._recorder is not None:
            scene, at_s = glimpse.scene, frame.captured_s
            event = None if scene is None else SceneSeen(at_s, self.revision, scene)
            self._recorder.saw(frame, glimpse.poses, event)
        return glimpse.scene is not None

    def zones_changed(self) -> None:
        """Number the scene again: its plans knew other zones."""
        self.revision += 1

    @property
    def hold(self) -> str | None:
        """Reason why all robots hold; None if they need not."""
        return self.doubt.hold or self.glimpse.hold

    def is_measurable(self, known_revision: int) -> bool:
        """True if clearances mean something in this or a later scene; on unknown ground none do."""
        return known_revision >= self._measurable_revision and not self.glimpse.hold
