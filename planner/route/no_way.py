"""Reasons for a refusal: a station too near to a border, the narrowest place, the radius that fits.

Rules and units
- The widest robot is that of the widest path over the chains, exact if wider than the generators'
  spacing: narrower gaps count as walls.
- A reason is a sentence with the scene's units.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from planner.borders import box_tree_kernels, inside_kernels
from planner.borders.generators import Borders
from planner.diagram.agvd import Chains
from planner.path import Bottleneck, NoPath
from planner.route.taut import certain
from planner.scene import Bounds, UnknownCells, Vec
from planner.search.chain_search import (
    CLEARANCE_ROUNDING,
    Network,
    attach,
    cheapest_routes,
    widest_gap,
)
from planner.shared.figures import placed, sized


@dataclass(frozen=True, slots=True)
class Blocked:
    """Absence of a path for a disc of radius ``need`` from ``start`` to ``goal``.

    ``stations`` are all requested ones, in order. ``reason`` says why the disc cannot be at one of
    them, None if the path is at fault. ``names`` are those of both ends; ``remarks`` report
    uncertainty.
    """

    start: Vec
    goal: Vec
    need: float
    stations: tuple[Vec, ...]
    reason: str | None = None
    names: tuple[str, str] = ("the start", "the goal")
    remarks: tuple[str, ...] = ()


def explain(
    borders: Borders, chains: Chains, blocked: Blocked, radius: float, units: str = ""
) -> NoPath | None:
    """Narrowest place of the widest path; None if there is no path for any robot."""
    found = widest_way(borders, chains, blocked.stations)
    if found is None:
        return None
    wide, (x, y) = found
    fits = max(wide - (blocked.need - radius), 0.0)
    reason = blocked.reason
    if reason is None:
        width = sized(2.0 * wide, units, beside=2.0 * blocked.need)
        reason = f"{_no_way(blocked, units)}: the widest is {width} wide at {placed(x, y)}"
    return NoPath(reason, Bottleneck(x, y, 2.0 * wide), fits, blocked.remarks)


def walled_in(blocked: Blocked, spacing: float, units: str = "") -> NoPath:
    """Refusal of robots of any size: borders with gaps up to ``spacing`` separate the stations."""
    if blocked.reason is not None:
        return NoPath(blocked.reason, remarks=blocked.remarks)
    gaps = f"borders lie between them, with no gap wider than {sized(spacing, units)}"
    return NoPath(f"{_no_way(blocked, units)}: {gaps}", remarks=blocked.remarks)


def _no_way(blocked: Blocked, units: str) -> str:
    width = sized(2.0 * blocked.need, units)
    start, goal = _at(blocked.start), _at(blocked.goal)
    if len(blocked.stations) > 2:
        start, goal = f"{blocked.names[0]} {start}", f"{blocked.names[1]} {goal}"
    return f"no path from {start} to {goal} is {width} wide throughout"


def widest_way(
    borders: Borders, chains: Chains, stations: Sequence[Vec]
) -> tuple[float, Vec] | None:
    """Largest radius that can make the journey, and its narrowest place, or None."""
    narrowest: tuple[float, Vec] | None = None
    network = Network.of(chains, 1.0, 0.0)
    least = CLEARANCE_ROUNDING * borders.extent
    for a, b in pairwise(stations):
        if a == b:
            wide = float(borders.distances(np.array([a]))[0][0])
            if narrowest is None or wide < narrowest[0]:
                narrowest = (wide, a)
            continue
        entries, exits = attach(borders, network, a, least), attach(borders, network, b, least)
        gap = widest_gap(network, entries, exits)
        if gap <= least:
            return None
        least_gap = gap * (1.0 - 1e-12)
        route, _ = cheapest_routes(borders, network, entries, exits, least_gap, 1)
        if not len(route):
            return None
        way = certain(borders, route, gap)
        line = route.points if way is None else way
        wide, x, y, _, _ = box_tree_kernels.polyline_clearance(borders.tree, line)
        if wide <= least:
            return None
        if narrowest is None or wide < narrowest[0]:
            narrowest = (wide, (x, y))
    return narrowest


@dataclass(frozen=True, slots=True)
class NamedStation:
    """A station, its nearest primitive, the distance to it, and if an object is there."""

    name: str
    at: Vec
    distance: float
    nearest: int
    is_solid: bool

    @classmethod
    def of(cls, borders: Borders, name: str, at: Vec) -> NamedStation:
        """Measure the place against the borders."""
        return cls(name, at, *inside_kernels.standing(borders.tree, borders.closed, *at))


def why_not(
    borders: Borders,
    place: NamedStation,
    need: float,
    units: str = "",
    what: str = "the radius",
    unknown: UnknownCells | None = None,
) -> str | None:
    """Reason why a disc of radius ``need`` cannot be there, or None.

    ``what`` names the requirement; ``unknown`` marks uncertain obstacles.
    """
    (x, y), distance = place.at, place.distance
    subject = f"{place.name} {_at(place.at)}"
    bounds = Bounds(*borders.box)
    if not bounds.contains(place.at):
        return f"{subject} lies outside the bounds, {bounds.ranges}"
    if place.is_solid:
        inside = np.flatnonzero(borders.owners_around(x, y, distance))
        if len(inside) and unknown is not None and unknown.holds(x, y):
            return f"{subject} lies in an unknown part of the map"
        if len(inside):
            return f"{subject} lies inside obstacle {inside[0]}"
    if distance < need - CLEARANCE_ROUNDING * borders.extent:
        owner = borders.owner[place.nearest]
        border = "the bounds" if owner < 0 else f"obstacle {owner}"
        return (
            f"{subject} is {sized(distance, units, beside=need)} from {border}, "
            f"nearer than {what} of {sized(need, units, beside=distance)}"
        )
    return None


def _at(place: Vec) -> str:
    return f"({place[0]:g}, {place[1]:g})"
