"""A robot that is to reach something on a computer that may stand still meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from navigation.link.link_snapshot import LinkSnapshot
from tests.support.waiting import wait_until


class Startable(Protocol):
    """A link of a robot."""

    def snapshot(self) -> LinkSnapshot:
        """Present state."""
        ...

    def start(self) -> None:
        """Drive the mission."""
        ...


def on_its_way(link: Startable, reached: Callable[[], bool], patience_s: float) -> bool:
    """Wait for ``reached``; restart a robot whose lease lapsed while the computer stood still."""

    def is_reached() -> bool:
        snapshot = link.snapshot()
        if snapshot.mission_id is not None and not snapshot.running and not snapshot.mission_done:
            link.start()
            wait_until(lambda: link.snapshot().running, 0.1)  # not again before it could begin
        return reached()

    return wait_until(is_reached, patience_s)
