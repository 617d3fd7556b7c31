"""The kernel's structures and requests for cameras, as far as Clearway uses them.

Sizes and gaps follow this machine's C compiler (ctypes). Source: linux/videodev2.h and
linux/v4l2-controls.h, version 6.1; names as there, in lower case.
"""

from __future__ import annotations

import ctypes
from ctypes import Structure, Union, c_char, c_int32, c_int64, c_long, c_uint8, c_uint32, c_ulong
from typing import Any, Final

CAPTURE: Final = 1
"""V4L2_BUF_TYPE_VIDEO_CAPTURE"""
MMAP: Final = 1
"""V4L2_MEMORY_MMAP"""

CAN_CAPTURE: Final = 0x1
CAN_CAPTURE_PLANES: Final = 0x1000
CAN_STREAM: Final = 0x04000000
HAS_NODE_CAPABILITIES: Final = 0x80000000

BUFFER_ERROR: Final = 0x40
STAMPED_AT_START: Final = 0x00010000
STAMP_SOURCE: Final = 0x00070000

CAN_SET_RATE: Final = 0x1000
"""V4L2_CAP_TIMEPERFRAME"""


class Capability(Structure):
    """struct v4l2_capability"""

    _fields_ = (
        ("driver", c_char * 16),
        ("card", c_char * 32),
        ("bus_info", c_char * 32),
        ("version", c_uint32),
        ("capabilities", c_uint32),
        ("device_caps", c_uint32),
        ("reserved", c_uint32 * 3),
    )


class FormatDescription(Structure):
    """struct v4l2_fmtdesc"""

    _fields_ = (
        ("index", c_uint32),
        ("type", c_uint32),
        ("flags", c_uint32),
        ("description", c_char * 32),
        ("pixelformat", c_uint32),
        ("mbus_code", c_uint32),
        ("reserved", c_uint32 * 3),
    )


class FrameSizes(Structure):
    """struct v4l2_frmsizeenum; ``sides`` is (width, height), or least, most, step of both."""

    _fields_ = (
        ("index", c_uint32),
        ("pixel_format", c_uint32),
        ("type", c_uint32),
        ("sides", c_uint32 * 6),
        ("reserved", c_uint32 * 2),
    )


class Fraction(Structure):
    """struct v4l2_fract"""

    _fields_ = (("numerator", c_uint32), ("denominator", c_uint32))


class FrameIntervals(Structure):
    """struct v4l2_frmivalenum; ``spans`` is one interval, or the least, the most and the step."""

    _fields_ = (
        ("index", c_uint32),
        ("pixel_format", c_uint32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("type", c_uint32),
        ("spans", Fraction * 3),
        ("reserved", c_uint32 * 2),
    )


class PixelFormat(Structure):
    """struct v4l2_pix_format"""

    _fields_ = (
        ("width", c_uint32),
        ("height", c_uint32),
        ("pixelformat", c_uint32),
        ("field", c_uint32),
        ("bytesperline", c_uint32),
        ("sizeimage", c_uint32),
        ("colorspace", c_uint32),
        ("priv", c_uint32),
        ("flags", c_uint32),
        ("ycbcr_enc", c_uint32),
        ("quantization", c_uint32),
        ("xfer_func", c_uint32),
    )


class _FormatUnion(Union):
    # the kernel's union has a member that begins with a pointer: hence the alignment
    _fields_ = (("pix", PixelFormat), ("raw", c_uint8 * 200), ("aligned", c_ulong))


class Format(Structure):
    """struct v4l2_format"""

    _fields_ = (("type", c_uint32), ("fmt", _FormatUnion))


class StreamParameters(Structure):
    """struct v4l2_streamparm, of a capture"""

    _fields_ = (
        ("type", c_uint32),
        ("capability", c_uint32),
        ("capturemode", c_uint32),
        ("timeperframe", Fraction),
        ("extendedmode", c_uint32),
        ("readbuffers", c_uint32),
        ("reserved", c_uint8 * 176),
    )


class BufferRequest(Structure):
    """struct v4l2_requestbuffers"""

    _fields_ = (
        ("count", c_uint32),
        ("type", c_uint32),
        ("memory", c_uint32),
        ("capabilities", c_uint32),
        ("reserved", c_uint32),
    )


class _Timestamp(Structure):
    _fields_ = (("tv_sec", c_long), ("tv_usec", c_long))


class _BufferPlace(Union):
    _fields_ = (("offset", c_uint32), ("userptr", c_ulong))


class Buffer(Structure):
    """struct v4l2_buffer"""

    _fields_ = (
        ("index", c_uint32),
        ("type", c_uint32),
        ("bytesused", c_uint32),
        ("flags", c_uint32),
        ("field", c_uint32),
        ("timestamp", _Timestamp),
        ("timecode", c_uint32 * 4),
        ("sequence", c_uint32),
        ("memory", c_uint32),
        ("m", _BufferPlace),
        ("length", c_uint32),
        ("reserved2", c_uint32),
        ("request_fd", c_int32),
    )


class ControlQuery(Structure):
    """struct v4l2_queryctrl"""

    _fields_ = (
        ("id", c_uint32),
        ("type", c_uint32),
        ("name", c_char * 32),
        ("minimum", c_int32),
        ("maximum", c_int32),
        ("step", c_int32),
        ("default_value", c_int32),
        ("flags", c_uint32),
        ("reserved", c_uint32 * 2),
    )


class Control(Structure):
    """struct v4l2_control"""

    _fields_ = (("id", c_uint32), ("value", c_int32))


class _MenuLabel(Union):
    _pack_ = 1
    _layout_ = "ms"
    _fields_ = (("name", c_char * 32), ("value", c_int64))


class ControlMenu(Structure):
    """struct v4l2_querymenu, packed as in the header"""

    _pack_ = 1
    _layout_ = "ms"
    _fields_ = (
        ("id", c_uint32),
        ("index", c_uint32),
        ("label", _MenuLabel),
        ("reserved", c_uint32),
    )


def _request(direction: int, number: int, of: type[Any]) -> int:
    """_IOC: 1 writes, 2 reads, 3 both."""
    return direction << 30 | ctypes.sizeof(of) << 16 | ord("V") << 8 | number


QUERYCAP: Final = _request(2, 0, Capability)
ENUM_FMT: Final = _request(3, 2, FormatDescription)
G_FMT: Final = _request(3, 4, Format)
S_FMT: Final = _request(3, 5, Format)
REQBUFS: Final = _request(3, 8, BufferRequest)
QUERYBUF: Final = _request(3, 9, Buffer)
QBUF: Final = _request(3, 15, Buffer)
DQBUF: Final = _request(3, 17, Buffer)
STREAMON: Final = _request(1, 18, c_int32)
STREAMOFF: Final = _request(1, 19, c_int32)
G_PARM: Final = _request(3, 21, StreamParameters)
S_PARM: Final = _request(3, 22, StreamParameters)
G_CTRL: Final = _request(3, 27, Control)
S_CTRL: Final = _request(3, 28, Control)
QUERYCTRL: Final = _request(3, 36, ControlQuery)
QUERYMENU: Final = _request(3, 37, ControlMenu)
ENUM_FRAMESIZES: Final = _request(3, 74, FrameSizes)
ENUM_FRAMEINTERVALS: Final = _request(3, 75, FrameIntervals)
