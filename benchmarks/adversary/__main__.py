"""Every attack, judged: the table in benchmarks/results/adversary.md.

    python -m benchmarks.adversary [--only TEXT] [--runs N] [--seed S] [--quick] [--keep FOLDER]

One attack at a time, 15 to 25 seconds each. Ends with 1 where a bar was not held.
"""

from __future__ import annotations

import argparse
import signal
import sys
import time
from pathlib import Path

from benchmarks.adversary.attacks import ATTACKS, QUICK
from benchmarks.adversary.bars import Outcome
from benchmarks.adversary.report import table
from benchmarks.adversary.run import prepare, run_attack

RESULT = Path(__file__).parents[1] / "results" / "adversary.md"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--only", default="", help="attacks whose kind or name contains this")
    parser.add_argument("--runs", type=int, default=1, help="of each attack, each its own seed")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--quick", action="store_true", help="a few representative attacks")
    parser.add_argument("--keep", type=Path, help="leave the folders of all runs there")
    parser.add_argument("--list", action="store_true", help="name the attacks and end")
    options = parser.parse_args()
    attacks = [
        one
        for one in (QUICK if options.quick else ATTACKS)
        if options.only in f"{one.kind}: {one.name}"
    ]
    if options.list or not attacks:
        print("\n".join(f"{one.kind}: {one.name}" for one in ATTACKS))
        return 0 if options.list else 2
    for number in (signal.SIGTERM, signal.SIGHUP):  # a run's processes end with it
        signal.signal(number, _end)
    prepare()
    began_s = time.monotonic()
    runs: list[tuple[str, Outcome]] = []
    for attack in attacks:
        for seed in range(options.seed, options.seed + options.runs):
            keep = options.keep and options.keep / f"{attack.kind} {attack.name} {seed}".replace(
                "/", "-"
            )
            outcome = run_attack(attack, seed, keep)
            runs.append((attack.kind, outcome))
            _tell(attack.kind, outcome)
    command = "python -m benchmarks.adversary" + f" --runs {options.runs}" * (options.runs > 1)
    text = table(runs, time.monotonic() - began_s, command)
    if len(attacks) == len(ATTACKS):
        RESULT.write_text(text)
    print(text)
    return int(any(outcome.failures for _, outcome in runs))


def _end(number: int, _frame: object) -> None:
    raise SystemExit(128 + number)


def _tell(kind: str, outcome: Outcome) -> None:
    held = "held" if not outcome.failures else "NOT HELD: " + "; ".join(outcome.failures)
    stop = "-" if outcome.stop_s is None else f"{outcome.stop_s:.2f}"
    print(
        f"{kind}: {outcome.attack}, seed {outcome.seed}, {outcome.took_s:.0f} s: gap "
        f"{outcome.least_gap_m * 1e3:.0f} mm, stop {stop} s, stood {outcome.stood_s:.2f} s, drove "
        f"{outcome.drove_s:.2f} s, blind {outcome.blind_m:.2f} m; "
        f"{outcome.state}: {outcome.sentence}: {held}",
        flush=True,
    )


if __name__ == "__main__":
    sys.exit(main())
