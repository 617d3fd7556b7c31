"""Cameras of Linux (V4L2), asked and read by the kernel's own requests.

`node` opens a device; `modes` lists what it can deliver and chooses; `controls` sets exposure,
gain, focus, white balance and mains frequency; `stream` reads its buffers; `pixels` makes pictures
of them; `identity` finds a camera again after a replug; `users` names who else has it open;
`device` puts these together as a camera. OpenCV's capture hides formats, controls, damage and
sequence numbers, and linuxpy, the library with all of this, is under the GPL; Clearway is not.
"""
