"""The mission: what is to be visited, and the table of states between standing and done.

The table is the whole of the logic of states: what is not in it does not happen. The
documentation's diagram is drawn from it (`python -m navigation.mission.mission`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum
from typing import Final

STOPPING: Final = "stopping"
"""The state that people read in place of `State.STOPPED` until the robot is known to stand."""


class State(Enum):
    """Where the mission stands."""

    IDLE = "idle"
    PLANNING = "planning"
    PROVING = "proving"
    DRIVING = "driving"
    HOLDING = "holding"
    STOPPED = "stopped"
    DONE = "done"
    FAILED = "failed"


class Event(Enum):
    """What may happen to a mission."""

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
    """An event that the mission's state does not allow, or a station that cannot be."""


@dataclass(frozen=True, slots=True)
class Station:
    """A place to visit: metres in the arena, the heading to stand at, and how long to stay."""

    x: float
    y: float
    heading_rad: float | None = None
    dwell_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Mission:
    """Stations, how many of them were visited, the state, and the sentence that explains it.

    ``any_order``: the stations but the last may be visited in the order that is shortest; the
    first plan settles it.
    """

    stations: tuple[Station, ...] = ()
    visited: int = 0
    any_order: bool = False
    state: State = State.IDLE
    reason: str = "no mission was given"
    paused: bool = False
    """Whether the operator has paused it; a restart of the program keeps that."""
    errand: Station | None = None
    """The place that a robot comes back to which has visited all and steps aside for another."""

    @property
    def places(self) -> tuple[Station, ...]:
        """The stations, and behind them the place of an errand."""
        return self.stations if self.errand is None else (*self.stations, self.errand)

    @property
    def remaining(self) -> tuple[Station, ...]:
        """The places that are still to be visited, in order."""
        return self.places[self.visited :]

    @property
    def is_over(self) -> bool:
        """Whether nothing more will happen without a new order."""
        return self.state in (State.DONE, State.FAILED, State.STOPPED)

    def after(self, event: Event, reason: str) -> Mission:
        """The mission after an event; ``MissionError`` where the table has no such move."""
        try:
            state = TRANSITIONS[self.state, event]
        except KeyError:
            raise MissionError(
                f"a mission that is {self.state.value} cannot take '{event.value}'"
            ) from None
        return replace(self, state=state, reason=reason)

    def allows(self, event: Event) -> bool:
        """Whether the table has a move for the event."""
        return (self.state, event) in TRANSITIONS

    def given(
        self, stations: tuple[Station, ...], reason: str, *, any_order: bool = False
    ) -> Mission:
        """A new mission in place of this one."""
        if not stations:
            raise MissionError("a mission needs at least one station")
        return replace(
            self.after(Event.GIVEN, reason),
            stations=stations,
            visited=0,
            any_order=any_order,
            errand=None,
        )

    def stepping_aside(self, place: Station, reason: str) -> Mission:
        """The same, which was over, with an errand: aside for another robot, and back."""
        if self.remaining:
            raise MissionError("a robot that has stations to visit steps aside for no other")
        return replace(self.after(Event.GIVEN, reason), errand=place)

    def arrived(self, reason: str) -> Mission:
        """The mission at its end; an errand is over too."""
        return replace(self.after(Event.ARRIVED, reason), visited=len(self.stations), errand=None)

    @property
    def cannot_skip(self) -> str:
        """The reason why no station can be skipped now; empty where one can."""
        if self.state is State.STOPPED:
            return "the robot is stopped: re-arm it first (clearway resume)"
        if self.visited >= len(self.stations):
            return "nothing to skip: no station is left to visit"
        if self.any_order and len(self.stations) > 1:
            return "nothing to skip yet: the first plan decides which station is next"
        return ""

    def without_next(self) -> Mission:
        """The mission without the station that is next; done where that was the last one.

        A robot under way plans for the rest. One that waits for an order waits on: a pause, a
        re-armed stop and a failed mission are ended by `clearway resume`, not by this.
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

    def settled(self, order: tuple[int, ...]) -> Mission:
        """The same with its stations but the last in this order, which then stays."""
        if not self.any_order or self.visited:
            return self
        *vias, goal = self.stations
        if sorted(order) != list(range(len(vias))):
            raise MissionError(f"order {order}: must name each of {len(vias)} stations once")
        return replace(self, stations=(*(vias[i] for i in order), goal), any_order=False)

    def with_visited(self, visited: int) -> Mission:
        """The same with more stations visited; the count never falls."""
        if not self.visited <= visited <= len(self.stations):
            raise MissionError(
                f"visited = {visited}: must be in {self.visited}..{len(self.stations)}"
            )
        return replace(self, visited=visited)


def diagram() -> Iterator[str]:
    """The table as a Mermaid state diagram, a line each."""
    yield "stateDiagram-v2"
    yield f"    [*] --> {State.IDLE.value}"
    for (state, event), following in TRANSITIONS.items():
        yield f"    {state.value} --> {following.value}: {event.value}"


if __name__ == "__main__":
    print("\n".join(diagram()))
