"""Frames from devices, streams, files and folders.

- `sources` finds a source's camera; `camera` is the interface, and a frame.
- `v4l2/` serves cameras plugged in, `capture` network streams, `picture_files` and `folder` the
  disk, with `picture_size` and `picture_turn` read from a file's header.
- `latest_frame` reads one camera in a thread and keeps its newest frame; `several_frames` does so
  for several cameras.
- `arrival_clock` puts another device's times on our clock, and `rate_remark` names a camera's wrong
  rate.
"""

from vision.camera.camera import Camera, CameraError, Frame

__all__ = ["Camera", "CameraError", "Frame"]
