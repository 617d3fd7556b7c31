"""Waits at gates, and the one that is in vain. Seconds."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Final

from navigation.fleet.members import Member
from navigation.fleet.releases import Held, release_of
from navigation.mission.mission import State

PATIENCE_S: Final = 6.0
"""A robot that holds usually continues by itself: marker hidden, link silent."""
GOING: Final = (State.DRIVING, State.PLANNING, State.PROVING)


class GateWaits:
    """Time since when each robot waits at a gate for another that does not come."""

    def __init__(self) -> None:
        self._since_s: dict[str, float] = {}

    def in_vain(
        self,
        now_s: float,
        members: Mapping[str, Member],
        held: Mapping[str, Held],
        refused: Collection[str],
    ) -> str | None:
        """Sentence about a robot awaited in vain; ``refused`` names robots that get no path."""
        for name, one in members.items():
            if one.state is not State.DRIVING or name not in held:
                continue
            count, gate = release_of(name, held)
            if gate is None or held[name].executed < count:
                self._since_s.pop(name, None)
                continue
            other, its = members.get(gate.other), held.get(gate.other)
            is_refused = gate.other in refused
            if other is not None and other.state in GOING and its is not None and not is_refused:
                self._since_s.pop(name, None)
                continue
            since_s = self._since_s.setdefault(name, now_s)
            if its is None or its.broken or is_refused or now_s - since_s > PATIENCE_S:
                self._since_s.clear()
                return f"{gate.other} does not come: planning around it"
        return None
