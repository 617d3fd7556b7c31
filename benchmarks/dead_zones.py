"""Stops with a heading on wheels that do not turn below some speed, for each kind of robot.

    python -m benchmarks.robots --dead

Our own robot drives the whole run of ``configs/simulation.yaml``, pictures and all; the others
drive a metre or so behind their drivers, and turn. All in virtual time, with `SEEDS`; the worst of
each is shown. ``robot.least_wheel_m_s`` is a little above the order at which a wheel at rest begins
to turn, as its owner would measure it.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Final, NamedTuple

from firmware_protocol.wire.messages import StopReason
from navigation.config import load_config
from navigation.config.known_robots import CLEARWAY, least_wheel_m_s
from navigation.link.drivers.create2_wheel import LEAST_MM_S, driven
from navigation.run.virtual_run import run_virtually
from navigation.simulator.drive_model import DriveModel
from tests.support.robots.driven_bench import DrivenBench, scaled_goal

CONFIG: Final = Path(__file__).parents[1] / "configs" / "simulation.yaml"
ZONES_M_S: Final = (0.0, 0.005, 0.02, 0.04)
SEEDS: Final = (1, 2, 3)
MOST_MM, MOST_DEG = 3.0, 1.0
PATIENCE_S: Final = 60.0
ABOVE: Final = 1.05
"""A wheel at rest is sure to turn by so much above the order at which it may."""


class Stop(NamedTuple):
    """The result of one run."""

    done: bool
    goal_mm: float
    goal_deg: float
    seconds: float
    least_mm_s: float


def least_for(name: str, zone_m_s: float) -> float:
    """The `robot.least_wheel_m_s` that the owner of such a robot would configure."""
    starts_m_s = ABOVE * zone_m_s * (1.0 + DriveModel().stiction)
    own = least_wheel_m_s(name, None)  # type: ignore[arg-type]
    steps: list[float] = []
    if name == "create2":
        steps = sorted({driven(order) / 1000 for order in range(LEAST_MM_S, 200)})
        if starts_m_s < steps[0]:
            return own
    elif name == "turtlebot3":
        steps = [own * number for number in range(1, 6)]
    least = max(own, starts_m_s)
    return next((step for step in steps if step >= least > 0.0), least)


def own_stop(zone_m_s: float, seed: int) -> Stop:
    """A whole run with our firmware's twin."""
    least = least_for(CLEARWAY, zone_m_s)
    config = load_config(
        CONFIG,
        {
            "CLEARWAY_ROBOT__LEAST_WHEEL_M_S": str(least),
            "CLEARWAY_SIMULATION__ROBOT__DEAD_ZONE_M_S": str(zone_m_s),
            "CLEARWAY_SIMULATION__SEED": str(seed),
        },
    )
    report = run_virtually(config).only
    if report.goal_error_m is None or report.goal_error_deg is None:
        return Stop(False, math.inf, math.inf, report.duration_s, 1e3 * least)
    done = report.state == "done"
    mm, deg = 1e3 * report.goal_error_m, report.goal_error_deg
    return Stop(done, mm, deg, report.duration_s, 1e3 * least)


def driven_stop(name: str, zone_m_s: float, seed: int) -> Stop:
    """A stop with a heading behind a driver."""
    least = least_for(name, zone_m_s)
    bench = DrivenBench(name, seed=seed, dead_zone_m_s=zone_m_s, least_wheel_m_s=least)
    control = bench.robot.controller
    bench.get_ready()
    bench.send(5, *scaled_goal(name))
    began_s = bench.now_s
    while not bench.is_done and bench.now_s < began_s + PATIENCE_S:
        bench.tick()
        if control.reason is StopReason.STUCK:
            break
    seconds = bench.now_s - began_s
    bench.run(0.5)
    x, y, heading = bench.drive.pose
    mm = 1e3 * math.dist((x, y), scaled_goal(name)[-1])
    return Stop(bench.is_done, mm, abs(math.degrees(heading)), seconds, 1e3 * least)


def worst(name: str, zone_m_s: float) -> Stop:
    """The worst of every number over the seeds."""
    stop = own_stop if name == CLEARWAY else lambda *case: driven_stop(name, *case)
    stops = [stop(zone_m_s, seed) for seed in SEEDS]
    most = [max(column) for column in zip(*(one[1:] for one in stops), strict=True)]
    return Stop(all(one.done for one in stops), *most)


def show_dead_zones(names: list[str]) -> None:
    """A row a robot and dead zone; what is beyond the limits in bold."""
    limits = f"limits: {MOST_MM:g} mm, {MOST_DEG:g} deg"
    worst_of = f"goal, worst of {len(SEEDS)}"
    print(f"| robot | dead zone | least_wheel_m_s | state | {worst_of} | seconds | {limits} |")
    print("|---|---|---|---|---|---|---|")
    for name in names:
        for zone_m_s in ZONES_M_S:
            found = worst(name, zone_m_s)
            kept = found.done and found.goal_mm <= MOST_MM and found.goal_deg <= MOST_DEG
            print(
                f"| {name} | {1e3 * zone_m_s:g} mm/s | {found.least_mm_s / 1e3:.3g} | "
                f"{'done' if found.done else '**not done**'} | {found.goal_mm:.1f} mm, "
                f"{found.goal_deg:.2f} deg | {found.seconds:.1f} s | "
                f"{'kept' if kept else '**missed**'} |",
                flush=True,
            )
