"""The eye of a run with several cameras above one arena.

- `joined_parts` makes it from the configuration: a tracker for each camera, and one floor plan.
- `joined_eye` takes the cameras' frames and returns one set of poses and one scene.
"""
