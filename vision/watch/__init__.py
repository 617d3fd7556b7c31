"""Changes from one picture to the next, and the scene brought up to date.

- `change` looks for changes in the arena; a static one costs a millisecond a frame.
- `refit` fits again what has changed, and keeps the rest of the scene.
- `fixed_points` follows points that do not move; from their common movement `camera_place` judges
  if the camera was knocked.
- `drift` is its sequential test of movement.
"""
