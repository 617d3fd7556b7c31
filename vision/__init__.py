"""Global Vision: from a picture to a scene and robot poses.

Names are imported on first use, so that a module that needs one part does not pay for the
compiled kernels of the others.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vision.calibration import Calibration, CalibrationError
    from vision.calibration_file import load_calibration, save_calibration
    from vision.camera import Camera, CameraError, Frame
    from vision.change import Change, SceneWatcher
    from vision.doubts import doubts_about
    from vision.grey import PictureError
    from vision.latest_frame import LatestFrame
    from vision.markers import MarkedRobot, MarkerTracker, RobotPose
    from vision.observe import extract
    from vision.sources import camera_for

__all__ = [
    "Calibration",
    "CalibrationError",
    "Camera",
    "CameraError",
    "Change",
    "Frame",
    "LatestFrame",
    "MarkedRobot",
    "MarkerTracker",
    "PictureError",
    "RobotPose",
    "SceneWatcher",
    "camera_for",
    "doubts_about",
    "extract",
    "load_calibration",
    "save_calibration",
]

_HOME = {
    "Calibration": "vision.calibration",
    "CalibrationError": "vision.calibration",
    "Camera": "vision.camera",
    "CameraError": "vision.camera",
    "Change": "vision.change",
    "Frame": "vision.camera",
    "LatestFrame": "vision.latest_frame",
    "MarkedRobot": "vision.markers",
    "MarkerTracker": "vision.markers",
    "PictureError": "vision.binarise",
    "RobotPose": "vision.markers",
    "SceneWatcher": "vision.change",
    "camera_for": "vision.sources",
    "doubts_about": "vision.doubts",
    "extract": "vision.observe",
    "load_calibration": "vision.calibration_file",
    "save_calibration": "vision.calibration_file",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'vision' has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
