"""Six robots that run with their page, inside the test's process, so that the truth is at hand.

They run in virtual time, no faster than real time and as slowly as the machine needs: nothing here
goes stale because a browser has the processor.
"""

from __future__ import annotations

import math
import re
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any

from navigation.config import Config, parse_config
from navigation.config.several.each_robot import each_robot
from navigation.dashboard import Dashboard
from navigation.dashboard.hub import Hub
from navigation.dashboard.settings.desk import Desk
from navigation.loop.daemon import Daemon
from navigation.loop.people import People
from navigation.loop.run_state import RunState
from navigation.mission.mission import State
from navigation.run.kernels.plan_together import plan_together
from navigation.run.kernels.warm_up import warm_up
from navigation.run.virtual_world import VirtualWorld
from tests.browser.programs.live import CONFIGS
from tests.browser.programs.served import until

FIRST_MISSION_ID = 7
EXCHANGE = {
    "ada": (2.20, 1.60), "bob": (0.20, 1.60), "cleo": (0.20, 0.20),
    "dan": (2.20, 0.20), "eve": (1.20, 1.62), "finn": (1.20, 0.18),
}  # fmt: skip
"""Where each goes when all exchange places."""
BREATH_S = 0.003
"""After each cycle: whoever gives an order gets its turn."""
TOLD_AFTER_S = 0.15
"""The page hears ten times a second of the world's time what is so."""


def fleet_config(rate_hz: int = 8, noise_grey: float | None = None) -> Config:
    """The six of the shipped fleet without missions of their own, their page at any free port."""
    text = (CONFIGS / "fleet.yaml").read_text()
    text = re.sub(r"^mission:.*\n(?:  .*\n)+", "", text, flags=re.MULTILINE)
    text = text.replace("rate_hz: 10", f"rate_hz: {rate_hz}")
    if noise_grey is not None:
        text = text.replace(
            "  time_limit_s", f"  camera: {{noise_grey: {noise_grey}}}\n  time_limit_s"
        )
    text += "\ndashboard: {port: 0}\n"
    return parse_config(text, "live_fleet.yaml", CONFIGS, {})


class _OneAtATime:
    """Orders between two cycles: the virtual world is one thread's at a time."""

    def __init__(self, people: People, turn: threading.Lock) -> None:
        self._people, self._turn = people, turn

    def __getattr__(self, name: str) -> Callable[..., Any]:
        order = getattr(self._people, name)

        def take(*arguments: Any) -> Any:
            with self._turn:
                return order(*arguments)

        return take

    def settle(self) -> None:
        """Wait for cycles, which have turns of their own."""
        self._people.settle()


class LiveFleet:
    """Daemon, control loop and dashboard of several robots.

    Without ``pictures`` none is drawn or looked at: the daemon is told where everything is, and
    the page shows an empty floor.
    """

    def __init__(self, config: Config, desk: Desk | None = None, *, pictures: bool = False) -> None:
        self.config = config
        self.world = VirtualWorld(config, pictures=pictures)
        self.daemon = Daemon(config, self.world, first_mission_id=FIRST_MISSION_ID)
        self._turn = threading.Lock()
        self.daemon.people = self.people = _OneAtATime(self.daemon.people, self._turn)
        self.said: list[str] = []
        self._holds: Callable[[RunState], bool] | None = None
        self._held_since_s = math.inf
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._cycle, name="control loop")
        self._dashboard = Dashboard(
            self.daemon,
            say=self.said.append,
            clock=self.world.clock,
            desk=desk,
        )

    def __enter__(self) -> LiveFleet:
        warm_up(self.config, self.said.append)
        plan_together(self.config)
        self.daemon.__enter__()
        self._thread.start()
        self._dashboard.__enter__()
        assert self._dashboard.url is not None, self.said
        until(lambda: self._dashboard.hub is not None)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._dashboard.__exit__()
        self._stopping.set()
        self._thread.join()
        self.daemon.__exit__(kind, error, trace)

    def _cycle(self) -> None:
        while not self._stopping.is_set():
            if self._is_held():
                self._stopping.wait(BREATH_S)
                continue
            began_s, then_s = time.monotonic(), self.world.clock()
            with self._turn:
                self.daemon.cycle()
            spare_s = self.world.clock() - then_s - (time.monotonic() - began_s)
            self._stopping.wait(max(BREATH_S, spare_s))

    def hold_when(self, holds: Callable[[RunState], bool]) -> None:
        """Let time stand still once something is true and the page has heard of it."""
        self._holds = holds

    def _is_held(self) -> bool:
        now = self.daemon.state
        if self._holds is None or now is None:
            return False
        if math.isinf(self._held_since_s) and self._holds(now):
            self._held_since_s = now.time_s
        return now.time_s - self._held_since_s >= TOLD_AFTER_S

    @property
    def url(self) -> str:
        """Where the page is."""
        assert self._dashboard.url is not None
        return self._dashboard.url

    @property
    def hub(self) -> Hub:
        """The dashboard's inside."""
        assert self._dashboard.hub is not None
        return self._dashboard.hub

    @property
    def names(self) -> tuple[str, ...]:
        """Of all robots."""
        return tuple(each_robot(self.config))

    def state(self, name: str) -> State:
        """Of one robot's mission."""
        return self.daemon.robots[name].pilot.mission.state

    def place(self, name: str) -> tuple[float, float]:
        """Where a robot really is."""
        x, y, _ = self.world.truths[name].robot.pose()
        return x, y

    def calm_down(self) -> None:
        """Leave no stop, mission or operator behind for the next test."""
        self._holds, self._held_since_s = None, math.inf
        self.hub.seat.holder = None
        self.people.stop("the test is over")
        links = [seat.link for seat in self.daemon.robots.values()]
        until(lambda: all(link.snapshot().estopped for link in links))
        self.people.settle()  # whom the loop does not know to be stopped yet is not re-armed
        self.people.resume()
        until(lambda: not any(link.snapshot().estopped for link in links))
        until(lambda: not any(self.state(n) is State.STOPPED for n in self.names))
