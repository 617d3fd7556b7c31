"""The roadmap as lines with clearances, for pictures, without its graph.

A graph of thousands of edges takes seconds to make.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from planner.diagram import bisector_kernels
from planner.scene import FloatArray, IntArray

if TYPE_CHECKING:
    from planner.roadmap.roadmap import Roadmap

END = -2
"""The pair of a line's last point: nothing follows it."""


@dataclass(frozen=True, slots=True)
class Curves:
    """Consecutive lines: line i is ``points[first[i] : first[i + 1]]``.

    ``clearances`` (n,) are the points', exact; ``pairs`` (n, 2) the pieces beside the link to the
    next point, -1 if it is straight, ``END`` at a line's last. ``narrowest`` is the least
    clearance.
    """

    points: FloatArray
    clearances: FloatArray
    first: IntArray
    pairs: IntArray
    narrowest: float


def curves_of(roadmap: Roadmap) -> Curves | None:
    """The roadmap's edges through the points of its chains; None if it has none."""
    chains = roadmap.clipped.chains
    kept = [c for c in roadmap.kept if chains.first[c + 1] - chains.first[c] > 1]
    if not kept:
        return None
    rows = np.concatenate([np.arange(chains.first[c], chains.first[c + 1]) for c in kept])
    counts = np.array([chains.first[c + 1] - chains.first[c] for c in kept])
    first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    pairs = np.where(chains.proved[rows, None], chains.pieces[rows], -1).astype(np.int32)
    pairs[first[1:] - 1] = END
    narrowest = max(float(chains.gap[rows].min()), roadmap.radius)
    clearances = np.maximum(chains.rho[rows], roadmap.radius)
    return Curves(chains.points[rows], clearances, first, pairs, narrowest)


def followed(roadmap: Roadmap, curves: Curves, flatness: float) -> Curves:
    """The same lines with more points, within about ``flatness`` of the bisectors."""
    borders = roadmap.borders
    points, pairs = bisector_kernels.follow(
        borders.tree, np.ascontiguousarray(curves.points), curves.pairs, 0.0, flatness,
        borders.equal, np.inf,
    )  # fmt: skip
    clearances = np.maximum(borders.distances(points)[0], roadmap.radius)
    first = np.concatenate([[0], np.flatnonzero(pairs[:, 0] == END) + 1]).astype(np.int32)
    return Curves(points, clearances, first, pairs, curves.narrowest)
