"""How many runs a second `clearway sweep` makes, by its processes, and that rows do not differ.

    python -m benchmarks.sweep [--runs 16] [--workers 1,2] [--output benchmarks/results/sweep.md]

The runs are configs/simulation.yaml with a camera of 640x480, each with its own errors. The
processes are started and have loaded their kernels before the clock runs, as in a long sweep.
Runs a second are this machine's and suffer from its load, which each row tells.
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
import time
from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from navigation.config import Config, load_config
from navigation.run.kernels.warm_up import warm_up
from navigation.sweep.runs import Row, Sweep, run_rows
from navigation.sweep.variations import Variation, variation
from navigation.sweep.workers import local_executor
from tests.support.runs.virtual import CONFIGS, short_config

STATIONS = [{"x_m": 0.20, "y_m": 0.60}, {"x_m": 0.20, "y_m": 1.60}]
RATE_HZ = 30.0
"""Rate of the camera, as in the shipped simulation."""


def timed(config: Config, variations: list[Variation], workers: int) -> tuple[list[Row], float]:
    """The rows by run, and the seconds that the sweep took with its processes ready."""
    with local_executor(workers) as pool:
        list(pool.map(_settle, range(4 * workers)))
        kept: Callable[[], Executor] = lambda: _Kept(pool)  # noqa: E731 - the sweep shuts it down
        begun_s = time.perf_counter()
        rows = list(Sweep(config, variations, kept, workers).rows())
        took_s = time.perf_counter() - begun_s
    return sorted(rows, key=lambda row: row.run), took_s


class _Kept(Executor):
    """A pool that outlives the sweep, so that its end is not timed."""

    def __init__(self, pool: Executor) -> None:
        self.submit = pool.submit  # type: ignore[method-assign]

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Leave it open."""


def _settle(number: int) -> None:
    """Load the program and its kernels: a whole run."""
    config = short_config(STATIONS[:1])
    run_rows(config, variation(config, 1, number))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=16)
    parser.add_argument(
        "--workers", default=",".join(str(n + 1) for n in range(os.cpu_count() or 1))
    )
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    warm_up(load_config(CONFIGS / "simulation.yaml", {}), print)
    config = short_config(STATIONS, camera={"rate_hz": RATE_HZ})
    chosen = [variation(config, 1, run) for run in range(options.runs)]
    lines = [
        "| processes | runs/s | virtual s a second | against 1 process | rows as with 1 | load |",
        "|---|---|---|---|---|---|",
    ]
    alone: tuple[list[Row], float] | None = None
    same = True
    for workers in map(int, options.workers.split(",")):
        load = os.getloadavg()[0]
        rows, took_s = timed(config, chosen, workers)
        alone = alone or (rows, took_s)
        same &= rows == alone[0]
        virtual_s = sum(row.duration_s or 0.0 for row in rows)
        lines.append(
            f"| {workers} | {len(rows) / took_s:.2f} | {virtual_s / took_s:.1f} "
            f"| {alone[1] / took_s:.2f} x | {'yes' if rows == alone[0] else 'no'} | {load:.1f} |"
        )
        print(lines[-1], flush=True)
    if options.output is not None:
        heading = [
            "# Runs a second of a sweep", "",
            f"`python -m benchmarks.sweep --runs {options.runs} --workers {options.workers}`,",
            f"Python {platform.python_version()}, {os.cpu_count()} processors; load: the machine's "
            "when the row began.", "",
        ]  # fmt: skip
        options.output.write_text("\n".join([*heading, *lines]) + "\n", encoding="utf-8")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
