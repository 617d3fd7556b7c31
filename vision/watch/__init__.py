"""Changes from one picture to the next, and the scene brought up to date.

- `change` looks for changes in the arena; a static one costs a millisecond a frame.
- `refit` fits again what has changed, and keeps the rest of the scene.
- `fixed_points` follows points of the picture that do not move; from them `camera_place` judges by
  their common movement if the camera was knocked.
- `drift` is the sequential test of a movement behind it.
"""
