"""Ways onto the roadmap's chains and over them: what one costs, how wide it is, its line.

Rules and units
- Stations attach inside a chain, by retraction: straight away from the nearest border until a
  second one is as near, and then onto the chain.
- A way costs its length, and more where it is narrow; clearances are exact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner import bisector_kernels, distance_kernels, search_kernels
from planner.agvd import Chains
from planner.bisectors import EQUAL
from planner.chain_lines import Line, along, join, to_end
from planner.generators import Borders
from planner.scene import FloatArray, IntArray, Vec

DETOUR = 4.0
"""How much longer a step at a clearance of one radius may be, at the preference just below 1."""
NEAR = 0.25
"""A retracted place this near to a chain, in radii, has met it."""
ENTRIES = 8
"""Chains tried as a station's way onto the roadmap."""
ROUNDING = 1e-9
"""Clearances are equal within this share of the scene's extent."""


@dataclass(frozen=True, slots=True)
class Network:
    """The chains, what every link and chain costs, and which chains leave which node."""

    chains: Chains
    cost: FloatArray
    total: FloatArray
    around: IntArray
    leaving: IntArray

    @classmethod
    def of(cls, chains: Chains, need: float, preference: float) -> Network:
        """Costs for a disc of radius ``need``. O(points)."""
        cost, total = search_kernels.chain_costs(
            chains.rho, chains.gap, chains.step, chains.first, chains.length,
            need, DETOUR * preference,
        )  # fmt: skip
        around, leaving = search_kernels.adjacency(chains.ends, len(chains.node_xy))
        return cls(chains, cost, total, around, leaving)


@dataclass(frozen=True, slots=True)
class Entry:
    """A station's way onto chain ``chain`` at point ``link`` + ``part`` of its link.

    ``access`` (n, 2) runs from the station to the place on the chain; ``gap`` is its exact
    clearance. ``to_end`` are cost and clearance from there to the chain's two ends.
    """

    chain: int
    link: int
    part: float
    access: FloatArray
    cost: float
    gap: float
    to_end: tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True, slots=True)
class Gates:
    """All entries of a station as ways to nodes (2 n,): ``node``, ``access`` and ``gap``.

    ``access`` is what it costs to get to the entry's place on its chain.
    """

    entries: tuple[Entry, ...]
    node: IntArray
    access: FloatArray
    gap: FloatArray

    @classmethod
    def of(cls, chains: Chains, entries: Sequence[Entry]) -> Gates:
        """Gate 2 i + end leads from entry i to that end of its chain."""
        both = [(e, end) for e in entries for end in range(2)]
        return cls(
            tuple(entries),
            np.array([chains.ends[e.chain, end] for e, end in both], np.int32),
            np.array([e.cost for e, _ in both]),
            np.array([min(e.gap, e.to_end[end][1]) for e, end in both]),
        )

    def costs(self, floor: float, dearer: FloatArray | None = None) -> FloatArray:
        """(2 n,) the gates' costs, infinity where their clearance is below ``floor``.

        ``dearer`` are factors for what is walked of each chain.
        """
        cost = self.access.copy()
        for i, entry in enumerate(self.entries):
            factor = 1.0 if dearer is None else dearer[entry.chain]
            cost[2 * i] += factor * entry.to_end[0][0]
            cost[2 * i + 1] += factor * entry.to_end[1][0]
        return np.where(self.gap >= floor, cost, np.inf)


def attach(
    borders: Borders, network: Network, place: Vec, floor: float, anywhere: bool = False
) -> Gates:
    """Ways from a place onto the chains, each with clearance >= ``floor``; the nearest first.

    Where retraction meets a chain that chain is the way; with ``anywhere``, or where it meets
    none, any of the nearest chains that a straight line reaches.
    """
    chains = network.chains
    x, y, _, _, _ = search_kernels.retract(*borders.tree, *place, 2.0 * borders.extent)
    ridge = (x, y)
    usable = np.ones(len(chains), dtype=np.bool_)
    found = search_kernels.nearest_links(chains.points, chains.first, usable, x, y, ENTRIES)
    entries: list[Entry] = []
    for chain, link, part, away in zip(*(a.tolist() for a in found), strict=True):
        if chain < 0:
            break
        met = found[3][0] <= NEAR * floor and not anywhere
        if met and entries and away > found[3][0] + ROUNDING * borders.extent:
            break
        a, b = chains.points[link], chains.points[min(link + 1, chains.first[chain + 1] - 1)]
        foot = a + part * (b - a)
        if chains.proved[link]:
            left, right = chains.pieces[link]
            foot[0], foot[1], _ = bisector_kernels.slide_between(
                borders.kind, borders.data, left, right, foot[0], foot[1], EQUAL * borders.extent
            )
        access = np.array([place, ridge, foot])
        gap = distance_kernels.polyline_clearance(*borders.tree, access)[0]
        if gap < floor:
            continue
        ends = _to_ends(network, chain, link, part)
        length = math.dist(place, ridge) + away
        entries.append(Entry(chain, link, part, access, length, gap, ends))
    return Gates.of(chains, entries)


def _to_ends(
    network: Network, chain: int, link: int, part: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Cost and clearance from a place inside a chain to its first and to its last point."""
    chains, cost = network.chains, network.cost
    lo, hi = int(chains.first[chain]), int(chains.first[chain + 1]) - 1
    if lo == hi:
        return ((0.0, float(chains.rho[lo])),) * 2
    back = float(cost[lo:link].sum() + part * cost[link])
    ahead = float(cost[link + 1 : hi].sum() + (1.0 - part) * cost[link])
    return (
        (back, float(chains.gap[lo : link + 1].min())),
        (ahead, float(chains.gap[link:hi].min())),
    )


def widest_gap(network: Network, start: Gates, goal: Gates) -> float:
    """The largest clearance a way from any entry to any exit can keep, -inf where none leads."""
    chains = network.chains
    best = search_kernels.widest(
        network.around, network.leaving, chains.ends, chains.clearance,
        start.node, start.gap, goal.node, goal.gap,
    )  # fmt: skip
    return max(float(best), *(gap for gap, _, _, _ in _direct(network, start, goal)), -math.inf)


def cheapest(
    network: Network, start: Gates, goal: Gates, floor: float, dearer: FloatArray | None = None
) -> tuple[Line, frozenset[int]] | None:
    """The route and its chains: the cheapest way from any entry to any exit, or None.

    ``dearer`` are factors >= 1, one a chain.
    """
    chains = network.chains
    best, entry, out, steps = search_kernels.cheapest(
        network.around, network.leaving, chains.ends,
        network.total if dearer is None else network.total * dearer, chains.clearance, floor,
        start.node, start.costs(floor, dearer), goal.node, goal.costs(floor, dearer),
    )  # fmt: skip
    direct: tuple[Entry, Entry] | None = None
    for gap, apart, a, b in _direct(network, start, goal):
        here = a.cost + b.cost + apart * (1.0 if dearer is None else float(dearer[a.chain]))
        if gap >= floor and here < best:
            best, direct = here, (a, b)
    if not math.isfinite(best):
        return None
    if direct is not None:
        a, b = direct
        inner = along(chains, (a.link, a.part), (b.link, b.part), a.access[-1], b.access[-1])
        lines = [Line.straight(a.access), inner, Line.straight(b.access).reversed()]
        return join(lines), frozenset({a.chain})
    (a, a_end), (b, b_end) = _gate(start, entry), _gate(goal, out)
    lines = [Line.straight(a.access), to_end(chains, a.chain, a.link, a.access[-1], a_end)]
    for step in steps.tolist():
        c, end = divmod(step, 2)
        line = Line.part(chains, chains.first[c], chains.first[c + 1])
        lines.append(line if end == 0 else line.reversed())
    lines.append(to_end(chains, b.chain, b.link, b.access[-1], b_end).reversed())
    lines.append(Line.straight(b.access).reversed())
    return join(lines), frozenset([a.chain, b.chain, *(steps // 2).tolist()])


def costs_between(network: Network, stations: Sequence[Gates], floor: float) -> FloatArray:
    """(m, m) what the cheapest way between any two stations costs, infinity where none leads.

    One search a station.
    """
    chains = network.chains
    m = len(stations)
    matrix = np.zeros((m, m))
    for i, start in enumerate(stations):
        far = search_kernels.costs_from(
            network.around, network.leaving, chains.ends, network.total, chains.clearance, floor,
            start.node, start.costs(floor),
        )  # fmt: skip
        for j in range(i + 1, m):
            goal = stations[j]
            best = float((far[goal.node] + goal.costs(floor)).min(initial=np.inf))
            for gap, apart, a, b in _direct(network, start, goal):
                if gap >= floor:
                    best = min(best, a.cost + b.cost + apart)
            matrix[i, j] = matrix[j, i] = best
    return matrix


def _gate(gates: Gates, number: int) -> tuple[Entry, int]:
    return gates.entries[number // 2], number % 2


def _direct(network: Network, start: Gates, goal: Gates) -> list[tuple[float, float, Entry, Entry]]:
    """Ways within one chain: clearance, cost from place to place, entry and exit."""
    chains = network.chains
    found = []
    for a in start.entries:
        for b in goal.entries:
            if a.chain != b.chain:
                continue
            lo, hi = min(a.link, b.link), max(a.link, b.link)
            alone = chains.first[a.chain + 1] - chains.first[a.chain] == 1
            between = chains.rho[lo] if alone else chains.gap[lo : hi + 1].min()
            apart = abs(_position(network.cost, a) - _position(network.cost, b))
            found.append((min(a.gap, b.gap, float(between)), apart, a, b))
    return found


def _position(cost: FloatArray, entry: Entry) -> float:
    return float(cost[: entry.link].sum() + entry.part * cost[entry.link])
