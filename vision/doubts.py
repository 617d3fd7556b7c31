"""Whether a scene as a whole is in doubt: nothing was seen in a picture, or far too much.

Rules
- A doubt is a sentence among the scene's remarks, and the same for whoever asks later: it follows
  from the scene alone. Scenes of maps and texts without a binarisation have none.
- An arena may be empty, and a picture without contrast looks the same: whoever drives where there
  were obstacles before has to ask.
"""

from __future__ import annotations

from dataclasses import replace

from planner.scene import Scene

MOST_RECORDS = 1000
"""Arenas have tens. Of the real pictures in ``CLEARWAY_REAL_DATA`` the parts on a table have 66,
rooms with a chessboard held up in them 264 at most (640 x 480); smoothed noise has 900."""


def doubts_about(scene: Scene) -> tuple[str, ...]:
    """Why nobody should drive in a picture's scene unasked; mostly nothing. O(objects)."""
    if scene.binarisation is None:
        return ()
    if not scene.objects:
        return (f"no obstacle was found in the picture: {scene.binarisation.reason}",)
    records = sum(len(o.records) + sum(map(len, o.holes)) for o in scene.objects)
    if records > MOST_RECORDS:
        return (
            f"{records} records were found, more than {MOST_RECORDS}: this is hardly a picture of "
            "an arena, or it is out of focus, very noisy or of the other polarity",
        )
    return ()


def with_doubts(scene: Scene) -> Scene:
    """The scene with its doubts before its remarks."""
    doubts = doubts_about(scene)
    return replace(scene, remarks=(*doubts, *scene.remarks)) if doubts else scene
