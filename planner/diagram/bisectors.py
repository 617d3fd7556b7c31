"""Exact curves of a roadmap's edges: lines, parabolas, hyperbolas and ellipses.

An edge runs along bisectors, each of two pieces of the borders; scene's units.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from planner.borders.generators import BoolArray, Borders
from planner.diagram import bisector_kernels
from planner.scene import POINT, FloatArray, IntArray, Vec
from planner.scene.primitives import ROUND

__all__ = ["Curve", "Piece", "describe", "edge_curve"]

Curve: TypeAlias = Literal["line", "parabola", "hyperbola", "ellipse", "straight"]


@dataclass(frozen=True, slots=True)
class Piece:
    """Part of an edge: the bisector of the pieces ``left`` and ``right`` of the borders.

    ``curve`` is "line", "parabola", "hyperbola", or "ellipse" (between a circle and what lies
    inside it); "straight" if the bisector is unproved and the straight line between the ends was
    measured. ``left`` and ``right`` index ``Borders.kind`` and ``Borders.data``, as seen from
    ``start`` to ``end``.
    """

    curve: Curve
    left: int
    right: int
    start: Vec
    end: Vec


def describe(
    borders: Borders, points: FloatArray, pairs: IntArray, proved: BoolArray
) -> tuple[Piece, ...]:
    """Runs between the same two pieces along a chain; ``pairs`` as in ``Chains``.

    Every measured straight line stays separate.
    """
    out: list[Piece] = []
    last = len(points) - 1
    begin = 0
    for i in range(last):
        same = i + 1 < last and (pairs[i + 1] == pairs[begin]).all()
        if same and proved[i + 1] and proved[begin]:
            continue
        left, right = int(pairs[begin, 0]), int(pairs[begin, 1])
        curve: Curve = "straight"
        if proved[begin]:
            curve = _curve(borders, left, right, points[begin])
        a, b = points[begin], points[i + 1]
        out.append(
            Piece(curve, left, right, (float(a[0]), float(a[1])), (float(b[0]), float(b[1])))
        )
        begin = i + 1
    return tuple(out)


def edge_curve(borders: Borders, pieces: Sequence[Piece], flatness: float) -> FloatArray:
    """Exact geometry of an edge as a polyline (n, 2), to within about ``flatness``."""
    points = np.array([pieces[0].start, *(piece.end for piece in pieces)])
    pairs = [(-1, -1) if p.curve == "straight" else (p.left, p.right) for p in pieces]
    curve: FloatArray
    curve, _ = bisector_kernels.follow(
        borders.tree, points, np.array([*pairs, (-1, -1)], np.int32), 0.0, flatness,
        borders.equal, np.inf,
    )  # fmt: skip
    return curve


def _curve(borders: Borders, left: int, right: int, at: FloatArray) -> Curve:
    round_left, round_right = _radius(borders, left, at), _radius(borders, right, at)
    if round_left is None and round_right is None:
        return "line"
    if round_left is None or round_right is None:
        return "parabola"
    if round_left == round_right:
        return "line"
    return "hyperbola" if round_left >= 0.0 and round_right >= 0.0 else "ellipse"


def _radius(borders: Borders, piece: int, at: FloatArray) -> float | None:
    """Radius of a round piece, negative as seen from inside; None for a straight one."""
    kind = borders.kind[piece]
    if kind == POINT:
        return 0.0
    if kind not in ROUND:
        return None
    x, y, r = (float(v) for v in borders.data[piece, :3])
    outside = np.hypot(at[0] - x, at[1] - y) >= r
    return r if outside else -r
