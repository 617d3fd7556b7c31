"""Which side of every obstacle a way passes: ways are distinct where one is no shift of another.

Method: a ray leads from one place of each obstacle to infinity, all of them parallel. The rays
that a way crosses, in order and with their directions, with neighbours that undo each other
struck out, are a word of the free group over the obstacles. Two ways with the same ends can be
shifted into each other without crossing an obstacle exactly where their words are equal.
"""

from __future__ import annotations

import numpy as np

from planner.borders.generators import Borders
from planner.scene import FloatArray
from planner.scene.primitives import ROUND

Word = tuple[int, ...]
"""Obstacles + 1 in the order of crossing, negative where crossed towards smaller x."""


def anchors(borders: Borders) -> FloatArray:
    """(n, 2) one place of every obstacle, in the obstacles' order."""
    k = borders.primitive_count
    owners, firsts = np.unique(borders.owner[:k], return_index=True)
    places: FloatArray = borders.data[firsts[owners >= 0], :2].copy()
    arcs = np.isin(borders.kind[firsts[owners >= 0]], ROUND)
    rows = borders.data[firsts[owners >= 0]][arcs]
    places[arcs] += rows[:, 2:3] * np.c_[np.cos(rows[:, 3]), np.sin(rows[:, 3])]
    return places


def word(places: FloatArray, way: FloatArray) -> Word:
    """The reduced word of a way (m, 2) among obstacles at ``places`` (n, 2). O(n m).

    Rays lead towards growing y. Those of obstacles at the same x count as shifted to the right
    by less than anything, the later the further.
    """
    x, y = way[:, 0], way[:, 1]
    left = x[:, None] <= places[:, 0]
    piece, obstacle = np.nonzero(left[1:] != left[:-1])
    px, py = places[obstacle, 0], places[obstacle, 1]
    t = (px - x[piece]) / (x[piece + 1] - x[piece])
    above = y[piece] + t * (y[piece + 1] - y[piece]) > py
    rightward = left[piece, obstacle]
    piece, t, obstacle, rightward = piece[above], t[above], obstacle[above], rightward[above]
    tie = np.where(rightward, obstacle, -obstacle)
    reduced: list[int] = []
    for i in np.lexsort((tie, t, piece)).tolist():
        letter = int(obstacle[i]) + 1
        letter = letter if rightward[i] else -letter
        if reduced and reduced[-1] == -letter:
            reduced.pop()
        else:
            reduced.append(letter)
    return tuple(reduced)
