"""A running program with its dashboard, inside the test's process, so that the truth is at hand."""

from __future__ import annotations

import math
import re
import threading
from pathlib import Path
from types import TracebackType

from navigation.config import Config, parse_config
from navigation.loop.daemon import Daemon
from navigation.mission.mission import State
from navigation.run.kernels.warm_up import warm_up
from navigation.run.world import World
from tests.browser.programs.served import PATIENCE_S, Served, until
from tests.support.runs.light_camera import with_light_camera

CONFIGS = Path(__file__).parents[3] / "configs"
STILL_M = 0.0005
"""Less than this in a tenth of a second is no movement."""


def live_config(rate_hz: int = 20, noise_grey: float = 2.5, *, light: bool = False) -> Config:
    """The shipped simulation without a mission of its own, its page at any free port.

    ``light``: with small pictures, at 20 a second, where a test does not look at them closely.
    """
    text = (CONFIGS / "simulation.yaml").read_text()
    if light:
        text = with_light_camera(text)
    text = re.sub(r"^mission:\n(?:  .*\n)+", "", text, flags=re.MULTILINE)
    text = text.replace("rate_hz: 30", f"rate_hz: {rate_hz}")
    text = text.replace("noise_grey: 2.5", f"noise_grey: {noise_grey}")
    text += "\ndashboard: {port: 0}\n"
    return parse_config(text, "live.yaml", CONFIGS, {})


class Live(Served):
    """Daemon, control loop and page, with the clock of the simulated world."""

    def __init__(self, config: Config) -> None:
        self.config = config
        self.world = World(config)
        self.daemon = Daemon(config, self.world, first_mission_id=7)
        super().__init__(self.daemon, self.world.clock)
        self._ready, self._stopping = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="control loop")

    def __enter__(self) -> Live:
        warm_up(self.config, self.said.append)
        self._thread.start()
        assert self._ready.wait(PATIENCE_S)
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

    def _run(self) -> None:
        with self.daemon:  # the world's clock waits for the thread that begins the run
            self._ready.set()
            while not self._stopping.is_set():
                self.daemon.cycle()

    @property
    def state(self) -> State:
        """The mission's state."""
        return self.daemon.robot.pilot.mission.state

    def drives(self) -> bool:
        """True if the robot is to drive now."""
        return self.state is State.DRIVING

    def place(self) -> tuple[float, float, float]:
        """Where the robot really is."""
        assert self.world.truths[""] is not None
        x, y, heading = self.world.truths[""].robot.pose()
        return x, y, heading

    def is_moving(self) -> bool:
        """True if the robot really moves."""
        x, y, heading = self.place()
        self.world.clock.wait(0.1)  # movement is a difference over time
        there = self.place()
        turned = abs(math.remainder(there[2] - heading, math.tau))
        return math.dist((x, y), there[:2]) > STILL_M or turned > 0.01

    def stands_within(self, seconds: float) -> bool:
        """True if it comes to a stand in so many seconds of the world's time, and stays there."""
        until_s = self.world.clock() + seconds
        while self.is_moving():
            if self.world.clock() > until_s:
                return False
        return not self.is_moving()

    def calm_down(self) -> None:
        """Leave no stop, pause, mission or operator behind for the next test."""
        self.hub.seat.holder = None
        mission = self.daemon.robot.pilot.mission
        under_way = (State.PLANNING, State.PROVING, State.DRIVING, State.HOLDING)
        if self.state in under_way or mission.paused:
            self.daemon.people.stop("the test is over")
            until(lambda: self.state is State.STOPPED)
        if self.state is State.STOPPED:
            until(lambda: self.daemon.robot.link.snapshot().estopped)
            self.daemon.people.resume()
        until(lambda: self.state in (State.IDLE, State.DONE, State.FAILED))
        until(lambda: not self.daemon.robot.link.snapshot().estopped)
