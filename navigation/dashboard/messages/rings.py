"""What is kept for those who come later: the newest so many items, each with its number."""

from __future__ import annotations

from collections import deque
from itertools import islice
from typing import Generic, TypeVar

Item = TypeVar("Item")


class Ring(Generic[Item]):
    """The newest ``size`` items; ``next`` is the number of the one to come, from 0."""

    def __init__(self, size: int) -> None:
        self._items: deque[Item] = deque(maxlen=size)
        self.next = 0

    def append(self, item: Item) -> None:
        """Add an item; the oldest goes where the ring is full."""
        self._items.append(item)
        self.next += 1

    def since(self, number: int, most: int) -> tuple[int, list[Item]]:
        """The items from ``number`` on, at most so many, and the number of the first of them.

        Items that have gone are left out, so the first may have a higher number.
        """
        first = max(number, self.next - len(self._items))
        skip = first - (self.next - len(self._items))
        return first, list(islice(self._items, skip, skip + most))

    @property
    def last(self) -> Item | None:
        """The newest item, None where there is none."""
        return self._items[-1] if self._items else None
