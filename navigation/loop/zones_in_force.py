"""Zones of a running program: those configured, and the changes that people make.

Any thread may change them; the control loop acts on a change in its next cycle. A zone keeps the
form it was written in, so that a page can draw it, and a file can hold it.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection, Sequence
from typing import Final

from navigation.config.zones import MOST_ZONES, ZoneSection
from navigation.mission.mission import MissionError
from planner.zones.zone import Zone

MOST_UNDONE: Final = 50
"""Changes that can be taken back: chosen."""


class ZonesInForce:
    """The zones by name, in the order in which they were made; ``robots`` are the known names.

    ``changed`` is called after each change, in the thread that made it.
    """

    def __init__(self, zones: Sequence[ZoneSection], robots: Collection[str]) -> None:
        self._robots = frozenset(robots) - {""}
        self._lock = threading.Lock()
        self._sections = tuple(zones)
        self._before: list[tuple[ZoneSection, ...]] = []
        self.revision = 0
        """Number of changes so far."""
        self.changed: Callable[[], None] = lambda: None

    @property
    def sections(self) -> tuple[ZoneSection, ...]:
        """The zones as they are written in a configuration."""
        return self._sections

    def zones(self) -> tuple[Zone, ...]:
        """Return the zones as the planner has them."""
        return tuple(one.zone() for one in self._sections)

    def put(self, zone: ZoneSection) -> None:
        """Add a zone, or replace the one of its name; ``MissionError`` if that cannot be."""
        unknown = sorted(set(zone.robots) - self._robots)
        if unknown:
            there = ", ".join(sorted(self._robots)) or "one robot, which has no name"
            raise MissionError(f"zone '{zone.name}': robot '{unknown[0]}': there is {there}")
        with self._lock:
            others = tuple(one for one in self._sections if one.name != zone.name)
            if len(others) >= MOST_ZONES:
                raise MissionError(f"zone '{zone.name}': there are {MOST_ZONES} zones already")
            self._set((*others, zone))
        self.changed()

    def remove(self, name: str) -> None:
        """Remove a zone; ``MissionError`` if there is none of that name."""
        with self._lock:
            others = tuple(one for one in self._sections if one.name != name)
            if len(others) == len(self._sections):
                names = ", ".join(one.name for one in self._sections) or "no zones"
                raise MissionError(f"zone '{name}': there are {names}")
            self._set(others)
        self.changed()

    def undo(self) -> None:
        """Take the last change back; ``MissionError`` if there is none."""
        with self._lock:
            if not self._before:
                raise MissionError("no change of zones to take back")
            self._sections = self._before.pop()
            self.revision += 1
        self.changed()

    def _set(self, sections: tuple[ZoneSection, ...]) -> None:
        self._before = [*self._before[1 - MOST_UNDONE :], self._sections]
        self._sections = sections
        self.revision += 1
