"""Chains for a robot: cut where their clearance passes its radius.

Nodes at one place are merged: beside walls much thinner than the generators' spacing a vertex may
occur twice, joined by parts too narrow for any robot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from planner.borders.generators import BoolArray, Borders
from planner.diagram.agvd import Chains
from planner.roadmap import clip_kernels
from planner.search.chain_search import CLEARANCE_ROUNDING

EQUAL_WIDTHS = 4.0
"""Multiple of the rounding by which a path may be too narrow and still count as wide enough."""
CHAIN_ASTRAY = 16.0
"""Multiple of the rounding beyond which a chain's end is too far off its bisector for a dead
end."""


@dataclass(frozen=True, slots=True)
class Clipped:
    """Chains that the robot follows throughout, or nowhere: ``wide`` (c,) says which.

    Nodes of the cuts come after the others.
    """

    chains: Chains
    wide: BoolArray


def clip_chains(borders: Borders, chains: Chains, radius: float) -> Clipped:
    """Cut the chains where they pass ``radius``. O(points)."""
    rounding = CLEARANCE_ROUNDING * borders.extent
    # in the paper's mode no chain is on its bisectors
    astray = CHAIN_ASTRAY * borders.equal if chains.proved.any() else math.inf
    solids = clip_kernels.Solids(borders.closed, borders.box)
    limits = clip_kernels.PartLimits(
        radius, radius - EQUAL_WIDTHS * borders.equal, rounding, borders.equal, astray
    )
    parts, wide = clip_kernels.wide_parts(
        borders.tree, solids, chains.arrays, len(chains.node_xy), limits
    )
    if len(parts.where):
        chains, wide = _cut(borders, chains, parts, wide)
    same = clip_kernels.same_nodes(chains.node_xy, chains.ends, wide, rounding)
    return Clipped(replace(chains, ends=same[chains.ends]), wide)


def _cut(
    borders: Borders, chains: Chains, parts: clip_kernels.Parts, whole: BoolArray
) -> tuple[Chains, BoolArray]:
    cut, wide, new = clip_kernels.cut_chains(
        borders.tree, chains.arrays, len(chains.node_xy), parts, whole
    )
    node_xy = np.concatenate([chains.node_xy, new[:, :2]])
    node_rho = np.concatenate([chains.node_rho, new[:, 2]])
    return Chains(**cut._asdict(), node_xy=node_xy, node_rho=node_rho), wide
