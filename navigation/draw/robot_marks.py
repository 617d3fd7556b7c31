"""Marks of a robot in a picture: its heading, its name beside it, its track in pieces."""

from __future__ import annotations

import math

import numpy as np

from navigation.draw.shapes import Colour, Label, Screen, Strokes
from planner.borders.polyline import distances_to_polyline
from planner.scene import FloatArray


def nose(
    x: float, y: float, size: float, heading_rad: float, colour: Colour, screen: Screen
) -> Strokes:
    """Draw a line along the heading from a robot's middle to its rim."""
    angle = screen.heading(heading_rad)
    tip = (x + size * math.cos(angle), y + size * math.sin(angle))
    return Strokes((np.array([(x, y), tip]),), colour, 2.5)


def lines_of(track: FloatArray | None) -> list[FloatArray]:
    """Lines (k >= 2, m) between the rows of NaN of a track (n, m)."""
    if track is None:
        return []
    pieces = np.split(track, np.flatnonzero(np.isnan(track[:, 0])))
    whole = [piece[~np.isnan(piece[:, 0])] for piece in pieces]
    return [piece for piece in whole if len(piece) > 1]


def name_beside(
    name: str, x: float, y: float, size: float, colour: Colour, screen: Screen, path: FloatArray
) -> Label:
    """Place the name right, left, below or above: inside the frame and off the path."""
    width = 8.0 * len(name)
    low, high = screen.frame.min(axis=0), screen.frame.max(axis=0)
    places = [
        (x + size + 6.0, y + 4.5, "start", x + size + 6.0 + 0.5 * width),
        (x - size - 6.0, y + 4.5, "end", x - size - 6.0 - 0.5 * width),
        (x, y + size + 16.0, "middle", x),
        (x, y - size - 8.0, "middle", x),
    ]
    best, room = places[0], -math.inf
    for place in places:
        middle = np.array([place[3], place[1] - 4.5])
        reach = (0.5 * width + 4.0, 8.0)
        if (middle - reach < low).any() or (middle + reach > high).any():
            continue
        off = distances_to_polyline(path, middle[None])[0] if len(path) > 1 else math.inf
        if min(off, 0.5 * width + 8.0) > room:
            best, room = place, min(off, 0.5 * width + 8.0)
    return Label(best[0], best[1], name, 14.0, colour, best[2], bold=True, halo=True)
