"""Doubts about a whole scene: nothing was found in the picture, or far too much.

Rules
- A doubt is one of the scene's remarks and follows from the scene alone, so a later check gives
  the same. Scenes of maps and texts have no binarisation, hence no doubts.
- An empty arena and a picture without contrast look the same: a driver that saw obstacles there
  before has to ask.
"""

from __future__ import annotations

from dataclasses import replace

from planner.scene import Scene, of_kind

MOST_RECORDS = 1000
"""Arenas have tens. Of the real pictures in ``CLEARWAY_REAL_DATA`` the parts on a table have 66,
rooms with a chessboard held up in them 264 at most (640 x 480); smoothed noise has 900."""


def doubts_about(scene: Scene) -> tuple[str, ...]:
    """Reasons to ask before driving in a picture's scene; usually none. O(objects)."""
    of_kind("scene", scene, Scene)
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
    """Put the scene's doubts before its remarks."""
    doubts = doubts_about(scene)
    return replace(scene, remarks=(*doubts, *scene.remarks)) if doubts else scene
