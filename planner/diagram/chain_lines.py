"""A roadmap edge's exact geometry as a polyline."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from planner.borders.generators import Borders
from planner.diagram import bisector_kernels
from planner.diagram.bisectors import Piece
from planner.scene import FloatArray


def edge_curve(borders: Borders, pieces: Sequence[Piece], flatness: float) -> FloatArray:
    """An edge's exact geometry as a polyline (n, 2) that leaves it by about ``flatness``."""
    points = np.array([pieces[0].start, *(piece.end for piece in pieces)])
    pairs = [(-1, -1) if p.curve == "straight" else (p.left, p.right) for p in pieces]
    curve: FloatArray
    curve, _ = bisector_kernels.follow(
        *borders.tree, points, np.array([*pairs, (-1, -1)], np.int32), 0.0, flatness,
        borders.equal,
    )  # fmt: skip
    return curve
