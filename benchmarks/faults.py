"""The complete fault matrix: every scenario over many seeds, as a table.

    python -m benchmarks.faults [--seeds 20] [--c-seeds 5] [--only TEXT]

Runs in virtual time, on the Python twin and on the C firmware built for this machine, and
writes benchmarks/results/faults.md. A run counts as passed when the
waypoints that the robot executed are the mission's, in order, none doubled, or when the robot
stopped and the host said why, where the fault leaves no other way. Ends with 1 where one did
not pass.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from pathlib import Path

from tests.support.c_robot import CRobot, missing_tool
from tests.support.fault_scenarios import SCENARIOS, robot_maker

RESULT = Path(__file__).parent / "results" / "faults.md"


def run_scenario(name: str, seeds: range) -> tuple[Counter[str], list[str]]:
    """Outcomes counted, and a line for each run that failed."""
    outcomes: Counter[str] = Counter()
    failures = []
    for seed in seeds:
        try:
            outcomes[SCENARIOS[name](seed)] += 1
        except AssertionError as error:
            failures.append(f"{name}, seed {seed}: {error}")
    return outcomes, failures


def run_all(robot: str, names: list[str], seeds: range) -> tuple[list[str], list[str]]:
    """Table rows and failures of all scenarios on one kind of robot."""
    rows, failures = [], []
    for name in names:
        outcomes, failed = run_scenario(name, seeds)
        failures += [f"{robot}: {line}" for line in failed]
        told = "; ".join(f"{count} x {what}" for what, count in outcomes.most_common())
        rows.append(f"| {name} | {robot} | {len(seeds)} | {len(seeds) - len(failed)} | {told} |")
        print(rows[-1], flush=True)
    return rows, failures


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--c-seeds", type=int, default=5)
    parser.add_argument("--only", default="", help="scenarios whose name contains this")
    options = parser.parse_args()
    names = [name for name in SCENARIOS if options.only in name]
    began_s = time.perf_counter()
    rows, failures = run_all("Python", names, range(options.seeds))
    if missing_tool() is None:
        token = robot_maker.set(lambda identity, drive: CRobot(identity, drive))  # type: ignore[arg-type,return-value]
        more, failed = run_all("C", names, range(100, 100 + options.c_seeds))
        robot_maker.reset(token)
        rows, failures = rows + more, failures + failed
    else:
        print(f"without {missing_tool()} there is no C firmware to run", file=sys.stderr)
    took_s = time.perf_counter() - began_s
    total = len(names) * (options.seeds + options.c_seeds)
    text = [
        "# Faults of the serial link",
        "",
        f"{len(names)} scenarios in virtual time, {options.seeds} seeds on the Python twin and "
        f"{options.c_seeds} on the C firmware: {total - len(failures)} of {total} passed, "
        f"{took_s:.0f} s.",
        "Passed: the waypoints executed are those sent, in order, nothing lost or doubled; or,",
        "where the fault leaves no other way, the robot stopped and the host said why.",
        "",
        "`python -m benchmarks.faults` makes this table again.",
        "",
        "| fault | robot | runs | passed | what happened |",
        "|---|---|---|---|---|",
        *rows,
    ]
    if failures:
        text += ["", "## Not passed", "", *[f"- {line}" for line in failures]]
    if not options.only and missing_tool() is None:
        RESULT.write_text("\n".join(text) + "\n")
    print("\n".join(failures), file=sys.stderr)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
