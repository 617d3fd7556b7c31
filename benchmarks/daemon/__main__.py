"""The running program against its figures: accuracy, clearance, latency, memory.

    python -m benchmarks.daemon
        [--only accuracy,arenas,kills,pictures,replan,wire,shutdown,memory,stretch]
        [--arenas 200] [--kept FILE] [--kills 200] [--workers 2]
        [--output benchmarks/results/daemon.md]

- arenas: random arenas in virtual time, wheels wrong by up to 3 %, slip, noise: the least true
  clearance of the driven track, tracking and goal error
- accuracy: configs/simulation.yaml at 1280x960 in virtual time, wheels wrong by 3 %, 2 % slip
- pictures: the same configuration in virtual time with drawn pictures and without: how many times
  as fast as real time, by the processor's time
- wire: configs/simulation.yaml in real time: from a picture's exposure to its pose on the wire
- replan: in real time, from the exposure of the first picture that shows a new obstacle to the
  hold and to the new plan on its way to the robot
- kills: the program is killed at random moments of tours in virtual time, the robot power-cycled
  after every fourth kill, another program started: whether each station was visited once
- shutdown: from SIGTERM to the end of the process, with dashboard and recording
- memory: of a patrol of two hours in virtual time, how much the process has grown
- stretch: the same for some minutes of the whole program in real time

In the simulated camera a picture is drawn in part after its exposure (the robots), so that
`wire` and `replan` hold about a millisecond that a real camera would not take. Times of this
machine and its load: the table says how many processors it has and how busy they were.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path

import numpy as np
from pydantic import TypeAdapter

from benchmarks.daemon.in_real_time import Rows, replan, resident_mb, shutdown, stretch, wire
from navigation.config import load_config
from navigation.loop.daemon import Daemon
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from navigation.run.kernels.warm_up import warm_up
from navigation.run.robot_report import Report
from navigation.run.virtual_run import run_virtually
from navigation.run.virtual_world import VirtualWorld
from tests.support.runs.kills import Campaign, drive_under_fire
from tests.support.runs.virtual import CONFIGS, short_config
from tests.support.scenes.random_arenas import RADIUS_M, random_config

RATE_HZ = 30.0
"""Rate of the camera, as in the shipped simulation."""


def arenas(count: int, workers: int, kept: Path | None) -> Rows:
    """Random arenas, each driven once; those whose report lies in ``kept`` are not driven again."""
    known = {} if kept is None else _kept_reports(kept)
    began_s = time.perf_counter()
    missing = [seed for seed in range(count) if seed not in known]
    with ProcessPoolExecutor(workers) as pool:
        for seed, report in zip(missing, pool.map(_drive_arena, missing), strict=True):
            known[seed] = report
            clearance = report.min_clearance_m or 0.0
            if report.state != "done" or clearance < RADIUS_M:
                told = f"{report.state}, {report.reason}; {clearance:.4f} m"
                print(f"  arena {seed}: {told}", flush=True)
            if kept is not None:
                with kept.open("a", encoding="utf-8") as file:
                    file.write(json.dumps({"seed": seed, "report": asdict(report)}) + "\n")
    took_s = time.perf_counter() - began_s
    reports = [known[seed] for seed in range(count)]
    done = [report for report in reports if report.state == "done"]
    least = min(report.min_clearance_m or 0.0 for report in reports)
    yield f"arenas driven to the goal, of {count}", str(len(done)), "all", len(done) == count
    yield (
        "least clearance of any track, less the radius",
        f"{(least - RADIUS_M) * 1e3:.1f} mm", ">= 0", least >= RADIUS_M,
    )  # fmt: skip
    yield from _accuracy_rows(done, "arenas")
    virtual_s = sum(known[seed].duration_s for seed in missing)
    if missing:
        yield "virtual time", f"{virtual_s:.0f} s, {virtual_s / took_s:.1f} times as fast", "", True


def _kept_reports(path: Path) -> dict[int, Report]:
    """By seed: the reports of an earlier, interrupted campaign."""
    if not path.exists():
        return {}
    lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    as_report = TypeAdapter(Report)
    return {line["seed"]: as_report.validate_python(line["report"]) for line in lines}


def _drive_arena(seed: int) -> Report:
    return run_virtually(random_config(seed)).only


def accuracy(seeds: int, workers: int) -> Rows:
    """The simulated run of `make run`, with worse wheels."""
    with ProcessPoolExecutor(workers) as pool:
        reports = list(pool.map(_drive_simulation, range(seeds)))
    done = [report for report in reports if report.state == "done"]
    yield f"runs driven to the goal, of {seeds}", str(len(done)), "all", len(done) == seeds
    yield from _accuracy_rows(done, "1280x960")


def _drive_simulation(seed: int) -> Report:
    config = load_config(CONFIGS / "simulation.yaml", {})
    assert config.simulation is not None
    sign = 1.0 if seed % 2 else -1.0
    robot = config.simulation.robot.model_copy(
        update={"wheel_radius_error": (0.03 * sign, -0.03 * sign), "slip": 0.02}
    )
    simulation = config.simulation.model_copy(update={"seed": seed, "robot": robot})
    return run_virtually(config.model_copy(update={"simulation": simulation})).only


def _accuracy_rows(reports: list[Report], where: str) -> Rows:
    goal_mm = np.array([(r.goal_error_m or 0.0) * 1e3 for r in reports])
    goal_deg = np.array([r.goal_error_deg or 0.0 for r in reports])
    rms_mm = np.array([(r.tracking_error_m.rms or 0.0) * 1e3 for r in reports])
    for name, values, limit, unit in (
        ("goal error", goal_mm, 5.0, "mm"),
        ("goal heading error", goal_deg, 1.0, "deg"),
        ("tracking error, rms", rms_mm, 10.0, "mm"),
    ):
        told = f"{np.median(values):.2f} median, {values.max():.2f} worst"
        yield f"{name} ({where})", f"{told} {unit}", f"<= {limit:g}", values.max() <= limit


def kills(count: int, workers: int) -> Rows:
    """Tours under fire until so many kills have come together."""
    told: list[Campaign] = []
    with ProcessPoolExecutor(workers) as pool:
        seeds = iter(range(10_000))
        while sum(one.kills for one in told) < count:
            told += pool.map(_tour_under_fire, [next(seeds) for _ in range(workers)])
            print(f"  {sum(one.kills for one in told)} kills", flush=True)
    for seed, one in enumerate(told):
        if one.state is not State.DONE or one.visits != [0, 1, 2]:
            print(f"  tour {seed}: {one}")
    well = sum(one.state is State.DONE and one.visits == [0, 1, 2] for one in told)
    fallen = sum(one.kills for one in told)
    yield (
        f"tours with each station visited once and the goal reached, {fallen} kills",
        f"{well} of {len(told)}", "all", well == len(told),
    )  # fmt: skip
    least = min(one.least_clearance_m for one in told)
    yield (
        "least clearance on tours under fire, less the radius",
        f"{(least - RADIUS_M) * 1e3:.1f} mm", ">= 0", least >= RADIUS_M,
    )  # fmt: skip


def _tour_under_fire(seed: int) -> Campaign:
    places = [(0.20, 0.60), (0.15, 1.15), (0.20, 1.60)]
    config = short_config(
        [{"x_m": x, "y_m": y, "dwell_s": 0.5} for x, y in places],
        simulation={"seed": seed}, camera={"rate_hz": RATE_HZ},
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        return drive_under_fire(config, Path(folder) / "journal", seed, 20, power_cycles=0.25)


def with_and_without_pictures() -> Rows:
    """Virtual time against processor time, with and without pictures; both have to end alike."""
    config = load_config(CONFIGS / "simulation.yaml", {})
    for pictures, wanted in ((True, 0.0), (False, 20.0)):
        began_s = time.process_time()
        report = run_virtually(config, pictures=pictures)
        times = report.duration_s / (time.process_time() - began_s)
        yield (
            f"times real time, {'with' if pictures else 'without'} pictures",
            f"{times:.1f} ({report.state} after {report.duration_s:.1f} s)",
            f">= {wanted:g}" if wanted else "",
            times >= wanted and report.state == "done",
        )


def memory(hours: float) -> Rows:
    """Patrol between two places in virtual time; memory after a tenth and at the end."""
    places = [{"x_m": 0.20, "y_m": 0.60}, {"x_m": 0.20, "y_m": 1.00}]
    config = short_config(places, camera={"rate_hz": RATE_HZ})
    world = VirtualWorld(config)
    early_mb = 0.0
    with Daemon(config, world, first_mission_id=1) as daemon:
        end_s = world.clock() + hours * 3600.0
        begun_s = world.clock()
        while world.clock() < end_s:
            now = daemon.cycle().only
            if now.mission.state in (State.IDLE, State.DONE):
                daemon.people.give(stations_of(config))
            if not early_mb and world.clock() - begun_s > 0.1 * hours * 3600.0:
                early_mb = resident_mb(os.getpid())
        grown_mb = resident_mb(os.getpid()) - early_mb
        missions = daemon.robot.pilot.plans
    yield (
        f"memory grown over {hours:g} h of patrol in virtual time, {missions} plans",
        f"{grown_mb:.1f} MB, from {early_mb:.0f} MB", "<= 5 MB", grown_mb <= 5.0,
    )  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--only", default="accuracy,arenas,kills,pictures,replan,wire,shutdown,memory,stretch"
    )
    parser.add_argument("--arenas", type=int, default=200)
    parser.add_argument("--kept", type=Path, help="reports of arenas, to go on after a break")
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--hours", type=float, default=2.0)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    parts: dict[str, Callable[[], Rows]] = {
        "accuracy": lambda: accuracy(10, options.workers),
        "arenas": lambda: arenas(options.arenas, options.workers, options.kept),
        "kills": lambda: kills(options.kills, options.workers),
        "pictures": with_and_without_pictures,
        "replan": lambda: replan(10),
        "wire": lambda: wire(3),
        "shutdown": lambda: shutdown(5),
        "memory": lambda: memory(options.hours),
        "stretch": lambda: stretch(options.minutes),
    }
    warm_up(load_config(CONFIGS / "simulation.yaml", {}), print)
    lines = ["| part | figure | measured | target | met |", "|---|---|---|---|---|"]
    met = True
    for name in options.only.split(","):
        load = os.getloadavg()[0]
        for figure, value, target, ok in parts[name]():
            lines.append(f"| {name} | {figure} | {value} | {target} | {'yes' if ok else 'no'} |")
            print(lines[-1], flush=True)
            met &= ok
        print(f"  load when {name} began: {load:.1f}", flush=True)
    if options.output is not None:
        heading = [
            "# The running program", "",
            f"`python -m benchmarks.daemon --only {options.only} --arenas {options.arenas}`,",
            f"Python {platform.python_version()}, {os.cpu_count()} processors.", "",
        ]  # fmt: skip
        options.output.write_text("\n".join([*heading, *lines]) + "\n", encoding="utf-8")
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
