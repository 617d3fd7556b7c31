"""What the simulated camera sees: where it is, what it draws, and boards for calibrating it.

- `pinhole`: the camera's place and lens, and where points come to lie in its picture.
- `drawing`: floor, obstacles and robots, painted as the lens shows them, with light and noise.
- `camera`: frames of the arena at a rate, with the times of a real camera.
- `boards`: pictures of a calibration board, for trying out a calibration without one.
"""
