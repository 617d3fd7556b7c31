"""Events that still hold when a recording continues in a new file, which begins with them.

The newest of each kind, and each robot's plan with its request. An unanswered request is carried
too, or its later answer would answer nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from navigation.fleet.request import Answer, FleetAnswer
from navigation.recording.events import (
    Counted,
    PlanAnswered,
    PlanAsked,
    RecordedEvent,
    RoadmapBuilt,
    SceneSeen,
    Told,
    ZonesChanged,
)
from navigation.recording.json_bodies import FLEET_WAITS


class CurrentEvents:
    """Store of every written event; `carried` gives the events that still hold."""

    def __init__(self) -> None:
        self._newest: dict[object, SceneSeen | RoadmapBuilt | ZonesChanged | Told | Counted] = {}
        self._open: dict[int, PlanAsked] = {}
        """Unanswered, by id."""
        self._plans: dict[str, tuple[PlanAsked, PlanAnswered]] = {}
        """By robot; "" is a single one."""

    def take(self, event: RecordedEvent) -> None:
        """Take an event that was written."""
        match event:
            case SceneSeen() | RoadmapBuilt() | ZonesChanged():
                self._newest[type(event)] = event
            case Told(source=source):
                self._newest[Told, source] = event
            case Counted(topic=topic) if topic == FLEET_WAITS:
                self._newest[topic] = event
            case PlanAsked(request=request):
                self._open[request.id] = event
            case PlanAnswered(answer=answer):
                self._answered(event, _robots_of(answer))

    def _answered(self, event: PlanAnswered, robots: list[str]) -> None:
        number = event.answer.id
        asked = self._open.get(number)
        if asked is not None:
            self._plans |= dict.fromkeys(robots, (asked, event))
        # the planner answers in order: earlier requests get no answer after this
        self._open = {key: one for key, one in self._open.items() if key > number}

    def carried(self) -> Iterator[RecordedEvent]:
        """Yield the events in a readable order."""
        for event in self._newest.values():
            yield replace(event, carried=True) if isinstance(event, SceneSeen) else event
        pairs = {id(answered): (asked, answered) for asked, answered in self._plans.values()}
        for asked, answered in sorted(pairs.values(), key=lambda pair: pair[1].time_s):
            yield asked
            yield replace(answered, carried=True)
        yield from self._open.values()


def _robots_of(answer: Answer) -> list[str]:
    if isinstance(answer, FleetAnswer):
        return [*answer.promises, *answer.refused]
    return [""]
