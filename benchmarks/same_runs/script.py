"""When a run's trouble begins and ends, and what is noted of what people are told.

The trouble begins some time after its robot drives, and the run ends some time after the trouble:
all drawn from the run's own generator. Virtual seconds.
"""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

from benchmarks.same_runs.program import Stage
from benchmarks.same_runs.trace import Trace
from navigation.loop.run_state import RobotSnapshot
from navigation.mission.mission import State

PATIENCE_S: Final = 8.0
"""A robot that does not drive by then meets its trouble all the same."""
AFTERWARDS_S: Final = 12.0


@dataclass(frozen=True, slots=True)
class Scene:
    """What a step of a trouble may touch: the stage, the robot that it is about, and chance."""

    stage: Stage
    robot: int
    rng: random.Random


Do: TypeAlias = Callable[[Scene], None]


@dataclass(frozen=True, slots=True)
class Step:
    """Something that is done once, between ``least_s`` and ``most_s`` after the step before."""

    do: Do
    least_s: float = 0.2
    most_s: float = 4.0


class Script:
    """Plays the steps of a trouble in a run; `look` after each cycle."""

    def __init__(self, steps: Sequence[Step], robot: int, rng: random.Random, trace: Trace) -> None:
        self._steps, self._robot, self._rng, self._trace = deque(steps), robot, rng, trace
        self._has_steps = bool(steps)
        self._due_s: float | None = None
        self._said: dict[int, str] = {}

    def look(self, stage: Stage, states: Sequence[RobotSnapshot]) -> bool:
        """True once the run has gone on long enough after its trouble."""
        for number, state in enumerate(states):
            self._note(number, state)
        if not self._has_steps:
            return False
        now_s = stage.clock()
        if self._due_s is None and self._begins(states):
            self._due_s = now_s + self._pause_s()
        while self._due_s is not None and self._steps and now_s >= self._due_s:
            self._steps.popleft().do(Scene(stage, self._robot, self._rng))
            self._due_s = now_s + self._pause_s()
        return self._due_s is not None and now_s >= self._due_s

    def _begins(self, states: Sequence[RobotSnapshot]) -> bool:
        one = states[self._robot]
        drives = one.mission.state is State.DRIVING and one.link.executed >= 1
        return drives or one.time_s > PATIENCE_S

    def _pause_s(self) -> float:
        if not self._steps:
            return AFTERWARDS_S
        return self._rng.uniform(self._steps[0].least_s, self._steps[0].most_s)

    def _note(self, number: int, state: RobotSnapshot) -> None:
        """Note the sentence that a person is told of a robot, where it is news."""
        said = f"{state.mission.state.value}: {state.sentence}; {state.troubles}"
        if self._said.get(number) != said:
            self._said[number] = said
            self._trace.note("said", number, said)
