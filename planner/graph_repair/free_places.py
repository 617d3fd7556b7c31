"""The place to which an unsafe node moves: near, free, and with a path to its neighbours."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from planner.borders.free_rays import nearest_free
from planner.graph_repair.solid_ground import SolidGround
from planner.scene import FloatArray, Vec

PLACE_DIRECTIONS = 48
"""Directions in which places are sought (chosen: 8 degrees apart)."""
FIRST_RADII, GROWTH = 0.02, 1.12
"""Distance of the nearest ring of places, in radii, and from ring to ring (chosen: a place is at
most an eighth farther than the nearest)."""
STEP_HALVINGS = 12
"""Halvings of the last step towards the node: to 3e-5 of the distance."""
MOST_TRIED = 12
"""Places tried until one has a path to a neighbour (chosen)."""
MOST_ASKED = 4
"""Neighbours to which a path is sought (chosen)."""
FARTHER = 1.5
"""A place up to this much farther is taken if more neighbours then see it (chosen)."""


def free_place(
    at: Vec, neighbours: Sequence[Vec], ground: SolidGround, farthest: float
) -> Vec | str:
    """Return the free place nearest to an unsafe one, or why there is none.

    One with straight safe lines to more neighbours may be a little farther. It has paths to all
    neighbours, or to as many as any that was tried, and at least to one.
    """
    places = _places_around(at, ground, farthest)
    if not len(places):
        return "there is no free place on the map"
    near = np.hypot(*(places - at).T)
    close = np.flatnonzero(near <= FARTHER * near[0])[:MOST_TRIED]
    seen = [_seen(places[k], neighbours, ground) for k in close.tolist()]
    order = [int(close[k]) for k in np.lexsort((near[close], [-count for count in seen]))]
    order += [k for k in range(len(places)) if k not in set(order)][:MOST_TRIED]
    best: Vec | str = "no free place near it has a path to a neighbour"
    most = 0
    asked = neighbours[:MOST_ASKED]
    for k in order:
        place = (float(places[k, 0]), float(places[k, 1]))
        reached = sum(not isinstance(ground.path(place, other), str) for other in asked)
        if reached == len(asked):
            return place
        if reached > most:
            best, most = place, reached
    return best


def _seen(place: FloatArray, neighbours: Sequence[Vec], ground: SolidGround) -> int:
    return sum(ground.is_safe(np.array([place, other])) for other in neighbours)


def _places_around(at: Vec, ground: SolidGround, farthest: float) -> FloatArray:
    """Free places (n, 2), one in each direction that has any, the nearest first."""
    count = max(1, math.ceil(math.log(farthest / (FIRST_RADII * ground.radius), GROWTH)))
    rings = FIRST_RADII * ground.radius * GROWTH ** np.arange(count + 1)
    turns = np.linspace(0.0, math.tau, PLACE_DIRECTIONS, endpoint=False)
    return nearest_free(
        np.array(at), turns, np.asarray(rings, np.float64), ground.is_free, STEP_HALVINGS
    )
