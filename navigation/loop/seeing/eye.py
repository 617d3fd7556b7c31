"""The eye: one frame in, the robots' poses and, if the arena changed, the new scene out.

Markers come first, because robots' bodies must never become obstacles; then the watch for changes;
the extractor only after a change. Metres and radians in the arena, seconds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

import vision
from navigation.config.sections import VisionSection
from planner.scene import Bounds, FloatArray, Scene
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame
from vision.markers.marker_search import grey_of
from vision.markers.markers import MarkerTracker, RobotPose, body_discs_px
from vision.watch.camera_place import CameraPlace, PlaceReport
from vision.watch.change import Change, SceneWatcher
from vision.watch.refit import KnownScene

Poses: TypeAlias = Mapping[int, RobotPose]
"""By marker id."""


@dataclass(frozen=True, slots=True)
class RobotShape:
    """The disc around a robot, and its marker's height."""

    radius_m: float
    marker_height_m: float


@dataclass(frozen=True, slots=True)
class EyeSettings:
    """Search settings from the configuration."""

    bounds_m: Bounds
    vision: VisionSection
    driven_ids: tuple[int, ...]
    """Markers of the driven robots."""
    bodies: Mapping[int, RobotShape]
    """Driven robots and others, by marker id."""
    reach_m: float = 0.0
    """Distance that an unseen driven robot may be from where it was last seen: only these places
    are left out while another robot is seen."""


@dataclass(frozen=True, slots=True)
class Glimpse:
    """Findings of one frame: poses by marker id, and the scene if it is new."""

    captured_s: float
    poses: Mapping[int, RobotPose]
    scene: Scene | None
    change: Change | None
    doubles: Mapping[int, str] = field(default_factory=dict)
    """Sentence for each driven robot's marker that is seen twice, by marker id."""
    place: PlaceReport | None = None
    """Report on the camera's place; None if that is not watched."""
    picture: Frame | None = None
    """For people, if not the frame itself."""
    hold: str | None = None
    """Why no robot may drive by what is seen now."""
    troubles: Mapping[str, str] = field(default_factory=dict)
    """Troubles by subject; empty once they are over."""


class Eye:
    """Trackers, and the picture of the arena without its robots."""

    def __init__(
        self,
        calibration: Calibration,
        tracker: MarkerTracker,
        settings: EyeSettings,
        camera_place: CameraPlace | None = None,
    ) -> None:
        self.calibration = calibration
        self.settings = settings
        self._tracker, self._camera_place = tracker, camera_place
        self._watcher = self._new_watcher()
        self._last_seen: dict[int, RobotPose] = {}
        self._known: KnownScene | None = None

    def _new_watcher(self) -> SceneWatcher:
        return SceneWatcher()

    def look(self, frame: Frame, tell: Callable[[Poses], None] = lambda _: None) -> Glimpse:
        """Return this frame's poses; a scene once the robots were seen and after every change.

        ``tell`` gets each pose before anything else is looked at. While no driven robot is seen, or
        one has never been seen, any dark place may be its body: the scene stays as it was.
        """
        frame = replace(frame, image=grey_of(frame.image))
        seen = self._tracker.update(frame, lambda pose: tell({pose.id: pose}))
        poses = {pose.id: pose for pose in seen}
        self._last_seen.update(poses)
        discs = self._body_discs(poses) if self._last_seen else None
        place = self._look_at_camera_place(frame, discs)
        driven = self.settings.driven_ids
        if not all(i in self._last_seen for i in driven) or not any(i in poses for i in driven):
            return Glimpse(frame.captured_s, poses, None, None, self._doubles(), place)
        assert discs is not None
        change = self._watcher.update(frame.image, discs)
        scene = None
        if change is not None or self._known is None:
            self._known = self._brought_up_to_date(change)
            scene = self._known.scene
        return Glimpse(frame.captured_s, poses, scene, change, self._doubles(), place)

    def _look_at_camera_place(self, frame: Frame, discs: FloatArray | None) -> PlaceReport | None:
        """Look at the camera's place, which is learned once the robots were seen."""
        if self._camera_place is None:
            return None
        return self._camera_place.look(
            frame.image, discs, frame.captured_s, may_learn=self._known is not None
        )

    def _doubles(self) -> dict[int, str]:
        return doubles_of(self._tracker, self.settings.driven_ids)

    def _body_discs(self, poses: Poses) -> FloatArray:
        """Discs of all robots' bodies at their last known places."""
        bodies = self.settings.bodies
        return np.concatenate(
            [
                body_discs_px(
                    pose,
                    bodies[i].radius_m + (0.0 if i in poses else self.settings.reach_m),
                    self.calibration,
                    bodies[i].marker_height_m,
                )
                for i, pose in self._last_seen.items()
            ]
        )

    def _brought_up_to_date(self, change: Change | None) -> KnownScene:
        """Present scene; only changes are fitted again, if that can be trusted."""
        background = self._watcher.background
        if self._known is not None and change is not None and not (change.first or change.relit):
            known = self._known.refitted(background, change.rectangles)
            if known is not None:
                return known
        scene = vision.extract(
            background,
            **dict(self.settings.vision),
            calibration=self.calibration,
            bounds=self.settings.bounds_m,
        )
        return KnownScene.of(scene, self.calibration)


def doubles_of(tracker: MarkerTracker, driven_ids: Sequence[int]) -> dict[int, str]:
    """Sentences on driven robots' markers that are seen in two places."""
    found = {}
    for driven_id in driven_ids:
        places = tracker.doubles.get(driven_id, ())
        if len(places) > 1:
            where = " and ".join(f"({x:.2f}, {y:.2f}) m" for x, y, _ in places)
            found[driven_id] = f"the robot's marker {driven_id} is seen at {where} at once"
    return found
