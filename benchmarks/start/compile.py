"""How long the kernels take to compile on a machine that has none.

    python -m benchmarks.start.compile [--kernels 20]

Compiles what the warm-up compiles, eye and planner in a process each as it does, into a folder
that is thrown away, and prints wall and processor time. ``--kernels`` lists those that took
longest themselves, without the kernels that they call. One process after the other: each figure
is what it takes alone, and the wall time on two processors is the longer one's.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

CONFIG = Path("configs/simulation.yaml")
PARTS = ("eye", "planner")


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kernels", type=int, default=0, help="the slowest so many, by themselves")
    parser.add_argument("--part", choices=PARTS, help=argparse.SUPPRESS)
    options = parser.parse_args(argv)
    if options.part:
        print(json.dumps(_compile(options.part)))
        return 0
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for part in PARTS:
            command = [sys.executable, "-m", "benchmarks.start.compile", "--part", part]
            environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
            done = subprocess.run(command, env=environment, capture_output=True, check=True)
            found = json.loads(done.stdout)
            names = [name for name, _ in found["kernels"]]
            print(
                f"{part:8} {len(set(names)):4} kernels for {len(names):4} combinations of types"
                f"   {found['wall_s']:6.1f} s wall   {found['processor_s']:6.1f} s processor time",
                flush=True,
            )
            rows += [(seconds, part, name) for name, seconds in found["kernels"]]
    for seconds, part, name in sorted(rows, reverse=True)[: options.kernels]:
        print(f"{seconds:8.2f} s  {part:8} {name}")
    return 0


def _compile(part: str) -> dict[str, Any]:
    """Compile one part here and time every kernel, without those that it calls."""
    from numba.core import event  # documented: numba's manual for developers, "Event API"

    from navigation.config import load_config
    from navigation.run.kernels.compiling import RARELY
    from navigation.run.kernels.warm_up import compile_eye, compile_planner

    gc.set_threshold(*RARELY)  # as in the processes that compile
    begin_s, begin_processor_s = time.perf_counter(), time.process_time()
    with event.install_recorder("numba:compile") as recorder:
        if part == "eye":
            compile_eye(load_config(CONFIG))
        else:
            compile_planner()
    return {
        "wall_s": time.perf_counter() - begin_s,
        "processor_s": time.process_time() - begin_processor_s,
        "kernels": _own_times(recorder.buffer),
    }


def _own_times(records: Sequence[tuple[float, Any]]) -> list[tuple[str, float]]:
    """Seconds of each compilation in turn, less those of the compilations within it."""
    open_ones: list[list[float]] = []  # begin, seconds within
    found = []
    for moment_s, record in records:
        if record.is_start:
            open_ones.append([moment_s, 0.0])
            continue
        begin_s, within_s = open_ones.pop()
        took_s = moment_s - begin_s
        if open_ones:
            open_ones[-1][1] += took_s
        function = record.data["dispatcher"].py_func
        found.append((f"{function.__module__}.{function.__name__}", took_s - within_s))
    return found


if __name__ == "__main__":
    sys.exit(main())
