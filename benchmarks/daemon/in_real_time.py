"""The running program in real time: latencies, a new plan, shutting down, its memory for minutes.

Parts of `python -m benchmarks.daemon`; each starts `clearway run` as a user does, but for
`replan`, which looks into one. Times of this machine and its load.
"""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeAlias

import numpy as np

from navigation.config import Config, load_config
from navigation.control import ControlError, send_order
from navigation.loop.daemon import Daemon
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from navigation.run.world import World

CONFIGS = Path(__file__).parents[2] / "configs"
PROGRAM = [sys.executable, "-c", "from navigation.cli.main import main; main()", "run"]
PATROL = ((0.20, 0.60), (0.20, 1.00))
SHUTDOWN_S, GROWN_MB = 1.0, 5.0

Rows: TypeAlias = Iterator[tuple[str, str, str, bool]]
"""What was measured, the value, the target, and whether it was met."""


def wire(runs: int) -> Rows:
    """`clearway run` in real time, as a user starts it."""
    found = []
    for number in range(runs):
        with tempfile.TemporaryDirectory() as folder:
            report = Path(folder) / "report.json"
            subprocess.run(
                [*PROGRAM, str(CONFIGS / "simulation.yaml"), "--once", "--no-dashboard",
                 "--quiet", "--socket", str(Path(folder) / "c.sock"), "--report", str(report)],
                check=True, stdout=subprocess.DEVNULL, timeout=300,
                env={**os.environ, "CLEARWAY_RECORDING__RUNS_DIR": folder},
            )  # fmt: skip
            told = json.loads(report.read_text())
        found.append(told["latency_ms"]["capture_to_wire"])
        print(f"  run {number}: {found[-1]}, goal {told['goal_error_m']:.4f} m", flush=True)
    for name, limit in (("p50", 8.0), ("p99", 20.0)):
        values = [one[name] for one in found]
        yield (
            f"capture to wire {name}, 1280x960, 30 a second, best of {runs} runs",
            f"{min(values):.1f} ms (worst run {max(values):.1f})", f"<= {limit:g}",
            min(values) <= limit,
        )  # fmt: skip


def replan(runs: int) -> Rows:
    """An obstacle appears on the path of a robot that drives, in real time."""
    config = load_config(CONFIGS / "simulation.yaml", {})
    assert config.simulation is not None
    times: list[tuple[float, float]] = []
    for number in range(2 * runs):
        if len(times) == runs:
            break
        appears_s = 4.0 + 0.11 * number
        obstacle = {"record": "C (0.10,1.16) 0.08", "from_s": appears_s}
        data = config.model_dump()
        data["simulation"]["obstacles"] = (obstacle,)
        data["mission"]["stations"] = ({"x_m": 0.20, "y_m": 1.60},)
        measured = _measure_replan(Config.model_validate(data), appears_s)
        if measured is None:
            continue  # the robot held just then, for want of a processor
        times.append(measured)
        print(f"  replan {number}: hold {times[-1][0]:.1f}, plan {times[-1][1]:.1f} ms", flush=True)
    hold, plan = (np.array(column) for column in zip(*times, strict=True))
    for name, values in (("the robot is told to stop", hold), ("its new plan is sent", plan)):
        told = f"{np.median(values):.1f} median, {values.max():.1f} worst ms"
        yield (
            f"from the picture with the obstacle until {name}, {runs} times",
            told, "<= 100", float(np.median(values)) <= 100.0,
        )  # fmt: skip


def _measure_replan(config: Config, appears_s: float) -> tuple[float, float] | None:
    """Milliseconds from the exposure of the first picture with it to the hold and to the plan."""
    world = World(config)
    shown_s = held_s = 0.0
    with Daemon(config, world, first_mission_id=1) as daemon:
        assert world.truths[""] is not None
        daemon.people.give(stations_of(config))
        plans = 0
        while True:
            now = daemon.cycle().only
            at_s = world.clock()
            frame = now.frame
            due_s = world.truths[""].began_s + appears_s
            if shown_s == 0.0 and frame is not None and frame.captured_s >= due_s:
                if now.mission.state is not State.DRIVING:
                    return None
                shown_s, plans = frame.captured_s, len(daemon.robot.plans)
            if shown_s and held_s == 0.0 and now.mission.state is not State.DRIVING:
                held_s = at_s
            if held_s and len(daemon.robot.plans) > plans:
                return (held_s - shown_s) * 1e3, (at_s - shown_s) * 1e3
            assert at_s < due_s + 10.0, f"no new plan: {now.sentence}"


def shutdown(runs: int) -> Rows:
    """SIGTERM while the robot drives at its full speed and while it stands: until the process ends.

    With the dashboard and a recording, as a service has them.
    """
    for what, stations in (("drives", [[0.15, 1.15], [0.20, 1.60]]), ("stands", [])):
        took_s = [_shut_down(stations) for _ in range(runs)]
        told = f"{np.median(took_s):.2f} median, {max(took_s):.2f} worst s"
        yield (
            f"from SIGTERM to the end of the process while the robot {what}, {runs} times",
            told, f"<= {SHUTDOWN_S:g}", float(np.median(took_s)) <= SHUTDOWN_S,
        )  # fmt: skip


def _shut_down(stations: list[list[float]]) -> float:
    mission = json.dumps([{"x_m": x, "y_m": y} for x, y in stations])
    ready = re.compile(r"m to go" if stations else r"idle.*clearance")
    with _program({"CLEARWAY_MISSION__STATIONS": mission}) as (process, folder):
        _wait_until(lambda: ready.search((folder / "output").read_text()) is not None)
        time.sleep(2.0)  # under way, not just setting off
        begun_s = time.perf_counter()
        process.send_signal(signal.SIGTERM)
        process.wait(30.0)
        took_s = time.perf_counter() - begun_s
        said = (folder / "output").read_text()
        assert process.returncode == 0, said
        assert "interrupted" in said, said
    print(f"  shut down in {took_s:.2f} s", flush=True)
    return took_s


def stretch(minutes: float) -> Rows:
    """A patrol in real time with dashboard and recording: how much the process has grown."""
    sizes_mb, missions = [], 0
    with _program({"CLEARWAY_MISSION__STATIONS": "[]"}) as (process, folder):
        _wait_until(lambda: "idle" in (folder / "output").read_text())
        end_s = time.monotonic() + 60.0 * minutes
        while time.monotonic() < end_s:
            state = _order(folder, {"order": "status"})["state"]
            if state in ("idle", "done", "failed"):  # a busy machine may hold too long
                x_m, y_m = PATROL[missions % len(PATROL)]
                _order(folder, {"order": "go", "stations": [{"x_m": x_m, "y_m": y_m}]})
                missions += 1
            time.sleep(0.5)  # two samples of the memory a second
            sizes_mb.append(resident_mb(process.pid))
        process.send_signal(signal.SIGTERM)
        process.wait(30.0)
    early_mb, late_mb = (
        float(np.median(part)) for part in (sizes_mb[len(sizes_mb) // 4 :][:20], sizes_mb[-20:])
    )
    yield (
        f"memory grown from a quarter to the end of {minutes:g} min in real time with dashboard "
        f"and recording, {missions} missions",
        f"{late_mb - early_mb:.1f} MB, from {early_mb:.0f} MB", f"<= {GROWN_MB:g} MB",
        late_mb - early_mb <= GROWN_MB,
    )  # fmt: skip


@contextmanager
def _program(environment: dict[str, str]) -> Iterator[tuple[subprocess.Popen[bytes], Path]]:
    """`clearway run` over the simulation with dashboard and recording; ended at the end."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with (folder / "output").open("wb") as output:
            process = subprocess.Popen(
                [*PROGRAM, str(CONFIGS / "simulation.yaml"), "--socket", str(folder / "c.sock"),
                 "--record", str(folder / "recording")],
                stdout=output, stderr=subprocess.STDOUT,
                env={
                    **os.environ, "CLEARWAY_RECORDING__RUNS_DIR": name,
                    "CLEARWAY_DASHBOARD__PORT": "0", **environment,
                },
            )  # fmt: skip
        try:
            yield process, folder
        finally:
            process.kill()
            process.wait()


def _order(folder: Path, order: dict[str, object]) -> dict[str, str]:
    try:
        return send_order(folder / "c.sock", order)
    except ControlError as error:
        raise RuntimeError(f"{error}\n{(folder / 'output').read_text()[-2000:]}") from error


def _wait_until(reached: Callable[[], bool], patience_s: float = 300.0) -> None:
    end_s = time.monotonic() + patience_s
    while not reached():
        assert time.monotonic() < end_s, "the program is not ready"
        time.sleep(0.1)  # another program: there is nothing to wait on


def resident_mb(process: int) -> float:
    """What a process holds in memory."""
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6
