"""Labels with the obstacles' numbers, which messages use, and the costs of the alternatives.

- A number is inside its obstacle if it fits, else beside it; among very many obstacles, those that
  do not fit are left out.
- Widths of text are estimates, in screen pixels: SVG and PNG have different fonts.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from navigation.draw.shapes import INK, OTHER_PATH_INK, PAGE, Colour, Label, Screen
from planner.borders.polyline import arc_lengths, distances_to_polyline, points_at
from planner.path import Path
from planner.scene import FloatArray
from planner.shared.figures import sized

SIZE = 12.0
DIGIT_WIDTH = 8.0
MOST_BESIDE = 150
"""Most obstacles whose numbers are also drawn beside them."""
ROWS = (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.1, 0.9)
"""Heights at which the widest place is sought, as shares of an obstacle's."""
LOOKED_AT = 64
"""Places along an alternative; the farthest from all others bears its cost."""


def obstacle_labels(
    borders: list[list[FloatArray]], texts: list[str], screen: Screen, inside: Colour
) -> Iterator[Label]:
    """Label each obstacle, given its closed borders (n, 2) or its points, in screen pixels."""
    low, high = screen.frame.min(axis=0), screen.frame.max(axis=0)
    crowded = len(borders) > MOST_BESIDE
    for rings, text in zip(borders, texts, strict=True):
        if not rings:
            continue
        ring = max(rings, key=len)
        width = DIGIT_WIDTH * len(text)
        if crowded and (np.ptp(ring, axis=0) < (width, SIZE)).any():
            continue
        sides = np.concatenate([np.stack([r, np.roll(r, -1, axis=0)], axis=1) for r in rings])
        x, y = _widest_row(sides)
        reach = np.array([(i, j) for i in (-0.5, 0.0, 0.5) for j in (-0.5, 0.5)])
        if _holds(sides, (x, y) + reach * (width + 4.0, SIZE)).all():
            halo = inside != PAGE
            yield Label(x, y + 0.36 * SIZE, text, SIZE, inside, "middle", bold=True, halo=halo)
        elif not crowded:
            at = ring[np.argmax(ring @ (1.0, -1.0))]  # its upper right
            right = np.clip(at[0] + 4.0, low[0] + 2.0, high[0] - width - 2.0)
            above = np.clip(at[1] - 4.0, low[1] + SIZE, high[1] - 2.0)
            yield Label(float(right), float(above), text, SIZE, INK, halo=True)


def _holds(sides: FloatArray, places: FloatArray) -> NDArray[np.bool_]:
    """Mask of the places (m, 2) inside the sides (n, 2, 2), by even-odd."""
    (x0, y0), (x1, y1) = sides[:, 0].T, sides[:, 1].T
    x, y = places[:, 0, None], places[:, 1, None]
    cut = (y0 <= y) != (y1 <= y)
    right = x < x0 + (y - y0) / np.where(y0 == y1, 1.0, y1 - y0) * (x1 - x0)
    return np.asarray((cut & right).sum(axis=1) % 2 == 1)


def _widest_row(sides: FloatArray) -> tuple[float, float]:
    """Middle of the widest horizontal stretch inside borders, preferably at mid-height."""
    (x0, y0), (x1, y1) = sides[:, 0].T, sides[:, 1].T
    top, bottom = float(y0.min()), float(y0.max())
    best, most = (float(x0.mean()), float(y0.mean())), 0.0
    for share in ROWS:
        y = top + share * (bottom - top)
        cut = (y0 <= y) != (y1 <= y)
        xs = np.sort((x0 + (y - y0) / np.where(cut, y1 - y0, 1.0) * (x1 - x0))[cut]).tolist()
        for left, right in zip(xs[0::2], xs[1::2], strict=False):
            if right - left > 1.2 * most:
                most, best = right - left, (0.5 * (left + right), y)
    return best


def costs(path: Path, units: str, screen: Screen) -> Iterator[Label]:
    """Label each alternative with its cost, far from other lines."""
    lines = [screen.points(path.points), *(screen.points(p.points) for p in path.alternatives)]
    taken: list[FloatArray] = []
    for number, other in enumerate(path.alternatives, start=1):
        line = lines[number]
        if other.cost is None or len(line) < 2:
            continue
        lengths = arc_lengths(line)
        places = points_at(line, lengths, np.linspace(0.0, lengths[-1], LOOKED_AT)[1:-1])
        beside = [way for k, way in enumerate(lines) if k != number and len(way) > 1]
        text = f"{number}: cost {sized(other.cost, units)}"
        ends = np.outer((-1.0, 0.0, 1.0), (0.5 * 7.5 * len(text), 0.0))
        room = [
            min(
                *(distances_to_polyline(way, place + ends).min() for way in beside),
                *(2.0 * abs(float(place[1] - label[1])) for label in taken),
                60.0,
            )
            for place in places
        ]
        x, y = places[int(np.argmax(room))].tolist()
        taken.append(np.array((x, y)))
        yield Label(x, y + 4.5, text, SIZE, OTHER_PATH_INK, "middle", bold=True, halo=True)
