"""The complete fault matrix: every scenario over many seeds, as a table.

    python -m benchmarks.faults [--seeds 20] [--only TEXT]

Runs in virtual time and writes benchmarks/results/faults.md. A run counts as passed when the
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

from tests.support.fault_scenarios import SCENARIOS

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


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--only", default="", help="scenarios whose name contains this")
    options = parser.parse_args()
    names = [name for name in SCENARIOS if options.only in name]
    rows, failures = [], []
    began_s = time.perf_counter()
    for name in names:
        outcomes, failed = run_scenario(name, range(options.seeds))
        failures += failed
        told = "; ".join(f"{count} x {what}" for what, count in outcomes.most_common())
        passed = options.seeds - len(failed)
        rows.append(f"| {name} | {options.seeds} | {passed} | {told} |")
        print(rows[-1], flush=True)
    took_s = time.perf_counter() - began_s
    total = len(names) * options.seeds
    text = [
        "# Faults of the serial link",
        "",
        f"{len(names)} scenarios x {options.seeds} seeds on the Python twin in virtual time, "
        f"{total - len(failures)} of {total} passed, {took_s:.0f} s.",
        "Passed: the waypoints executed are those sent, in order, nothing lost or doubled; or,",
        "where the fault leaves no other way, the robot stopped and the host said why.",
        "",
        "`python -m benchmarks.faults` makes this table again.",
        "",
        "| fault | runs | passed | what happened |",
        "|---|---|---|---|",
        *rows,
    ]
    if failures:
        text += ["", "## Not passed", "", *[f"- {line}" for line in failures]]
    if not options.only:
        RESULT.write_text("\n".join(text) + "\n")
    print("\n".join(failures), file=sys.stderr)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
