"""The page of a program in the test's process, which can be taken away and brought back alone."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import TracebackType

from navigation.dashboard import Bench, Dashboard
from navigation.dashboard.hub import Hub
from navigation.dashboard.settings.desk import Desk
from navigation.loop.daemon import Daemon
from navigation.mission.mission import State
from tests.support.runs.shown import FakeDaemon
from tests.support.waiting import wait_until

CYCLE_EVERY_S = 0.1
PATIENCE_S = 45.0
"""Nothing may depend on the machine's being fast."""


def until(holds: Callable[[], bool]) -> None:
    """Wait for something that has to come, however busy the machine is."""
    assert wait_until(holds, PATIENCE_S)


class Served:
    """The page of ``shown``; ``clock`` is that of its program."""

    def __init__(self, shown: FakeDaemon | Daemon, clock: Callable[[], float]) -> None:
        self.shown, self.clock = shown, clock
        self.said: list[str] = []
        self._dashboard: Dashboard | None = None

    def bring_back(
        self,
        *,
        token: str | None = None,
        own_token: str | None = None,
        desk: Desk | None = None,
        bench: Bench | None = None,
    ) -> None:
        """Serve the page, at the same port as before."""
        self.take_away()
        section = self.shown.config.dashboard.model_copy(update={"token": token})
        self.shown.config = self.shown.config.model_copy(update={"dashboard": section})
        dashboard = Dashboard(
            self.shown,
            say=self.said.append,
            clock=self.clock,
            own_token=own_token,
            show_token=True,
            desk=desk,
            bench=bench,
        ).__enter__()
        self._dashboard = dashboard
        assert dashboard.url is not None, self.said
        port = int(dashboard.url.split(":")[2].split("/")[0])
        section = section.model_copy(update={"port": port})
        self.shown.config = self.shown.config.model_copy(update={"dashboard": section})
        until(lambda: dashboard.hub is not None)  # its thread makes its event loop first

    def take_away(self) -> None:
        """End the page's server; the program continues."""
        if self._dashboard is not None:
            self._dashboard.__exit__()
            self._dashboard = None

    @property
    def hub(self) -> Hub:
        """The dashboard's inside."""
        assert self._dashboard is not None
        assert self._dashboard.hub is not None
        return self._dashboard.hub

    @property
    def url(self) -> str:
        """The page's address."""
        return f"http://127.0.0.1:{self.shown.config.dashboard.port}/"


class ShownProgram(Served):
    """A daemon that only shows, in cycles of a tenth of a second, with its page.

    It drives nowhere and measures no time: what the page shows of an order, and what it orders, is
    the same on a busy machine.
    """

    def __init__(self, daemon: FakeDaemon) -> None:
        super().__init__(daemon, daemon.clock)
        self.daemon = daemon
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._cycle, name="cycles")

    def __enter__(self) -> ShownProgram:
        self._thread.start()
        self.bring_back()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.take_away()
        self._stopping.set()
        self._thread.join()

    def _cycle(self) -> None:
        while not self._stopping.wait(CYCLE_EVERY_S):
            self.daemon.cycle()

    @property
    def state(self) -> State:
        """The mission's state."""
        return self.daemon.mission.state

    def drives(self) -> bool:
        """True if the robot has an order to drive."""
        return self.state is State.DRIVING

    def is_stopped(self) -> bool:
        """True if a STOP has arrived, and nothing has left it since."""
        return self.state is State.STOPPED
