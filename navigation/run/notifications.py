"""The configured call, made once when a mission is done, stopped or failed.

Another thread makes it: the control loop never waits for it and gets none of its errors.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from datetime import datetime
from types import TracebackType
from typing import TYPE_CHECKING, Final

from navigation.config.notify import PLACEHOLDER, NotifySection
from navigation.config.secrecy.secrets import hide
from navigation.machine.logs import RunLog
from navigation.machine.outside_calls import OutsideCall, OutsideCalls
from navigation.mission.mission import MissionProgress, State
from navigation.shared.outside import printable

if TYPE_CHECKING:
    from navigation.loop.run_state import RunState

MOST_CHARACTERS: Final = 2000
"""Chosen: of a sentence; a fleet's has a part for each robot."""
ENDED: Final = (State.DONE, State.STOPPED, State.FAILED)
LONE: Final = "robot"
"""Name of a lone robot."""


class Notifications:
    """Observer of a run's cycles; call `cycle` after each, `end` once.

    ``now`` gives the wall time. ``say`` gets a line if a call fails. Missions that are over in the
    first cycle, by a journal or a kept stop, are no news.
    """

    def __init__(
        self,
        section: NotifySection,
        log: RunLog,
        say: Callable[[str], None],
        now: Callable[[], datetime],
    ) -> None:
        self._section, self._log, self._say, self._now = section, log, say, now
        is_on = section.command is not None or section.url is not None
        self._calls = OutsideCalls(section.within_s) if is_on else None
        self._before: dict[str, MissionProgress] = {}

    def __enter__(self) -> Notifications:
        if self._calls is not None:
            self._calls.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._calls is not None:
            self._calls.__exit__(kind, error, trace)
            self._report(self._calls)

    def cycle(self, now: RunState) -> None:
        """Call for each robot whose mission has ended in this cycle."""
        if self._calls is None:
            return
        for name, one in now.robots.items():
            before = self._before.get(name)
            self._before[name] = one.mission
            if before is not None and _is_news(before, one.mission):
                self._notify(self._calls, name, one.mission.state, one.sentence)
        self._report(self._calls)

    def end(self, state: State, reason: str) -> None:
        """Call for each robot that was under way when a limit of time failed the run."""
        if self._calls is None or state is not State.FAILED:
            return
        for name, mission in self._before.items():
            if mission.state not in ENDED:
                self._notify(self._calls, name, state, reason)

    def _notify(self, calls: OutsideCalls, name: str, state: State, sentence: str) -> None:
        values = {
            "state": state.value,
            "robot": name or LONE,
            "sentence": printable(hide(sentence), MOST_CHARACTERS),
            "time": self._now().astimezone().isoformat(timespec="seconds"),
        }
        if self._section.command is not None:
            words = tuple(filled(argument, values) for argument in self._section.command)
            calls.put(OutsideCall(command=words))
        elif self._section.url is not None:
            calls.put(OutsideCall(url=self._section.url, body=json.dumps(values)))

    def _report(self, calls: OutsideCalls) -> None:
        for sentence in calls.news():
            self._log.write("warning", "notify", reason=sentence)
            self._say(f"a notification failed: {sentence}")


def filled(argument: str, values: Mapping[str, str]) -> str:
    """Replace an argument's placeholders, and none within their values."""
    return PLACEHOLDER.sub(lambda match: values[match[1]], argument)


def _is_news(before: MissionProgress, now: MissionProgress) -> bool:
    """True if a mission is over now; one that only stepped aside was done before."""
    was_aside = before.errand is not None and now.state is State.DONE
    return now.state in ENDED and now.state is not before.state and not was_aside
