"""Sides on which a path passes the obstacles.

Method: parallel rays lead from one place of each obstacle to infinity. The rays that a path
crosses, in order and with directions, after cancelling neighbours that undo each other, are a word
of the free group over the obstacles. Paths with the same ends shift into each other without
crossing an obstacle exactly if their words are equal.
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
    """Reduced word of a path (m, 2) among obstacles from :func:`anchors`.

    Rays lead towards growing y. Rays at the same x count as shifted to the right infinitesimally,
    later ones further. O(m log n), plus sorting the crossings.
    """
    return tuple(kernels.word(places, way).tolist())
