"""Borders of a scene or of zones, indexed: exact distances, and lengths inside.

Rules and units
- A clearance is the distance to the nearest border, exact, without sampling; 0 where a line
  touches an object or runs in one.
- The length inside is found by steps of the distance to the nearest border, within which nothing
  changes, and bisection where a border is crossed. A border that is left again within ``STEP`` of
  the line may be missed there, never in the clearance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from planner.borders import box_tree_kernels, inside_kernels
from planner.borders.generators import Borders, gather_borders
from planner.scene import FloatArray, Primitives, Scene

STEP = 1e-3
"""Least step along an edge, as a part of its length."""
SURE = 1.0 - 1e-9
"""Share of a distance that surely contains no border."""
HALVINGS = 12
"""Halvings of a step in which a border is crossed: to 2.5e-7 of the edge's length."""


@dataclass(frozen=True, slots=True)
class _Walls:
    """Borders of a scene, with its bounds only where they are walls."""

    scene: Scene
    bounds: bool

    def primitives(self) -> Primitives:
        """Return the borders as flat arrays."""
        return self.scene.primitives(include_bounds=self.bounds)


@dataclass(frozen=True, slots=True)
class Ground:
    """A scene, indexed for distances; None borders if there is nothing in it.

    ``box`` is x_min, y_min, x_max, y_max of what is not off the map, infinite without bounds.
    """

    borders: Borders | None
    box: FloatArray = field(default_factory=lambda: np.array([-np.inf, -np.inf, np.inf, np.inf]))

    @classmethod
    def of(cls, scene: Scene, *, bounds: bool) -> Ground:
        """Index a scene; with ``bounds`` its rectangle's sides are walls."""
        if not bounds and not scene.objects:
            return cls(None)
        borders = gather_borders(_Walls(scene, bounds))
        return cls(borders, np.array(scene.view)) if bounds else cls(borders)

    def signed(self, points: FloatArray) -> FloatArray:
        """Distance of every point (n, 2), negative in an object and off the map."""
        if self.borders is None:
            return np.full(len(points), np.inf)
        b = self.borders
        return inside_kernels.signed_distances(  # type: ignore[no-any-return]
            b.tree, b.closed, self.box, np.ascontiguousarray(points)
        )

    def clearances(self, lines: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Clearance (m,) of every line, and the place (m, 2) where it is least."""
        gap, at = np.full(len(lines), np.inf), np.zeros((len(lines), 2))
        if not lines or self.borders is None:
            return gap, at
        measure, tree = box_tree_kernels.polyline_clearance, self.borders.tree
        for k, line in enumerate(lines):
            gap[k], at[k, 0], at[k, 1], _, _ = measure(tree, np.ascontiguousarray(line))
        # a line that touches no border is on one side of all of them
        first = np.array([line[0] for line in lines])
        inside = (self.signed(first) < 0.0) & (gap > 0.0)
        gap[inside], at[inside] = 0.0, first[inside]
        return gap, at

    def lengths_inside(self, lines: Sequence[FloatArray]) -> FloatArray:
        """Length (m,) of every line in objects or off the map."""
        counts = [len(line) - 1 for line in lines]
        owner = np.repeat(np.arange(len(lines)), counts)
        begin = np.concatenate([np.empty((0, 2)), *(line[:-1] for line in lines)])
        along = np.concatenate([np.empty((0, 2)), *(line[1:] for line in lines)]) - begin
        inside = self._inside(begin, along, np.hypot(*along.T))
        total: FloatArray = np.bincount(owner, inside, len(lines)).astype(np.float64)
        return total

    def _inside(self, begin: FloatArray, along: FloatArray, length: FloatArray) -> FloatArray:
        """Length (p,) of every straight piece in objects or off the map."""
        total = np.zeros(len(length))
        left = np.flatnonzero(length > 0.0)
        unit = along[left] / length[left, None]
        begin, length = begin[left], length[left]
        at = np.zeros(len(left))
        here = self.signed(begin)
        while len(left):
            after = np.minimum(at + np.maximum(np.abs(here), STEP * length), length)
            there = self.signed(begin + after[:, None] * unit)
            solid = here < 0.0
            turn = np.where(solid, after, at)
            crossed = np.flatnonzero(solid != (there < 0.0))
            # no border is nearer than the distance says
            clear = np.minimum(at + np.abs(here) * SURE, after)[crossed]
            turn[crossed] = self._border(
                begin[crossed], unit[crossed], clear, after[crossed], solid[crossed]
            )
            np.add.at(
                total, left, np.where(solid, turn - at, np.where(there < 0.0, after - turn, 0.0))
            )
            more = after < length
            left, begin, unit, length = left[more], begin[more], unit[more], length[more]
            at, here = after[more], there[more]
        return total

    def _border(
        self,
        begin: FloatArray,
        unit: FloatArray,
        low: FloatArray,
        high: FloatArray,
        solid: NDArray[np.bool_],
    ) -> FloatArray:
        """Place along each piece where it passes from one side to the other, by bisection."""
        if not len(begin):
            return low
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            same = (self.signed(begin + middle[:, None] * unit) < 0.0) == solid
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        middle_of: FloatArray = 0.5 * (low + high)
        return middle_of
