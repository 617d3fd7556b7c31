"""Routes onto and over the roadmap's chains: cost, width, line.

Rules and units
- Stations attach inside a chain, by retraction (:mod:`planner.search.attach_kernels`).
- Clearances are exact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from planner.borders.generators import Borders
from planner.diagram.agvd import Chains
from planner.scene import FloatArray, IntArray, Vec
from planner.search import (
    alternative_kernels,
    attach_kernels,
    chain_graph_kernels,
    route_search_kernels,
)
from planner.search.chain_graph_kernels import ChainGraph, Gates

DETOUR = 4.0
"""Cost added to a step at a clearance of one radius, in lengths, at the preference just below 1."""
CHAIN_NEAR = 0.25
"""A retracted place this near to a chain, in radii, has met it."""
ENTRIES = 8
"""Chains tried as a station's way onto the roadmap."""
WORK = 40_000_000
"""Steps over chains that a search for routes takes at most: about 0.2 s."""
CLEARANCE_ROUNDING = 1e-9
"""Clearances are equal within this share of the scene's extent."""


@dataclass(frozen=True, slots=True)
class Network:
    """The chains, and their costs as ``graph``."""

    chains: Chains
    graph: ChainGraph

    @classmethod
    def of(cls, chains: Chains, need: float, preference: float) -> Network:
        """Compute costs for a disc of radius ``need``. O(points)."""
        arrays, weight = chains.arrays, DETOUR * preference
        priced = chain_graph_kernels.price_chains(arrays, len(chains.node_xy), need, weight)
        return cls(chains, ChainGraph(arrays, *priced))


@dataclass(frozen=True, slots=True)
class Lines:
    """Routes concatenated: route i is ``points[begin[i] : begin[i + 1]]``.

    ``pairs`` (n, 2) are the pieces left and right of the link to the next point, -1 if it is
    straight.
    """

    points: FloatArray
    pairs: IntArray
    begin: IntArray

    def __len__(self) -> int:
        return len(self.begin) - 1

    def after(self, first: int, most_points: int) -> Lines:
        """Routes from number ``first`` on, up to ``most_points`` points together."""
        here = int(self.begin[min(first, len(self))])
        last = int(np.searchsorted(self.begin, here + most_points, side="right"))
        begin = self.begin[first:last]
        end = int(begin[-1]) if len(begin) else here
        begin = begin - here if len(begin) else np.zeros(1, np.int32)
        return Lines(self.points[here:end], self.pairs[here:end], begin)


def attach(
    borders: Borders, network: Network, place: Vec, floor: float, anywhere: bool = False
) -> Gates:
    """Ways from a place onto the chains, each with clearance >= ``floor``.

    The chain that retraction meets; if ``anywhere``, or if it meets none, any of the nearest chains
    that a straight line reaches.
    """
    extent = borders.extent
    return attach_kernels.attach(  # type: ignore[no-any-return]
        borders.tree, network.graph, *place, floor, -1.0 if anywhere else CHAIN_NEAR * floor,
        CLEARANCE_ROUNDING * extent, borders.equal, 2.0 * extent, ENTRIES,
    )  # fmt: skip


def widest_gap(network: Network, start: Gates, goal: Gates) -> float:
    """Largest clearance of any path from an entry to an exit, -inf if there is none."""
    return float(route_search_kernels.widest_way(network.graph, start, goal))


def cheapest_routes(
    borders: Borders,
    network: Network,
    start: Gates,
    goal: Gates,
    floor: float,
    wanted: int,
    budget: int = WORK,
    dearest: float = math.inf,
) -> tuple[Lines, int]:
    """The ``wanted`` cheapest routes without a loop that keep ``floor``, the cheapest first.

    Fewer if no more exist, if the ``budget`` of steps over chains is spent, or if the others are
    more than ``dearest`` times as dear as the first. The second value is the work, above ``budget``
    only if spent.
    """
    *found, work = alternative_kernels.cheapest_routes(
        network.graph,
        floor,
        start,
        goal,
        wanted,
        CLEARANCE_ROUNDING * borders.extent,
        budget,
        dearest,
    )
    return Lines(*found), int(work)
