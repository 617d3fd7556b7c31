"""Results of the planner's thread, kept for the control loop's next cycle."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from navigation.fleet.request import Answer, Request
from navigation.loop.planning import SceneCheck
from navigation.loop.traffic.traffic import TrafficPlanner
from navigation.recording.events import PlanAnswered, PlanAsked, RoadmapBuilt

if TYPE_CHECKING:
    from navigation.loop.recorder import Recorder


class PlannerNews:
    """Scenes with a roadmap, and the newest plan; ``wake`` calls the loop to take them."""

    def __init__(
        self,
        planner: TrafficPlanner,
        clock: Callable[[], float],
        wake: Callable[[], None],
        recorder: Recorder | None,
    ) -> None:
        self._planner, self._clock, self._wake = planner, clock, wake
        self._recorder = recorder
        self._lock = threading.Lock()
        self._answers: deque[Answer] = deque(maxlen=1)
        self._checks: deque[SceneCheck] = deque()
        self._scene_s = self._asked_s = 0.0
        self.known_revision = 0
        """Newest scene whose roadmap the loop knows."""
        self.roadmap_s: float | None = None
        """Time from a new scene to its roadmap."""
        self.plan_s: float | None = None
        """Time from a request to its answer."""

    # From the control loop.

    def gets_scene(self) -> None:
        """Note that a scene goes to the planner."""
        self._scene_s = self._clock()

    def gets_request(self, request: Request, now_s: float) -> None:
        """Note that a request goes to the planner."""
        self._asked_s = now_s
        if self._recorder is not None:
            self._recorder.put(PlanAsked(now_s, request))

    def take(self) -> tuple[list[SceneCheck], Answer | None]:
        """News since the last cycle."""
        with self._lock:
            checks = list(self._checks)
            self._checks.clear()
            answer = self._answers.pop() if self._answers else None
        if checks:
            self.known_revision = checks[-1].revision
        return checks, answer

    # From the planner's thread.

    def on_scene(self, check: SceneCheck) -> None:
        """Take a scene whose roadmap was built."""
        now_s = self._clock()
        self.roadmap_s = now_s - self._scene_s
        roadmap = self._planner.roadmap
        if self._recorder is not None and roadmap is not None:
            self._recorder.put(RoadmapBuilt(now_s, check.revision, roadmap, check.zones))
        with self._lock:
            self._checks.append(check)
        self._wake()

    def on_answer(self, answer: Answer) -> None:
        """Take the answer to a request."""
        now_s = self._clock()
        self.plan_s = now_s - self._asked_s
        if self._recorder is not None:
            self._recorder.put(PlanAnswered(now_s, answer))
        with self._lock:
            self._answers.append(answer)
        self._wake()
