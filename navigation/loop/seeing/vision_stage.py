"""Vision in the control loop: dates frames, looks at them, and replaces a failed eye.

A frame's time is its exposure, corrected by the measured latency. Seconds of the world's clock.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from navigation.config import Config
from navigation.config.sections import RobotSection
from navigation.config.several.each_camera import each_camera
from navigation.loop.seeing.eye import Eye, Glimpse
from navigation.loop.seeing.eye_settings import eye_settings, marked_robots, place_settings
from navigation.loop.seeing.joined.joined_eye import JoinedEye
from navigation.loop.seeing.joined.joined_parts import joined_eye
from navigation.shared.supervisor import in_words
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame
from vision.joined.floor_plan import FloorPlan
from vision.markers.markers import MarkerTracker, RobotPose
from vision.watch.camera_place import CameraPlace


class KnowsLatency(Protocol):
    """A witness, or several."""

    def latency_s(self) -> float:
        """Measured delay of the camera's pictures."""
        ...


@dataclass(frozen=True, slots=True)
class EyeParts:
    """Makers of an eye's parts; ``watches_place`` if they can notice that a camera was knocked."""

    tracker: Callable[..., MarkerTracker] = MarkerTracker
    eye: Callable[..., Eye] = Eye
    joined: Callable[..., JoinedEye] = JoinedEye
    watches_place: bool = True


class VisionStage:
    """The eye, the error that ended the last one, and the duration of the last look."""

    def __init__(
        self,
        config: Config,
        calibration: Calibration,
        witness: KnowsLatency,
        clock: Callable[[], float],
        driven: Sequence[RobotSection] = (),
        floor_plan: FloorPlan | None = None,
        parts: EyeParts = EyeParts(),
    ) -> None:
        self._parts = parts
        self._config, self._calibration = config, calibration
        self._floor_plan = floor_plan
        self._driven = tuple(driven)
        self._witness, self._clock = witness, clock
        self._failure: str | None = None
        self._places = self._watched_places()
        self._newest: dict[str, Frame] = {}
        self.eye = self._open_eye()
        self.look_s: float | None = None

    def failure(self) -> str | None:
        """Error that ended it, in words."""
        return self._failure

    def restart(self) -> None:
        """Open a new eye, which keeps only the cameras' places."""
        self.eye = self._open_eye()
        self._failure = None

    def look(
        self, frame: Frame, tell: Callable[[Mapping[int, RobotPose]], None]
    ) -> tuple[Frame, Glimpse] | None:
        """Return the frame with its own time and what it shows; None if the eye fails.

        ``tell`` gets the poses first.
        """
        began_s = self._clock()
        if self._failure is not None:
            return None
        frame = self._dated(frame)
        self._newest[frame.source if self._floor_plan is not None else ""] = frame
        try:
            glimpse = self.eye.look(frame, tell)
        except Exception as error:  # noqa: BLE001 - said, and the eye is made again
            self._failure = in_words(error)
            return None
        self.look_s = self._clock() - began_s
        return glimpse.picture or frame, glimpse

    def newest(self, camera: str | None) -> Frame | None:
        """Newest picture of the only camera, or of the named one of several; None without any."""
        return self._newest.get(camera or "")

    def _watched_places(self) -> tuple[CameraPlace, ...]:
        config, plan, began_s = self._config, self._floor_plan, self._clock()
        if not self._parts.watches_place:
            return ()
        if plan is None:
            return (CameraPlace(self._calibration, place_settings(config), began_s),)
        return tuple(
            CameraPlace(calibration, place_settings(config, calibration), began_s, name)
            for name, calibration in zip(each_camera(config), plan.cameras, strict=True)
        )

    def _open_eye(self) -> Eye | JoinedEye:
        if self._floor_plan is not None:
            return joined_eye(
                self._config,
                self._floor_plan,
                self._driven,
                self._places,
                self._parts.tracker,
                self._parts.joined,
            )
        robots = marked_robots(self._config, self._driven)
        rolling_s = self._config.camera.rolling_shutter_ms / 1000.0
        dictionary = self._config.robot.dictionary
        tracker = self._parts.tracker(self._calibration, robots, dictionary, rolling_s)
        settings = eye_settings(self._config, self._driven)
        return self._parts.eye(self._calibration, tracker, settings, *self._places)

    def _dated(self, frame: Frame) -> Frame:
        """Return the frame with its exposure time; a stamp in the future counts as now."""
        stamp_s = frame.captured_s if math.isfinite(frame.captured_s) else -math.inf
        stamp_s = min(stamp_s, self._clock())
        return replace(frame, captured_s=stamp_s - self._witness.latency_s())
