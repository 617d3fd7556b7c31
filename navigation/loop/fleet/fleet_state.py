"""What the running program of several robots tells of itself after each cycle.

Nothing here changes any more once it is made. Metres, radians, seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from navigation.loop.daemon_state import DaemonState
from navigation.mission.mission import State


@dataclass(frozen=True, slots=True)
class FleetState:
    """By name: each robot as if it were alone, and whom it waits for."""

    time_s: float
    robots: Mapping[str, DaemonState]
    waits: Mapping[str, str]
    """Who waits for whom and why, in a sentence each."""
    rounds: int = 0
    """How often all were planned together."""
    waits_for: Mapping[str, str] = field(default_factory=dict)
    """Of those in ``waits`` that wait for one other robot: for which."""

    @property
    def is_over(self) -> bool:
        """Whether nothing more will happen without a new order."""
        return all(one.mission.is_over or not one.mission.places for one in self.robots.values())

    @property
    def state(self) -> State:
        """Of all robots together: the worst end, and before it that of one that is under way."""
        states = [one.mission.state for one in self.robots.values() if one.mission.places]
        for state in (State.DRIVING, State.PROVING, State.PLANNING, State.HOLDING):
            if state in states:
                return state
        for state in (State.STOPPED, State.FAILED):
            if state in states:
                return state
        return State.DONE if State.DONE in states else State.IDLE

    @property
    def sentence(self) -> str:
        """What each robot has to say that is not at its end."""
        told = {
            name: self.waits.get(name) or one.sentence
            for name, one in self.robots.items()
            if one.mission.places and one.mission.state is not State.DONE
        }
        if not told:
            return "all robots are at rest at their goals"
        return "; ".join(f"{name}: {sentence}" for name, sentence in told.items())
