"""Zones of a running program: those configured, and the changes that people make.

Any thread may change them; the control loop acts in its next cycle. A zone keeps its written form,
for pages and files. A change that a file keeps is on the disk before it is answered, or the answer
says that it is not: a thread writes it, so that no order waits longer than ``ANSWER_S`` for a disk
that hangs.
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
from navigation.mission.mission import MissionError
from planner.zones.zone import Zone

MOST_UNDONE: Final = 50
"""Chosen: changes that can be taken back."""
ANSWER_S: Final = 2.0
"""Longest wait of an answer for the disk: chosen, a slow card's sync takes less."""
RETRY_S: Final = 1.0
"""Pause before a write that failed is tried again, as a journal's."""
UNKNOWN: Final = "a restart would not know of this change"


class ZonesInForce:
    """The zones in the order in which they were made; ``robots`` are the known names.

    ``changed`` is called after each change, in the thread that made it. ``trouble`` says why a
    restart would not know of the changes, although a file keeps them.
    """

    def __init__(self, zones: Sequence[ZoneSection], robots: Collection[str]) -> None:
        self._robots = frozenset(robots) - {""}
        self._lock = threading.Lock()
        self._sections = self._configured = tuple(zones)
        self._kept: KeptZones | None = None
        self._disk = threading.Condition()
        self._asked = self._done = 0
        """Writes of the file."""
        self._writes = False
        """True while a thread writes."""
        self._ended = False
        self.trouble = ""
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
        return self._kept is not None

    def changes(self) -> tuple[ZoneChange, ...]:
        """Return what differs from the configuration."""
        return changes_between(self._configured, self._sections)

    def restore(self, kept: KeptZones | None, earlier: Sequence[ZoneChange] = ()) -> list[str]:
        """Take over changes of an earlier run, and keep further ones; return what to say.

        ``earlier`` are those of the run before in the same program, which hold whatever the file
        has. ``KeptZonesError`` if the file's are lost: then no change is kept before `keep_in`.
        """
        lost, changes = None, tuple[ZoneChange, ...]()
        try:
            changes = kept.read() if kept is not None else ()
        except KeptZonesError as error:
            lost = error
        newest = {one.name: one for one in (*changes, *earlier)}
        sections, said = with_changes(self._configured, tuple(newest.values()), self._robots)
        if sections != self._sections:
            self._sections = sections
            self.revision += 1
            self.changed()
        if lost is not None:
            raise lost
        if kept is not None:
            self._kept = kept
            if any(one not in changes for one in earlier):
                self._write()
        return said

    def keep_in(self, kept: KeptZones) -> None:
        """Keep the changes so far and all further ones."""
        self._kept = kept
        self._write()

    def put(self, zone: ZoneSection) -> None:
        """Add a zone, or replace the one of its name; ``MissionError``."""
        unknown = sorted(set(zone.robots) - self._robots)
        if unknown:
            there = ", ".join(sorted(self._robots)) or "one robot, which has no name"
            raise MissionError(f"zone '{zone.name}': robot '{unknown[0]}': there is {there}")
        with self._lock:
            others = tuple(one for one in self._sections if one.name != zone.name)
            if len(others) >= MOST_ZONES:
                raise MissionError(f"zone '{zone.name}': there are {MOST_ZONES} zones already")
            too_many = too_many_places((*others, zone))
            if too_many is not None:
                raise MissionError(f"zone '{zone.name}': with it zones have {too_many}")
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

    def undo(self) -> None:
        """Take the last change back; ``MissionError``."""
        with self._lock:
            if not self._before:
                raise MissionError("no change of zones to take back")
            self._sections = self._before.pop()
            self.revision += 1
        self._tell()

    def end(self) -> None:
        """Write no more: the run is over."""
        with self._disk:
            self._ended = True
            self._disk.notify_all()

    def _tell(self) -> None:
        """Wake the loop, which acts at once, and write the change down."""
        self.changed()
        self._write()

    def _write(self) -> None:
        kept = self._kept
        if kept is None:
            return
        with self._disk:
            self._asked += 1
            asked = self._asked
            self._disk.notify_all()
            if not self._writes:
                self._writes = True
                threading.Thread(
                    target=self._write_newest, args=(kept,), name="zones", daemon=True
                ).start()
            if not self._disk.wait_for(lambda: self._done >= asked, ANSWER_S):
                self.trouble = f"{UNKNOWN}: {kept.path}: not on the disk after {ANSWER_S:g} s"

    def _write_newest(self, kept: KeptZones) -> None:
        """Write the changes until they are on the disk and none came meanwhile."""
        while True:
            with self._disk:
                asked = self._asked
            trouble = ""
            try:
                kept.write(self.changes())
            except KeptZonesError as error:
                trouble = f"{UNKNOWN}: {error}"
            with self._disk:
                self.trouble, self._done = trouble, asked
                self._disk.notify_all()
                if trouble and self._asked == asked and not self._ended:
                    self._disk.wait(RETRY_S)
                self._writes = not self._ended and (bool(trouble) or self._asked > asked)
                if not self._writes:
                    return

    def _set(self, sections: tuple[ZoneSection, ...]) -> None:
        self._before = [*self._before[1 - MOST_UNDONE :], self._sections]
        self._sections = sections
        self.revision += 1
