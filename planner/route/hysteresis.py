"""Hysteresis between plans: a repeated request keeps the last path unless another is better.

Rules and units
- Without memory, noise would make the plan jump between paths of equal cost.
- The last path, continued from the robot's place, remains the answer while it keeps the required
  clearance and no other way is cheaper by more than ``STAY``; if it is blocked, the same holds for
  the cheapest path on the same sides of the obstacles.
- Lengths are in the scene's units.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from planner.borders import box_tree_kernels, clear_kernels
from planner.borders.generators import Borders
from planner.borders.polyline import arc_lengths, moves, nearest_length, points_at
from planner.path import NoPath, Path
from planner.route.taut import judge
from planner.scene import FloatArray, Vec
from planner.search.homotopy import anchors, word

STAY = 0.02
"""A new path must be cheaper by this share to be taken."""
MERGE = 4.0
"""A robot beside its last path returns to it within this multiple of its distance from it."""


def last_legs(path: Path | NoPath | None, count: int) -> list[FloatArray | None]:
    """The path's last ``count`` stretches between stations, with leading None for missing ones.

    Stretches match from the end, as passed stations are not requested again.
    """
    legs: list[FloatArray | None] = [None] * count
    if isinstance(path, Path):
        legs += [path.points[a : b + 1] if a < b else None for a, b in pairwise(path.stations)]
    return legs[len(legs) - count :]


def continued(borders: Borders, last: FloatArray, start: Vec, goal: Vec, need: float) -> FloatArray:
    """The last path (n, 2) between its places nearest to the start and the goal, joined to both.

    The ends join it at a small angle if ``need`` is kept there, else straight across. The
    result need not keep ``need``.
    """
    lengths = arc_lengths(last)
    begin = nearest_length(last, lengths, start)
    end = nearest_length(last, lengths, goal, begin)
    first = _joined(borders, last, lengths, start, begin, end, need)
    final = _joined(borders, last, lengths, goal, end, first, need)
    inner = last[(lengths > first) & (lengths < final)]
    ends = points_at(last, lengths, np.array([first, final]))
    way = np.concatenate([[start], ends[:1], inner, ends[1:], [goal]])
    return np.ascontiguousarray(way[moves(way)])


def _joined(
    borders: Borders,
    line: FloatArray,
    lengths: FloatArray,
    place: Vec,
    at: float,
    towards: float,
    need: float,
) -> float:
    """Length at which a place joins the line, ahead if clear."""
    (near,) = points_at(line, lengths, np.array([at]))
    reach = min(MERGE * math.dist(near, place), abs(towards - at))
    for part in (1.0, 0.5, 0.25):
        there = at + math.copysign(part * reach, towards - at)
        ends = np.array([place, *points_at(line, lengths, np.array([there]))])
        if clear_kernels.keeps(borders.tree, ends, need):
            return there
    return at


def is_kept(borders: Borders, way: FloatArray, need: float) -> bool:
    """True if the path keeps ``need`` from all borders."""
    return bool(clear_kernels.keeps(borders.tree, way, need - borders.equal))


def preferred(
    borders: Borders, last: FloatArray, ways: Sequence[FloatArray], need: float, preference: float
) -> FloatArray:
    """The last path, one of the ``ways`` on the same sides of the obstacles, or else the first.

    ``ways`` are the paths found, the best first; ``last`` is the last path continued.
    """
    most = _cost(borders, ways[0], need, preference) * (1.0 + STAY)
    if is_kept(borders, last, need):
        return last if _cost(borders, last, need, preference) <= most else ways[0]
    places = anchors(borders)
    side = word(places, last)
    return next(
        (
            way
            for way in sorted(ways, key=lambda way: _cost(borders, way, need, preference))
            if word(places, way) == side and _cost(borders, way, need, preference) <= most
        ),
        ways[0],
    )


def _cost(borders: Borders, way: FloatArray, need: float, preference: float) -> float:
    """Cost of a path; of the widest path, the inverse of its clearance."""
    if preference < 1.0:
        return judge(borders, way, need, preference)
    gap = float(box_tree_kernels.polyline_clearance(borders.tree, way)[0])
    return math.inf if gap <= 0.0 else 1.0 / gap
