"""The exact shortest path that keeps a clearance: straight lines and arcs around corners.

Rules and units
- The borders, moved outwards by the clearance, leave arcs around corners and round borders; the
  path consists of such arcs and their common tangents.
- The answer's chords lie outside the arcs, so it keeps the clearance, as proved. It exceeds the
  path by less than ``CHORD_RAD ** 2 / 12`` of its arcs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from planner.borders import box_tree_kernels
from planner.borders.generators import JOINT, Borders
from planner.borders.polyline import moves
from planner.scene import FloatArray, Vec
from planner.search import tangent_kernels

CHORD_RAD = 0.05
"""An arc's chords turn by at most this; below the least turn that smoothing rounds."""
FINER_CHORDS = (1.0, 0.25, 0.0625)
"""Parts of ``CHORD_RAD`` tried in turn, where chords outside an arc come too near to others."""
SPARE = 1e-9
"""Kept on top of the clearance, as a share of the scene's extent, so that rounding costs none."""
BUDGET = 8_000_000
"""Tangents tried before the search gives up: about 0.3 s (`benchmarks/routes.py`). Among 1,000
obstacles it took 2,200,000 at most."""


@dataclass(frozen=True, slots=True)
class Shortest:
    """The path (n, 2), or None if none is shorter than asked.

    ``certain`` is False if the search gave up, so a shorter one may exist.
    """

    way: FloatArray | None
    certain: bool


def shortest_way(
    borders: Borders,
    start: Vec,
    goal: Vec,
    keep: float,
    longest: float = math.inf,
    budget: int | None = None,
) -> Shortest:
    """Find the shortest path from start to goal that keeps ``keep``, if shorter than ``longest``.

    The path may be as near to a border as a station is by rounding. ``budget`` is the most tangents
    tried, ``BUDGET`` if None.
    """
    ends = np.array([start, goal])
    standing = float(borders.distances(ends)[0].min())
    spare = SPARE * borders.extent
    radius = min(keep + spare, standing)
    k = borders.primitive_count
    discs = tangent_kernels.discs_around(
        borders.kind[:k],
        borders.data[:k],
        radius,
        JOINT * borders.extent,
        ends[0],
        ends[1],
        longest,
    )
    outcome, _, tangents, _ = tangent_kernels.shortest(
        borders.tree, discs, radius - 0.25 * spare, longest, BUDGET if budget is None else budget
    )
    if outcome != tangent_kernels.FOUND:
        return Shortest(None, outcome == tangent_kernels.NONE_SHORTER)
    for part in FINER_CHORDS:
        way = _polyline(discs, tangents, part * CHORD_RAD)
        gap = box_tree_kernels.polyline_clearance(borders.tree, way)[0]
        if gap >= radius - 0.5 * spare:
            return Shortest(way, certain=True)
    return Shortest(None, certain=False)


def _polyline(discs: FloatArray, tangents: FloatArray, chord_rad: float) -> FloatArray:
    points = [discs[tangent_kernels.START, None, :2]]
    for arrived, left in pairwise(tangents):
        disc, side, a = int(arrived[3]), arrived[4], arrived[5]
        x, y, r = discs[disc, :3]
        sweep = tangent_kernels.turn_towards(a, left[2], side)
        count = max(1, math.ceil(sweep / chord_rad))
        turned = a + side * sweep * (np.arange(count) + 0.5) / count
        out = r / math.cos(0.5 * sweep / count)
        points.append(np.c_[x + out * np.cos(turned), y + out * np.sin(turned)])
    points.append(discs[tangent_kernels.GOAL, None, :2])
    way = np.concatenate(points)
    return np.ascontiguousarray(way[moves(way)])
