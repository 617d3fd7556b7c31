"""The mission: stations to visit, and the table of its states.

The table is the whole logic of states; the documentation's diagram is drawn from it (`python -m
navigation.mission.mission`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum
from typing import Final

STOPPING: Final = "stopping"
"""People read this for `State.STOPPED` until the robot is known to be at rest."""


class State(Enum):
    """State of the mission."""

    IDLE = "idle"
    PLANNING = "planning"
    PROVING = "proving"
    DRIVING = "driving"
    HOLDING = "holding"
    STOPPED = "stopped"
    DONE = "done"
    FAILED = "failed"


class Event(Enum):
    """Possible event of a mission."""

    GIVEN = "mission given"
    PLANNED = "plan accepted"
    NO_PLAN = "no safe plan"
    REPLAN = "new plan needed"
    PROVE = "to prove itself"
    PROVED = "proved itself"
    HOLD = "unsafe or paused"
    CLEARED = "cause gone"
    ARRIVED = "last station reached"
    SKIPPED = "last station skipped"
    STOP = "emergency stop"
    REARM = "re-armed by hand"
    FAIL = "given up"


_S, _E = State, Event

TRANSITIONS: dict[tuple[State, Event], State] = {
    (_S.IDLE, _E.GIVEN): _S.PLANNING,
    (_S.DONE, _E.GIVEN): _S.PLANNING,
    (_S.FAILED, _E.GIVEN): _S.PLANNING,
    (_S.PLANNING, _E.GIVEN): _S.PLANNING,
    (_S.DRIVING, _E.GIVEN): _S.PLANNING,
    (_S.PROVING, _E.GIVEN): _S.PLANNING,
    (_S.HOLDING, _E.GIVEN): _S.HOLDING,
    (_S.PLANNING, _E.PLANNED): _S.DRIVING,
    (_S.PLANNING, _E.NO_PLAN): _S.HOLDING,
    (_S.PLANNING, _E.HOLD): _S.HOLDING,
    (_S.PLANNING, _E.REPLAN): _S.PLANNING,
    (_S.PLANNING, _E.PROVE): _S.PROVING,
    (_S.PROVING, _E.PROVED): _S.PLANNING,
    (_S.PROVING, _E.HOLD): _S.HOLDING,
    (_S.DRIVING, _E.REPLAN): _S.PLANNING,
    (_S.DRIVING, _E.HOLD): _S.HOLDING,
    (_S.DRIVING, _E.ARRIVED): _S.DONE,
    (_S.HOLDING, _E.HOLD): _S.HOLDING,
    (_S.HOLDING, _E.CLEARED): _S.PLANNING,
    (_S.STOPPED, _E.REARM): _S.IDLE,
    **{(state, _E.STOP): _S.STOPPED for state in State},
    **{
        (state, _E.SKIPPED): _S.DONE
        for state in (_S.IDLE, _S.PLANNING, _S.PROVING, _S.DRIVING, _S.HOLDING, _S.FAILED)
    },
    **{
        (state, _E.FAIL): _S.FAILED
        for state in (_S.IDLE, _S.PLANNING, _S.PROVING, _S.DRIVING, _S.HOLDING, _S.STOPPED)
    },
}


class MissionError(ValueError):
    """Error: an event that the mission's state does not allow, or an impossible station."""


@dataclass(frozen=True, slots=True)
class Station:
    """Place to visit: metres in the arena, the heading at rest, and the stay."""

    x: float
    y: float
    heading_rad: float | None = None
    dwell_s: float = 0.0


@dataclass(frozen=True, slots=True)
class MissionProgress:
    """Stations, number visited, state, and the sentence that explains it.

    ``any_order``: the first plan puts all stations but the last in the shortest order.
    """

    stations: tuple[Station, ...] = ()
    visited: int = 0
    any_order: bool = False
    state: State = State.IDLE
    reason: str = "no mission was given"
    paused: bool = False
    """True if the operator has paused it; kept over a restart."""
    errand: Station | None = None
    """Place to return to after stepping aside for another robot, all stations visited."""

    @property
    def places(self) -> tuple[Station, ...]:
        """Stations, then the place of an errand."""
        return self.stations if self.errand is None else (*self.stations, self.errand)

    @property
    def remaining(self) -> tuple[Station, ...]:
        """Places still to visit, in order."""
        return self.places[self.visited :]

    @property
    def is_over(self) -> bool:
        """True if nothing more will happen without a new order."""
        return self.state in (State.DONE, State.FAILED, State.STOPPED)

    def after(self, event: Event, reason: str) -> MissionProgress:
        """Mission after an event; ``MissionError`` if the table has no such move."""
        try:
            state = TRANSITIONS[self.state, event]
        except KeyError:
            raise MissionError(
                f"a mission that is {self.state.value} cannot take '{event.value}'"
            ) from None
        return replace(self, state=state, reason=reason)

    def given(
        self, stations: tuple[Station, ...], reason: str, *, any_order: bool = False
    ) -> MissionProgress:
        """New mission in place of this one."""
        if not stations:
            raise MissionError("a mission needs at least one station")
        return replace(
            self.after(Event.GIVEN, reason),
            stations=stations,
            visited=0,
            any_order=any_order,
            errand=None,
        )

    def stepping_aside(self, place: Station, reason: str) -> MissionProgress:
        """This finished mission with an errand: aside for another robot, and back."""
        if self.remaining:
            raise MissionError("a robot that has stations to visit steps aside for no other")
        return replace(self.after(Event.GIVEN, reason), errand=place)

    def taking_over(self, other: MissionProgress) -> MissionProgress:
        """This state with the stations of another mission, and its progress."""
        return replace(
            self,
            stations=other.stations,
            visited=other.visited,
            any_order=other.any_order,
            paused=other.paused,
            errand=other.errand,
        )

    def rearmed(self) -> MissionProgress:
        """Mission after a stop: it waits for an order."""
        left = len(self.remaining)
        what = f"resume to continue with {left} station{'s' * (left != 1)}, or " if left else ""
        return self.after(Event.REARM, f"re-armed by hand: {what}give a new goal")

    def arrived(self, reason: str) -> MissionProgress:
        """Mission at its end, its errand included."""
        return replace(self.after(Event.ARRIVED, reason), visited=len(self.stations), errand=None)

    @property
    def cannot_skip(self) -> str:
        """Reason why no station can be skipped now; empty if one can."""
        if self.state is State.STOPPED:
            return "the robot is stopped: re-arm it first (clearway resume)"
        if self.visited >= len(self.stations):
            return "nothing to skip: no station is left to visit"
        if self.any_order and len(self.stations) > 1:
            return "nothing to skip yet: the first plan decides which station is next"
        return ""

    def without_next(self) -> MissionProgress:
        """Mission without the next station; done if that was the last one.

        A robot under way plans for the rest. One that waits for an order keeps waiting.
        """
        skipped, rest = self.remaining[0], self.stations[self.visited + 1 :]
        left = replace(self, stations=self.stations[: self.visited] + rest)
        where = f"({skipped.x:g}, {skipped.y:g}) m"
        if not rest:
            done = f"the last station, at {where}, was skipped; {self.visited} visited before it"
            return left.after(Event.SKIPPED, done)
        sentence = f"the station at {where} was skipped"
        if self.state in (State.PLANNING, State.DRIVING):
            return left.after(Event.REPLAN, f"{sentence}: on to the next one")
        if self.state in (State.IDLE, State.FAILED):
            count = f"{len(rest)} station{'s' * (len(rest) != 1)}"
            return replace(left, reason=f"{sentence}: resume to continue with {count}")
        return left

    def settled(self, order: tuple[int, ...]) -> MissionProgress:
        """Mission with all stations but the last in this order, which then stays."""
        if not self.any_order or self.visited:
            return self
        *vias, goal = self.stations
        if sorted(order) != list(range(len(vias))):
            raise MissionError(f"order {order}: must name each of {len(vias)} stations once")
        return replace(self, stations=(*(vias[i] for i in order), goal), any_order=False)

    def with_visited(self, visited: int) -> MissionProgress:
        """Mission with more stations visited; the count never falls."""
        if not self.visited <= visited <= len(self.stations):
            raise MissionError(
                f"visited = {visited}: must be in {self.visited}..{len(self.stations)}"
            )
        return replace(self, visited=visited)


def diagram() -> Iterator[str]:
    """Yield the table as a Mermaid state diagram, line by line."""
    yield "stateDiagram-v2"
    yield f"    [*] --> {State.IDLE.value}"
    for (state, event), following in TRANSITIONS.items():
        yield f"    {state.value} --> {following.value}: {event.value}"


if __name__ == "__main__":
    print("\n".join(diagram()))
