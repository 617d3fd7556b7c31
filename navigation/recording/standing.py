"""What still holds when a recording goes on in another file: that file begins with it.

Of each kind the newest: the scene and its roadmap, what every mission is and why, who waits for
whom, and each robot's plan with the request that it answers. A request that is not answered yet
goes along too, or its answer in the next file would answer nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from navigation.recording.events import (
    Counted,
    FleetAnswered,
    FleetAsked,
    PlanAnswered,
    PlanAsked,
    RecordedEvent,
    RoadmapBuilt,
    SceneSeen,
    Told,
)
from navigation.recording.json_bodies import FLEET_WAITS

Asked = PlanAsked | FleetAsked
Answered = PlanAnswered | FleetAnswered


class Standing:
    """Takes every event that is written; `carried` gives those that still hold."""

    def __init__(self) -> None:
        self._newest: dict[object, SceneSeen | RoadmapBuilt | Told | Counted] = {}
        self._open: dict[tuple[bool, int], Asked] = {}
        """Not answered yet, by whether it is of several robots, and id."""
        self._plans: dict[str, tuple[Asked, Answered]] = {}
        """By robot; "" is a single one."""

    def take(self, event: RecordedEvent) -> None:
        """It was written."""
        match event:
            case SceneSeen() | RoadmapBuilt():
                self._newest[type(event)] = event
            case Told(source=source):
                self._newest[Told, source] = event
            case Counted(topic=topic) if topic == FLEET_WAITS:
                self._newest[topic] = event
            case PlanAsked() | FleetAsked():
                self._open[isinstance(event, FleetAsked), event.request.id] = event
            case PlanAnswered():
                self._answered(event, [""])
            case FleetAnswered(answer=answer):
                self._answered(event, [*answer.promises, *answer.refused])

    def _answered(self, event: Answered, robots: list[str]) -> None:
        several, number = isinstance(event, FleetAnswered), event.answer.id
        asked = self._open.get((several, number))
        if asked is not None:
            self._plans |= dict.fromkeys(robots, (asked, event))
        # the planner answers in order: what was asked before is not answered any more
        self._open = {key: one for key, one in self._open.items() if key > (several, number)}

    def carried(self) -> Iterator[RecordedEvent]:
        """In the order in which they can be read."""
        for event in self._newest.values():
            yield replace(event, carried=True) if isinstance(event, SceneSeen) else event
        pairs = {id(answered): (asked, answered) for asked, answered in self._plans.values()}
        for asked, answered in sorted(pairs.values(), key=lambda pair: pair[1].time_s):
            yield asked
            yield replace(answered, carried=True)
        yield from self._open.values()
