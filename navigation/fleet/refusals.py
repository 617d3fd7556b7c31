"""Robots without a path, and why a new plan would be pointless."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from navigation.fleet.members import Member
from navigation.fleet.orders import ON_TRACK_M
from navigation.mission.cycle import PlanRequest
from navigation.mission.mission import State, Station


def because_of(others: Iterable[str], is_refused: Callable[[Sequence[str]], bool]) -> str:
    """End of a refusal's sentence: other robots such that without any of them there is a plan.

    Empty if the refusal depends on no other robot, or on more than these. ``is_refused`` answers
    for the robots of these names alone; it is asked once a name, and twice more. Where each of
    several robots closes the path, one of them is named.
    """
    left = list(dict.fromkeys(others))
    if not left or is_refused([]) or not is_refused(left):
        return ""
    for name in left if len(left) > 1 else ():
        fewer = [one for one in left if one != name]
        if is_refused(fewer):
            left = fewer
    return f", because {listed(left)} {'are' if len(left) > 1 else 'is'} in the way"


def with_names(reason: str, names: Sequence[str]) -> str:
    """Replace robots' numbers in a reason by their names."""

    def named(found: re.Match[str]) -> str:
        return listed([names[int(n)] for n in re.findall(r"\d+", found.group(0))])

    return re.sub(r"\brobots? \d+(?:, \d+)*(?: and \d+)?", named, reason)


def listed(names: Sequence[str]) -> str:
    """Names for a sentence: "ada, bob and cleo", each once."""
    unique = list(dict.fromkeys(names))
    if len(unique) < 2:
        return "".join(unique)
    return f"{', '.join(unique[:-1])} and {unique[-1]}"


@dataclass(frozen=True, slots=True)
class Situation:
    """While it lasts, another plan would be refused too."""

    revision: int
    goals: frozenset[tuple[str, Station]]
    at_rest: Mapping[str, tuple[float, float]]
    """Places of the robots that do not drive."""

    def is_like(self, other: Situation | None) -> bool:
        """True if nothing has changed except by noise."""
        if other is None or (self.revision, self.goals) != (other.revision, other.goals):
            return False
        if self.at_rest.keys() != other.at_rest.keys():
            return False
        places = ((at, other.at_rest[name]) for name, at in self.at_rest.items())
        return all(math.dist(here, there) < ON_TRACK_M for here, there in places)


class Refusals:
    """Refusals of the last answered plan."""

    def __init__(self) -> None:
        self.reasons: dict[str, str] = {}
        """By robot."""
        self._goals: dict[str, Station] = {}
        self._hung_on: Situation | None = None
        self._asked: tuple[dict[str, Station], Situation] | None = None

    def ask(
        self,
        wishes: Mapping[str, PlanRequest],
        revision: int,
        at_rest: Mapping[str, tuple[float, float]],
    ) -> None:
        """Note a plan's request and situation."""
        goals = {name: request.stations[0] for name, request in wishes.items()}
        self._asked = goals, Situation(revision, frozenset(), at_rest)

    def take(self, reasons: Mapping[str, str]) -> None:
        """Take the answer's refusals."""
        assert self._asked is not None
        goals, situation = self._asked
        self.reasons = dict(reasons)
        self._goals = {name: goals[name] for name in reasons}
        self._hung_on = replace(situation, goals=frozenset(self._goals.items()))

    def refuse(self, names: Iterable[str], why: str) -> None:
        """Refuse robots in this cycle, without a request."""
        self.reasons = dict.fromkeys(names, why)
        self._goals, self._hung_on = {}, None

    def still_hold(
        self,
        members: Mapping[str, Member],
        asking: Mapping[str, PlanRequest],
        revision: int,
        at_rest: Mapping[str, tuple[float, float]],
    ) -> bool:
        """True if their situation is unchanged."""
        goals = frozenset(
            (name, asking[name].stations[0] if name in asking else goal)
            for name, goal in self._goals.items()
            if members[name].state in (State.PLANNING, State.HOLDING)
        )
        return Situation(revision, goals, at_rest).is_like(self._hung_on)

    def will_ask(self, members: Mapping[str, Member], asking: Mapping[str, PlanRequest]) -> bool:
        """True if a refused robot holds, and will ask again."""
        return any(
            name not in asking and members[name].state is State.HOLDING for name in self.reasons
        )
