"""The robots that people own, behind their drivers, beside our own firmware: their twins' figures.

    python -m benchmarks.robots             whole runs: configs/create2.yaml and so on
    python -m benchmarks.robots --stops     who stops the robot, and after how long
    python -m benchmarks.robots --hung      how far it drives when its driver's process hangs
    python -m benchmarks.robots --dead      a stop with a heading on wheels with a dead zone

A run takes about forty seconds of real time, a stop about five. ``--only create2`` measures one;
``--load 6`` keeps six busy processes beside ``--hung``.
The times of stops are from the event to wheels at rest, at the robot's ordinary speed, and how far
it went meanwhile; they hold the robot's braking. How far it drives when its driver hangs is counted
from the driver's last beat, and may be 0.3 s at its speed and its motors' lag. Dead zones are
measured in virtual time: `benchmarks.dead_zones`.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.dead_zones import show_dead_zones
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.messages import Waypoint, WaypointFlag
from navigation.config.known_robots import CLEARWAY, KNOWN_ROBOTS
from navigation.link.drivers.driver_link import DriverLink
from navigation.link.drivers.driver_process import DriverProcess
from navigation.link.serial_link import SerialLink
from navigation.simulator.robot import SimulatedRobot
from navigation.simulator.twins.kinds import TWINS
from tests.support.robots.troubled_drivers import TROUBLES, drive_into

CONFIGS = Path(__file__).parents[1] / "configs"
RUNS = {CLEARWAY: "simulation.yaml"} | {name: f"{name}.yaml" for name in KNOWN_ROBOTS}
GOAL_MM, GOAL_DEG, TRACKING_MM = 10.0, 2.0, 15.0
END = WaypointFlag.STOP | WaypointFlag.END
PATIENCE_S = 12.0
OWN_SPEED_M_S = 0.3


# Whole runs.


def run(name: str) -> dict[str, Any]:
    """The report of `clearway run` on the robot's configuration."""
    from navigation.config import load_config
    from navigation.run.runner import Runner

    with tempfile.TemporaryDirectory(prefix="clearway-robots-") as folder:
        os.chmod(folder, 0o700)
        config = load_config(CONFIGS / RUNS[name], {"CLEARWAY_RECORDING__RUNS_DIR": folder})
        runner = Runner(
            config,
            once=True,
            say=lambda _line: None,
            socket=Path(folder) / "socket",
            dashboard=False,
        )
        report = runner.run().report
        report.write(Path(folder) / "r.json")
        body: dict[str, Any] = json.loads((Path(folder) / "r.json").read_text())
        return body


def show_runs(names: list[str]) -> None:
    """A row each, and what is beyond the limits in bold."""
    print(f"| robot | state | goal | tracking rms, most | duration |  limits: {GOAL_MM:g} mm, "
          f"{GOAL_DEG:g} deg, {TRACKING_MM:g} mm rms |")  # fmt: skip
    print("|---|---|---|---|---|---|")
    for name in names:
        report = run(name)
        if report["state"] != "done":
            print(f"| {name} | **{report['state']}**: {report['reason']} | | | | **missed** |")
            continue
        goal_mm, goal_deg = report["goal_error_m"] * 1e3, report["goal_error_deg"]
        rms, most = (report["tracking_error_m"][key] * 1e3 for key in ("rms", "max"))
        kept = (
            report["state"] == "done"
            and goal_mm <= GOAL_MM
            and goal_deg <= GOAL_DEG
            and rms <= TRACKING_MM
        )
        print(
            f"| {name} | {report['state']} | {goal_mm:.1f} mm, {goal_deg:.2f} deg | {rms:.1f} mm, "
            f"{most:.1f} mm | {report['duration_s']:.0f} s | {'kept' if kept else '**missed**'} |",
            flush=True,
        )


# Who stops it.


class Bench(NamedTuple):
    """A robot that drives, and what may be done to it."""

    robot: SimulatedRobot
    link: SerialLink
    driver: DriverProcess | None
    leases: threading.Event

    def moves(self) -> bool:
        """True if its wheels turn."""
        return self.robot.moving


def hang_the_daemon(bench: Bench) -> None:
    """The control loop gives no lease any more."""
    bench.leases.clear()


def kill_the_driver(bench: Bench) -> None:
    """By SIGKILL."""
    assert bench.driver is not None
    assert bench.driver.pid is not None
    os.kill(bench.driver.pid, signal.SIGKILL)


def pull_the_cable(bench: Bench) -> None:
    """Nothing passes in either direction, as where the computer dies."""
    bench.robot.unplug()


EVENTS: dict[str, Callable[[Bench], None]] = {
    "the daemon hangs": hang_the_daemon,
    "the driver is killed": kill_the_driver,
    "the PC dies, or the cable is pulled": pull_the_cable,
}


@contextmanager
def driving(name: str) -> Iterator[Bench]:
    """The robot on its way, with a control loop beside it."""
    leases, over = threading.Event(), threading.Event()
    leases.set()
    speed = OWN_SPEED_M_S if name == CLEARWAY else 0.8 * KNOWN_ROBOTS[name].speed_m_s
    rng = np.random.default_rng(1)
    robot = SimulatedRobot(rng=rng, twin=None if name == CLEARWAY else TWINS[name]())
    with robot:
        driver = None
        if name == CLEARWAY:
            link = SerialLink(robot.port)
        else:
            known = KNOWN_ROBOTS[name]
            settings = DriveSettings(track_m=known.track_m, max_speed_m_s=speed)
            driver = DriverProcess(name, robot.port, known.baud, settings)
            driver.start()
            link = DriverLink(driver.port, driver.word)

        def control() -> None:
            while not over.wait(0.033):
                if leases.is_set():
                    with suppress(Exception):
                        link.pose_fix(*robot.pose(), time.monotonic())
                        link.lease(True, 0.01)

        thread = threading.Thread(target=control)
        try:
            link.open()
            thread.start()
            wait_until(lambda: link.snapshot().clock_offset_s is not None)
            link.upload(5, [Waypoint(6.0, 0.0, speed), Waypoint(9.0, 0.0, 0.0, flags=END)])
            wait_until(lambda: robot.pose()[0] > 2.5 * speed)
            yield Bench(robot, link, driver, leases)
        finally:
            over.set()
            thread.join()
            link.close()
            if driver is not None:
                driver.stop()


def wait_until(holds: Callable[[], bool], seconds: float = 20.0) -> bool:
    """Whether it held in time."""
    end_s = time.monotonic() + seconds
    while time.monotonic() < end_s:
        if holds():
            return True
        time.sleep(0.005)  # the robot behind the port is another process
    return False


def stop_time(name: str, event: Callable[[Bench], None]) -> str:
    """``0.62 s, 0.21 m``, or that nothing stopped it."""
    with driving(name) as bench:
        began_s, began = time.monotonic(), bench.robot.pose()
        event(bench)
        if not wait_until(lambda: not bench.moves(), PATIENCE_S):
            return f"nothing in {PATIENCE_S:g} s"
        gone_m = math.dist(bench.robot.pose()[:2], began[:2])
        return f"{time.monotonic() - began_s:.2f} s, {gone_m:.2f} m"


def show_stops(names: list[str]) -> None:
    """A row a robot, a column an event."""
    print(f"| robot | speed | {' | '.join(EVENTS)} |")
    print("|---|---|" + "---|" * len(EVENTS))
    for name in names:
        speed = OWN_SPEED_M_S if name == CLEARWAY else 0.8 * KNOWN_ROBOTS[name].speed_m_s
        cells = [
            "no driver" if name == CLEARWAY and event is kill_the_driver else stop_time(name, event)
            for event in EVENTS.values()
        ]
        print(f"| {name} | {speed:.2f} m/s | {' | '.join(cells)} |", flush=True)


# Drivers that hang.


def show_hung(names: list[str], load: int) -> None:
    """A row a robot, a column a trouble; what is beyond its bar in bold.

    ``load``: so many busy processes beside it, from when the robot has its speed.
    """
    print(f"| robot | {' | '.join(TROUBLES)} |")
    print("|---|" + "---|" * len(TROUBLES))
    for name in names:
        cells = []
        for trouble in TROUBLES:
            found = drive_into(trouble, name, load)
            mark = "" if found.driven_m <= found.bar_m else "**"
            cells.append(f"{mark}{found.driven_m:.3f} of {found.bar_m:.3f} m{mark}")
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


def main() -> None:
    """See the module's text."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--stops", action="store_true")
    parser.add_argument("--only", choices=[*RUNS], action="append")
    parser.add_argument("--hung", action="store_true")
    parser.add_argument("--load", type=int, default=0, metavar="N", help="busy processes beside")
    parser.add_argument("--dead", action="store_true")
    options = parser.parse_args()
    names = options.only or [*RUNS]
    if options.dead:
        show_dead_zones(names)
    elif options.hung:
        show_hung([name for name in names if name != CLEARWAY], options.load)
    else:
        (show_stops if options.stops else show_runs)(names)


if __name__ == "__main__":
    main()
