"""A floor with markers and boxes, seen by a pinhole: for tests of cameras that are moved."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from planner.scene import Bounds, FloatArray
from vision.calibration.calibration import Calibration
from vision.camera.camera import Image

SIZE = (640, 480)
BOUNDS = Bounds(0.0, 0.0, 2.0, 1.5)
DICTIONARY = "DICT_4X4_50"
MARKER_M = 0.12
PLACES: dict[int, tuple[float, float]] = {
    20: (-0.12, -0.10), 21: (2.12, -0.08), 22: (2.10, 1.60), 23: (-0.10, 1.58), 24: (1.0, 1.62),
}  # fmt: skip
BOXES = ((0.3, 0.3, 0.2, 0.1), (1.4, 0.4, 0.1, 0.3), (0.8, 0.9, 0.3, 0.1), (0.02, 1.2, 0.1, 0.2))
"""x, y, width, height of dark boxes, metres."""
_TEXEL_M = 0.002
_LOW = (-0.6, -0.6)
_SIDE = 1700
FOCAL_PX = 560.0
MATRIX = np.array([[FOCAL_PX, 0.0, 319.0], [0.0, FOCAL_PX, 241.0], [0.0, 0.0, 1.0]])


def hanging(
    tilt_deg: tuple[float, float] = (1.0, -1.5),
    turn_deg: float = 0.5,
    at_m: tuple[float, float, float] = (1.02, 0.74, 2.6),
    distortion: Sequence[float] = (0.0,) * 5,
) -> Calibration:
    """A camera that looks down, and exactly how its pixels lie on the floor."""
    turns = (math.radians(tilt_deg[0]), math.radians(tilt_deg[1]), math.radians(turn_deg))
    rotation = np.diag([1.0, -1.0, -1.0])
    for axis in np.eye(3) * np.array(turns):
        rotation = cv2.Rodrigues(axis)[0] @ rotation
    pose = np.column_stack([rotation, -rotation @ np.array(at_m)])
    return Calibration.from_camera(SIZE, MATRIX, np.array(distortion), pose)


def floor_texture(
    places: Mapping[int, tuple[float, float]] | None = None,
    boxes: Sequence[tuple[float, float, float, float]] = BOXES,
) -> Image:
    """The floor from above, y up: light, with dark boxes and markers that face +x."""
    floor = np.full((_SIDE, _SIDE), 205, dtype=np.uint8)
    for x, y, width, height in boxes:
        (x0, y0), (x1, y1) = _texel(x, y), _texel(x + width, y + height)
        floor[y1:y0, x0:x1] = 45
    book = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, DICTIONARY))
    cell = round(MARKER_M / _TEXEL_M / 6)
    for marker_id, (x, y) in (PLACES if places is None else places).items():
        marker = cv2.copyMakeBorder(
            cv2.aruco.generateImageMarker(book, marker_id, 6 * cell), *(cell,) * 4,
            cv2.BORDER_CONSTANT, value=230,
        )  # fmt: skip
        column, row = _texel(x, y)
        half = len(marker) // 2
        floor[row - half : row + half, column - half : column + half] = marker
    return floor


def _texel(x: float, y: float) -> tuple[int, int]:
    return round((x - _LOW[0]) / _TEXEL_M), _SIDE - round((y - _LOW[1]) / _TEXEL_M)


def photograph(
    camera: Calibration, floor: Image, rng: np.random.Generator | None = None, gain: float = 1.0
) -> Image:
    """The floor as the camera sees it, with noise of 2.5 grey levels where ``rng`` is given."""
    fine = 4
    arena_from_texel = np.array(
        [
            [_TEXEL_M, 0.0, _LOW[0] + 0.5 * _TEXEL_M],
            [0.0, -_TEXEL_M, _LOW[1] + (_SIDE - 0.5) * _TEXEL_M],
            [0.0, 0.0, 1.0],
        ]
    )
    shift = (fine - 1) / 2.0
    fine_from_pixel = np.array([[fine, 0.0, shift], [0.0, fine, shift], [0.0, 0.0, 1.0]])
    to_fine = fine_from_pixel @ np.linalg.inv(camera.arena_from_pixel) @ arena_from_texel
    size = (SIZE[0] * fine, SIZE[1] * fine)
    seen = cv2.warpPerspective(floor, to_fine, size, flags=cv2.INTER_LINEAR, borderValue=150)
    small = cv2.resize(seen, SIZE, interpolation=cv2.INTER_AREA).astype(np.float64) * gain
    small = cv2.GaussianBlur(small, (0, 0), 0.6)
    picture = np.clip(np.rint(small), 0, 255).astype(np.uint8)
    return picture if rng is None else noisy(picture, rng)


def noisy(picture: Image, rng: np.random.Generator) -> Image:
    """The picture with noise of 2.5 grey levels."""
    noise = rng.normal(0.0, 2.5, picture.shape)
    return np.clip(np.rint(picture + noise), 0, 255).astype(np.uint8)


def seen_corners(camera: Calibration, centre_m: tuple[float, float]) -> FloatArray:
    """A marker's corners (4, 2) px, clockwise from its top left one, facing +x."""
    half = 0.5 * MARKER_M
    offsets = np.array([(-half, half), (half, half), (half, -half), (-half, -half)])
    return camera.image_from_arena(np.array(centre_m) + offsets)
