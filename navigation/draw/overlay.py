"""The records of a scene drawn over the picture that they were found in.

Rules and units
- The scene is in pixels. The picture is enlarged so that half a pixel can be seen, and its
  contrast is lowered so that the lines stand out.
- Colours are those of the other pictures (``shapes.py``): segments crimson, arcs violet,
  circles green, corners dots of ink.
"""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from navigation.draw import shapes
from planner.scene import (
    Arc,
    CircleRecord,
    Edge,
    PointRecord,
    Record,
    Scene,
    SceneObject,
    Vec,
    object_records,
    record_edges,
)

SEGMENT_BGR, ARC_BGR, CIRCLE_BGR, CORNER_BGR = (
    colour[::-1] for colour in (shapes.BOTTLENECK, shapes.TRACK, shapes.PATH, shapes.INK)
)
LARGEST_PX = 4000
"""Width or height that an enlarged picture stays below."""
SHIFT_BITS = 4
"""OpenCV draws lines between points of 1/16 pixel."""


def draw_overlay(image: NDArray[Any], scene: Scene) -> NDArray[np.uint8]:
    """The picture, enlarged, in pale colours, with every record drawn: (h', w', 3) BGR."""
    scale = max(1, min(4, LARGEST_PX // max(image.shape[:2])))
    top = max(int(image.max()), 1) if image.dtype == np.uint16 else 255
    eight = np.asarray(image * (255.0 / top), dtype=np.uint8)
    if eight.ndim == 2 or eight.shape[2] == 1:
        eight = np.repeat(eight.reshape(*eight.shape[:2], 1), 3, axis=2)
    pale = 128 + eight[:, :, :3] // 2
    canvas: NDArray[np.uint8] = pale.repeat(scale, axis=0).repeat(scale, axis=1)
    for obj in scene.objects:
        _draw_object(canvas, obj, scale)
    return canvas


def _draw_object(canvas: NDArray[np.uint8], obj: SceneObject, scale: int) -> None:
    for record in object_records(obj):
        colour = CIRCLE_BGR if isinstance(record, CircleRecord) else SEGMENT_BGR
        for edge in record_edges(record):
            own = ARC_BGR if isinstance(edge, Arc) and colour == SEGMENT_BGR else colour
            line = _fixed(edge_points(edge), scale)
            cv2.polylines(canvas, [line], False, own, 1, cv2.LINE_AA, SHIFT_BITS)
        for corner in _corners(record):
            center = _fixed([corner], scale)[0]
            radius = 2 << SHIFT_BITS
            cv2.circle(canvas, center.tolist(), radius, CORNER_BGR, -1, cv2.LINE_AA, SHIFT_BITS)


def edge_points(edge: Edge) -> list[Vec]:
    """A polyline along an edge of a scene in pixels, within 0.02 pixel of it."""
    if not isinstance(edge, Arc):
        return [edge.start, edge.end]
    begin, sweep = edge.sweep(y_down=True)
    step = 2.0 * math.acos(1.0 - min(0.02 / edge.radius, 0.5))
    count = max(2, math.ceil(abs(sweep) / step))
    (x, y), r = edge.center, edge.radius
    angles = [begin + sweep * i / count for i in range(count + 1)]
    return [(x + r * math.cos(a), y + r * math.sin(a)) for a in angles]


def _corners(record: Record) -> list[Vec]:
    if isinstance(record, PointRecord):
        return [record.at]
    if isinstance(record, CircleRecord):
        return []
    return [p for edge in record_edges(record) for p in (edge.start, edge.end)]


def _fixed(points: list[Vec], scale: int) -> NDArray[np.int32]:
    """Scene points as OpenCV's fixed-point pixels of the enlarged picture."""
    enlarged = (np.array(points) + 0.5) * scale - 0.5
    return np.rint(enlarged * (1 << SHIFT_BITS)).astype(np.int32)
