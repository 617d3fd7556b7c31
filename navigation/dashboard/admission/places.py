"""Who is connected to the page's port, until when, and who makes room. Opens nothing.

Rules
- A connection is cut that has not sent a whole request, or taken its answer, by its time; one
  that is closing has a moment to take the last words.
- Where all places are taken, or all of one address's share, a new connection takes the place of
  the one that has been there for longest and is no viewer: whoever sends a request at once is
  read before that happens. Viewers, whose number the hub limits, are never cut for a connection.

Seconds of the clock that the caller has.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from math import inf
from typing import Final, Protocol

CLOSE_WITHIN_S: Final = 1.0


class Line(Protocol):
    """What is cut: a transport of asyncio."""

    def abort(self) -> None:
        """Cut it at once."""

    def is_closing(self) -> bool:
        """Whether it is closed, or will be when everything was sent."""
        ...


@dataclass(slots=True, eq=False)
class OpenConnection:
    """One connection: where it comes from, and until when it may be as it is."""

    line: Line
    address: str
    until_s: float
    is_closing: bool = False


class OpenConnections:
    """At most ``most`` connections beside viewers, ``most_an_address`` of them from one address."""

    def __init__(self, most: int, most_an_address: int) -> None:
        self.most, self.most_an_address = most, most_an_address
        self.cut = 0
        """How many connections were cut: late, or to make room."""
        self._waiting: dict[OpenConnection, None] = {}
        self._viewers: dict[OpenConnection, None] = {}
        self._shares: Counter[str] = Counter()

    def __len__(self) -> int:
        return len(self._waiting) + len(self._viewers)

    def come(self, place: OpenConnection) -> None:
        """A connection was accepted; another one is cut where there is no room."""
        if self._shares[place.address] >= self.most_an_address:
            self._cut_oldest(place.address)
        elif len(self._waiting) >= self.most:
            self._cut_oldest(None)
        self._waiting[place] = None
        self._shares[place.address] += 1

    def look(self, place: OpenConnection) -> None:
        """A connection has become a viewer: it may stay, and no longer counts among the others."""
        self._leave_waiting(place)
        place.until_s = inf
        self._viewers[place] = None

    def go(self, place: OpenConnection) -> None:
        """A connection has ended."""
        self._leave_waiting(place)
        self._viewers.pop(place, None)

    def make_room(self) -> None:
        """Cut the oldest connection that is no viewer: no descriptor is left."""
        self._cut_oldest(None)

    def sweep(self, now_s: float) -> None:
        """Cut those whose time is over."""
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
        for place in self._waiting:  # as they came
            if address in (None, place.address):
                self._cut(place)
                return

    def _cut(self, place: OpenConnection) -> None:
        self.cut += 1
        self.go(place)
        place.line.abort()
