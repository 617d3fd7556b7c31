"""Eyes for one camera and for several that get the simulation's truth instead of pictures.

All decisions are those of `Eye` and `JoinedEye`. People see a blank picture. Metres, radians,
seconds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import vision
from navigation.loop.seeing.eye import Eye, EyeSettings, Glimpse, Poses
from navigation.loop.seeing.joined.joined_eye import JoinedEye
from navigation.run.without_pictures.sights import Sights
from navigation.run.without_pictures.true_watcher import Things, TrueWatcher
from planner.scene import Binarisation, Scene
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame, Image
from vision.doubts import with_doubts
from vision.joined.floor_plan import FloorPlan
from vision.markers.markers import MarkerTracker
from vision.records.unseen import hidden_by_lens, with_unseen
from vision.watch.change import Change
from vision.watch.refit import KnownScene

FLOOR_GREY = 200


class TrueEye(Eye):
    """`Eye` of a simulated camera that draws nothing."""

    def __init__(
        self,
        calibration: Calibration,
        tracker: MarkerTracker,
        settings: EyeSettings,
        *,
        sights: Sights,
    ) -> None:
        self._sights = sights
        self._blank = _blank(calibration)
        super().__init__(calibration, tracker, settings)

    def _new_watcher(self) -> TrueWatcher:
        return TrueWatcher(self._sights, self.calibration)

    def look(self, frame: Frame, tell: Callable[[Poses], None] = lambda _: None) -> Glimpse:
        """Return what `Eye.look` does, with a blank picture for people."""
        glimpse = super().look(frame, tell)
        return replace(glimpse, picture=replace(frame, image=self._blank))

    def _brought_up_to_date(self, change: Change | None) -> KnownScene:
        assert isinstance(self._watcher, TrueWatcher)
        scene = _scene_of(self._watcher.things, self.settings, self.calibration)
        hidden = hidden_by_lens(self.calibration, scene.bounds, vision.extract)
        return KnownScene(with_unseen(scene, hidden), self.calibration, ())


class TrueJoinedEye(JoinedEye):
    """`JoinedEye` of simulated cameras that draw nothing."""

    def __init__(
        self,
        plan: FloorPlan,
        trackers: Sequence[MarkerTracker],
        *given: Any,
        sights: Sights,
    ) -> None:
        self._sights = sights
        self._blank = _blank(plan.calibration)
        self.plan = plan
        super().__init__(plan, trackers, *given)

    def _new_watcher(self, index: int) -> TrueWatcher:
        return TrueWatcher(self._sights, self.plan.cameras[index])

    def _brought_up_to_date(self, _index: int, change: Change | None) -> KnownScene:
        self._note_live()
        things: Things = {}
        for one in self._views:
            if one.background is not None and isinstance(one.watcher, TrueWatcher):
                things |= one.watcher.things
        scene = _scene_of(things, self.settings, self.plan.calibration)
        return KnownScene(with_unseen(scene, self._unseen), self.plan.calibration, ())

    def _picture(self, captured_s: float) -> Frame:
        self._count += 1
        return Frame(self._blank, captured_s, self._count - 1, " + ".join(self._joined.names))


def _scene_of(things: Things, settings: EyeSettings, calibration: Calibration) -> Scene:
    """Scene of the known things, with the doubts that a picture of it would raise."""
    how = Binarisation("truth", 128.0, settings.vision.polarity, "the simulation holds none")
    return with_doubts(
        Scene(
            units="m",
            bounds=settings.bounds_m,
            objects=tuple(things[i].seen for i in sorted(things)),
            size=calibration.size,
            binarisation=how,
        )
    )


def _blank(calibration: Calibration) -> Image:
    width, height = calibration.size
    blank = np.full((height, width), FLOOR_GREY, np.uint8)
    blank.setflags(write=False)
    return blank
