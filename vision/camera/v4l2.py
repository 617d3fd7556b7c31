"""What a V4L2 device node says of itself, asked of the kernel without opening a stream.

A camera may have several nodes: one gives pictures, another what belongs to them (metadata). All
report what the whole camera can do, and each what this node of it can.

Source: VIDIOC_QUERYCAP in the Linux kernel's documentation of V4L2 (linux/videodev2.h).
"""

from __future__ import annotations

import errno
import fcntl
import os
import struct
from typing import Final

_QUERYCAP: Final = 0x80685600
"""_IOR('V', 0, struct v4l2_capability)"""
_CAPABILITY: Final = struct.Struct("16s32s32sIII12x")
"""driver, card, bus, version, capabilities of the whole, capabilities of this node"""
_VIDEO_CAPTURE, _VIDEO_CAPTURE_MPLANE, _DEVICE_CAPS = 0x1, 0x1000, 0x80000000


def gives_pictures(path: str) -> bool | None:
    """Whether a device node is one that pictures can be had from; None where it cannot be asked.

    A camera that another program uses answers too.
    """
    answer = bytearray(_CAPABILITY.size)
    try:
        node = os.open(path, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
    except OSError:
        return None
    try:
        fcntl.ioctl(node, _QUERYCAP, answer)
    except OSError as error:
        return False if error.errno in (errno.ENOTTY, errno.EINVAL) else None
    finally:
        os.close(node)
    *_, whole, of_this_node = _CAPABILITY.unpack(answer)
    can = of_this_node if whole & _DEVICE_CAPS else whole
    return bool(can & (_VIDEO_CAPTURE | _VIDEO_CAPTURE_MPLANE))
