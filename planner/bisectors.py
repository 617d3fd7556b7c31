"""From the generators' approximate diagram to the exact one.

Rules and units
- The sampled topology is a proposal. Its vertices are solved on their pieces, and each must
  prove itself by an empty circle; where one cannot, generators are added at the feet around
  it and the diagram is made anew. At an exact vertex the added generators have the same empty
  circle, so the proposal becomes right where it was wrong.
- Clearances below half the spacing are not refined: no robot of the radius gets there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from planner import bisector_kernels
from planner.agvd import Agvd, Places, diagram, omit_invalid
from planner.generators import BoolArray, Borders, Generators
from planner.scene import ARC, CIRCLE, POINT, FloatArray, IntArray, Vec

Curve: TypeAlias = Literal["line", "parabola", "hyperbola", "ellipse", "straight"]

ROUNDS = 4
"""How often generators are added at most; one or two rounds were enough on random scenes."""
EQUAL = 1e-12
"""Distances are equal within this share of the scene's extent."""


def solve_exactly(agvd: Agvd) -> tuple[Agvd, Places]:
    """The diagram refined until its vertices are exact, and where they are."""
    places, refined = _solve_once(agvd)
    for _ in range(ROUNDS):
        if refined is None:
            break
        agvd = omit_invalid(diagram(refined), refined, "exact")
        places, refined = _solve_once(agvd)
    return agvd, places


def _solve_once(agvd: Agvd) -> tuple[Places, Generators | None]:
    """Solve all vertices; the generators to try next, or None where all circles are empty."""
    generators, borders = agvd.generators, agvd.generators.borders
    xy, rho, state, extra, extra_label = bisector_kernels.solve_vertices(
        agvd.ordinary.edges,
        agvd.valid,
        agvd.ordinary.vertices,
        agvd.ordinary.vertex_sites,
        generators.label,
        borders.kind,
        borders.data,
        borders.owner,
        borders.before,
        borders.after,
        borders.order,
        borders.large,
        borders.boxes,
        borders.primitive_count,
        generators.spacing,
        0.5 * generators.spacing,
        EQUAL * borders.extent,
    )
    places = Places(xy, rho, state)
    if not len(extra):
        return places, None
    return places, Generators(
        np.concatenate([generators.sites, extra]),
        np.concatenate([generators.label, extra_label]),
        generators.spacing,
        borders,
    )


@dataclass(frozen=True, slots=True)
class Piece:
    """A part of an edge: the bisector of the pieces ``left`` and ``right`` of the borders.

    ``curve`` is what it is exactly: "line", "parabola", "hyperbola", or "ellipse" (between a
    circle and what lies inside it); "straight" where the bisector could not be proved and the
    straight line between the ends was measured instead. ``left`` and ``right`` index
    ``Borders.kind`` and ``Borders.data``, as seen from ``start`` to ``end``.
    """

    curve: Curve
    left: int
    right: int
    start: Vec
    end: Vec


def describe(
    borders: Borders, points: FloatArray, pairs: IntArray, proved: BoolArray
) -> tuple[Piece, ...]:
    """The runs between the same two pieces along a chain; ``pairs`` as in ``Chains``."""
    out: list[Piece] = []
    last = len(points) - 1
    begin = 0
    for i in range(last):
        same = i + 1 < last and (pairs[i + 1] == pairs[begin]).all()
        if same and bool(proved[i + 1]) == bool(proved[begin]):
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


def _curve(borders: Borders, left: int, right: int, at: FloatArray) -> Curve:
    """What the bisector of two pieces is, seen from a place on it."""
    round_left, round_right = _radius(borders, left, at), _radius(borders, right, at)
    if round_left is None and round_right is None:
        return "line"
    if round_left is None or round_right is None:
        return "parabola"
    if round_left == round_right:
        return "line"
    return "hyperbola" if round_left >= 0.0 and round_right >= 0.0 else "ellipse"


def _radius(borders: Borders, piece: int, at: FloatArray) -> float | None:
    """The radius of a round piece, negative as seen from inside; None for a straight one."""
    kind = borders.kind[piece]
    if kind == POINT:
        return 0.0
    if kind not in (CIRCLE, ARC):
        return None
    x, y, r = (float(v) for v in borders.data[piece, :3])
    outside = np.hypot(at[0] - x, at[1] - y) >= r
    return r if outside else -r
