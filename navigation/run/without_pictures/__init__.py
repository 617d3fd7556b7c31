"""A simulated run without pictures: its eye gets the simulation's truth, as a camera would see it.

- `looking` makes the cameras and the parts of the eye, and refuses what only pictures can show.
- `sights` is the camera: a frame's picture is tiny and holds a number, under which the eye finds
  what was to be seen.
- `true_tracker` finds the markers and `true_watcher` the obstacles at that number; `true_eye` makes
  poses and scenes of both. They replace the parts that analyse pictures and keep all decisions
  about what is believed.
"""
