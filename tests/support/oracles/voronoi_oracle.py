"""The Voronoi diagram straight from its definition, in exact rational arithmetic, O(n^3).

Two sites share an edge where the points of their bisector that no third site is closer to form
an interval with a length. Each third site cuts the bisector m + t d with one linear inequality;
everything is an integer or a fraction, so ties need no tolerance. Nothing here is shared with
the kernel: no triangles, circles, predicates or order.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

Edge = tuple[int, int, tuple[Fraction, Fraction] | None, tuple[Fraction, Fraction] | None]


def exact_sites(sites: Sequence[Sequence[float]]) -> list[tuple[Fraction, Fraction]]:
    return [(Fraction(float(x)), Fraction(float(y))) for x, y in sites]


def exact_edges(sites: Sequence[Sequence[float]]) -> list[Edge]:
    """(i, j, from, to) for i < j, first rows of coincident sites; None is at infinity."""
    points = exact_sites(sites)
    first: dict[tuple[Fraction, Fraction], int] = {}
    for i, p in enumerate(points):
        first.setdefault(p, i)
    rows = sorted(first.values())
    edges: list[Edge] = []
    for a, i in enumerate(rows):
        for j in rows[a + 1 :]:
            interval = _free_interval(points, rows, i, j)
            if interval is not None:
                edges.append((i, j, *(_at(points[i], points[j], t) for t in interval)))
    return edges


def exact_neighbours(sites: Sequence[Sequence[float]]) -> NDArray[np.int32]:
    pairs = [(i, j) for i, j, _, _ in exact_edges(sites)]
    return np.array(sorted(pairs), dtype=np.int32).reshape(-1, 2)


def _free_interval(
    points: list[tuple[Fraction, Fraction]], rows: list[int], i: int, j: int
) -> tuple[Fraction | None, Fraction | None] | None:
    """The t for which no site is closer to m + t d than i and j; None where that has no length."""
    (ax, ay), (bx, by) = points[i], points[j]
    mx, my, dx, dy = (ax + bx) / 2, (ay + by) / 2, ay - by, bx - ax
    low: Fraction | None = None
    high: Fraction | None = None
    for k in rows:
        if k in (i, j):
            continue
        # |x - c|^2 >= |x - a|^2 with x = m + t d is slope t <= bound
        cx, cy = points[k]
        slope = 2 * (dx * (cx - ax) + dy * (cy - ay))
        bound = (mx - cx) ** 2 + (my - cy) ** 2 - (mx - ax) ** 2 - (my - ay) ** 2
        if slope == 0:
            if bound < 0:
                return None
        elif slope > 0:
            high = bound / slope if high is None else min(high, bound / slope)
        else:
            low = bound / slope if low is None else max(low, bound / slope)
        if low is not None and high is not None and low >= high:
            return None
    return low, high


def _at(
    a: tuple[Fraction, Fraction], b: tuple[Fraction, Fraction], t: Fraction | None
) -> tuple[Fraction, Fraction] | None:
    if t is None:
        return None
    return (a[0] + b[0]) / 2 + t * (a[1] - b[1]), (a[1] + b[1]) / 2 + t * (b[0] - a[0])
