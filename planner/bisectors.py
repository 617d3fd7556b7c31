"""From the generators' approximate diagram to the exact one.

Rules and units
- The sampled topology is a proposal. Its vertices are solved on their pieces, and each must
  prove itself by an empty circle; where one cannot, generators are added at the feet around
  it and the diagram is made anew. At an exact vertex the added generators have the same empty
  circle, so the proposal becomes right where it was wrong.
- Clearances below half the spacing are not refined: no robot of the radius gets there.
"""

from __future__ import annotations

import numpy as np

from planner import bisector_kernels
from planner.agvd import Agvd, Places, diagram, omit_invalid
from planner.generators import Generators

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
