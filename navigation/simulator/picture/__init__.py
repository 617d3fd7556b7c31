"""The simulated camera: its place, its pictures, and boards for calibrating it.

- `pinhole`: the camera's place and lens, and the places of points in its picture.
- `drawing`: floor, obstacles and robots, painted as the lens shows them, with light and blur.
- `timed_camera`: times of exposure and delivery; `camera`: frames of the arena at those times, with
  noise; `knocked_camera`: several of these, one after each knock.
- `boards`: pictures of a calibration board; `held_board`: a camera that sees one moved by hand.
"""
