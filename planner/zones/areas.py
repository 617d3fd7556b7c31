"""Areas of the floor, in the scene's units and frame.

``outlines`` are closed records; those of a band are one capsule for each piece of its line, which
overlap at its corners, so the band is exact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

from planner.scene import (
    Arc,
    CircleRecord,
    PolygonRecord,
    SceneError,
    SceneObject,
    Segment,
    Vec,
)
from planner.scene.polygons import objects_from_polygons
from planner.shared.arguments import as_float, as_numbers


@dataclass(frozen=True, slots=True)
class PolygonArea:
    """Inside of a polygon, its corners in either sense; :class:`SceneError` if two sides cross."""

    corners: tuple[Vec, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "corners", _places("polygon", self.corners))
        objects_from_polygons([self.corners], (), y_down=False)

    def outlines(self, *, y_down: bool) -> tuple[SceneObject, ...]:
        """Return the outline as the only object."""
        return objects_from_polygons([self.corners], (), y_down=y_down)


@dataclass(frozen=True, slots=True)
class CircleArea:
    """Disc of ``radius`` > 0 around ``center``; :class:`SceneError` otherwise."""

    center: Vec
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", _places("circle", [self.center])[0])
        object.__setattr__(self, "radius", _positive("circle: radius", self.radius))

    def outlines(self, *, y_down: bool) -> tuple[SceneObject, ...]:
        """Return the circle as the only object."""
        del y_down  # a circle looks the same either way
        return (SceneObject(0, (CircleRecord(self.center, self.radius),)),)


@dataclass(frozen=True, slots=True)
class BandArea:
    """All places within half of ``width`` of a polyline; :class:`SceneError` if it is none.

    Places repeated in a row are dropped. The line's order is the band's direction.
    """

    line: tuple[Vec, ...]
    width: float

    def __post_init__(self) -> None:
        line = _places("line", self.line)
        line = (*line[:1], *(b for a, b in pairwise(line) if a != b))
        if len(line) < 2:
            raise SceneError(f"line: {len(line)} different places: must be 2 or more")
        object.__setattr__(self, "line", line)
        object.__setattr__(self, "width", _positive("line: width", self.width))

    def outlines(self, *, y_down: bool) -> tuple[SceneObject, ...]:
        """Return a capsule for each piece of the line."""
        return tuple(
            SceneObject(number, (_capsule(a, b, 0.5 * self.width, y_down=y_down),))
            for number, (a, b) in enumerate(pairwise(self.line))
        )


@dataclass(frozen=True, slots=True)
class MaskArea:
    """Objects of a mask, see :func:`planner.load_mask`; ``source`` is its file."""

    objects: tuple[SceneObject, ...]
    source: str = ""

    def outlines(self, *, y_down: bool) -> tuple[SceneObject, ...]:
        """Return the mask's objects."""
        del y_down  # a mask is in metres, as its map
        return self.objects


Area: TypeAlias = PolygonArea | CircleArea | BandArea | MaskArea


def _places(what: str, values: Sequence[Sequence[float]]) -> tuple[Vec, ...]:
    rows = as_numbers(what, values, "places [x, y]")
    if rows.ndim != 2 or rows.shape[1] != 2:
        raise SceneError(f"{what}: shape {rows.shape}: must be places [x, y]")
    places = tuple((x, y) for x, y in rows.tolist())
    if not all(math.isfinite(x) and math.isfinite(y) for x, y in places):
        raise SceneError(f"{what}: all coordinates must be finite")
    return places


def _positive(what: str, value: float) -> float:
    number = as_float(what, value)
    if not 0.0 < number < math.inf:
        raise SceneError(f"{what} = {number:g}: must be > 0 and finite")
    return number


def _capsule(a: Vec, b: Vec, radius: float, *, y_down: bool) -> PolygonRecord:
    """Places within ``radius`` of a segment; its outline runs clockwise on the screen."""
    length = math.dist(a, b)
    # to the left as seen on the screen, so that the outline is clockwise
    turn = -1.0 if y_down else 1.0
    nx = -turn * (b[1] - a[1]) / length * radius
    ny = turn * (b[0] - a[0]) / length * radius
    a_left, a_right = (a[0] + nx, a[1] + ny), (a[0] - nx, a[1] - ny)
    b_left, b_right = (b[0] + nx, b[1] + ny), (b[0] - nx, b[1] - ny)
    return PolygonRecord(
        (
            Segment(a_left, b_left),
            Arc(b_left, b_right, b, radius, ccw=False),
            Segment(b_right, a_right),
            Arc(a_right, a_left, a, radius, ccw=False),
        )
    )
