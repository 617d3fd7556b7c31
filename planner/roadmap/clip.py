"""The chains for a robot: cut where their clearance passes its radius.

Rules and units
- A chain that is as wide as the robot in places only is cut there: its wide parts are chains of
  their own, and what is too narrow between them, too. What the cuts make are nodes.
- What is narrower than the robot by rounding only is as wide as the robot.
- Nodes at one place are one: beside walls much thinner than the generators' spacing a vertex may
  be there twice, with what is too narrow for any robot between.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from planner.borders.generators import BoolArray, Borders
from planner.diagram.agvd import Chains
from planner.roadmap import clip_kernels
from planner.scene import FloatArray, IntArray
from planner.search.chain_search import ROUNDING

EQUAL = 4.0
"""A way narrower than the robot by so many times what is equal, or less, is as wide."""
ASTRAY = 16.0
"""A dead end farther off its bisector than so many times what is equal is none."""


@dataclass(frozen=True, slots=True)
class Clipped:
    """Chains each of which the robot follows throughout, or nowhere: ``wide`` (c,) says which.

    Nodes keep their numbers; those of the cuts come behind them.
    """

    chains: Chains
    wide: BoolArray


def clip_chains(borders: Borders, chains: Chains, radius: float) -> Clipped:
    """Cut the chains where they pass ``radius``. O(points)."""
    rounding = ROUNDING * borders.extent
    # in the paper's mode no chain is on its bisectors
    astray = ASTRAY * borders.equal if chains.proved.any() else math.inf
    solids = borders.closed, borders.box
    where, places, wide = clip_kernels.wide_parts(
        *borders.tree, solids, chains.points, chains.first, chains.pieces, chains.proved,
        chains.rho, chains.gap, chains.clearance, chains.ends, len(chains.node_xy), radius,
        radius - EQUAL * borders.equal, rounding, borders.equal, astray,
    )  # fmt: skip
    if len(where):
        chains, wide = _cut(borders, chains, where, places, wide)
    same = clip_kernels.same_nodes(chains.node_xy, chains.ends, wide, rounding)
    return Clipped(replace(chains, ends=same[chains.ends]), wide)


def _cut(
    borders: Borders, chains: Chains, where: IntArray, places: FloatArray, whole: BoolArray
) -> tuple[Chains, BoolArray]:
    points, first, pieces, proved, rho, gap, step, ends, length, clearance, wide, new = (
        clip_kernels.cut_chains(
            *borders.tree, chains.points, chains.first, chains.pieces, chains.proved, chains.rho,
            chains.gap, chains.step, chains.ends, len(chains.node_xy), where, places, whole,
        )
    )  # fmt: skip
    cut = Chains(
        points=points,
        first=first,
        pieces=pieces,
        rho=rho,
        gap=gap,
        step=step,
        ends=ends,
        length=length,
        clearance=clearance,
        node_xy=np.concatenate([chains.node_xy, new[:, :2]]),
        node_rho=np.concatenate([chains.node_rho, new[:, 2]]),
        proved=proved,
    )
    return cut, wide
