"""Borders of a scene or of zones, indexed: exact distances, and parts of lines in or near objects.

Rules and units
- A clearance is the distance to the nearest border, exact, without sampling; 0 where a line
  touches an object or runs in one.
- A part below a clearance is found by steps of the difference, within which nothing changes, and
  bisection where it changes sign; inside is below 0. A part shorter than ``RAY_STEP`` of the line
  may be missed there, never in the clearance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from planner.borders import box_tree_kernels, inside_kernels
from planner.borders.generators import Borders, gather_borders
from planner.scene import FloatArray, IntArray, Primitives, Scene

RAY_STEP = 1e-3
"""Least step along an edge, as a part of its length."""
SURE = 1.0 - 1e-9
"""Share of a distance that surely contains no border."""
CROSSING_HALVINGS = 12
"""Halvings of a step in which a border is crossed: to 2.5e-7 of the edge's length."""
TOUCHING_SHARE = 1e-12
"""Parts nearer than this share of their place along the line touch."""


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
    ``zones`` are further obstacles, whose borders may cross those of the scene.
    """

    borders: Borders | None
    box: FloatArray = field(default_factory=lambda: np.array([-np.inf, -np.inf, np.inf, np.inf]))
    zones: Ground | None = None

    @classmethod
    def of(cls, scene: Scene, *, bounds: bool) -> Ground:
        """Index a scene; with ``bounds`` its rectangle's sides are walls."""
        if not bounds and not scene.objects:
            return cls(None)
        borders = gather_borders(_Walls(scene, bounds))
        return cls(borders, np.array(scene.view)) if bounds else cls(borders)

    def signed(self, points: FloatArray) -> FloatArray:
        """Distance of every point (n, 2), negative in an object and off the map."""
        points = np.ascontiguousarray(points)
        signed = np.full(len(points), np.inf)
        if self.borders is not None:
            tree, closed = self.borders.tree, self.borders.closed
            signed = inside_kernels.signed_distances(tree, closed, self.box, points)
        return signed if self.zones is None else np.minimum(signed, self.zones.signed(points))

    def clearances(self, lines: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Clearance (m,) of every line, and the place (m, 2) where it is least."""
        gap, at = self._own_clearances(lines)
        if self.zones is not None:
            other, near = self.zones.clearances(lines)
            at = np.where((other < gap)[:, None], near, at)
            gap = np.minimum(gap, other)
        return gap, at

    def _own_clearances(self, lines: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Clearances and places, zones aside."""
        gap, at = np.full(len(lines), np.inf), np.zeros((len(lines), 2))
        if not lines or self.borders is None:
            return gap, at
        measure, tree = box_tree_kernels.polyline_clearance, self.borders.tree
        for k, line in enumerate(lines):
            gap[k], at[k, 0], at[k, 1], _, _ = measure(tree, np.ascontiguousarray(line))
        # a line that touches no border is on one side of all of them
        first = np.array([line[0] for line in lines])
        inside = (replace(self, zones=None).signed(first) < 0.0) & (gap > 0.0)
        gap[inside], at[inside] = 0.0, first[inside]
        return gap, at

    def lengths_inside(self, lines: Sequence[FloatArray]) -> FloatArray:
        """Length (m,) of every line in objects or off the map."""
        owner, begin, end = self.parts_below(lines, 0.0)
        total: FloatArray = np.bincount(owner, end - begin, len(lines)).astype(np.float64)
        return total

    def parts_below(
        self, lines: Sequence[FloatArray], level: float
    ) -> tuple[IntArray, FloatArray, FloatArray]:
        """Parts of the lines whose clearance is less than a level.

        Returns the line (k,), and the lengths along it (k,) where each part begins and ends. Parts
        are in order and do not touch.
        """
        counts = [len(line) - 1 for line in lines]
        owner = np.repeat(np.arange(len(lines), dtype=np.int32), counts)
        first = np.concatenate([np.empty((0, 2)), *(line[:-1] for line in lines)])
        along = np.concatenate([np.empty((0, 2)), *(line[1:] for line in lines)]) - first
        length = np.hypot(*along.T)
        # the length along its own line at which each piece begins
        before = np.cumsum(length) - length
        starts = np.cumsum([0, *counts])[:-1]
        offset = before - before[np.minimum(starts, max(len(before) - 1, 0))][owner]
        piece, begin, end = self._below(first, along, length, level)
        begin, end = begin + offset[piece], end + offset[piece]
        order = np.lexsort((begin, owner[piece]))
        return _joined(owner[piece][order], begin[order], end[order])

    def _below(
        self, begin: FloatArray, along: FloatArray, length: FloatArray, level: float
    ) -> tuple[IntArray, FloatArray, FloatArray]:
        """Parts of straight pieces with less clearance: piece, begin, end; they may touch."""
        found: list[tuple[IntArray, FloatArray, FloatArray]] = []
        left = np.flatnonzero(length > 0.0).astype(np.int32)
        unit = along[left] / length[left, None]
        begin, length = begin[left], length[left]
        at = np.zeros(len(left))
        here = self.signed(begin) - level
        while len(left):
            after = np.minimum(at + np.maximum(np.abs(here), RAY_STEP * length), length)
            there = self.signed(begin + after[:, None] * unit) - level
            below = here < 0.0
            turn = np.where(below, after, at)
            crossed = np.flatnonzero(below != (there < 0.0))
            # the clearance changes no faster than the place
            clear = np.minimum(at + np.abs(here) * SURE, after)[crossed]
            turn[crossed] = self._turn(
                begin[crossed], unit[crossed], clear, after[crossed], below[crossed], level
            )
            to = np.where(below, turn, np.where(there < 0.0, after, turn))
            since = np.where(below, at, turn)
            some = to > since
            found.append((left[some], since[some], to[some]))
            more = after < length
            left, begin, unit, length = left[more], begin[more], unit[more], length[more]
            at, here = after[more], there[more]
        if not found:
            return np.empty(0, np.int32), np.empty(0), np.empty(0)
        pieces, since, to = (np.concatenate(column) for column in zip(*found, strict=True))
        return pieces, since, to

    def _turn(
        self,
        begin: FloatArray,
        unit: FloatArray,
        low: FloatArray,
        high: FloatArray,
        below: NDArray[np.bool_],
        level: float,
    ) -> FloatArray:
        """Place along each piece where its clearance passes the level, by bisection."""
        if not len(begin):
            return low
        for _ in range(CROSSING_HALVINGS):
            middle = 0.5 * (low + high)
            same = (self.signed(begin + middle[:, None] * unit) < level) == below
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        middle_of: FloatArray = 0.5 * (low + high)
        return middle_of


def _joined(
    owner: IntArray, begin: FloatArray, end: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Join parts of one line that touch."""
    apart = np.ones(len(owner), np.bool_)
    apart[1:] = (owner[1:] != owner[:-1]) | (begin[1:] > end[:-1] * (1.0 + TOUCHING_SHARE))
    first = np.flatnonzero(apart)
    last = np.append(first[1:], len(owner))[: len(first)] - 1
    return owner[first], begin[first], end[last]
