"""Curved lines one pixel wide: an open chain of pixels becomes the record A.

Rules and units
- The chain's points are its pixels' centres, in order, in rectified pixels, y down.
- Pixels side by side are neighbours; diagonal ones only if no pixel joins them.
- One arc if every pixel's centre lies within ``CURVE_NEAR_PX`` of it, otherwise a polyline.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from planner.scene import Arc, Edge, Segment, Vec
from vision.outline.fit.edge_shape_kernels import fit_circle, refine_circle

Pixel = tuple[int, int]
CURVE_NEAR_PX = 0.75
"""Largest distance of a drawn curve's pixels: half a pixel's diagonal, and a little."""
FEWEST_CHAIN_PX = 5
"""Pixels of the shortest chain whose bend is no rounding."""
SIDES = ((1, 0), (0, 1), (-1, 0), (0, -1))
ACROSS = ((1, 1), (-1, 1), (-1, -1), (1, -1))


def open_chain(pixels: list[Pixel]) -> list[Pixel] | None:
    """Pixels in order from end to end, or None if they are no open chain, with two ends and no
    branches."""
    if len(pixels) < FEWEST_CHAIN_PX:
        return None
    links = _links(set(pixels))
    # a sharp bend leaves a single pixel sticking out
    nubs = {p for p, near in links.items() if len(near) == 1 and len(links[near[0]]) == 3}
    if nubs:
        links = _links(set(pixels) - nubs)
    if max(len(near) for near in links.values()) > 2:
        return None
    ends = [pixel for pixel, near in links.items() if len(near) == 1]
    if len(ends) != 2:
        return None
    chain = [min(ends)]
    before: Pixel | None = None
    while True:
        onward = [pixel for pixel in links[chain[-1]] if pixel != before]
        if not onward:
            return chain if len(chain) == len(links) else None
        before = chain[-1]
        chain.append(onward[0])


def _links(there: set[Pixel]) -> dict[Pixel, list[Pixel]]:
    links: dict[Pixel, list[Pixel]] = {}
    for x, y in there:
        links[x, y] = [(x + dx, y + dy) for dx, dy in SIDES if (x + dx, y + dy) in there]
        links[x, y] += [
            (x + dx, y + dy)
            for dx, dy in ACROSS
            if (x + dx, y + dy) in there and not {(x + dx, y), (x, y + dy)} & there
        ]
    return links


def chain_edges(points: NDArray[np.float64]) -> tuple[list[Edge], float]:
    """One arc along the points (n, 2), or a polyline's segments; and the rms residual."""
    px, py = np.ascontiguousarray(points[:, 0]), np.ascontiguousarray(points[:, 1])
    circle = np.empty(3)
    if fit_circle(px, py, 0, len(px), circle):
        refine_circle(px, py, 0, len(px), circle)
        cx, cy, radius = circle.tolist()
        away = np.hypot(px - cx, py - cy) - radius
        if float(np.abs(away).max()) <= CURVE_NEAR_PX:
            # y down: the angle grows clockwise on the screen
            turn = float(np.sum((px[:-1] - cx) * np.diff(py) - (py[:-1] - cy) * np.diff(px)))
            start, end = (_onto(px[i], py[i], cx, cy, radius) for i in (0, -1))
            arc = Arc(start, end, (cx, cy), radius, ccw=turn < 0.0)
            return [arc], float(np.sqrt(np.mean(away**2)))
    corners = _corners(points, 0, len(points) - 1)
    vertices = [(float(px[i]), float(py[i])) for i in [0, *corners, len(points) - 1]]
    edges: list[Edge] = [Segment(a, b) for a, b in pairwise(vertices)]
    return edges, 0.5 * CURVE_NEAR_PX


def _onto(x: float, y: float, cx: float, cy: float, radius: float) -> Vec:
    share = radius / math.hypot(x - cx, y - cy)
    return float(cx + (x - cx) * share), float(cy + (y - cy) * share)


def _corners(points: NDArray[np.float64], first: int, last: int) -> list[int]:
    found: list[int] = []
    stack = [(first, last)]
    while stack:
        a, b = stack.pop()
        along = points[b] - points[a]
        off = points[a + 1 : b] - points[a]
        if len(off) == 0:
            continue
        far = np.abs(off[:, 0] * along[1] - off[:, 1] * along[0]) / math.hypot(*along)
        where = int(np.argmax(far))
        if far[where] > CURVE_NEAR_PX:
            found.append(a + 1 + where)
            stack += [(a, a + 1 + where), (a + 1 + where, b)]
    return sorted(found)
