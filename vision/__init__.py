"""Global Vision: from a picture to a scene and robot poses.

Names are imported on first use, so that a module that needs one part does not pay for the
compiled kernels of the others.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vision.binarise import PictureError
    from vision.camera import Camera, CameraError, Frame
    from vision.observe import extract

__all__ = [
    "Camera",
    "CameraError",
    "Frame",
    "PictureError",
    "extract",
]

_HOME = {
    "Camera": "vision.camera",
    "CameraError": "vision.camera",
    "Frame": "vision.camera",
    "PictureError": "vision.binarise",
    "extract": "vision.observe",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'vision' has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
