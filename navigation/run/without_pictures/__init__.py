"""A simulated run without pictures: its eye gets the simulation's truth, as a camera would see it.

`sights` is the camera: a frame's picture is tiny and holds a number, by which the eye finds what
was to be seen. `true_tracker`, `true_watcher` and `true_eye` take the place of the parts that look
at pictures; all that decides what is believed is theirs. `looking` says what a world looks with,
and refuses what only pictures can show.
"""
