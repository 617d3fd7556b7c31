"""A slow oracle: how far sampled points are from what `clearway extract --format json` printed.

Written against the JSON's fields alone; it shares no code with the planner.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
ARC_STEPS = 4000


def edges_of(record: dict[str, Any]) -> list[dict[str, Any]]:
    """A record's edges; a circle becomes one full arc, a point an edge of no length."""
    match record["type"]:
        case "P":
            return [{"kind": "segment", "from": record["at"], "to": record["at"]}]
        case "S":
            return [{"kind": "segment", "from": record["from"], "to": record["to"]}]
        case "C":
            x, y = record["center"]
            start = [x + record["radius"], y]
            return [
                {
                    "kind": "arc",
                    "from": start,
                    "to": start,
                    "center": record["center"],
                    "radius": record["radius"],
                    "ccw": False,
                }
            ]
        case _:
            return list(record["edges"])


def borders(scene: dict[str, Any]) -> Iterator[list[dict[str, Any]]]:
    """Every object's outline and holes, as lists of records."""
    for item in scene["objects"]:
        yield item["records"]
        yield from item["holes"]


def trace(edge: dict[str, Any], y_down: bool) -> Points:
    """(k, 2) points along an edge from its start to its end; two for a segment."""
    if edge["kind"] == "segment":
        return np.array([edge["from"], edge["to"]], dtype=np.float64)
    cx, cy = edge["center"]
    a = math.atan2(edge["from"][1] - cy, edge["from"][0] - cx)
    b = math.atan2(edge["to"][1] - cy, edge["to"][0] - cx)
    falls = edge["ccw"] == y_down  # as seen on the screen, angles fall where y grows downwards
    turn = ((a - b) if falls else (b - a)) % math.tau or math.tau
    angles = a + (-turn if falls else turn) * np.linspace(0.0, 1.0, ARC_STEPS)
    return np.stack((cx + edge["radius"] * np.cos(angles), cy + edge["radius"] * np.sin(angles)), 1)


def outline(records: list[dict[str, Any]], y_down: bool) -> Points:
    """(k, 2) points round a closed border."""
    return np.concatenate([trace(edge, y_down) for r in records for edge in edges_of(r)])


def signed_area(points: Points) -> float:
    """The shoelace area: > 0 where the angle grows along the border."""
    x, y = points.T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2.0


def inside(points: Points, border: Points) -> NDArray[np.bool_]:
    """Whether each point lies inside a closed border, by counting crossings to the right."""
    found = np.zeros(len(points), dtype=np.bool_)
    for (x0, y0), (x1, y1) in zip(border, np.roll(border, -1, axis=0), strict=True):
        if y0 == y1:
            continue
        spans = (y0 > points[:, 1]) != (y1 > points[:, 1])
        at = x0 + (points[:, 1] - y0) * (x1 - x0) / (y1 - y0)
        found ^= spans & (points[:, 0] < at)
    return found


def distances(points: Points, scene: dict[str, Any], y_down: bool = True) -> Points:
    """Each point's distance from the nearest border or side of the bounds (not signed)."""
    x0, y0, x1, y1 = scene["bounds"]
    sides = [(points[:, 0] - x0), (x1 - points[:, 0]), (points[:, 1] - y0), (y1 - points[:, 1])]
    least = np.abs(np.stack(sides)).min(axis=0)
    for records in borders(scene):
        for record in records:
            for edge in edges_of(record):
                least = np.minimum(least, _edge_distance(points, edge, y_down))
    return np.asarray(least)


def _edge_distance(points: Points, edge: dict[str, Any], y_down: bool) -> Points:
    corners = trace(edge, y_down)
    least = np.full(len(points), np.inf)
    for start in range(0, len(points), 500):
        part = points[start : start + 500]
        if edge["kind"] == "segment":
            a, d = corners[0], corners[1] - corners[0]
            square = float(d @ d)
            t = np.clip((part - a) @ d / square, 0.0, 1.0) if square else np.zeros(len(part))
            off = np.hypot(*(part - (a + t[:, None] * d)).T)
        else:
            off = np.hypot(*np.moveaxis(part[:, None] - corners[None, ::4], 2, 0)).min(axis=1)
        least[start : start + 500] = off
    return least


def walk(path: Any, step: float) -> Points:
    """(k, 2) points along a polyline, no further than ``step`` apart, its corners included."""
    corners = np.asarray(path, dtype=np.float64)
    parts = [corners[:1]]
    for a, b in itertools.pairwise(corners):
        count = max(1, math.ceil(math.dist(a, b) / step))
        parts.append(a + (b - a) * np.linspace(0.0, 1.0, count + 1)[1:, None])
    return np.concatenate(parts)
