"""Places for the boxes of a graph without circles: in floors, with arrows that run downwards.

The usual four steps (Sugiyama, Tagawa and Toda 1981): a floor for each box, so that everything it
imports is below it; a bend on each floor that an arrow passes; an order on each floor with few
crossings, by the mean place of the neighbours; and places along the floor, again by the
neighbours. Nothing is random, so the same imports give the same picture.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, pairwise
from statistics import mean

import networkx as nx

SWEEPS = 24
GAP_PX = 18.0
BEND_PX = 4.0
"""How much of a floor an arrow takes that only passes."""

Place = tuple[str, str, int] | str
"""A box by its name, or a bend: from, to, floor."""


@dataclass(frozen=True, slots=True)
class Layout:
    """Floors from the top, centres along them in pixels, and each arrow as the places it passes."""

    floors: list[list[Place]]
    x_px: dict[Place, float]
    arrows: list[list[Place]]
    width_px: float


def laid_out(graph: nx.DiGraph, widths_px: dict[str, float]) -> Layout:
    """Lay out a graph; arrows that follow from others are left out."""
    reduced = nx.transitive_reduction(graph)
    floor = {
        name: number
        for number, names in enumerate(nx.topological_generations(reduced.reverse()))
        for name in names
    }
    top = max(floor.values(), default=0)
    arrows: list[list[Place]] = [
        [a, *((a, b, at) for at in range(floor[a] - 1, floor[b], -1)), b]
        for a, b in sorted(reduced.edges)
    ]
    floors: list[list[Place]] = [
        sorted(name for name in reduced if floor[name] == number) for number in range(top, -1, -1)
    ]
    for arrow in arrows:
        for bend in arrow[1:-1]:
            floors[top - bend[2]].append(bend)
    floors = best_order(floors, arrows)
    width = {place: widths_px.get(place, BEND_PX) for one in floors for place in one}
    widest = max(sum(width[place] for place in one) + GAP_PX * (len(one) - 1) for one in floors)
    return Layout(floors, along(floors, arrows, width, widest), arrows, widest)


def neighbours(arrows: list[list[Place]]) -> dict[Place, list[Place]]:
    found: dict[Place, list[Place]] = {}
    for arrow in arrows:
        for a, b in pairwise(arrow):
            found.setdefault(a, []).append(b)
            found.setdefault(b, []).append(a)
    return found


def best_order(floors: list[list[Place]], arrows: list[list[Place]]) -> list[list[Place]]:
    """The order with the fewest crossings that sweeps down and up come upon."""
    near = neighbours(arrows)
    best, least = floors, crossings(floors, arrows)
    for sweep in range(SWEEPS):
        rows = list(range(len(floors)))
        for row in rows if sweep % 2 == 0 else rows[::-1]:
            beside = row - 1 if sweep % 2 == 0 else row + 1
            if not 0 <= beside < len(floors):
                continue
            at = {
                place: i / max(1, len(floors[beside]) - 1) for i, place in enumerate(floors[beside])
            }
            own = {place: i / max(1, len(floors[row]) - 1) for i, place in enumerate(floors[row])}
            wish = {
                place: mean([at[n] for n in near.get(place, []) if n in at] or [own[place]])
                for place in floors[row]
            }
            floors = [*floors[:row], sorted(floors[row], key=wish.__getitem__), *floors[row + 1 :]]
        if (now := crossings(floors, arrows)) < least:
            best, least = floors, now
    return best


def crossings(floors: list[list[Place]], arrows: list[list[Place]]) -> int:
    """How many pairs of arrows cross between two floors."""
    order = {place: i for floor in floors for i, place in enumerate(floor)}
    row = {place: i for i, floor in enumerate(floors) for place in floor}
    pieces = [(row[a], order[a], order[b]) for arrow in arrows for a, b in pairwise(arrow)]
    return sum(
        one[0] == other[0] and (one[1] - other[1]) * (one[2] - other[2]) < 0
        for one, other in combinations(pieces, 2)
    )


def along(
    floors: list[list[Place]],
    arrows: list[list[Place]],
    width: dict[Place, float],
    widest: float,
) -> dict[Place, float]:
    """Centres in pixels: as near to the neighbours' mean as the order and the frame allow."""
    near = neighbours(arrows)
    x: dict[Place, float] = {}
    for floor in floors:
        used = sum(width[place] for place in floor) + GAP_PX * (len(floor) - 1)
        left = (widest - used) / 2.0
        for place in floor:
            x[place] = left + width[place] / 2.0
            left += width[place] + GAP_PX
    for sweep in range(SWEEPS):
        for floor in floors if sweep % 2 == 0 else floors[::-1]:
            for i in (range(len(floor)), range(len(floor) - 1, -1, -1))[sweep // 2 % 2]:
                place = floor[i]
                half = width[place] / 2.0
                least, most = half, widest - half
                if i > 0:
                    least = x[floor[i - 1]] + width[floor[i - 1]] / 2.0 + GAP_PX + half
                if i < len(floor) - 1:
                    most = x[floor[i + 1]] - width[floor[i + 1]] / 2.0 - GAP_PX - half
                wish = mean([x[n] for n in near.get(place, [])] or [x[place]])
                x[place] = max(least, min(most, wish))
    return x
