"""Doubts about the arena as seen now, which hold the robot.

An empty arena and a picture without contrast look the same. A doubt about the first scene is
reported. If a sound scene came before, the robot holds until a sound one returns or a person
accepts the arena as seen.

A camera that has moved shows every place displaced. No one can accept that: the robot holds until
the camera is back, or a run with a new calibration begins. If most of the fixed points have
vanished, perhaps with obstacles, a person may accept it, unless there are floor markers.
"""

from __future__ import annotations

from navigation.loop.seeing.eye import Glimpse
from planner.scene import Scene
from vision.doubts import doubts_about
from vision.watch.camera_place import NOTHING_KNOWN


class SceneDoubt:
    """Doubt about the scene, fed with every glimpse; ``floor_markers`` show the camera's place."""

    def __init__(self, *, floor_markers: bool = False) -> None:
        self._was_sound = self._accepted = False
        self._doubt = ""
        self._objects_before = 0
        self._place = NOTHING_KNOWN
        self._floor_markers = floor_markers
        self._accepted_loss = False

    def look(self, glimpse: Glimpse) -> dict[str, str]:
        """Take a frame's findings; return sentences by subject."""
        if glimpse.scene is not None:
            self.see(glimpse.scene)
        if glimpse.place is not None:
            self._place = glimpse.place
            self._accepted_loss &= bool(self._place.lost)
        place = self._place
        said = (place.moved, place.lost, *place.remarks)
        return {"arena": self._doubt, "camera's place": "; ".join(filter(None, said))}

    def see(self, scene: Scene) -> None:
        """Take the newest scene."""
        doubts = doubts_about(scene)
        self._doubt = doubts[0] if doubts else ""
        if not doubts:
            self._was_sound, self._accepted = True, False
            self._objects_before = len(scene.objects)

    def accept(self) -> None:
        """Accept the arena as seen."""
        self._accepted = bool(self._doubt)
        self._accepted_loss = bool(self._place.lost) and not self._floor_markers

    @property
    def remark(self) -> str | None:
        """Remark on the newest scene, if it is not sound."""
        return self._doubt or None

    @property
    def hold(self) -> str | None:
        """Reason why the robot holds, if any."""
        return self._place.moved or self._hold_for_loss() or self._hold_for_scene()

    def _hold_for_loss(self) -> str | None:
        if not self._place.lost or self._accepted_loss:
            return None
        if self._floor_markers:
            return self._place.lost
        return f"{self._place.lost}: look, then resume accepts it"

    def _hold_for_scene(self) -> str | None:
        if not self._doubt or not self._was_sound or self._accepted:
            return None
        count = self._objects_before
        before = "1 obstacle was" if count == 1 else f"{count} obstacles were"
        return f"{self._doubt}, where {before} seen before: look, then resume accepts it"
