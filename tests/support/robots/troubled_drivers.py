"""Robots that drive while their driver's process is frozen, killed, slow, or loops: how far.

The distance is the twin's own, from the driver's last beat to wheels at rest. Its bar: 0.3 s at the
speed that it had, and what its motors' lag makes of an order. Metres, seconds.
"""

from __future__ import annotations

import itertools
import math
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from itertools import pairwise
from typing import Any, Final, NamedTuple

import numpy as np

from firmware_protocol.wire.messages import Waypoint, WaypointFlag
from navigation.config.known_robots import KNOWN_ROBOTS
from navigation.link.drivers.driven_robot import DrivenRobot
from navigation.link.drivers.driver_link import DriverLink
from navigation.link.drivers.driver_process import DriverProcess
from navigation.link.drivers.serve import Work, serve
from navigation.simulator.drive_model import DriveModel
from navigation.simulator.robot import SimulatedRobot
from navigation.simulator.twins.kinds import TWINS
from tests.support.processes.busy import busy
from tests.support.robots.driven_bench import settings_of
from tests.support.waiting import wait_until

TROUBLES: Final = ("frozen", "killed", "slow", "loops")
PATIENCE_S: Final = 60.0
"""With what is waited for on a busy machine; nothing is measured by it."""
STOPPED_AFTER_S: Final = 0.3
LAG_S: Final = DriveModel().lag_s
SPEED_SHARE: Final = 0.8
"""Of a robot's fastest; its speed at the trouble is within a tenth of it."""
LOADED_S: Final = 0.5
"""So long busy processes have had before the trouble begins."""
TURN_S: Final = 0.3
"""Each turn of a driver that is slow."""
STARTS: Final = 3
"""On a busy computer a driver may be ended before its robot has its speed: then again."""
BEGINS_S: Final = 1.0
"""A robot that was given a mission begins to drive within this."""
END = WaypointFlag.STOP | WaypointFlag.END


class Bench(NamedTuple):
    """A robot, its driver, and the link to it."""

    twin: SimulatedRobot
    driver: DriverProcess
    link: DriverLink

    @property
    def pid(self) -> int:
        assert self.driver.pid is not None
        return self.driver.pid


@contextmanager
def driven(name: str, work: Work = serve) -> Iterator[Bench]:
    """A robot that can be driven, and a loop that gives poses and leases."""
    with SimulatedRobot(twin=TWINS[name](), rng=np.random.default_rng(3)) as twin:
        baud = KNOWN_ROBOTS[name].baud
        driver = DriverProcess(name, twin.port, baud, settings_of(name), work=work)
        driver.start()
        over = threading.Event()
        link = DriverLink(driver.port, driver.word)

        def control() -> None:
            while not over.wait(0.033):
                with suppress(Exception):
                    link.pose_fix(*twin.pose(), time.monotonic())
                    link.lease(True, 0.01)

        thread = threading.Thread(target=control)
        try:
            link.open()
            thread.start()
            assert wait_until(lambda: link.snapshot().clock_offset_s is not None, PATIENCE_S)
            yield Bench(twin, driver, link)
        finally:
            over.set()
            thread.join()
            link.close()
            driver.stop()


def set_off(bench: Bench, name: str, ended: Callable[[], bool] = lambda: False) -> None:
    """Give the robot a mission, and another one where a busy machine has let it stop.

    Returns when it has its speed, or when it has ``ended``.
    """
    end_s = time.monotonic() + PATIENCE_S
    numbers = itertools.count(5 + 100 * bench.driver.restarts)
    while not (drives(bench, name) or ended()):
        assert time.monotonic() < end_s, bench.link.snapshot().standing_reason
        x_m, speed_m_s = bench.twin.pose().x_m, SPEED_SHARE * KNOWN_ROBOTS[name].speed_m_s
        way = [Waypoint(x_m + 3.0, 0.0, speed_m_s), Waypoint(x_m + 6.0, 0.0, 0.0, flags=END)]
        bench.link.upload(next(numbers), way)
        wait_until(lambda: bench.twin.moving or ended(), BEGINS_S)
        wait_until(lambda: drives(bench, name) or not bench.twin.moving or ended(), PATIENCE_S)


def drives(bench: Bench, name: str) -> bool:
    """True if it has its speed."""
    least_m_s = 0.9 * SPEED_SHARE * KNOWN_ROBOTS[name].speed_m_s
    return bench.twin.moving and fastest_m_s(bench.twin) > least_m_s


def fastest_m_s(twin: SimulatedRobot, until_s: float = math.inf) -> float:
    """Of the last half second, over 0.1 s each time; ``until_s``: before that moment."""
    rows = twin.track()
    rows = rows[rows[:, 0] <= until_s][-25::5]
    return max((math.dist(a[1:3], b[1:3]) / (b[0] - a[0]) for a, b in pairwise(rows)), default=0.0)


def driven_since_m(twin: SimulatedRobot, from_s: float) -> float:
    """The length of its track from a moment of the clock on."""
    rows = twin.track()
    return sum(math.dist(a[1:3], b[1:3]) for a, b in pairwise(rows[rows[:, 0] >= from_s]))


class Measured(NamedTuple):
    """How far a robot drove after its driver's last beat, and how far it may."""

    speed_m_s: float
    driven_m: float

    @property
    def bar_m(self) -> float:
        return (STOPPED_AFTER_S + LAG_S) * self.speed_m_s


def drive_into(trouble: str, name: str, load: int = 0) -> Measured:
    """Bring a driver into trouble while its robot drives.

    ``load``: so many busy processes beside it, from when the robot has its speed.
    """
    work = serve if trouble in ("frozen", "killed") else partial(_in_trouble, name, trouble)
    with ExitStack() as until:
        bench = until.enter_context(driven(name, work))
        for _ in range(STARTS):
            measured = _drive_once_into(trouble, name, bench, load)
            if measured.speed_m_s > 0.5 * SPEED_SHARE * KNOWN_ROBOTS[name].speed_m_s:
                break
            assert wait_until(lambda: bench.link.snapshot().down_reason is None, PATIENCE_S)
        return measured


def _drive_once_into(trouble: str, name: str, bench: Bench, load: int) -> Measured:
    restarts, since_s = bench.driver.restarts, bench.driver.beat_s

    def look() -> bool:
        nonlocal since_s
        if bench.driver.restarts == restarts:
            since_s = bench.driver.beat_s
        return bench.driver.restarts > restarts

    set_off(bench, name, look)
    with busy(load):
        # a load alone may keep a driver from its beat: then that is what is measured
        hangs = look() or wait_until(look, LOADED_S if load else 0.0)
        if not hangs and trouble in ("frozen", "killed"):
            os.kill(bench.pid, signal.SIGSTOP if trouble == "frozen" else signal.SIGKILL)
        assert wait_until(look, PATIENCE_S)
        assert wait_until(lambda: not bench.twin.moving, PATIENCE_S)
    speed_m_s = fastest_m_s(bench.twin, since_s + STOPPED_AFTER_S)
    return Measured(speed_m_s, driven_since_m(bench.twin, since_s))


def _in_trouble(name: str, trouble: str, *arguments: Any) -> None:
    """The work of a process that drives well at first, and then is slow or never comes round."""
    tick, speed_m_s = DrivenRobot.tick, SPEED_SHARE * KNOWN_ROBOTS[name].speed_m_s

    def troubled_tick(robot: DrivenRobot, now_s: float) -> None:
        tick(robot, now_s)
        if robot.driver.heard.left_m > speed_m_s:  # a second's travel: it has its speed
            if trouble == "slow":
                time.sleep(TURN_S)  # the slowness itself
            while trouble == "loops":
                pass

    DrivenRobot.tick = troubled_tick  # type: ignore[method-assign]
    serve(*arguments)
