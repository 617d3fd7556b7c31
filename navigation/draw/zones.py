"""Zones in a picture: each kind has its colour and its pattern, and each zone its name.

- Keep out is hatched in red, no waiting in blue the other way round and wider, so that the two
  differ without colour. Slow is amber, with its speed.
- A one-way zone has arrows along its line, a lane a dashed line in its middle.
- A band is drawn as one area, however its pieces overlap.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np

from navigation.draw.numbers import obstacle_labels
from navigation.draw.outlines import chain_points, ring_points
from navigation.draw.shapes import Area, Colour, Screen, Shape, Strokes
from planner.borders.polyline import arc_lengths, distances_to_polyline, points_at
from planner.scene import FloatArray
from planner.shared.figures import sized
from planner.zones.areas import BandArea
from planner.zones.zone import KIND_NAMES, Zone, ZoneKind

COLOURS: Final[dict[ZoneKind, Colour]] = {
    "keep_out": (196, 32, 38),
    "slow": (160, 92, 0),
    "one_way": (0, 110, 128),
    "lane": (24, 128, 60),
    "wait": (44, 84, 196),
}
"""On the page too; chosen, dark enough for words on the floor's colour: tested."""
FILL: Final = 0.13
"""Chosen, so that roadmap and paths show through."""
EDGE: Final = 1.6
EDGE_STEP: Final = 0.02
"""Distance of a band edge's points, in its widths: indifferent, gaps at bends are less."""
SAG: Final = 1e-3
"""Depth of the chords of an arc's points, in the arc's diameters: derived, 1.7e-4 of 3 degrees."""
HATCH: Final[dict[ZoneKind, tuple[float, float]]] = {"keep_out": (9.0, 45.0), "wait": (15.0, -45.0)}
"""Distance of the lines, and their angle in degrees."""
ARROW_EVERY: Final = 46.0
ARROW: Final = 7.0
"""Length of an arrow's barbs; shorter in a narrow band."""
LANE_DASH: Final = (9.0, 7.0)


def zone_shapes(zones: Sequence[Zone], screen: Screen) -> Iterator[Shape]:
    """Draw all zones, their areas first."""
    for zone in zones:
        yield from _area(zone, screen)
    for zone in zones:
        yield from _pattern(zone, screen)


def zone_names(zones: Sequence[Zone], screen: Screen, units: str) -> Iterator[Shape]:
    """Write each zone's name, speed and robots inside it if they fit, else beside it."""
    for zone in zones:
        rings, off = _rings(zone, screen), 0.0
        if isinstance(zone.area, BandArea):  # where it is longest, and off its pattern
            rings = [max(rings, key=lambda ring: float(np.ptp(ring, axis=0).sum()))]
            width = zone.area.width * screen.scale
            off = 0.25 * width if zone.kind in ("one_way", "lane") else 0.0
        if not rings:
            continue
        colour = COLOURS[zone.kind]
        for label in obstacle_labels([rings], [_words(zone, units)], screen, colour):
            yield replace(label, y=label.y - off, colour=colour, bold=True, halo=True)


def zone_kinds(zones: Sequence[Zone]) -> list[tuple[ZoneKind, str]]:
    """Return the kinds of zones, with their count in words for the legend."""
    counts = {kind: sum(zone.kind == kind for zone in zones) for kind in KIND_NAMES}
    return [
        (kind, f"{KIND_NAMES[kind]}{'s' * (count > 1)} ({count})")
        for kind, count in counts.items()
        if count
    ]


def zone_mark(kind: ZoneKind, left: float, y: float) -> list[Shape]:
    """Draw a kind's mark for the legend, 28 pixels wide."""
    colour = COLOURS[kind]
    x0, x1, y0, y1 = left + 2.0, left + 30.0, y - 7.0, y + 7.0
    box = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    shapes: list[Shape] = [Area((box,), colour, FILL)]
    middle = np.array([(x0 + 3.0, y), (x1 - 3.0, y)])
    if kind in HATCH:
        shapes.append(Strokes(tuple(_hatching([box], *HATCH[kind])), colour, 1.0))
    elif kind == "one_way":
        barbs = (_barb(x0 + 11.0, y, 0.0, 5.0), _barb(x0 + 21.0, y, 0.0, 5.0))
        shapes.append(Strokes(barbs, colour, 1.8))
    elif kind == "lane":
        shapes.append(Strokes((middle,), colour, 1.5, dash=(6.0, 4.0)))
    return [*shapes, Strokes((np.vstack([box, box[:1]]),), colour, EDGE)]


def _words(zone: Zone, units: str) -> str:
    speed = "" if zone.speed is None else f", {sized(zone.speed, units)}/s"
    robots = f" ({', '.join(zone.robots)})" if zone.robots else ""
    return f"{zone.name}{speed}{robots}"


def _area(zone: Zone, screen: Screen) -> Iterator[Shape]:
    colour = COLOURS[zone.kind]
    if isinstance(zone.area, BandArea):
        width = zone.area.width * screen.scale
        yield Strokes((screen.points(zone.area.line),), colour, width, opacity=FILL)
        yield Strokes(tuple(_band_edges(zone.area, screen)), colour, EDGE)
        return
    rings = _rings(zone, screen)
    if rings:
        yield Area(tuple(rings), colour, FILL)
        yield Strokes(tuple(np.vstack([ring, ring[:1]]) for ring in rings), colour, EDGE)


def _pattern(zone: Zone, screen: Screen) -> Iterator[Shape]:
    colour = COLOURS[zone.kind]
    if zone.kind in HATCH:
        if isinstance(zone.area, BandArea):  # each piece by itself; the lines are the same
            groups = [[ring] for ring in _rings(zone, screen)]
        else:
            groups = [_rings(zone, screen)]
        lines = [line for group in groups for line in _hatching(group, *HATCH[zone.kind])]
        if lines:
            yield Strokes(tuple(lines), colour, 1.0, opacity=0.75)
    if not isinstance(zone.area, BandArea):
        return
    line = screen.points(zone.area.line)
    if zone.kind == "one_way":
        size = min(ARROW, 0.3 * zone.area.width * screen.scale)
        yield Strokes(tuple(_arrows(line, size)), colour, 2.0)
    elif zone.kind == "lane":
        yield Strokes((line,), colour, 1.5, dash=LANE_DASH)


def _rings(zone: Zone, screen: Screen) -> list[FloatArray]:
    """Closed outlines (n, 2) on the screen, one for each piece of a band."""
    return [
        screen.points(ring)
        for one in zone.area.outlines(y_down=screen.y_down)
        for ring in ring_points(one, screen.y_down)
    ]


def _band_edges(band: BandArea, screen: Screen) -> Iterator[FloatArray]:
    """Yield the parts (k, 2) of the pieces' outlines that are in no other piece."""
    pieces = list(pairwise(np.array(band.line)))
    for number, outline in enumerate(band.outlines(y_down=screen.y_down)):
        ring = _densely(chain_points(outline.records[0], screen.y_down), EDGE_STEP * band.width)
        shown = np.ones(len(ring), dtype=np.bool_)
        for other, piece in enumerate(pieces):
            if other != number:
                shown &= distances_to_polyline(np.array(piece), ring) >= (0.5 - SAG) * band.width
        cuts = np.flatnonzero(~shown)
        for part in np.split(np.arange(len(ring)), cuts):
            kept = part[shown[part]]
            if len(kept) > 1:
                yield screen.points(ring[kept])


def _densely(ring: FloatArray, step: float) -> FloatArray:
    line = np.vstack([ring, ring[:1]])
    lengths = arc_lengths(line)
    at = np.union1d(lengths, np.arange(0.0, lengths[-1], step))
    return points_at(line, lengths, at)


def _hatching(rings: Sequence[FloatArray], distance: float, angle_deg: float) -> list[FloatArray]:
    """Parallel lines (2, 2) inside closed rings, by even-odd; they continue from ring to ring."""
    if not rings:
        return []
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    turned = np.array([(c, -s), (s, c)])  # a row times this is in the hatching's own axes
    own = [ring @ turned for ring in rings]
    sides = np.concatenate([np.stack([r, np.roll(r, -1, axis=0)], axis=1) for r in own])
    (x0, y0), (x1, y1) = sides[:, 0].T, sides[:, 1].T
    lines = []
    first, last = math.ceil(y0.min() / distance), math.floor(y0.max() / distance)
    for row in range(first, last + 1):
        y = row * distance
        cut = (y0 <= y) != (y1 <= y)
        xs = np.sort((x0 + (y - y0) / np.where(cut, y1 - y0, 1.0) * (x1 - x0))[cut])
        for left, right in zip(xs[0::2], xs[1::2], strict=False):
            lines.append(np.array([(left, y), (right, y)]) @ turned.T)
    return lines


def _arrows(line: FloatArray, size: float) -> Iterator[FloatArray]:
    lengths = arc_lengths(line)
    count = max(1, int(lengths[-1] / ARROW_EVERY))
    for k in range(count):
        at = lengths[-1] * (k + 0.5) / count
        (x, y), (bx, by) = points_at(line, lengths, np.array([at, min(at + 1.0, lengths[-1])]))
        yield _barb(x, y, math.atan2(by - y, bx - x), size)


def _barb(x: float, y: float, angle: float, size: float) -> FloatArray:
    """Two strokes that meet at (x, y) like a greater-than sign."""
    ends = [(x - size * math.cos(angle + t), y - size * math.sin(angle + t)) for t in (-0.7, 0.7)]
    return np.array([ends[0], (x, y), ends[1]])
