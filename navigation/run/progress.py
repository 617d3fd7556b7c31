"""Lines about a run: news of each robot and, at intervals, the distance to go."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from navigation.loop.run_state import RobotSnapshot, RunState
from navigation.mission.mission import State

PROGRESS_EVERY_S: Final = 1.0


class ProgressLines:
    """News of each cycle: ``say`` gets lines for a terminal, ``status`` all robots' state."""

    def __init__(self, say: Callable[[str], None], status: Callable[[str], object]) -> None:
        self._say, self._status = say, status
        self._said: dict[str, tuple[State, str]] = {}
        self._said_s = -math.inf

    def cycle(self, now: RunState) -> None:
        """Report a cycle that ended with ``now``."""
        any_news = False
        for name, one in now.robots.items():
            if not self._is_news(name, one):
                continue
            self._said[name] = one.mission.state, one.sentence
            self._said_s = now.time_s
            of = f"{name:<8} " if name else ""
            self._say(f"{now.time_s:6.1f} s  {of}{one.mission.state.value:<8}  {one.sentence}")
            any_news = True
        if any_news:
            self._status(f"{now.state.value}: {now.sentence}")
        if now.time_s - self._said_s >= PROGRESS_EVERY_S and not now.is_over:
            self._said_s = now.time_s
            parts = (
                _of_all(now) if len(now.robots) > 1 else _of_one(next(iter(now.robots.values())))
            )
            self._say(f"{now.time_s:6.1f} s  {now.state.value:<8}  {parts}")

    def _is_news(self, name: str, one: RobotSnapshot) -> bool:
        mission, said = one.mission, self._said.get(name)
        if said is None:
            # one of several robots without a mission has no news until it is stopped
            return not name or bool(mission.places) or mission.state is State.STOPPED
        if said[0] is not mission.state:
            return True
        return mission.state is not State.HOLDING and said[1] != one.sentence


def why_stopped(now: RunState) -> str | None:
    """Cause of each robot's emergency stop; None if none is stopped."""
    causes = {
        name: one.sentence for name, one in now.robots.items() if one.mission.state is State.STOPPED
    }
    if len(causes) == len(now.robots) and len(set(causes.values())) == 1:
        all_of_them = "all robots: " if len(causes) > 1 else ""
        return f"{all_of_them}{next(iter(causes.values()))}"
    return "; ".join(f"{name}: {sentence}" for name, sentence in causes.items()) or None


def _of_all(now: RunState) -> str:
    parts = []
    for name, one in now.robots.items():
        if one.to_go_m is not None and not one.mission.is_over:
            parts.append(f"{name} {one.to_go_m:.2f} m to go")
        elif one.mission.state is State.HOLDING:
            parts.append(f"{name} holds")
    return ", ".join(parts)


def _of_one(now: RobotSnapshot) -> str:
    if now.mission.state is State.HOLDING or now.pose is None:
        return now.sentence
    turned_deg = math.degrees(now.pose.heading_rad)
    parts = [f"at ({now.pose.x:.3f}, {now.pose.y:.3f}) m, {turned_deg:4.0f} deg"]
    if now.to_go_m is not None:
        parts.append(f"{now.to_go_m:.2f} m to go")
    if now.clearance_m is not None:
        parts.append(f"clearance {now.clearance_m:.3f} m")
    parts.append(f"station {now.mission.visited}/{len(now.mission.stations)}")
    return "  ".join(parts)
