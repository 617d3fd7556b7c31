"""The newest items, each with its number, for latecomers."""

from __future__ import annotations

from collections import deque
from itertools import islice
from typing import Generic, TypeVar

Item = TypeVar("Item")


class Ring(Generic[Item]):
    """The newest ``size`` items; ``next`` is the number of the next one, from 0."""

    def __init__(self, size: int) -> None:
        self._items: deque[Item] = deque(maxlen=size)
        self.next = 0

    def append(self, item: Item) -> None:
        """Add an item; a full ring drops its oldest."""
        self._items.append(item)
        self.next += 1

    def since(self, number: int, most: int) -> tuple[int, list[Item]]:
        """At most ``most`` kept items from ``number`` on, and the number of the first."""
        first = max(number, self.next - len(self._items))
        skip = first - (self.next - len(self._items))
        return first, list(islice(self._items, skip, skip + most))

    @property
    def last(self) -> Item | None:
        """The newest item, None if empty."""
        return self._items[-1] if self._items else None
