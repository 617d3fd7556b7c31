"""Doubts about a whole scene: nothing was found in the picture, or far too much.

Rules
- A doubt follows from the scene alone, so a later check gives the same. Scenes of maps and texts
  have no binarisation, hence no doubts.
- An empty arena and a picture without contrast look the same: a driver that saw obstacles before
  has to ask.
"""

from __future__ import annotations

from dataclasses import replace

from planner.scene import Scene, of_kind

MOST_RECORDS = 1000
"""Chosen: arenas have tens; of ``CLEARWAY_REAL_DATA`` rooms have 264 at most, and smoothed noise
has 900."""


def doubts_about(scene: Scene) -> tuple[str, ...]:
    """Reasons to ask before driving in a picture's scene. O(objects)."""
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
