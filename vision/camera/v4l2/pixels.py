"""Pictures from a camera's buffers: raw formats and JPEG, with damage detected.

Rules
- Pictures are grey (h, w) or BGR (h, w, 3). Grey is the Y of raw YUV and of a JPEG, whose colours
  are then not decoded.
- A damaged picture gives None: a JPEG without its end or of another size than agreed, or a raw one
  with too few bytes. Zeros after a JPEG are not damage.
"""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np

from vision.camera.camera import Image
from vision.camera.picture_size import picture_size
from vision.camera.v4l2.modes import PACKED, Size

_END: Final = b"\xff\xd9"
_PACKED_YUV: Final = {
    "YUYV": (cv2.COLOR_YUV2GRAY_YUY2, cv2.COLOR_YUV2BGR_YUY2),
    "UYVY": (cv2.COLOR_YUV2GRAY_UYVY, cv2.COLOR_YUV2BGR_UYVY),
    "YVYU": (cv2.COLOR_YUV2GRAY_YVYU, cv2.COLOR_YUV2BGR_YVYU),
}
_PLANAR_YUV: Final = {
    "NV12": cv2.COLOR_YUV2BGR_NV12,
    "NV21": cv2.COLOR_YUV2BGR_NV21,
    "YU12": cv2.COLOR_YUV2BGR_I420,
    "YV12": cv2.COLOR_YUV2BGR_YV12,
}
# V4L2 names the first row's first pixels, OpenCV the second row's second ones
_MOSAICS: Final = {
    "RGGB": (cv2.COLOR_BayerBG2GRAY, cv2.COLOR_BayerBG2BGR),
    "BA81": (cv2.COLOR_BayerRG2GRAY, cv2.COLOR_BayerRG2BGR),
    "GBRG": (cv2.COLOR_BayerGR2GRAY, cv2.COLOR_BayerGR2BGR),
    "GRBG": (cv2.COLOR_BayerGB2GRAY, cv2.COLOR_BayerGB2BGR),
}


def picture_of(
    data: Image, fourcc: str, size: Size, bytes_per_line: int, *, colour: bool
) -> Image | None:
    """Copy the picture in a buffer's bytes (n,); None if it is damaged."""
    if fourcc in PACKED:
        return _of_jpeg(data, size, colour=colour)
    return _of_raw(data, fourcc, size, bytes_per_line, colour=colour)


def _of_jpeg(data: Image, size: Size, *, colour: bool) -> Image | None:
    head = data[:4096].tobytes()
    if picture_size(head) != size and picture_size(data.tobytes()) != size:
        return None
    tail = data[-65536:].tobytes().rstrip(b"\0")
    if not tail.endswith(_END) and _END not in tail:
        return None
    how = cv2.IMREAD_COLOR if colour else cv2.IMREAD_GRAYSCALE
    try:
        picture = cv2.imdecode(data, how | cv2.IMREAD_IGNORE_ORIENTATION)
    except cv2.error:
        return None
    return None if picture is None else picture.astype(np.uint8, copy=False)


def _of_raw(
    data: Image, fourcc: str, size: Size, bytes_per_line: int, *, colour: bool
) -> Image | None:
    width, height = size
    bytes_per_pixel = 2 if fourcc in _PACKED_YUV else 3 if fourcc in ("BGR3", "RGB3") else 1
    line = max(bytes_per_line, width * bytes_per_pixel)
    rows = height * 3 // 2 if fourcc in _PLANAR_YUV else height
    if fourcc in ("YU12", "YV12") and line != width:
        return None
    if len(data) < line * (rows - 1) + width * bytes_per_pixel:
        return None
    whole = data[: line * rows]
    if len(whole) < line * rows:
        whole = np.pad(whole, (0, line * rows - len(whole)))
    plane = whole.reshape(rows, line)[:, : width * bytes_per_pixel]
    return _converted(np.ascontiguousarray(plane), fourcc, size, colour=colour)


def _converted(plane: Image, fourcc: str, size: Size, *, colour: bool) -> Image:
    width, height = size
    if fourcc == "GREY":
        return plane.copy()
    if fourcc in _PACKED_YUV:
        code = _PACKED_YUV[fourcc][colour]
        picture = cv2.cvtColor(plane.reshape(height, width, 2), code)
    elif fourcc in _PLANAR_YUV:
        if not colour:
            return plane[:height].copy()
        picture = cv2.cvtColor(plane, _PLANAR_YUV[fourcc])
    elif fourcc in _MOSAICS:
        picture = cv2.cvtColor(plane, _MOSAICS[fourcc][colour])
    else:
        picture = plane.reshape(height, width, 3)
        if fourcc == "RGB3":
            code = cv2.COLOR_RGB2BGR if colour else cv2.COLOR_RGB2GRAY
            picture = cv2.cvtColor(picture, code)
        else:
            picture = picture.copy() if colour else cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    return picture.astype(np.uint8, copy=False)
