"""Distance between two cameras' outlines on the floor that both see.

Rules and units
- Each camera's sub-pixel edge points are put on the floor, in metres. Every point well inside the
  common view is measured from the line through the other camera's two nearest points.
- The median counts, so a few edges that only one camera sees do not. Something high leans away from
  each camera, so its upper edges differ; the limit must allow for that.
- If both cameras have fewer than ``LEAST_COMMON_POINTS`` in the common view, the answer is unknown;
  if only one has, they contradict each other once the other has twice as many.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from vision.binarise import Method, Polarity
from vision.binarise.binarise import binarise
from vision.borders.contours import follow_borders, locate_edges
from vision.calibration.calibration import FloatArray
from vision.camera.camera import Image
from vision.joined.floor_plan import FloorPlan
from vision.picture_error import PictureError

LEAST_COMMON_POINTS: Final = 60
"""Least edge points in the common view: chosen, an outline of 20 pixels."""
MOST_POINTS: Final = 1500
"""Most points of each camera; of more every second, third, ... is taken."""
INSIDE_PX: Final = 8.0
"""Distance inside both pictures at which one's edge can be in the other."""
FARTHEST_M: Final = 0.25
"""Largest distance of a point from its partner."""


def edge_points_m(
    picture: Image,
    plan: FloorPlan,
    index: int,
    *,
    polarity: Polarity = "dark",
    method: Method = "auto",
    threshold: float | None = None,
) -> FloatArray:
    """Edge points (k, 2) of one camera's grey picture, on the floor in metres."""
    try:
        binary = binarise(picture, polarity=polarity, method=method, threshold=threshold)
    except PictureError:
        return np.empty((0, 2))
    edges = locate_edges(binary, follow_borders(binary.mask))
    return plan.cameras[index].arena_from_image(edges.points)


def outlines_apart_m(
    plan: FloorPlan, one: int, other: int, points: FloatArray, others: FloatArray
) -> float | None:
    """Median distance of two cameras' edge points where both see the floor, in metres.

    ``points`` (k, 2) and ``others`` (n, 2) come from `edge_points_m`. The larger of both
    directions; with too few points of one, ``FARTHEST_M`` if the other has twice enough, else None.
    O(k n), at most ``MOST_POINTS``.
    """
    here, there = (_in_both(plan, one, other, each) for each in (points, others))
    if min(len(here), len(there)) < LEAST_COMMON_POINTS:
        enough = max(len(here), len(there)) >= 2 * LEAST_COMMON_POINTS
        return FARTHEST_M if enough else None
    return max(_off_m(here, others), _off_m(there, points))


def _in_both(plan: FloorPlan, one: int, other: int, points: FloatArray) -> FloatArray:
    if not len(points):
        return points
    at = np.rint(plan.calibration.image_from_arena(points)).astype(int)
    height, width = plan.depth_px.shape[1:]
    there = (at >= 0).all(axis=1) & (at[:, 0] < width) & (at[:, 1] < height)
    found = points[there]
    columns, rows = at[there].T
    found = found[plan.overlap(one, other, INSIDE_PX)[rows, columns]]
    return np.asarray(found[:: 1 + len(found) // MOST_POINTS], dtype=np.float64)


def _off_m(points: FloatArray, others: FloatArray) -> float:
    """Median distance of points (k, 2) from the lines through the others' nearest two."""
    low, high = points.min(axis=0) - FARTHEST_M, points.max(axis=0) + FARTHEST_M
    near = others[((others >= low) & (others <= high)).all(axis=1)]
    near = near[:: 1 + len(near) // (2 * MOST_POINTS)]
    if len(near) < 2:
        return FARTHEST_M
    away = np.hypot(*(points[:, None, :] - near[None, :, :]).transpose(2, 0, 1))
    first, second = np.argpartition(away, 1, axis=1)[:, :2].T
    a, b = near[first], near[second]
    along = b - a
    length = np.hypot(*along.T)
    offset = points - a
    across = np.abs(along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0])
    nearest = away.min(axis=1)
    off = np.where(length > 0.0, across / np.maximum(length, 1e-12), nearest)
    # the line counts only between its points and slightly beyond
    off = np.where(nearest > 3.0 * length, nearest, np.minimum(off, nearest))
    return float(np.median(np.minimum(off, FARTHEST_M)))
