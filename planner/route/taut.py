"""From routes over the chains to proved polylines: taut and cut short.

A preference above 0 asks for more clearance than needed, where there is room.
"""

from __future__ import annotations

import math

from planner.borders import box_tree_kernels
from planner.borders.generators import Borders
from planner.route import taut_kernels
from planner.scene import FloatArray, IntArray
from planner.search.chain_search import CLEARANCE_ROUNDING, DETOUR, Lines

WISH_RADII = 2.0
"""Radii of clearance kept on top of the first, where there is room, per unit of preference."""
TIGHT_CHORDS = 1e-9
"""A bend exactly as wide as needed is followed in chords that take this part of the radius."""
WIDEST_SLACK = 1e-6
"""The widest path's polyline may be narrower than the path by this part of its clearance."""
PATH_FLATNESS = 0.02
"""Largest distance of a path from the bisector it follows, in radii, where there is room."""


def is_clear(
    borders: Borders, ends: FloatArray, standing: float, need: float, preference: float
) -> bool:
    """True if the straight line has the clearance that the preference asks for.

    That is ``1 + WISH_RADII * preference`` radii, or that of its ``ends`` (2, 2), ``standing``, if
    smaller. The widest path (preference 1) is never cut short.
    """
    if preference >= 1.0:
        return False
    wish = min(need * (1.0 + WISH_RADII * preference), standing)
    least = max(need - borders.equal, wish - CLEARANCE_ROUNDING * borders.extent)
    return bool(box_tree_kernels.polyline_clearance(borders.tree, ends)[0] >= least)


def finish(
    borders: Borders, lines: Lines, need: float, preference: float
) -> tuple[FloatArray, IntArray]:
    """Proved polylines of the routes: taut, or unchanged if that cannot be proved.

    Unproved routes are left out; the widest path (preference 1) is not pulled taut. Returns all
    points (n, 2), and the start of each path (m + 1,).
    """
    wish = math.inf if preference >= 1.0 else need * (1.0 + WISH_RADII * preference)
    return _proved(borders, lines, need, wish, PATH_FLATNESS * need)


def as_wide(borders: Borders, lines: Lines, need: float, wide: float) -> FloatArray | None:
    """Polyline of the first route, nearly ``wide`` or at least ``need``; else None."""
    for keep in (max(need, wide * (1.0 - WIDEST_SLACK)), need):
        ways, first = _proved(borders, lines, keep, math.inf, PATH_FLATNESS * need)
        if len(first) > 1:
            return ways
    return None


def _proved(
    borders: Borders, lines: Lines, need: float, wish: float, flatness: float
) -> tuple[FloatArray, IntArray]:
    ways: FloatArray
    ways, first = taut_kernels.finish(
        borders.tree, lines.points, lines.pairs, lines.begin, wish, need, flatness,
        borders.equal, borders.equal + TIGHT_CHORDS * need,
    )  # fmt: skip
    return ways, first


def best_cut(
    borders: Borders, ways: FloatArray, first: IntArray, need: float, preference: float
) -> FloatArray:
    """The cheapest path after straight cuts, which may change sides of obstacles."""
    best: FloatArray = taut_kernels.best_cut(
        borders.tree, ways, first, need, need * (1.0 + WISH_RADII * preference),
        DETOUR * preference, borders.equal,
    )  # fmt: skip
    return best


def judge(borders: Borders, way: FloatArray, need: float, preference: float) -> float:
    """Cost of a path: its length, and more where it is narrow."""
    return float(taut_kernels.judge(borders.tree, way, need, DETOUR * preference, math.inf))


def certain(borders: Borders, lines: Lines, need: float) -> FloatArray | None:
    """Polyline of the first route, near enough to the bisectors to keep ``need``, or None."""
    ways, first = finish(borders, lines, need, 1.0)
    return ways if len(first) > 1 else None
