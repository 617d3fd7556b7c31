"""Fixed points of a picture, and how far each is seen from its first place.

Rules and units
- Raw pixels, centres at integers. A point is a small patch of the picture: a floor marker, or a
  corner at the arena's border or beyond; corners farther inside only if these are too few.
- A patch is found where its normalised correlation is highest, to a fraction of a pixel by a
  parabola, whatever the light.
- A patch that looks like another place nearby is no fixed point.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from planner.scene import Bounds
from vision.calibration.calibration import Calibration, FloatArray
from vision.camera.camera import Image

CORNER_NAME = "at "
"""Beginning of the corners' names; the place in metres follows."""
MOST_CORNERS = 12
"""More cost time and show nothing new: a camera has six ways to move."""
HALF_PX, MARKER_HALF_PX = 12, 16
NEAR_PX, WIDE_PX = 8, 48
"""Reach of the search for a patch: in every frame, and now and then for lost ones."""
LEAST_LIKENESS = 0.7
"""Least likeness of a patch and the picture: a corner at 2.5 grey levels of noise has 0.99, half
covered 0.5."""
MOST_LIKENESS = 0.85
"""Largest likeness of a patch and another place."""
_LEAST_SPREAD = 8.0
"""Grey levels: a patch without contrast shows noise."""
_CANDIDATES, _QUALITY = 200, 0.05
_BORDER_SHARE = 0.08
"""Share of the arena's shorter side within which a corner is at the border."""
_APART = 12
"""Least distance of corners: this part of the picture's longer side."""
_SMOOTHING_PX = 1.5
_RIVAL_PX = 4

_Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class FixedPoint:
    """A patch of a picture: its middle, and ``marker_id`` if it is a floor marker's."""

    name: str
    place_px: tuple[float, float]
    patch: Image
    corner_px: tuple[int, int]
    """The patch's upper left pixel in its picture."""
    marker_id: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Readings:
    """One frame: ``moved_px`` (n, 2) from each point's first place, NaN if not seen.

    ``covered`` (n): a robot hides the point.
    """

    moved_px: FloatArray
    covered: _Flags

    @property
    def seen(self) -> _Flags:
        """Mask (n) of the points found."""
        return np.asarray(np.isfinite(self.moved_px[:, 0]))


def point_at(
    grey: Image, place_px: tuple[float, float], name: str, half_px: int, marker_id: int | None
) -> FixedPoint | None:
    """Fixed point with the patch around ``place_px``; None if it is plain or not whole."""
    column, row = round(place_px[0]), round(place_px[1])
    x0, y0 = column - half_px, row - half_px
    side = 2 * half_px + 1
    if x0 < 0 or y0 < 0 or x0 + side > grey.shape[1] or y0 + side > grey.shape[0]:
        return None
    patch = np.ascontiguousarray(grey[y0 : y0 + side, x0 : x0 + side])
    if float(patch.std()) < _LEAST_SPREAD:
        return None
    return FixedPoint(name, place_px, patch, (x0, y0), marker_id)


def corners_of(
    grey: Image, discs: FloatArray, calibration: Calibration, bounds: Bounds
) -> list[FixedPoint]:
    """Corners that are fixed points, at most ``MOST_CORNERS``, those at the border first.

    Robots cover ``discs`` (k, 3) x, y, radius. O(pixels).
    """
    smooth = cv2.GaussianBlur(grey, (0, 0), _SMOOTHING_PX)
    apart_px = max(grey.shape) / _APART
    found: object = cv2.goodFeaturesToTrack(smooth, _CANDIDATES, _QUALITY, apart_px / 4.0)
    if found is None:
        return []
    places = np.asarray(found, dtype=np.float64).reshape(-1, 2)
    places = places[~_covered(places, HALF_PX, discs)]
    if not len(places):
        return []
    floor = calibration.arena_from_image(places)
    chosen: list[FixedPoint] = []
    for i in np.argsort(_far_inside(floor, bounds), kind="stable").tolist():
        x, y = places[i].tolist()
        if any(np.hypot(x - p.place_px[0], y - p.place_px[1]) < apart_px for p in chosen):
            continue
        name = f"{CORNER_NAME}({floor[i, 0]:.2f}, {floor[i, 1]:.2f}) m"
        point = point_at(grey, (x, y), name, HALF_PX, None)
        if point is not None and _is_unlike_its_neighbours(grey, point):
            chosen.append(point)
        if len(chosen) == MOST_CORNERS:
            break
    return chosen


def _far_inside(floor_m: FloatArray, bounds: Bounds) -> _Flags:
    """Mask of places (n, 2) neither at the arena's border nor beyond it."""
    low, high = np.array([bounds.x_min, bounds.y_min]), np.array([bounds.x_max, bounds.y_max])
    rim = _BORDER_SHARE * float((high - low).min())
    return np.asarray(((floor_m > low + rim) & (floor_m < high - rim)).all(axis=1))


def _is_unlike_its_neighbours(grey: Image, point: FixedPoint) -> bool:
    likeness, (left, up) = _likeness(grey, point, (0, 0), WIDE_PX)
    column, row = point.corner_px[0] - left, point.corner_px[1] - up
    rows = slice(max(0, row - _RIVAL_PX), row + _RIVAL_PX + 1)
    columns = slice(max(0, column - _RIVAL_PX), column + _RIVAL_PX + 1)
    likeness[rows, columns] = -1.0
    return float(likeness.max()) < MOST_LIKENESS


def _covered(places: FloatArray, half_px: float, discs: FloatArray) -> _Flags:
    if not len(discs):
        return np.zeros(len(places), dtype=np.bool_)
    apart = np.hypot(*(places[:, None, :] - discs[None, :, :2]).transpose(2, 0, 1))
    return np.asarray((apart < discs[:, 2] + 1.5 * half_px).any(axis=1))


def _likeness(
    grey: Image, point: FixedPoint, moved: tuple[int, int], reach_px: int
) -> tuple[NDArray[np.float32], tuple[int, int]]:
    side = len(point.patch)
    x0, y0 = point.corner_px[0] + moved[0] - reach_px, point.corner_px[1] + moved[1] - reach_px
    left, up = max(0, x0), max(0, y0)
    window = grey[up : y0 + 2 * reach_px + side, left : x0 + 2 * reach_px + side]
    if window.shape[0] < side or window.shape[1] < side:
        return np.full((1, 1), -1.0, dtype=np.float32), (left, up)
    found = cv2.matchTemplate(window, point.patch, cv2.TM_CCOEFF_NORMED)
    return np.asarray(found, dtype=np.float32), (left, up)


def _find(
    grey: Image, point: FixedPoint, moved: tuple[int, int], reach_px: int
) -> tuple[float, float] | None:
    """Movement of the patch, searched around ``moved``; None if it is not there."""
    likeness, (left, up) = _likeness(grey, point, moved, reach_px)
    _, best, _, (column, row) = cv2.minMaxLoc(likeness)
    height, width = likeness.shape
    # a peak on the rim is the flank of something outside
    if not best >= LEAST_LIKENESS or not (0 < column < width - 1 and 0 < row < height - 1):
        return None
    across, down = likeness[row, column - 1 : column + 2], likeness[row - 1 : row + 2, column]
    x = left + column - point.corner_px[0] + _top_of_parabola(across)
    y = up + row - point.corner_px[1] + _top_of_parabola(down)
    return x, y


def _top_of_parabola(three: NDArray[np.float32]) -> float:
    before, middle, after = (float(v) for v in three)
    bend = before - 2.0 * middle + after
    return 0.5 * (before - after) / bend if bend < 0.0 else 0.0


class PointMeter:
    """Measurement of one picture's points in later frames; O(points) patches a frame."""

    def __init__(self, points: Sequence[FixedPoint]) -> None:
        self.points = tuple(points)
        self._places = np.array([p.place_px for p in points], dtype=np.float64).reshape(-1, 2)
        self._last: list[tuple[int, int] | None] = [(0, 0)] * len(self.points)
        self._turn = 0

    def measure(self, grey: Image, discs: FloatArray) -> Readings:
        """Measure each point's movement since it was learned; robots cover ``discs`` (k, 3).

        Each frame searches farther away for one lost point.
        """
        moved = np.full((len(self.points), 2), np.nan)
        covered = _covered(self._places, HALF_PX, discs)
        lost = []
        for i, point in enumerate(self.points):
            if covered[i]:
                continue
            last = self._last[i]
            found = _find(grey, point, last, NEAR_PX) if last is not None else None
            if found is None and last != (0, 0):
                found = _find(grey, point, (0, 0), NEAR_PX)
            if found is None:
                lost.append(i)
            self._take(i, found, moved)
        if lost:
            self._turn += 1
            i = lost[self._turn % len(lost)]
            self._take(i, _find(grey, self.points[i], (0, 0), WIDE_PX), moved)
        return Readings(moved, covered)

    def _take(self, i: int, found: tuple[float, float] | None, moved: FloatArray) -> None:
        self._last[i] = None if found is None else (round(found[0]), round(found[1]))
        if found is not None:
            moved[i] = found
