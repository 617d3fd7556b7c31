"""Plans where everything touches: scenes on a grid of seven by seven, each path measured apart.

    python benchmarks/grid_scenes.py [--scenes 100000] [--first 0] [--minutes 0]
        [--output benchmarks/results/grid_scenes.md]

Two to six records of every kind, radii from 0.05 to 1, stations on a grid of eighths, with two
alternatives. Counted are plans that take more than a second of processor time, exceptions, paths
nearer than the radius, clearances other than numpy's own, and stations within a solid.
"""

from __future__ import annotations

import argparse
import platform
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.support.scenes.grid_scenes import SLOWEST_S, Tally, judge


def report(tally: Tally, first: int) -> str:
    return "\n".join(
        [
            "# Plans where everything touches",
            "",
            f"`python benchmarks/grid_scenes.py --scenes {tally.scenes} --first {first}`, Python "
            f"{platform.python_version()}, {platform.machine()}.",
            "",
            f"| scenes | plans | paths | slowest, ms | beyond {SLOWEST_S:g} s | exceptions "
            "| below the radius | wrong clearance | within a solid | bounds reached |",
            "|---|---|---|---|---|---|---|---|---|---|",
            f"| {tally.scenes} | {tally.plans} | {tally.paths} | {1e3 * tally.slowest_s:.0f} "
            f"| {len(tally.hangs)} | {len(tally.exceptions)} | {len(tally.below)} "
            f"| {len(tally.wrong)} | {len(tally.in_solid)} | {tally.bounded} |",
            "",
        ]
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=100_000)
    parser.add_argument("--first", type=int, default=0, help="the first scene's seed")
    parser.add_argument("--minutes", type=float, default=0.0, help="stop after so many; 0: never")
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    for seed in range(20):  # compiles
        judge(seed, Tally())
    tally = Tally()
    begun_s = time.monotonic()
    for seed in range(options.first, options.first + options.scenes):
        faults = tally.faults
        judge(seed, tally)
        if tally.faults > faults or tally.scenes % 1000 == 0:
            print(f"seed {seed}: {tally}", file=sys.stderr, flush=True)
        if options.minutes and time.monotonic() - begun_s > 60.0 * options.minutes:
            break
    text = report(tally, options.first)
    print(text)
    if options.output:
        options.output.parent.mkdir(parents=True, exist_ok=True)
        options.output.write_text(text, encoding="utf-8")
    sys.exit(tally.faults > 0)


if __name__ == "__main__":
    main()
