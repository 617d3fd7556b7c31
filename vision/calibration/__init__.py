"""From pixels to metres and back: the model of a camera above an arena, and its file.

- `lens_model` is the lens: Brown's model or OpenCV's fisheye model, and how far each reaches.
- `calibration` joins it to the homography of the floor and to heights above it, with compiled
  loops in `calibration_kernels`.
- `blind` finds parts of a picture that show no usable floor.
- `calibration_file` reads and writes YAML, with errors that name file, line and column.
"""

from vision.calibration.calibration import Calibration, CalibrationError

__all__ = ["Calibration", "CalibrationError"]
