"""A running program with its dashboard, inside the test's process, so that the truth is at hand."""

from __future__ import annotations

import math
import re
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from navigation.cli.setup.check import file_problems
from navigation.config import Config, parse_config
from navigation.dashboard import Bench, Dashboard, ShownDaemon
from navigation.dashboard.hub import Hub
from navigation.dashboard.settings.desk import Around, Desk
from navigation.loop.daemon import Daemon
from navigation.mission.mission import State
from navigation.run.kernels.warm_up import warm_up
from navigation.run.world import World
from tests.support.waiting import wait_until
from vision.calibrate.lens import Lens
from vision.camera.camera import Image

CONFIGS = Path(__file__).parents[2] / "configs"
STILL_M = 0.0005
"""Less than this in a tenth of a second is no movement."""


def live_config(rate_hz: int = 20, noise_grey: float = 2.5, **dashboard: object) -> Config:
    """The shipped simulation without a mission of its own, its page at any free port."""
    text = (CONFIGS / "simulation.yaml").read_text()
    text = re.sub(r"^mission:\n(?:  .*\n)+", "", text, flags=re.MULTILINE)
    text = text.replace("rate_hz: 30", f"rate_hz: {rate_hz}")
    text = text.replace("noise_grey: 2.5", f"noise_grey: {noise_grey}")
    lines = {"port": 0, **dashboard}
    text += "\ndashboard:\n" + "".join(f"  {key}: {value}\n" for key, value in lines.items())
    return parse_config(text, "live.yaml", CONFIGS, {})


class Live:
    """Daemon, control loop and dashboard, which can be taken away and brought back alone."""

    def __init__(self, config: Config) -> None:
        self.config = config
        self.world = World(config)
        self.daemon = Daemon(config, self.world, first_mission_id=7)
        self.said: list[str] = []
        self.own_token: str | None = None
        """What the page asks for from the next `bring_back` on; None: nothing."""
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._cycle, name="control loop")
        self._dashboard: Dashboard | None = None
        self._port = config.dashboard.port
        self._desk: Desk | None = None
        self._bench: Bench | None = None

    def __enter__(self) -> Live:
        warm_up(self.config, self.said.append)
        self.daemon.__enter__()
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
        self.daemon.__exit__(kind, error, trace)

    def _cycle(self) -> None:
        while not self._stopping.is_set():
            self.daemon.cycle()

    # The dashboard.

    def bring_back(self) -> None:
        """Serve the page, at the same port as before."""
        section = self.config.dashboard.model_copy(update={"port": self._port})
        shown = ShownDaemon(self.daemon)
        shown.config = self.config.model_copy(update={"dashboard": section})
        self._dashboard = Dashboard(
            shown,
            say=self.said.append,
            own_token=self.own_token,
            show_token=True,
            desk=self._desk,
            bench=self._bench,
        ).__enter__()
        assert self._dashboard.url is not None, self.said
        self._port = int(self._dashboard.url.split(":")[2].split("/")[0])
        # the thread needs a moment to make its event loop
        assert wait_until(lambda: self._dashboard is not None and self._dashboard.hub is not None)

    def serve_settings(self, file: Path, state: Path) -> None:
        """Let the page change a file from the next `bring_back` on; this run goes on as it is."""
        self._desk = Desk(
            Around(file, state, {}, file_problems, lambda: ([], []), reload=lambda: None)
        )

    def serve_calibration(self, config: Config, save: Callable[[Lens, Image | None], str]) -> Bench:
        """Let the page calibrate the camera of ``config`` from the next `bring_back` on."""
        calibration = self.world.calibration
        self._bench = Bench(self.daemon, config, calibration, save, time.monotonic, time.sleep)
        return self._bench

    @property
    def hub(self) -> Hub:
        """The dashboard's inside."""
        assert self._dashboard is not None
        assert self._dashboard.hub is not None
        return self._dashboard.hub

    def take_away(self) -> None:
        """End the page's server; the program goes on."""
        if self._dashboard is not None:
            self._dashboard.__exit__()
            self._dashboard = None

    @property
    def url(self) -> str:
        """Where the page is."""
        return f"http://127.0.0.1:{self._port}/"

    # The truth.

    @property
    def state(self) -> State:
        """The mission's state."""
        return self.daemon.pilot.mission.state

    def drives(self) -> bool:
        """Whether the robot is to drive now."""
        return self.state is State.DRIVING

    def place(self) -> tuple[float, float, float]:
        """Where the robot really is."""
        assert self.world.truth is not None
        x, y, heading = self.world.truth.robot.pose()
        return x, y, heading

    def is_moving(self) -> bool:
        """Whether the robot really moves."""
        x, y, heading = self.place()
        time.sleep(0.1)  # movement is a difference over time
        there = self.place()
        turned = abs(math.remainder(there[2] - heading, math.tau))
        return math.dist((x, y), there[:2]) > STILL_M or turned > 0.01

    def stands_within(self, seconds: float) -> bool:
        """Whether it comes to a stand in so many seconds, and stays there."""
        return wait_until(lambda: not self.is_moving(), seconds) and not self.is_moving()

    def calm_down(self) -> None:
        """Leave no stop, pause, mission or operator behind for the next test."""
        self.hub.seat.holder = None
        mission = self.daemon.pilot.mission
        under_way = (State.PLANNING, State.PROVING, State.DRIVING, State.HOLDING)
        if self.state in under_way or mission.paused:
            self.daemon.stop("the test is over")
            assert wait_until(lambda: self.state is State.STOPPED)
        if self.state is State.STOPPED:
            assert wait_until(lambda: self.daemon.link.snapshot().estopped)
            self.daemon.resume()
        quiet = (State.IDLE, State.DONE, State.FAILED)
        assert wait_until(lambda: self.state in quiet), self.state
        assert wait_until(lambda: not self.daemon.link.snapshot().estopped)
