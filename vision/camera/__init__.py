"""Frames in: devices, streams, files and folders, and the newest frame of a camera."""

from vision.camera.camera import Camera, CameraError, Frame

__all__ = ["Camera", "CameraError", "Frame"]
