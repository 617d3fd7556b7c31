"""Connections to the page's port, their deadlines, and the one to cut for another.

Rules
- A connection is cut if it has not sent a whole request, or taken its answer, in time.
- If all places, or all of one address's share, are taken, a new connection replaces the oldest that
  is not a viewer; a request sent at once is read first. Viewers, limited by the hub, are never cut
  for a connection.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from math import inf
from typing import Final, Protocol

CLOSE_WITHIN_S: Final = 1.0


class Line(Protocol):
    """A transport of asyncio that can be cut."""

    def abort(self) -> None:
        """Cut it at once."""

    def is_closing(self) -> bool:
        """True if it is closed, or will be when everything was sent."""


@dataclass(slots=True, eq=False)
class OpenConnection:
    """One connection: its address and its deadline, seconds of the caller's clock."""

    line: Line
    address: str
    until_s: float
    is_closing: bool = False


class OpenConnections:
    """At most ``most`` connections beside viewers, ``most_an_address`` of them from one address."""

    def __init__(self, most: int, most_an_address: int) -> None:
        self.most, self.most_an_address = most, most_an_address
        self.cut = 0
        """Connections that were cut: late, or to make room."""
        self._waiting: dict[OpenConnection, None] = {}
        self._viewers: dict[OpenConnection, None] = {}
        self._shares: Counter[str] = Counter()

    def __len__(self) -> int:
        return len(self._waiting) + len(self._viewers)

    def come(self, place: OpenConnection) -> None:
        """Add an accepted connection; another may have to go."""
        if self._shares[place.address] >= self.most_an_address:
            self._cut_oldest(place.address)
        elif len(self._waiting) >= self.most:
            self._cut_oldest(None)
        self._waiting[place] = None
        self._shares[place.address] += 1

    def look(self, place: OpenConnection) -> None:
        """Make a connection a viewer, which may stay."""
        self._leave_waiting(place)
        place.until_s = inf
        self._viewers[place] = None

    def go(self, place: OpenConnection) -> None:
        """Remove an ended connection."""
        self._leave_waiting(place)
        self._viewers.pop(place, None)

    def make_room(self) -> None:
        """Cut the oldest connection that is not a viewer."""
        self._cut_oldest(None)

    def sweep(self, now_s: float) -> None:
        """Cut connections past their deadline."""
        for place in (*self._waiting, *self._viewers):
            if not place.is_closing and place.line.is_closing():
                place.is_closing = True
                place.until_s = min(place.until_s, now_s + CLOSE_WITHIN_S)
            if now_s > place.until_s:
                self._cut(place)

    def _leave_waiting(self, place: OpenConnection) -> None:
        if place in self._waiting:
            del self._waiting[place]
            self._shares[place.address] -= 1
            if not self._shares[place.address]:
                del self._shares[place.address]

    def _cut_oldest(self, address: str | None) -> None:
        for place in self._waiting:  # in order of arrival
            if address in (None, place.address):
                self._cut(place)
                return

    def _cut(self, place: OpenConnection) -> None:
        self.cut += 1
        self.go(place)
        place.line.abort()
