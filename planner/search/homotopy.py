"""Which side of every obstacle a path passes: paths are distinct where one is no shift of another.

Method: a ray leads from one place of each obstacle to infinity, all of them parallel. The rays
that a path crosses, in order and with their directions, with neighbours that undo each other
struck out, are a word of the free group over the obstacles. Two paths with the same ends can be
shifted into each other without crossing an obstacle exactly where their words are equal.
"""

from __future__ import annotations

from planner.borders.generators import Borders
from planner.scene import FloatArray
from planner.search import homotopy_kernels as kernels

Word = tuple[int, ...]
"""Obstacles + 1 in the order of crossing, negative where crossed towards smaller x."""


def anchors(borders: Borders) -> FloatArray:
    """(n, 3) one place of every obstacle and the obstacle's number, by x."""
    return kernels.anchors(  # type: ignore[no-any-return]
        borders.kind, borders.data, borders.owner, borders.primitive_count
    )


def word(places: FloatArray, way: FloatArray) -> Word:
    """The reduced word of a path (m, 2) among obstacles as from :func:`anchors`.

    Rays lead towards growing y. Those of obstacles at the same x count as shifted to the right
    by less than anything, the later the further. O(m log n), and what sorting the crossings takes.
    """
    return tuple(kernels.word(places, way).tolist())
