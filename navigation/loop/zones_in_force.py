"""Zones of a running program: those configured, and the changes that people make.

Any thread may change them; the control loop acts in its next cycle. A zone keeps its written form,
for pages and files. A change that a file keeps is on the disk before it is answered, or the answer
says that it is not.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection, Sequence
from typing import Final

from navigation.config.zones import MOST_ZONES, ZoneSection
from navigation.config.zones.zone_checks import too_many_places
from navigation.journal.kept_zones import (
    KeptZones,
    KeptZonesError,
    ZoneChange,
    changes_between,
    with_changes,
)
from navigation.journal.zones_writer import UNKNOWN, ZonesWriter
from navigation.mission.mission import MissionError
from planner.zones.zone import Zone

MOST_UNDONE: Final = 50
"""Chosen: changes that can be taken back."""


class ZonesInForce:
    """The zones in the order in which they were made; ``robots`` are the known names.

    ``changed`` is called after each change, in the thread that made it.
    """

    def __init__(self, zones: Sequence[ZoneSection], robots: Collection[str]) -> None:
        self._robots = frozenset(robots) - {""}
        self._lock = threading.Lock()
        self._sections = self._configured = tuple(zones)
        self._writer: ZonesWriter | None = None
        self._lost = ""
        """Trouble of changes while a damaged file is where theirs would be."""
        self._ended = False
        self._before: list[tuple[ZoneSection, ...]] = []
        self.revision = 0
        """Number of changes so far."""
        self.changed: Callable[[], None] = lambda: None

    @property
    def sections(self) -> tuple[ZoneSection, ...]:
        """Zones as a configuration has them."""
        return self._sections

    def zones(self) -> tuple[Zone, ...]:
        """Zones as the planner has them."""
        return tuple(one.zone() for one in self._sections)

    @property
    def are_kept(self) -> bool:
        """True if a file keeps the changes."""
        return self._writer is not None

    @property
    def trouble(self) -> str:
        """Reason why a restart would not know of the changes, although a file keeps them."""
        return self._lost if self._writer is None else self._writer.trouble

    def changes(self) -> tuple[ZoneChange, ...]:
        """Return what differs from the configuration."""
        return changes_between(self._configured, self._sections)

    def restore(self, kept: KeptZones | None, before: ZonesInForce | None = None) -> list[str]:
        """Take over changes of an earlier run, and keep further ones; return what to say.

        ``before`` are the zones of the run before in the same program: its changes hold whatever
        its file has, and beside those of another file. All hold, even where the configuration has
        got others since, and together they are twice as many as can be added.
        ``KeptZonesError`` if the file's are lost: then no change is kept before `keep_in`.
        """
        lost, in_file = None, dict[str, ZoneChange]()
        try:
            in_file = {} if kept is None else {one.name: one for one in kept.read()}
        except KeptZonesError as error:
            lost = error
        newest, writer = in_file, None
        if before is not None:
            newest = {one.name: one for one in before.changes()}
            writer = before._writer
            if writer is None or kept is None or writer.kept.path != kept.path:
                newest, writer = in_file | newest, None
        sections, said = with_changes(self._configured, tuple(newest.values()), self._robots)
        if sections != self._sections:
            self._sections = sections
            self.revision += 1
            self.changed()
            too_many = _too_many(sections)
            if too_many is not None:
                said.append(f"{too_many}: all hold, and none is added before some are removed")
        if lost is not None:
            self._lost = f"{UNKNOWN}: {lost}"
            raise lost
        if kept is not None:
            self._writer = writer or ZonesWriter(kept)
            self._writer.take_over(self.changes)
            if newest != in_file or self.trouble:
                self._writer.write()
        return said

    def keep_in(self, kept: KeptZones) -> None:
        """Keep the changes so far and all further ones."""
        self._writer = ZonesWriter(kept)
        self._writer.take_over(self.changes)
        self._writer.write()

    def put(self, zone: ZoneSection) -> None:
        """Add a zone, or replace the one of its name; ``MissionError``."""
        unknown = sorted(set(zone.robots) - self._robots)
        if unknown:
            there = ", ".join(sorted(self._robots)) or "one robot, which has no name"
            raise MissionError(f"zone '{zone.name}': robot '{unknown[0]}': there is {there}")
        with self._lock:
            others = tuple(one for one in self._sections if one.name != zone.name)
            too_many = _too_many((*others, zone))
            if too_many is not None:
                raise MissionError(f"zone '{zone.name}': with it there are {too_many}")
            self._set((*others, zone))
        self._tell()

    def remove(self, name: str) -> None:
        """Remove a zone; ``MissionError``."""
        with self._lock:
            others = tuple(one for one in self._sections if one.name != name)
            if len(others) == len(self._sections):
                names = ", ".join(one.name for one in self._sections) or "no zones"
                raise MissionError(f"zone '{name}': there are {names}")
            self._set(others)
        self._tell()

    def undo(self, seen: int | None = None) -> None:
        """Take the last change back; ``MissionError``, if it is not that of revision ``seen``."""
        with self._lock:
            if seen is not None and seen != self.revision:
                raise MissionError("zones were changed by someone else since: look at them first")
            if not self._before:
                raise MissionError("no change of zones to take back")
            *before, last = self._before
            self._set(last)
            self._before = before
        self._tell()

    def end(self) -> None:
        """Refuse further changes, and wait a little for the disk: the run is over."""
        with self._lock:
            self._ended = True
            self.changed = lambda: None
        if self._writer is not None:
            self._writer.end()

    def _tell(self) -> None:
        """Wake the loop, which acts at once, and write the change down."""
        self.changed()
        if self._writer is not None:
            self._writer.write()

    def _set(self, sections: tuple[ZoneSection, ...]) -> None:
        if self._ended:
            raise MissionError("this run is over: its zones are not changed any more")
        self._before = [*self._before[1 - MOST_UNDONE :], self._sections]
        self._sections = sections
        self.revision += 1


def _too_many(zones: Sequence[ZoneSection]) -> str | None:
    """Sentence on too many zones, or places of them together; None if they are few enough."""
    if len(zones) > MOST_ZONES:
        return f"{len(zones)} zones: must be at most {MOST_ZONES}"
    return too_many_places(zones)
