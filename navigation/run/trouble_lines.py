"""Lines about a run's troubles: one when a trouble begins, one when it ends."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from navigation.machine.logs import RunLog

if TYPE_CHECKING:
    from navigation.loop.run_state import RunState


class TroubleLines:
    """Comparison of each cycle's troubles with the last; call `cycle`."""

    def __init__(self, log: RunLog, say: Callable[[str], None]) -> None:
        self._log, self._say = log, say
        self._before: tuple[str, ...] = ()

    def cycle(self, troubles: Iterable[str]) -> None:
        """Write and say which troubles have begun and ended."""
        before, self._before = self._before, tuple(troubles)
        for sentence in self._before:
            if sentence not in before:
                self._log.write("error", "trouble", reason=sentence)
                self._say(f"trouble: {sentence}")
        for sentence in before:
            if sentence not in self._before:
                self._log.write("info", "trouble", reason=f"over: {sentence}")
                self._say(f"trouble over: {sentence}")


def troubles_of(fleet: RunState) -> list[str]:
    """Troubles of all robots; one that not all share begins with the robot's name."""
    robots = fleet.robots
    counts = Counter(sentence for one in robots.values() for sentence in one.troubles)
    return list(
        dict.fromkeys(
            sentence if counts[sentence] == len(robots) else f"{name}: {sentence}"
            for name, one in robots.items()
            for sentence in one.troubles
        )
    )
