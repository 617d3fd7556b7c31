"""Pictures of ROS maps and masks other than PGM: the planner knows no OpenCV."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from planner.formats.map_files import Shades, read_bytes
from planner.scene import SceneError
from vision.camera.picture_size import oversize

PNG = b"\x89PNG\r\n\x1a\n"


def shades_of(image: NDArray[Any]) -> Shades:
    """Shades of a grey, BGR or BGRA picture of 8 or 16 bits; a mask of its transparent pixels."""
    most = float(np.iinfo(image.dtype).max)
    if image.ndim == 2:
        return image / most, np.zeros(image.shape, dtype=np.bool_)
    colours = image[:, :, :3] if image.shape[2] >= 3 else image[:, :, :1]
    shade = colours.mean(axis=2, dtype=np.float64) / most
    clear = np.zeros(shade.shape, dtype=np.bool_)
    if image.shape[2] in (2, 4):
        clear = np.asarray(image[:, :, -1] < most, dtype=np.bool_)
    return shade, clear


def read_png_shades(path: Path) -> Shades:
    """Shades of a whole PNG file and a mask of its transparent pixels; else `SceneError`.

    Of other kinds, OpenCV decodes a damaged file in part: a zone would be missing there.
    """
    data = read_bytes(path)
    large = oversize(data)
    if large:
        raise SceneError(f"{path}: {large}")
    if not data.startswith(PNG):
        raise SceneError(f"{path}: the picture of a mask must be PGM (P2 or P5) or PNG")
    image = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise SceneError(f"{path}: a damaged PNG picture")
    return shades_of(image)
