"""A camera's picture with its judgement drawn in: sharp and blurred tiles, clipping, markers."""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.quality import Quality
from vision.quality.brightness import WHITE
from vision.quality.focus import SHARP_PX

Canvas: TypeAlias = NDArray[Any]

GREEN, AMBER, RED, GREY = (70, 160, 40), (20, 150, 230), (40, 40, 215), (150, 150, 150)
"""Blue, green, red."""


def draw_judged(quality: Quality, arena_px: NDArray[np.float64] | None) -> NDArray[np.uint8]:
    """Draw the picture (h, w, 3) BGR; ``arena_px`` (n, 2) is the arena's border in it."""
    drawn: Canvas = cv2.cvtColor(quality.picture, cv2.COLOR_GRAY2BGR)
    drawn[quality.picture >= WHITE] = RED
    width = max(1, round(min(drawn.shape[:2]) / 400))
    rows, columns = quality.focus.blur_px.shape
    height, across = quality.picture.shape
    for row in range(rows):
        for column in range(columns):
            corner = (column * across // columns, row * height // rows)
            other = ((column + 1) * across // columns, (row + 1) * height // rows)
            blur_px = float(quality.focus.blur_px[row, column])
            colour = _colour(blur_px)
            inset = 2 * width
            cv2.rectangle(
                drawn, (corner[0] + inset, corner[1] + inset), (other[0] - inset, other[1] - inset),
                colour, width,
            )  # fmt: skip
            text = "no edge" if math.isnan(blur_px) else f"{blur_px:.1f} px"
            _write(drawn, text, (corner[0] + 4 * width, other[1] - 5 * width), colour, width)
    if arena_px is not None:
        ring = np.rint(16.0 * arena_px).astype(np.int32)
        cv2.polylines(drawn, [ring], True, AMBER, 2 * width, cv2.LINE_AA, 4)
    for marker in quality.markers:
        quad = np.rint(16.0 * marker.corners_px).astype(np.int32)
        blur_px = math.nan if marker.blur_px is None else marker.blur_px
        cv2.polylines(drawn, [quad], True, _colour(blur_px), 2 * width, cv2.LINE_AA, 4)
        x, y = (round(float(v)) for v in marker.corners_px.mean(axis=0))
        known = "" if math.isnan(blur_px) else f": {blur_px:.1f} px"
        _write(drawn, f"{marker.id}{known}", (x, y), _colour(blur_px), width)
    return np.asarray(drawn, dtype=np.uint8)


def _colour(blur_px: float) -> tuple[int, int, int]:
    if math.isnan(blur_px):
        return GREY
    return GREEN if blur_px <= SHARP_PX else RED


def _write(
    drawn: Canvas,
    text: str,
    at: tuple[int, int],
    colour: tuple[int, int, int],
    width: int,
) -> None:
    scale = 0.45 * width
    for thick, shade in ((3 * width, (255, 255, 255)), (width, colour)):
        cv2.putText(drawn, text, at, cv2.FONT_HERSHEY_SIMPLEX, scale, shade, thick, cv2.LINE_AA)
