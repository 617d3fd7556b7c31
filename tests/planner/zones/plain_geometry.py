"""Distances to areas by plain formulas, which share nothing with the planner."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from planner.scene import FloatArray
from planner.zones.areas import Area, BandArea, CircleArea, PolygonArea


def distances(area: Area, points: FloatArray) -> FloatArray:
    """Distance (n,) of points (n, 2) to the area's border, negative inside."""
    match area:
        case CircleArea(center, radius):
            return np.asarray(np.hypot(*(points - center).T) - radius)
        case BandArea(line, width):
            return to_line(points, np.array(line)) - 0.5 * width
        case PolygonArea(corners):
            ring = np.array([*corners, corners[0]])
            apart = to_line(points, ring)
            return np.where(_winding(points, ring) % 2 == 1, -apart, apart)
    raise AssertionError(area)


def to_line(points: FloatArray, line: FloatArray) -> FloatArray:
    """Distance (n,) to a polyline."""
    least = np.full(len(points), np.inf)
    for a, b in pairwise(line):
        share = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        least = np.minimum(least, np.hypot(*(points - a - share[:, None] * (b - a)).T))
    return least


def _winding(points: FloatArray, ring: FloatArray) -> FloatArray:
    """Number of sides that a ray to the right crosses."""
    crossings = np.zeros(len(points), int)
    for (ax, ay), (bx, by) in pairwise(ring):
        with np.errstate(divide="ignore", invalid="ignore"):
            x = ax + (points[:, 1] - ay) / (by - ay) * (bx - ax)
        crossings += ((ay > points[:, 1]) != (by > points[:, 1])) & (points[:, 0] < x)
    return crossings


def dense(line: FloatArray, step: float = 0.002) -> FloatArray:
    """Points of a polyline at most a step apart."""
    parts = [
        a + np.linspace(0.0, 1.0, max(int(np.hypot(*(b - a)) / step), 1) + 1)[:, None] * (b - a)
        for a, b in pairwise(line)
    ]
    return np.concatenate(parts)
