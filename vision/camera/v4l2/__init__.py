"""Cameras of Linux (V4L2), by the kernel's own requests.

- `structs` has the kernel's structures; `node` opens a device and asks it.
- `devices` lists cameras; `identity` finds one again after a replug; `users` names other programs
  that have it open.
- `modes` lists what it can deliver and chooses.
- `controls` sets exposure, gain, focus, white balance and mains frequency.
- `stream` reads its buffers, and `pixels` makes pictures of them.
- `device` joins these into a camera.

OpenCV's capture hides formats, controls, damage and sequence numbers; linuxpy is under the GPL.
"""
