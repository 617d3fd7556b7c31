"""A simulated run without pictures: its eye gets the simulation's truth, as a camera would see it.

- `looking` makes the cameras and the parts of the eye, and refuses what only pictures can show.
- `sights` is the camera: its tiny pictures hold the number of what was to be seen.
- `true_tracker` finds the markers and `true_watcher` the obstacles at that number; `true_eye` makes
  poses and scenes of both. They keep all decisions about what is believed.
"""
