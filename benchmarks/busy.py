"""Simulated runs beside a busy computer: how many are done, false alarms, and how long they take.

    python -m benchmarks.busy                    # fleet 20 times, three more 5 times each
    python -m benchmarks.busy fleet --times 3    # one configuration of configs/
    python -m benchmarks.busy --loops 0          # nothing beside it

Each run is `clearway run configs/NAME.yaml --once`, as a user starts it, beside so many processes
that compute without a pause. Times are this machine's.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tests.support.processes.busy import busy

CONFIGS = Path(__file__).parents[1] / "configs"
PROGRAM = [sys.executable, "-c", "from navigation.cli.main import main; main()", "run"]
TIMES = {"fleet": 20, "simulation": 5, "two_cameras": 5, "crossing": 5}
LONGEST_S = 900.0
ALARM = re.compile(r"runs away|does not come|was carried|stands still|did not report")
"""In a run in which nothing happens, each of these would be the busy computer's doing."""


def drive(name: str, folder: Path) -> tuple[dict[str, Any], list[str], float]:
    """Report of one run of a configuration, its false alarms, and the wall's seconds it took."""
    report = folder / "report.json"
    began_s = time.monotonic()
    said = subprocess.run(
        [*PROGRAM, str(CONFIGS / f"{name}.yaml"), "--once", "--no-dashboard",
         "--socket", str(folder / "c.sock"), "--report", str(report)],
        capture_output=True, text=True, timeout=LONGEST_S,
        env={
            **os.environ,
            "CLEARWAY_RECORDING__RUNS_DIR": str(folder),
            "XDG_STATE_HOME": str(folder),
        },
    )  # fmt: skip
    took_s = time.monotonic() - began_s
    alarms = [line.strip() for line in said.stdout.splitlines() if ALARM.search(line)]
    if not report.exists():
        why = said.stdout[-300:] + said.stderr[-300:]
        return {"state": "no report", "reason": why}, alarms, took_s
    found: dict[str, Any] = json.loads(report.read_text())
    return found, alarms, took_s


def measure(name: str, times: int) -> bool:
    """Run a configuration so many times; whether all runs were done without a false alarm."""
    states, spent, alarmed = [], [], 0
    for number in range(times):
        with tempfile.TemporaryDirectory() as folder:
            report, alarms, took_s = drive(name, Path(folder))
        states.append(report["state"])
        spent.append(took_s)
        alarmed += bool(alarms)
        told_s = report.get("duration_s") or 0.0
        print(
            f"  {name} {number}: {report['state']}, {told_s:.1f} s of its own time, "
            f"{took_s:.1f} s of the wall's: {report['reason']}",
            flush=True,
        )
        for alarm in alarms:
            print(f"    {alarm}", flush=True)
    done = states.count("done")
    print(
        f"{name}: {done} of {times} done, {alarmed} with a false alarm, "
        f"median {statistics.median(spent):.1f} s",
        flush=True,
    )
    return done == times and not alarmed


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit 1 where a run was not done, or had a false alarm."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("names", nargs="*", default=[], help="configurations of configs/")
    parser.add_argument("--times", type=int, help="runs of each")
    parser.add_argument("--loops", type=int, default=2, help="busy processes beside it (2)")
    told = parser.parse_args(arguments)
    with busy(told.loops):
        results = [measure(name, told.times or TIMES.get(name, 5)) for name in told.names or TIMES]
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main())
