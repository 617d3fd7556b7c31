"""Every marker in one picture: its identity, corners, and place on the floor.

Rules and units
- Corners (4, 2) are raw pixels, centres at integers, clockwise from the upright marker's top left
  one, where the fitted sides meet (``vision.markers.marker_corners``) or, with a calibration, of
  the whole pattern (``vision.markers.marker_pattern``). If the fit fails, the detector's stay;
  ``remark`` says why.
- A dictionary is OpenCV's by name or a file in its format (``nmarkers``, ``markersize``,
  ``marker_0`` ...). In a search of all, a marker belongs to the smallest of a family.

For moving robots use :class:`vision.MarkerTracker`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import ArrayLike

from vision.calibration.calibration import Calibration, FloatArray
from vision.camera.camera import Image
from vision.markers.marker_corners import why_refused
from vision.markers.marker_kernels import FITTED, fit_quad
from vision.markers.marker_pattern import pattern_bits
from vision.markers.marker_place_kernels import see_marker
from vision.markers.marker_search import (
    MarkerError,
    dictionary_by_name,
    dictionary_names,
    find_with,
    grey_of,
)
from vision.markers.sighting import nearest_square

_CELL_PX = 8
"""Side of a cell in the upright picture from which a marker is read again."""
_LEAST_AGREEMENT = 0.9
"""Least share of right cells in a search of all: OpenCV corrects more, which among thousands of
markers finds one in many a rectangle."""
_SAME_PLACE = 0.25
"""Readings of one marker are nearer to each other than this share of a side."""


@dataclass(frozen=True, slots=True, eq=False)
class Marker:
    """A marker in a picture; ``agreement`` is its share of right cells.

    ``pose`` is (x, y, heading) in metres and radians, ahead being the upright marker's right;
    ``size_m`` is the mean side. Both are None without a calibration. ``remark`` is empty if the
    corners are refined; ``error_px`` is then the worst one's standard error, larger if covered.
    Only a calibration reveals a cover over a whole side.
    """

    id: int
    dictionary: str
    corners_px: FloatArray
    agreement: float
    remark: str = ""
    pose: tuple[float, float, float] | None = None
    size_m: float | None = None
    error_px: float | None = None


def find_markers(
    image: ArrayLike,
    dictionary: str | Path | None = None,
    *,
    calibration: Calibration | None = None,
    height_m: float = 0.0,
) -> tuple[Marker, ...]:
    """Find the markers of one dictionary or all in a picture, ordered by dictionary and id.

    ``image`` (h, w) grey or (h, w, 3) BGR, uint8, is not changed. ``height_m`` is the markers'
    height above the calibrated floor. Raises ``MarkerError`` for an unknown dictionary, an invalid
    picture, or one of another size than the calibration's.
    """
    grey = _grey(image, calibration)
    found: list[Marker] = []
    for name, book in _books(dictionary):
        detector = cv2.aruco.ArucoDetector(book, cv2.aruco.DetectorParameters())
        for marker_id, quad in find_with(detector, grey):
            agreement = _agreement(grey, quad, pattern_bits(book, marker_id))
            if dictionary is not None or agreement >= _LEAST_AGREEMENT:
                called = name if dictionary is not None else _smallest(name, marker_id)
                bits = pattern_bits(book, marker_id)
                placed = _placed(grey, quad, bits, calibration, height_m)
                corners_px, remark, pose, size_m, error_px = placed
                found.append(
                    Marker(marker_id, called, corners_px, agreement, remark, pose, size_m, error_px)
                )
    return tuple(sorted(_best_of_each(found), key=lambda m: (m.dictionary, m.id)))


def crossing(corners: FloatArray) -> tuple[float, float]:
    """Intersection of a quadrilateral's (4, 2) diagonals: the square's centre, in perspective."""
    a, b, c, d = corners
    across, along = c - a, d - b
    turn = across[0] * along[1] - across[1] * along[0]
    gap = b - a
    share = (gap[0] * along[1] - gap[1] * along[0]) / turn
    x, y = a + share * across
    return float(x), float(y)


def read_dictionary(file: Path) -> cv2.aruco.Dictionary:
    """Read a dictionary in OpenCV's format; ``MarkerError`` if invalid."""
    book = cv2.aruco.Dictionary()
    try:
        storage = cv2.FileStorage(str(file), cv2.FILE_STORAGE_READ)
        if storage.isOpened() and book.readDictionary(storage.root()) and len(book.bytesList):
            return book
    except (cv2.error, SystemError):  # a constructor that fails within OpenCV raises the latter
        pass
    raise MarkerError(
        f"{file}: not a dictionary of markers: 'nmarkers', 'markersize' and 'marker_0' ... are"
        " expected, as OpenCV writes them"
    )


def _grey(image: ArrayLike, calibration: Calibration | None) -> Image:
    picture = np.asarray(image)
    if picture.dtype != np.uint8 or picture.ndim not in (2, 3) or not picture.size:
        raise MarkerError(
            f"a picture of shape {picture.shape}, {picture.dtype}: must be (h, w) grey or"
            " (h, w, 3) BGR, uint8"
        )
    grey = grey_of(picture)
    size = (grey.shape[1], grey.shape[0])
    if calibration is not None and tuple(calibration.size) != size:
        wanted = "x".join(map(str, calibration.size))
        raise MarkerError(f"the picture is {size[0]}x{size[1]}, the calibration's {wanted}")
    return np.ascontiguousarray(grey)


def _books(dictionary: str | Path | None) -> Iterator[tuple[str, cv2.aruco.Dictionary]]:
    if dictionary is None:
        largest: dict[str, str] = {}
        for name in sorted(dictionary_names(), key=_count_in):
            largest[re.sub(r"_\d+$", "", name)] = name
        for name in largest.values():
            yield name, dictionary_by_name(name)
    elif isinstance(dictionary, Path) or Path(dictionary).suffix:
        yield Path(dictionary).name, read_dictionary(Path(dictionary))
    else:
        wanted = dictionary.strip().upper()
        full = wanted if wanted.startswith("DICT_") else f"DICT_{wanted}"
        book = dictionary_by_name(dictionary)
        yield next((name for name in dictionary_names() if name.upper() == full), full), book


def _count_in(name: str) -> int:
    count = re.search(r"\dX\d_(\d+)$", name)
    return int(count[1]) if count else 0


def _smallest(name: str, marker_id: int) -> str:
    family = re.sub(r"_\d+$", "", name)
    alike = [one for one in dictionary_names() if re.sub(r"_\d+$", "", one) == family]
    return min((one for one in alike if _count_in(one) > marker_id), key=_count_in, default=name)


def _agreement(grey: Image, quad: FloatArray, bits: FloatArray) -> float:
    side = bits.shape[0] * _CELL_PX
    corners = np.array([(0, 0), (side, 0), (side, side), (0, side)], np.float32) - 0.5
    upright = cv2.warpPerspective(
        grey, cv2.getPerspectiveTransform(quad.astype(np.float32), corners), (side, side)
    )
    _, light = cv2.threshold(upright, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    cells = np.asarray(light).reshape(bits.shape[0], _CELL_PX, bits.shape[1], _CELL_PX)
    inner = cells[:, 2:-2, :, 2:-2].mean(axis=(1, 3))
    return float(np.mean((inner > 127.5) == (bits > 0.5)))


def _placed(
    grey: Image,
    quad: FloatArray,
    bits: FloatArray,
    calibration: Calibration | None,
    height_m: float,
) -> tuple[FloatArray, str, tuple[float, float, float] | None, float | None, float | None]:
    """Corners in raw pixels, remark, pose and side on the floor, and error."""
    guess_px, corners_px = np.array(quad, dtype=np.float64, order="C"), np.empty((4, 2))
    if calibration is None:
        straight = Calibration.from_scale(1.0, (grey.shape[1], grey.shape[0]))
        became, roughness_px, fit_px = fit_quad(
            grey, guess_px, bits.shape[0], straight.lens, corners_px
        )
        if became != FITTED:
            return quad, why_refused(became, roughness_px), None, None, None
        return corners_px, "", None, None, fit_px
    corners, remark, error_px = np.empty((4, 2)), "", None
    view = calibration.plane_view(height_m)
    became, roughness_px, fit_px = see_marker(grey, guess_px, bits, view, corners, corners_px)
    if became == FITTED:
        error_px = max(fit_px, nearest_square(corners)[2] / calibration.metres_per_pixel)
    else:
        corners_px, remark = quad, why_refused(became, roughness_px)
        corners = calibration.arena_from_image(quad, height_m)
        if not np.isfinite(corners).all():
            return quad, remark, None, None, None
    sides = np.roll(corners, -1, axis=0) - corners
    center = corners.mean(axis=0)
    ahead = (corners[1] + corners[2] - corners[0] - corners[3]) / 2.0
    heading_rad = float(np.arctan2(ahead[1], ahead[0]))
    size_m = float(np.hypot(sides[:, 0], sides[:, 1]).mean())
    return corners_px, remark, (float(center[0]), float(center[1]), heading_rad), size_m, error_px


def _best_of_each(found: list[Marker]) -> list[Marker]:
    """Keep each place's best reading: refined ones first, then by agreement."""
    kept: list[Marker] = []
    for marker in sorted(found, key=lambda m: (m.remark != "", -m.agreement)):
        center = marker.corners_px.mean(axis=0)
        side = float(np.linalg.norm(marker.corners_px[1] - marker.corners_px[0]))
        near = _SAME_PLACE * side
        if all(np.linalg.norm(other.corners_px.mean(axis=0) - center) > near for other in kept):
            kept.append(marker)
    return kept
