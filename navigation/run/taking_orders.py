"""The control socket of a run: opened, watched like every stage, and its news."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from navigation.control import ControlServer
from navigation.shared.supervisor import SupervisedPart

if TYPE_CHECKING:
    from navigation.loop.daemon import Daemon
    from navigation.machine.logs import RunLog


class TakingOrders:
    """Socket for people's orders, open until the run ends; call `cycle` after each cycle."""

    def __init__(
        self,
        open_things: ExitStack,
        socket: Path,
        daemon: Daemon,
        log: RunLog,
        say: Callable[[str], None],
    ) -> None:
        self._daemon, self._log, self._say = daemon, log, say
        self._control = open_things.enter_context(ControlServer(socket, daemon.people))
        part = SupervisedPart(self._control.failure, self._control.restart)
        daemon.look_after("control socket", part, lambda: self._control.turns)

    def cycle(self) -> None:
        """Report news once; a lasting fault becomes one of the run's troubles."""
        for sentence in self._control.news():
            self._log.write("warning", "trouble", reason=sentence)
            self._say(sentence)
        self._daemon.troubles["control socket"] = self._control.trouble
