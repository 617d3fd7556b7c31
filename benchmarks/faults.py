"""The complete fault matrix: every scenario over many seeds, as a table.

    python -m benchmarks.faults [--seeds 20] [--c-seeds 5] [--avr-seeds 5] [--only TEXT] [--jobs N]

Runs in virtual time, on the Python robot, on the C firmware built for this machine, and on its
AVR binary on an emulated ATmega328P, and writes benchmarks/results/faults.md. A run counts as
passed when the waypoints that the robot executed are the mission's, in order, none doubled, or
when the robot stopped and the host said why, where the fault leaves no other way. Ends with 1
where one did not pass.
"""

from __future__ import annotations

import argparse
import functools
import multiprocessing
import os
import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.support.robots import avr_robot, c_robot
from tests.support.robots.avr_firmware import AvrBoard
from tests.support.wire.fault_scenarios import SCENARIOS, robot_maker

RESULT = Path(__file__).parent / "results" / "faults.md"


@dataclass(frozen=True, slots=True)
class Run:
    """One scenario with one seed on one kind of robot, and its outcome or what went wrong."""

    name: str
    robot: str
    seed: int
    outcome: str = ""
    failure: str = ""


@functools.cache
def avr_build() -> avr_robot.AvrRobot:
    """The firmware and its emulator, built once a process."""
    return avr_robot.AvrRobot()


@contextmanager
def robot(kind: str) -> Iterator[None]:
    """The scenarios inside run on that kind of robot."""
    if kind == "Python":
        yield
        return
    board = AvrBoard(avr_build()) if kind == "AVR" else None
    maker = board or (lambda identity, drive: c_robot.CRobot(identity, drive))
    token = robot_maker.set(maker)  # type: ignore[arg-type]
    try:
        yield
    finally:
        robot_maker.reset(token)
        if board is not None:
            board.close()


def run_one(run: Run) -> Run:
    """The run with what came of it."""
    with robot(run.robot):
        try:
            return Run(run.name, run.robot, run.seed, outcome=SCENARIOS[run.name](run.seed))
        except Exception as error:  # noqa: BLE001 - whatever it is, the run has not passed
            told = " ".join(f"{type(error).__name__} {error}".split())
            return Run(run.name, run.robot, run.seed, failure=told[:300])


def row(name: str, kinds: list[str], done: list[Run]) -> str:
    """The table's row of one fault: passed of tried on each robot, and what happened on all."""
    cells = []
    for kind in kinds:
        tried = [run for run in done if (run.name, run.robot) == (name, kind)]
        cells.append(f"{sum(not run.failure for run in tried)}/{len(tried)}")
    tried = [run for run in done if run.name == name]
    outcomes = Counter(run.outcome for run in tried if not run.failure)
    cells += [str(len(tried)), str(sum(not run.failure for run in tried))]
    told = "; ".join(f"{count} x {what}" for what, count in outcomes.most_common())
    return f"| {name} | {' | '.join(cells)} | {told} |"


def table(kinds: list[str], done: list[Run], took_s: float) -> str:
    """The result as Markdown."""
    names = [name for name in SCENARIOS if any(run.name == name for run in done)]
    failed = [run for run in done if run.failure]
    text = [
        "# Faults of the serial link",
        "",
        f"{len(names)} scenarios in virtual time, each over several seeds: "
        f"{len(done) - len(failed)} of {len(done)} runs passed, {took_s:.0f} s.",
        "Passed: the waypoints executed are those sent, in order, nothing lost or doubled; or,",
        "where the fault leaves no other way, the robot stopped and the host said why.",
        "Python: the simulated robot, every executed waypoint seen. C: the firmware in this",
        "machine's code, judged by its chain's CRC. AVR: its binary on an emulated ATmega328P at",
        "115200 baud, judged by the chain's CRC in every one of its reports, and by its motors.",
        "",
        "`python -m benchmarks.faults` makes this table again.",
        "",
        f"| fault | {' | '.join(kinds)} | runs | passed | what happened |",
        f"|---|{'---|' * len(kinds)}---|---|---|",
        *[row(name, kinds, done) for name in names],
    ]
    if failed:
        lines = [f"- {run.robot}, {run.name}, seed {run.seed}: {run.failure}" for run in failed]
        text += ["", "## Not passed", "", *lines]
    return "\n".join(text) + "\n"


def planned(options: argparse.Namespace) -> Iterable[Run]:
    """The slow ones first, so that no processor waits for the last of them."""
    names = [name for name in SCENARIOS if options.only in name]
    seeds = {
        "AVR": range(200, 200 + options.avr_seeds),
        "C": range(100, 100 + options.c_seeds),
        "Python": range(options.seeds),
    }
    missing = {"AVR": avr_robot.missing_tools(), "C": c_robot.missing_tool(), "Python": None}
    for kind, numbers in seeds.items():
        if missing[kind] is not None:
            print(f"without {missing[kind]} there is no {kind} robot to run", file=sys.stderr)
            continue
        yield from (Run(name, kind, seed) for name in names for seed in numbers)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--c-seeds", type=int, default=5)
    parser.add_argument("--avr-seeds", type=int, default=5)
    parser.add_argument("--only", default="", help="scenarios whose name contains this")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    began_s = time.perf_counter()
    runs, done = list(planned(options)), []
    with multiprocessing.get_context("spawn").Pool(options.jobs) as pool:
        for run in pool.imap_unordered(run_one, runs):
            done.append(run)
            told = f"NOT PASSED: {run.failure}" if run.failure else run.outcome
            print(
                f"{len(done)}/{len(runs)} {run.robot}, {run.name}, {run.seed}: {told}", flush=True
            )
    kinds = [kind for kind in ("Python", "C", "AVR") if any(run.robot == kind for run in done)]
    text = table(kinds, sorted(done, key=lambda run: run.seed), time.perf_counter() - began_s)
    if not options.only and len(kinds) == 3:
        RESULT.write_text(text)
    print(text)
    return int(any(run.failure for run in done))


if __name__ == "__main__":
    sys.exit(main())
