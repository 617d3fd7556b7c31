"""Whether the arena as it is seen now can be what it was: what is in doubt holds the robot.

An arena without obstacles and a picture without contrast look the same. Where the first scene is
in doubt that is said, and whoever gives the mission has seen it; where a sound scene was there
before, the robot holds until a sound one comes again or a person accepts the arena as it is seen.

A camera that has moved shows every place beside where it is. Nobody accepts that: the robot holds
until the camera is back where it was, or a run with a new calibration begins. Where most of the
fixed points have vanished a person may accept it, unless there are floor markers: the points were
obstacles that somebody took away, perhaps.
"""

from __future__ import annotations

from navigation.loop.seeing.eye import Glimpse
from planner.scene import Scene
from vision.doubts import doubts_about
from vision.watch.camera_place import NOTHING_KNOWN


class SceneDoubt:
    """Fed with every glimpse; `accept` is a person's word.

    ``floor_markers``: whether the camera's place is watched by markers that nobody takes away.
    """

    def __init__(self, *, floor_markers: bool = False) -> None:
        self._was_sound = self._accepted = False
        self._doubt = ""
        self._objects_before = 0
        self._place = NOTHING_KNOWN
        self._floor_markers = floor_markers
        self._accepted_loss = False

    def look(self, glimpse: Glimpse) -> dict[str, str]:
        """Take what a frame has shown; what is to be said of it, by subject."""
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
        """The arena is as it is seen, however it was before."""
        self._accepted = bool(self._doubt)
        self._accepted_loss = bool(self._place.lost) and not self._floor_markers

    @property
    def remark(self) -> str | None:
        """What is to be said of the newest scene; None where it is sound."""
        return self._doubt or None

    @property
    def hold(self) -> str | None:
        """Why the robot has to hold, None where it need not."""
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
