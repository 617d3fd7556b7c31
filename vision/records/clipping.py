"""Records cut off at the picture's edge, beyond which nothing is seen.

Rules and units
- The scene's own units; the bounds are ``(x0, y0, x1, y1)``, parallel to the axes.
- An outline is cut at one side of the bounds after the other, and continues along that side (I. E.
  Sutherland and G. W. Hodgman, Reentrant Polygon Clipping, 1974); the rest of an arc keeps its
  circle. A record that leaves the bounds by at most ``EDGE_ROUNDING_PX`` stays as it is.
"""

from __future__ import annotations

import math

from planner.scene import Arc, CircleRecord, Edge, PolygonRecord, Segment, Vec

EDGE_ROUNDING_PX = 0.01
"""Distance beyond the edge that is rounding."""
CIRCLE_STRAY_PX = 0.5
"""Distance beyond the edge at which a circle still counts as whole."""
SAME_BOUND_SIDE = 1e-9
"""Distance of a point on a side of the bounds; a shorter edge is none."""


def clip_circle(
    record: CircleRecord, bounds: tuple[float, float, float, float]
) -> CircleRecord | PolygonRecord:
    """The circle, or its part within the bounds as an outline of arcs and segments."""
    (x, y), r = record.center, record.radius
    out = max(bounds[0] - x + r, bounds[1] - y + r, x + r - bounds[2], y + r - bounds[3])
    if out <= CIRCLE_STRAY_PX:
        return record
    west, east = (x - r, y), (x + r, y)
    halves = (Arc(west, east, (x, y), r, False), Arc(east, west, (x, y), r, False))
    edges = _clip(halves, bounds)
    return PolygonRecord(edges, record.residual_px) if edges else record


def clip_polygon(record: PolygonRecord, bounds: tuple[float, float, float, float]) -> PolygonRecord:
    """Part of the outline within the bounds; all of it if it hardly leaves them."""
    if _farthest_out(record.edges, bounds) <= EDGE_ROUNDING_PX:
        return record
    edges = _clip(record.edges, bounds)
    return PolygonRecord(edges, record.residual_px) if edges else record


def _farthest_out(edges: tuple[Edge, ...], bounds: tuple[float, float, float, float]) -> float:
    out = -math.inf
    for edge in edges:
        for axis in (0, 1):
            for limit, sign in ((bounds[axis], -1.0), (bounds[axis + 2], 1.0)):
                out = max(out, sign * (edge.start[axis] - limit))
                if isinstance(edge, Arc):
                    top = [edge.center[0], edge.center[1]]
                    top[axis] += sign * edge.radius
                    if _on_arc(edge, (top[0], top[1])):
                        out = max(out, sign * (top[axis] - limit))
    return out


def _clip(edges: tuple[Edge, ...], bounds: tuple[float, float, float, float]) -> tuple[Edge, ...]:
    for axis in (0, 1):
        for limit, sign in ((bounds[axis], -1.0), (bounds[axis + 2], 1.0)):
            edges = _clip_at(edges, axis, limit, sign)
    return edges


def _clip_at(edges: tuple[Edge, ...], axis: int, limit: float, sign: float) -> tuple[Edge, ...]:
    kept: list[Edge] = []
    for edge in edges:
        places = [edge.start, *_crossings(edge, axis, limit), edge.end]
        for i in range(len(places) - 1):
            piece = _piece(edge, places[i], places[i + 1])
            if math.dist(piece.start, piece.end) <= SAME_BOUND_SIDE and len(places) > 2:
                continue
            if sign * (_middle(piece)[axis] - limit) <= SAME_BOUND_SIDE:
                if kept:
                    kept += _between(kept[-1].end, piece.start)
                    piece = _piece(piece, kept[-1].end, piece.end)
                kept.append(piece)
    if kept:
        kept += _between(kept[-1].end, kept[0].start)
        kept[-1] = _piece(kept[-1], kept[-1].start, kept[0].start)
    return tuple(kept)


def _between(end: Vec, start: Vec) -> list[Edge]:
    """Edges that join two pieces: none if they meet up to rounding."""
    return [Segment(end, start)] if math.dist(end, start) > SAME_BOUND_SIDE else []


def _crossings(edge: Edge, axis: int, limit: float) -> list[Vec]:
    """Points where an edge meets a side of the bounds, in its order."""
    if isinstance(edge, Segment):
        a, b = edge.start[axis] - limit, edge.end[axis] - limit
        if a * b >= 0.0:
            return []
        other = 1 - axis
        across = edge.start[other] + (edge.end[other] - edge.start[other]) * a / (a - b)
        return [(limit, across) if axis == 0 else (across, limit)]
    off = limit - edge.center[axis]
    square = edge.radius * edge.radius - off * off
    if square <= 0.0:
        return []
    found: list[tuple[float, Vec]] = []
    for side in (-1.0, 1.0):
        across = edge.center[1 - axis] + side * math.sqrt(square)
        place = (limit, across) if axis == 0 else (across, limit)
        if _on_arc(edge, place):
            found.append((_turn_to(edge, place), place))
    return [place for _, place in sorted(found)]


def _piece(edge: Edge, start: Vec, end: Vec) -> Edge:
    if isinstance(edge, Segment):
        return Segment(start, end)
    return Arc(start, end, edge.center, edge.radius, edge.ccw)


def _turn_to(arc: Arc, place: Vec) -> float:
    """Angle from an arc's start to a place, in the arc's direction: 0 .. 2 pi.

    y down: the angle falls along a counter-clockwise arc.
    """
    begin = math.atan2(arc.start[1] - arc.center[1], arc.start[0] - arc.center[0])
    there = math.atan2(place[1] - arc.center[1], place[0] - arc.center[0])
    return ((begin - there) if arc.ccw else (there - begin)) % math.tau


def _on_arc(arc: Arc, place: Vec) -> bool:
    return 0.0 < _turn_to(arc, place) < _turn_to(arc, arc.end)


def _middle(edge: Edge) -> Vec:
    if isinstance(edge, Segment):
        return (0.5 * (edge.start[0] + edge.end[0]), 0.5 * (edge.start[1] + edge.end[1]))
    begin = math.atan2(edge.start[1] - edge.center[1], edge.start[0] - edge.center[0])
    half = 0.5 * _turn_to(edge, edge.end)
    angle = begin - half if edge.ccw else begin + half
    x = edge.center[0] + edge.radius * math.cos(angle)
    return (x, edge.center[1] + edge.radius * math.sin(angle))
