"""The lines about several robots: what is news of each, and now and then how far all have to go.

Metres, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from navigation.loop.daemon_state import RunState
from navigation.mission.mission import State

PROGRESS_EVERY_S: Final = 1.0


class FleetLines:
    """Says what is news after each cycle; `cycle`.

    ``say`` gets lines for a terminal, and ``status`` the state of all robots in one.
    """

    def __init__(self, say: Callable[[str], None], status: Callable[[str], object]) -> None:
        self._say, self._status = say, status
        self._said: dict[str, tuple[State, str]] = {}
        self._said_s = -math.inf

    def cycle(self, now: RunState) -> None:
        """After a cycle that ended with ``now``."""
        any_news = False
        for name, one in now.robots.items():
            mission = one.mission
            said = self._said.get(name)
            news = said is None or said[0] is not mission.state
            news |= (
                said is not None and mission.state is not State.HOLDING and said[1] != one.sentence
            )
            # a robot without a mission has nothing to say until it is stopped
            silent = not mission.places and said is None and mission.state is not State.STOPPED
            if not news or silent:
                continue
            self._said[name] = mission.state, one.sentence
            self._said_s = now.time_s
            state = mission.state.value
            self._say(f"{now.time_s:6.1f} s  {name:<8} {state:<8}  {one.sentence}")
            any_news = True
        if any_news:
            self._status(f"{now.state.value}: {now.sentence}")
        if now.time_s - self._said_s >= PROGRESS_EVERY_S and not now.is_over:
            self._said_s = now.time_s
            self._say(f"{now.time_s:6.1f} s  {now.state.value:<8} {_to_go(now)}")


def why_stopped(now: RunState) -> str | None:
    """The cause of each robot's emergency stop; None where none is stopped."""
    causes = {
        name: one.sentence for name, one in now.robots.items() if one.mission.state is State.STOPPED
    }
    if len(causes) == len(now.robots) and len(set(causes.values())) == 1:
        return f"all robots: {next(iter(causes.values()))}"
    return "; ".join(f"{name}: {sentence}" for name, sentence in causes.items()) or None


def _to_go(now: RunState) -> str:
    """The distance that each robot has still to go."""
    parts = []
    for name, one in now.robots.items():
        if one.to_go_m is not None and not one.mission.is_over:
            parts.append(f"{name} {one.to_go_m:.2f} m to go")
        elif one.mission.state is State.HOLDING:
            parts.append(f"{name} holds")
    return ", ".join(parts)
