"""From pixels to metres and back: the model of a camera over an arena, and its file."""

from vision.calibration.calibration import Calibration, CalibrationError

__all__ = ["Calibration", "CalibrationError"]
