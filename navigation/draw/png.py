"""A drawing as pixels with OpenCV, made smooth by drawing it at twice the size."""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from navigation.draw.shapes import (
    PAGE,
    Area,
    Colour,
    DiscShape,
    Drawing,
    Label,
    Photo,
    Shape,
    Strokes,
)
from planner.borders.polyline import arc_lengths, points_at
from planner.scene import FloatArray

Canvas: TypeAlias = NDArray[Any]

SUPERSAMPLING = 2
_SHIFT = 4
"""Fractional bits of coordinates."""
_FONT = cv2.FONT_HERSHEY_SIMPLEX
_FONT_HEIGHT = 22.0
"""Pixels of a capital letter at scale 1."""


def to_pixels(drawing: Drawing) -> NDArray[np.uint8]:
    """(height, width, 3) uint8, BGR."""
    size = (drawing.height * SUPERSAMPLING, drawing.width * SUPERSAMPLING, 3)
    canvas: Canvas = np.empty(size, dtype=np.uint8)
    canvas[:] = _bgr(PAGE)
    for layer in drawing.layers:
        target = canvas
        if layer.clipped:
            x0, y0, x1, y1 = (round(SUPERSAMPLING * v) for v in drawing.view)
            edge = SUPERSAMPLING
            target = canvas.copy()
            inside = np.s_[max(y0 - edge, 0) : y1 + edge, max(x0 - edge, 0) : x1 + edge]
        for shape in layer.shapes:
            _draw(target, shape)
        if layer.clipped:
            canvas[inside] = target[inside]
    small = cv2.resize(canvas, (drawing.width, drawing.height), interpolation=cv2.INTER_AREA)
    return np.asarray(small, dtype=np.uint8)


def _draw(canvas: Canvas, shape: Shape) -> None:
    opacity = 1.0 if isinstance(shape, Label) else shape.opacity
    target = canvas if opacity >= 1.0 else canvas.copy()
    match shape:
        case Area(rings, fill, _, stroke):
            fixed = [_fixed(ring) for ring in rings]
            cv2.fillPoly(target, fixed, _bgr(fill), cv2.LINE_AA, _SHIFT)
            if stroke:
                cv2.polylines(target, fixed, True, _bgr(stroke), 2, cv2.LINE_AA, _SHIFT)
        case Strokes(lines, colour, width, _, dash):
            pieces = [p for line in lines for p in _dashes(line, dash)]
            _polylines(target, pieces, colour, width)
        case DiscShape(motion=None):
            _disc(target, shape)
        case Label():
            _text(target, shape)
        case Photo():
            _photo(target, shape)
    if target is not canvas:
        cv2.addWeighted(target, opacity, canvas, 1.0 - opacity, 0.0, dst=canvas)


def _polylines(canvas: Canvas, lines: list[FloatArray], colour: Colour, width: float) -> None:
    thickness = max(1, round(width * SUPERSAMPLING))
    if not lines:
        return
    cuts = np.cumsum([len(line) for line in lines])[:-1]
    fixed = np.split(_fixed(np.concatenate(lines)), cuts)
    cv2.polylines(canvas, fixed, False, _bgr(colour), min(thickness, 32767), cv2.LINE_AA, _SHIFT)


def _disc(canvas: Canvas, disc: DiscShape) -> None:
    (center,) = _fixed(np.array([[disc.x, disc.y]])).reshape(-1, 2).tolist()
    radius = round(disc.radius * SUPERSAMPLING * (1 << _SHIFT))
    if disc.fill:
        cv2.circle(canvas, center, radius, _bgr(disc.fill), -1, cv2.LINE_AA, _SHIFT)
    if disc.stroke:
        thickness = max(1, round(disc.width * SUPERSAMPLING))
        cv2.circle(canvas, center, radius, _bgr(disc.stroke), thickness, cv2.LINE_AA, _SHIFT)


def _photo(canvas: Canvas, photo: Photo) -> None:
    x0, y0 = (round(SUPERSAMPLING * v) for v in (photo.x, photo.y))
    size = tuple(round(SUPERSAMPLING * v) for v in (photo.width, photo.height))
    large = cv2.resize(photo.pixels, size, interpolation=cv2.INTER_NEAREST)
    canvas[y0 : y0 + size[1], x0 : x0 + size[0]] = large


def _text(canvas: Canvas, label: Label) -> None:
    scale = label.size * 0.73 * SUPERSAMPLING / _FONT_HEIGHT
    weight = 2 if label.bold else 1
    (width, _), _ = cv2.getTextSize(label.text, _FONT, scale, weight)
    shift = {"start": 0.0, "middle": 0.5, "end": 1.0}[label.anchor]
    at = (round(label.x * SUPERSAMPLING - shift * width), round(label.y * SUPERSAMPLING))
    if label.halo:
        for angle in np.linspace(0.0, math.tau, 12, endpoint=False):
            around = (at[0] + round(4 * math.cos(angle)), at[1] + round(4 * math.sin(angle)))
            cv2.putText(canvas, label.text, around, _FONT, scale, _bgr(PAGE), weight, cv2.LINE_AA)
    cv2.putText(canvas, label.text, at, _FONT, scale, _bgr(label.colour), weight, cv2.LINE_AA)


def _dashes(line: FloatArray, dash: tuple[float, float] | None) -> list[FloatArray]:
    if dash is None or len(line) < 2:
        return [line]
    lengths = arc_lengths(line)
    pieces = []
    for begin in np.arange(0.0, lengths[-1], dash[0] + dash[1]):
        end = min(begin + dash[0], lengths[-1])
        inside = lengths[(lengths > begin) & (lengths < end)]
        pieces.append(points_at(line, lengths, np.concatenate([[begin], inside, [end]])))
    return pieces


def _fixed(points: FloatArray) -> NDArray[np.int32]:
    """OpenCV's fixed-point coordinates, clipped far off the page."""
    scaled = (points * SUPERSAMPLING + 0.5 * (SUPERSAMPLING - 1)) * (1 << _SHIFT)
    return np.rint(np.clip(scaled, -1e6, 1e6)).astype(np.int32)


def _bgr(colour: Colour) -> tuple[int, int, int]:
    return colour[2], colour[1], colour[0]
