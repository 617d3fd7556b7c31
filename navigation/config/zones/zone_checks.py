"""Checks across the zones of a configuration."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import Any, Final

import numpy as np

from navigation.config.marks import Location
from navigation.config.zones.section import ZoneSection
from planner.scene import Bounds, extent_points

MOST_PLACES: Final = 2000
"""Corners and places of all zones together: chosen, an answer with them has 90 kB, which a local
socket takes at once."""

_Found = Iterator[tuple[Location, str]]


def zone_names_differ(zones: Any) -> _Found:
    """Orders and messages name zones."""
    first: dict[str, int] = {}
    for index, zone in enumerate(zones):
        if zone.name in first:
            sentence = f"'{zone.name}' is the name of zones[{first[zone.name]}] already"
            yield ("zones", index, "name"), sentence
        first.setdefault(zone.name, index)


def zones_have_few_places(zones: Any) -> _Found:
    """Every answer about zones, and every page, gets them all."""
    sentence = too_many_places(zones)
    if sentence is not None:
        yield ("zones",), sentence


def too_many_places(zones: Sequence[ZoneSection]) -> str | None:
    """Sentence on too many corners together, or None."""
    count = sum(len(zone.polygon or zone.line or ()) for zone in zones)
    if count <= MOST_PLACES:
        return None
    return f"{count} corners and places together: must be at most {MOST_PLACES}"


def zones_are_for_known_robots(zones: Any, robots: Any) -> _Found:
    """A zone for a robot that is not there would hold for nobody."""
    known = [entry.name for entry in robots]
    for index, zone in enumerate(zones):
        unknown = unknown_robot(zone, known)
        if unknown is not None:
            yield ("zones", index, "robots"), unknown


def zones_lie_in_the_arena(arena: Any, zones: Any) -> _Found:
    """A zone that no robot can reach is a mistake in its places."""
    for index, zone in enumerate(zones):
        outside = outside_arena(zone, arena.bounds_m)
        if outside is not None:
            yield ("zones", index), outside


def unknown_robot(zone: ZoneSection, known: Collection[str]) -> str | None:
    """Reason why its robots, of the names ``known``, cannot be."""
    for name in zone.robots:
        if not known:
            return f"'{name}': this run has one robot, which has no name: leave it out"
        if name not in known:
            return f"'{name}' is none of robots: {', '.join(sorted(known))}"
    return None


def outside_arena(zone: ZoneSection, bounds_m: Sequence[float]) -> str | None:
    """Reason why it lies outside of the arena, judged by the extent of each part."""
    x0, y0, x1, y1 = bounds_m
    if not (x0 < x1 and y0 < y1):
        return None  # reported by itself
    parts = zone.zone().area.outlines(y_down=False)
    if not parts:
        return f"{zone.mask}: has no occupied cell: must mark some of the arena"
    for part in parts:
        places = np.array(list(extent_points(part)))
        low, high = places.min(axis=0), places.max(axis=0)
        if low[0] < x1 and low[1] < y1 and high[0] > x0 and high[1] > y0:
            return None
    return f"lies outside the arena: must reach into {Bounds(*bounds_m).ranges}"
