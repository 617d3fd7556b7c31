"""Counts violations of zones in random runs, and times a zone from its drawing to the new plan.

python -m benchmarks.zones [--runs N] [--first SEED]
"""

from __future__ import annotations

import argparse
import statistics
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from benchmarks.zones.drawn import crowded, drawn_to_planned_s, laboratory
from benchmarks.zones.random_runs import JudgedRun, judged_run

COUNT = 60
"""Zones drawn for a time."""


def main() -> None:
    """Print both figures."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.zones")
    parser.add_argument("--runs", type=int, default=300)
    parser.add_argument("--first", type=int, default=0, help="seed of the first run")
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    for name, scene, ends in (
        ("laboratory", laboratory(), (0.2, 0.2, 2.2, 1.6)),
        ("100 obstacles", crowded(1), (0.3, 0.3, 7.7, 5.7)),
    ):
        ms = sorted(1e3 * one for one in drawn_to_planned_s(scene, ends, COUNT, 1))
        print(
            f"drawn to planned, {name}: median {statistics.median(ms):.1f} ms,"
            f" 95 % {ms[int(0.95 * len(ms))]:.1f} ms, longest {ms[-1]:.1f} ms (bar 100)",
            flush=True,
        )
    seeds = range(given.first, given.first + given.runs)
    with ProcessPoolExecutor(given.processes, get_context("spawn")) as pool:
        runs = list(pool.map(judged_run, seeds))
    print(_summary(runs))


def _summary(runs: list[JudgedRun]) -> str:
    robots, arrived = sum(one.robots for one in runs), sum(one.arrived for one in runs)
    kinds = Counter(zone.kind for one in runs for zone in one.zones)
    broken = [(one.seed, each) for one in runs for each in one.violations]
    lines = [
        f"{len(runs)} runs, {robots} robots, {arrived} at their goals (the others were refused)",
        "zones: " + ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items())),
        f"violations: {len(broken)} (bar 0)",
        *(f"  seed {seed}: {each}" for seed, each in broken),
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    main()
