"""A run that takes any order and only notes it.

A new order needs nothing here: what the table's row calls is noted by its name.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any

from navigation.mission.mission import MissionError


class RecordedPeople:
    """In the place of `People`: ``orders`` has each call as (name, arguments but None).

    A call that is ``refused`` by its name raises `MissionError` with the sentence; one that is
    ``hanging`` waits until ``free`` is set; any other returns what ``answers`` has, or None.
    """

    def __init__(self, **answers: Any) -> None:
        self.orders: list[tuple[Any, ...]] = []
        self.settled = 0
        self.refused: dict[str, str] = {}
        self.hanging: set[str] = set()
        self.free, self.entered = threading.Event(), threading.Event()
        self._answers = answers

    def __getattr__(self, name: str) -> Callable[..., Any]:
        if name.startswith("_"):
            raise AttributeError(name)

        def take(*arguments: Any) -> Any:
            if name in self.refused:
                raise MissionError(self.refused[name])
            self._wait(name)
            self.orders.append((name, *(one for one in arguments if one is not None)))
            return self._answers.get(name)

        return take

    def _wait(self, name: str) -> None:
        if name in self.hanging:
            self.entered.set()
            assert self.free.wait(30.0)

    def settle(self) -> None:
        """Nothing to wait for, and no order."""
        self._wait("settle")
        self.settled += 1

    def describe(self, robot: str | None = None) -> Mapping[str, Any]:
        """Stopped once a stop was ordered, else idle; with the robot's name, where it is one."""
        stopped = any(name == "stop" for name, *_ in self.orders)
        whose = {} if robot is None else {"name": robot}
        return {"state": "stopped" if stopped else "idle", "reason": "waiting", **whose}
