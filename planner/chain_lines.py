"""Stretches of the roadmap's chains as lines, and the pieces that each runs between."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner import bisector_kernels
from planner.agvd import Chains
from planner.bisectors import EQUAL, Piece
from planner.generators import Borders
from planner.scene import FloatArray, IntArray

Place = tuple[int, float]
"""A point's index and the part of its link that is gone."""


@dataclass(frozen=True, slots=True)
class Line:
    """A polyline (n, 2) and the pieces (n, 2) that each link runs between, -1 where straight."""

    points: FloatArray
    pairs: IntArray

    def reversed(self) -> Line:
        """The same line the other way round: left and right change places."""
        pairs = np.full_like(self.pairs, -1)
        pairs[:-1] = self.pairs[:-1][::-1, ::-1]
        return Line(self.points[::-1], pairs)

    @classmethod
    def straight(cls, points: FloatArray) -> Line:
        """A line between no two pieces."""
        return cls(points, np.full((len(points), 2), -1, np.int32))

    @classmethod
    def part(cls, chains: Chains, lo: int, hi: int) -> Line:
        """The chain's points from lo up to hi, hi excluded; unproved links are straight."""
        pairs = np.where(chains.proved[lo:hi, None], chains.pieces[lo:hi], np.int32(-1))
        return cls(chains.points[lo:hi], pairs)


def along(chains: Chains, a: Place, b: Place, at_a: FloatArray, at_b: FloatArray) -> Line:
    """One chain from the place a, which lies at ``at_a``, to the place b."""
    if a > b:
        return along(chains, b, a, at_b, at_a).reversed()
    inner = Line.part(chains, a[0], b[0] + 1)
    return Line(np.concatenate([[at_a], inner.points[1:], [at_b]]), _with_end(inner.pairs))


def to_end(chains: Chains, chain: int, link: int, at: FloatArray, end: int) -> Line:
    """A chain from a place on link ``link``, which lies ``at``, to one of its ends."""
    lo, hi = int(chains.first[chain]), int(chains.first[chain + 1])
    if hi - lo == 1:
        return Line.straight(at[None])
    if end == 0:
        back = Line.part(chains, lo, link + 1)
        return Line(np.concatenate([back.points, at[None]]), _with_end(back.pairs)).reversed()
    ahead = Line.part(chains, link, hi)
    return Line(np.concatenate([at[None], ahead.points[1:]]), ahead.pairs)


def join(lines: Sequence[Line]) -> Line:
    """One line without repeated points; each starts where the one before it ends."""
    points = np.concatenate([line.points for line in lines])
    pairs = np.concatenate([line.pairs for line in lines])
    kept = np.ones(len(points), dtype=np.bool_)
    kept[:-1] = np.any(points[1:] != points[:-1], axis=1)
    return Line(points[kept], pairs[kept])


def edge_curve(borders: Borders, pieces: Sequence[Piece], flatness: float) -> FloatArray:
    """An edge's exact geometry as a polyline (n, 2) that leaves it by about ``flatness``."""
    points = np.array([pieces[0].start, *(piece.end for piece in pieces)])
    pairs = [(-1, -1) if p.curve == "straight" else (p.left, p.right) for p in pieces]
    curve: FloatArray
    curve, _ = bisector_kernels.follow(
        *borders.tree, points, np.array([*pairs, (-1, -1)], np.int32), 0.0, flatness,
        EQUAL * borders.extent,
    )  # fmt: skip
    return curve


def _with_end(pairs: IntArray) -> IntArray:
    return np.concatenate([pairs, [[-1, -1]]]).astype(np.int32)
