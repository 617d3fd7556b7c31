"""The residual map: a survey's points on the arena's picture, each with its residual as an arrow.

Rules and units
- The picture is pale, so that lines are seen on any floor; the arena's axes are a grid of round
  metres on it, with numbers where it meets the first lines.
- Arrows are enlarged; an arrow of round length beside the legend says by how much. Those of
  points that were left out are cut where they would leave the picture.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibrate.survey import ArenaFit
from vision.calibration.calibration import Calibration, FloatArray
from vision.camera.camera import Image

_ARROW_SHARE = 0.1
"""The longest arrow, as a share of the picture's width; twice for points left out."""
_LINES = 6
"""About so many grid lines along the longer side of the survey."""
_USED, _LEFT_OUT, _GRID, _INK = (30, 120, 0), (0, 0, 220), (190, 150, 110), (40, 40, 40)
_GRID_INK = (130, 70, 10)
_FONT = cv2.FONT_HERSHEY_SIMPLEX
_FOOT_PX = 44
_SCALE_SHARE = 0.08
"""The legend's arrow is about this share of the picture's width."""


def draw_residuals(fit: ArenaFit, background: Image | None = None) -> Image:
    """A picture (h, w, 3) of the survey on ``background``, the arena's picture, or on white.

    Used points are green, those left out red; the numbers beside them are millimetres.
    """
    calibration = fit.calibration
    picture = _pale(background, calibration.size)
    _draw_axes(picture, calibration, fit.survey.places_m)
    places = calibration.arena_from_image(fit.survey.pixels)
    moved = calibration.image_from_arena(places + fit.residuals_m) - fit.survey.pixels
    lengths = np.linalg.norm(moved, axis=1)
    longest_px = _ARROW_SHARE * calibration.size[0]
    enlarged = _enlargement(float(lengths[np.array(fit.used)].max()), longest_px)
    rows = zip(fit.survey.pixels, moved, lengths, fit.residuals_m, fit.used, strict=True)
    for pixel, step, length, residual, used in rows:
        colour = _USED if used else _LEFT_OUT
        arrow = pixel + step * min(enlarged, 2.0 * longest_px / max(float(length), 1e-9))
        start = _whole(pixel)
        cv2.circle(picture, start, 4, colour, 2, cv2.LINE_AA)
        cv2.arrowedLine(picture, start, _whole(arrow), colour, 2, cv2.LINE_AA, tipLength=0.2)
        millimetres = 1000.0 * float(np.linalg.norm(residual))
        _say(picture, f"{millimetres:.1f}", (start[0] + 7, start[1] - 7), colour)
    _draw_foot(picture, enlarged, calibration.metres_per_pixel)
    return picture


def _pale(background: Image | None, size: tuple[int, int]) -> Image:
    width, height = size
    if background is None:
        return np.full((height, width, 3), 255, np.uint8)
    if background.ndim == 2:
        background = np.asarray(cv2.cvtColor(background, cv2.COLOR_GRAY2BGR), dtype=np.uint8)
    return np.asarray(128 + background // 2, dtype=np.uint8)


def _draw_axes(picture: Image, calibration: Calibration, places_m: FloatArray) -> None:
    """Lines of equal x and of equal y at round metres, curved as the lens curves them."""
    low, high = places_m.min(axis=0), places_m.max(axis=0)
    step = _round_below(float((high - low).max()) / _LINES * 1.5)
    first, last = np.floor(low / step + 1e-9), np.ceil(high / step - 1e-9)
    for axis, name in ((0, "x"), (1, "y")):
        other = 1 - axis
        along = np.linspace(first[other], last[other], 33) * step
        for number in np.arange(first[axis], last[axis] + 1.0):
            line = np.empty((len(along), 2))
            line[:, axis], line[:, other] = number * step, along
            seen = calibration.image_from_arena(line)
            pixels = np.rint(seen[np.isfinite(seen[:, 0])]).astype(np.int32)
            thick = 2 if number == 0.0 else 1
            cv2.polylines(picture, [pixels], False, _GRID, thick, cv2.LINE_AA)
            at = _inside(picture, pixels)
            if at is not None:
                _say(picture, f"{name} {number * step + 0.0:g} m", at, _GRID_INK)


def _inside(picture: Image, pixels: NDArray[np.int32]) -> tuple[int, int] | None:
    """Where a line's first place with room for words is."""
    height, width = picture.shape[:2]
    for x, y in pixels.tolist():
        if 4 <= x < width - 60 and 14 <= y < height - _FOOT_PX - 4:
            return x + 3, y - 4
    return None


def _draw_foot(picture: Image, enlarged: float, metres_per_pixel: float) -> None:
    height, width = picture.shape[:2]
    picture[max(height - _FOOT_PX, 0) :] = 255
    words = f"residuals in mm, arrows {enlarged:g} times enlarged; green: used, red: left out"
    _say(picture, words, (6, height - 8), _INK)
    shown_mm = 1000.0 * _round_below(_SCALE_SHARE * width / enlarged * metres_per_pixel)
    length_px = shown_mm / 1000.0 / metres_per_pixel * enlarged
    begin, end = (8, height - 30), (8 + round(length_px), height - 30)
    cv2.arrowedLine(picture, begin, end, _INK, 2, cv2.LINE_AA, tipLength=0.15)
    middle = f"{shown_mm:g} mm in the middle of the picture"
    _say(picture, middle, (end[0] + 8, height - 26), _INK)


def _say(picture: Image, words: str, at: tuple[int, int], colour: tuple[int, int, int]) -> None:
    cv2.putText(picture, words, at, _FONT, 0.42, (255, 255, 255), 3, cv2.LINE_AA)
    cv2.putText(picture, words, at, _FONT, 0.42, colour, 1, cv2.LINE_AA)


def _whole(point: FloatArray) -> tuple[int, int]:
    return round(float(point[0])), round(float(point[1]))


def _round_below(length: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is no longer."""
    power = 10.0 ** math.floor(math.log10(length))
    return power * max(digit for digit in (1, 2, 5) if digit * power <= length * (1.0 + 1e-9))


def _enlargement(longest_px: float, wanted_px: float) -> float:
    """The largest of 1, 2, 5, 10, ... 1000 that makes the longest arrow no longer than wanted."""
    steps = [digit * 10.0**power for power in range(3) for digit in (1, 2, 5)] + [1000.0]
    return max((s for s in steps if s * longest_px <= wanted_px), default=1.0)
