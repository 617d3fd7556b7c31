"""Whether the arena as it is seen now can be what it was: a scene in doubt holds the robot.

An arena without obstacles and a picture without contrast look the same. Where the first scene is
in doubt that is said, and whoever gives the mission has seen it; where a sound scene was there
before, the robot holds until a sound one comes again or a person accepts the arena as it is seen.
"""

from __future__ import annotations

from planner.scene import Scene
from vision.doubts import doubts_about


class SceneDoubt:
    """Fed with every new scene; `accept` is a person's word."""

    def __init__(self) -> None:
        self._was_sound = self._accepted = False
        self._doubt = ""
        self._objects_before = 0

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

    @property
    def remark(self) -> str | None:
        """What is to be said of the newest scene; None where it is sound."""
        return self._doubt or None

    @property
    def hold(self) -> str | None:
        """Why the robot has to hold, None where it need not."""
        if not self._doubt or not self._was_sound or self._accepted:
            return None
        count = self._objects_before
        before = "1 obstacle was" if count == 1 else f"{count} obstacles were"
        return f"{self._doubt}, where {before} seen before: look, then resume accepts it"
