"""Remarks on a scene as the planner sees it, in plain sentences.

Objects that touch, cross, nest or coincide, or leave the bounds, are accepted, but a picture seldom
means it. Obstacles are named by their index in the scene, as in the reasons of ``NoPath``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from planner.borders import overlap_kernels
from planner.borders.generators import SAME_PLACE, Borders
from planner.roadmap.clip import Clipped
from planner.scene import FloatArray, primitive_kernels
from planner.shared.figures import sized

MOST_SENTENCES = 8
"""Sentences of a kind that are given in full."""
COMPASS = np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)])
"""Directions in which a circle reaches farthest."""


def remarks_on(borders: Borders, clipped: Clipped, radius: float, units: str) -> tuple[str, ...]:
    """Sentences on the scene's objects and on an empty roadmap."""
    out: list[str] = []
    if not len(borders.span):
        out.append("the scene has no objects: the roadmap is that of the empty bounds")
    out += _some(_relations(borders), "pairs of obstacles that meet or nest")
    out += _some(_strays(borders), "obstacles that leave the bounds")
    if not clipped.wide.any():
        out.append(f"the roadmap is empty: no passage is {sized(2.0 * radius, units)} wide")
    return tuple(out)


def remark_on_branches(left_out: Sequence[float], least: float, units: str) -> str:
    """Sentence on the dead ends shorter than ``least``."""
    limit = sized(least, units)
    if not left_out:
        return f"no dead end of the roadmap is shorter than {limit}: none was left out"
    which = "1 dead end" if len(left_out) == 1 else f"{len(left_out)} dead ends"
    longest = sized(max(left_out), units, beside=least)
    return f"left out {which} of the roadmap shorter than {limit}: the longest has {longest}"


def _some(sentences: list[str], rest: str) -> list[str]:
    if len(sentences) <= MOST_SENTENCES:
        return sentences
    return [*sentences[:MOST_SENTENCES], f"and {len(sentences) - MOST_SENTENCES} more {rest}"]


def _relations(borders: Borders) -> list[str]:
    k = borders.primitive_count
    pairs = overlap_kernels.related_objects(
        borders.kind,
        borders.data,
        borders.closed,
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
    """Sentences on objects that reach the bounds' walls."""
    if not (borders.owner < 0).any():
        return []
    x0, y0, x1, y1 = borders.box
    out = []
    for o, rough in enumerate(borders.object_boxes):
        if not _reaches(rough, borders.box):
            continue
        box = _exact_box(borders, o)
        if not _reaches(box, borders.box):
            continue
        away = box[2] < x0 or box[3] < y0 or box[0] > x1 or box[1] > y1
        how = "lies outside" if away else "touches or crosses"
        out.append(f"obstacle {o} {how} the bounds")
    return out


def _reaches(box: FloatArray, bounds: Sequence[float] | FloatArray) -> bool:
    return bool((box[:2] <= bounds[:2]).any() or (box[2:] >= bounds[2:]).any())


def _exact_box(borders: Borders, owner: int) -> FloatArray:
    """Exact box of an object; `Borders.object_boxes` take an arc's whole circle."""
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    data = borders.data
    for i in range(*borders.span[owner].tolist()):
        if borders.owner[i] != owner:
            continue
        row, kind = data[i], borders.kind[i]
        if kind == primitive_kernels.SEGMENT:
            places = [row[:2], row[2:4]]
        elif kind == primitive_kernels.POINT:
            places = [row[:2]]
        else:
            places = [row[:2] + row[2] * way for way in COMPASS]
            if kind == primitive_kernels.ARC:
                ends = (row[3], row[3] + row[4])
                places = [p for p in places if primitive_kernels.on_sweep(data, i, p[0], p[1])]
                places += [row[:2] + row[2] * np.array((np.cos(a), np.sin(a))) for a in ends]
        low, high = (
            np.minimum(low, np.min(places, axis=0)),
            np.maximum(high, np.max(places, axis=0)),
        )
    return np.array([*low, *high])
