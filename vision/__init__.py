"""Global Vision: from a picture to a scene and robot poses.

Names are imported on first use, so that a module that needs one part does not pay for the
compiled kernels of the others.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vision.calibration.calibration import Calibration, CalibrationError
    from vision.calibration.calibration_file import load_calibration, save_calibration
    from vision.camera.camera import Camera, CameraError, Frame
    from vision.camera.latest_frame import LatestFrame
    from vision.camera.sources import DeviceSettings, KnownCamera, camera_for
    from vision.camera.v4l2.controls import CameraControls
    from vision.doubts import doubts_about
    from vision.errors import PictureError
    from vision.markers.markers import MarkedRobot, MarkerTracker, RobotPose
    from vision.markers.reading import Marker, find_markers
    from vision.pipeline import extract
    from vision.watch.change import Change, SceneWatcher

__all__ = [
    "Calibration",
    "CalibrationError",
    "Camera",
    "CameraControls",
    "CameraError",
    "Change",
    "DeviceSettings",
    "Frame",
    "KnownCamera",
    "LatestFrame",
    "MarkedRobot",
    "Marker",
    "MarkerTracker",
    "PictureError",
    "RobotPose",
    "SceneWatcher",
    "camera_for",
    "doubts_about",
    "extract",
    "find_markers",
    "load_calibration",
    "save_calibration",
]

_HOME = {
    "Calibration": "vision.calibration.calibration",
    "CalibrationError": "vision.calibration.calibration",
    "Camera": "vision.camera.camera",
    "CameraControls": "vision.camera.v4l2.controls",
    "CameraError": "vision.camera.camera",
    "Change": "vision.watch.change",
    "DeviceSettings": "vision.camera.v4l2.device",
    "Frame": "vision.camera.camera",
    "KnownCamera": "vision.camera.v4l2.identity",
    "LatestFrame": "vision.camera.latest_frame",
    "MarkedRobot": "vision.markers.markers",
    "Marker": "vision.markers.reading",
    "MarkerTracker": "vision.markers.markers",
    "PictureError": "vision.errors",
    "RobotPose": "vision.markers.markers",
    "SceneWatcher": "vision.watch.change",
    "camera_for": "vision.camera.sources",
    "doubts_about": "vision.doubts",
    "extract": "vision.pipeline",
    "find_markers": "vision.markers.reading",
    "load_calibration": "vision.calibration.calibration_file",
    "save_calibration": "vision.calibration.calibration_file",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'vision' has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
