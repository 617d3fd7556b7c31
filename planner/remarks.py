"""What is remarkable about a scene as a planner sees it, in plain sentences.

Rules
- Objects that touch, cross, nest or coincide, and such as leave the bounds, are accepted: the
  solid is whatever lies in any of them. That they do is said, since a picture seldom means it.
- Obstacles are named by their index in the scene, as in the reasons of ``NoPath``.
"""

from __future__ import annotations

import numpy as np

from planner import overlap_kernels
from planner.agvd import Chains
from planner.generators import SAME_PLACE, Borders

MOST = 8
"""So many sentences of a kind are said in full; the others are counted."""


def remarks_on(borders: Borders, chains: Chains, radius: float) -> tuple[str, ...]:
    """Sentences on the scene's objects and on a roadmap that is empty."""
    out: list[str] = []
    if not len(borders.span):
        out.append("the scene has no objects: the roadmap is that of the empty bounds")
    out += _some(_relations(borders), "pairs of obstacles that meet or nest")
    out += _some(_strays(borders), "obstacles that leave the bounds")
    if not (chains.clearance >= radius).any():
        out.append(f"the roadmap is empty: no way is {2.0 * radius:g} wide")
    return tuple(out)


def _some(sentences: list[str], rest: str) -> list[str]:
    if len(sentences) <= MOST:
        return sentences
    return [*sentences[:MOST], f"and {len(sentences) - MOST} more {rest}"]


def _relations(borders: Borders) -> list[str]:
    k = borders.primitive_count
    pairs = overlap_kernels.related_objects(
        borders.kind,
        borders.data,
        borders.owner,
        borders.solid,
        borders.object_boxes,
        borders.span,
        SAME_PLACE * borders.extent,
    )
    data, kind = borders.data[:k], borders.kind[:k]
    out = []
    for a, b, how in sorted(pairs.tolist()):
        one, other = (slice(*borders.span[o].tolist()) for o in (a, b))
        if how == overlap_kernels.WITHIN:
            out.append(f"obstacle {a} lies inside obstacle {b}")
        elif np.array_equal(kind[one], kind[other]) and np.array_equal(data[one], data[other]):
            out.append(f"obstacles {a} and {b} coincide")
        else:
            out.append(f"obstacles {a} and {b} touch or cross")
    return out


def _strays(borders: Borders) -> list[str]:
    """Objects whose boxes reach the bounds' walls, where there are bounds."""
    if not (borders.owner < 0).any():
        return []
    x0, y0, x1, y1 = borders.box
    boxes = borders.object_boxes
    walls = (boxes[:, 0] <= x0) | (boxes[:, 1] <= y0) | (boxes[:, 2] >= x1) | (boxes[:, 3] >= y1)
    away = (boxes[:, 2] < x0) | (boxes[:, 3] < y0) | (boxes[:, 0] > x1) | (boxes[:, 1] > y1)
    return [
        f"obstacle {o} lies outside the bounds"
        if away[o]
        else f"obstacle {o} touches or crosses the bounds"
        for o in np.flatnonzero(walls).tolist()
    ]
