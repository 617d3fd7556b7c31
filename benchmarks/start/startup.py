"""From a fresh environment with the wheel to the first plan and the first metre driven.

    python -m benchmarks.start.startup dist/clearway-*.whl [--limits]

Installs the wheel into an environment of its own, with nothing compiled, and prints the seconds of
the first ``clearway plan``, of later ones, of ``clearway --help``, and from ``clearway run`` to a
driving robot; each beside what is wanted of it. ``--limits``: the exit code is 1 where a first
start takes so long that it must have compiled.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import venv
from collections.abc import Sequence
from pathlib import Path

TOP = Path(__file__).parents[2]
SCENE = TOP / "tests" / "golden" / "square.txt"
PLAN = ("plan", SCENE.name, "--start", "10,10", "--goal", "90,90", "--radius", "3")
MANUAL = Path("share/man/man1/clearway.1")
REPEATS = 5
COMPILED_S = 20.0
"""A first start that takes longer has compiled kernels, on whatever machine."""
DRIVING = re.compile(rb" s  driving\b")
GIVE_UP_S = 900.0


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("wheel", type=Path)
    parser.add_argument("--limits", action="store_true", help="fail where a start has compiled")
    options = parser.parse_args(argv)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        clearway = install(options.wheel, folder)
        shutil.copy(SCENE, folder)
        first_plan_s = seconds(clearway, PLAN, folder)
        rows = [
            ("wheel, MB", options.wheel.stat().st_size / 1e6, 40.0),
            ("first clearway plan, s", first_plan_s, 3.0),
            ("clearway plan, s", median(clearway, PLAN, folder), 0.6),
            ("clearway --help, s", median(clearway, ("--help",), folder), 0.15),
            ("clearway run to driving, s", seconds_to_driving(clearway, folder), 15.0),
        ]
    print(f"{'what':30} {'measured':>9} {'wanted':>7}")
    for what, measured, wanted in rows:
        print(f"{what:30} {measured:9.2f} {wanted:7.2f}")
    return int(options.limits and max(rows[1][1], rows[4][1]) > COMPILED_S)


def install(wheel: Path, folder: Path) -> Path:
    """A fresh environment with the wheel and what it needs; its program ``clearway``."""
    venv.create(folder / "venv", with_pip=True)
    pip: list[str | Path] = [
        folder / "venv" / "bin" / "python",
        "-m",
        "pip",
        "--disable-pip-version-check",
    ]
    subprocess.run([*pip, "install", "--quiet", wheel.resolve()], check=True)
    if not (folder / "venv" / MANUAL).exists():
        raise SystemExit(f"{wheel}: must install {MANUAL}")
    return folder / "venv" / "bin" / "clearway"


def environment() -> dict[str, str]:
    """This process's, without what would lead to other kernels."""
    return {name: text for name, text in os.environ.items() if not name.startswith("NUMBA_")}


def seconds(clearway: Path, arguments: Sequence[str], folder: Path) -> float:
    """Wall time of one command."""
    begin_s = time.perf_counter()
    subprocess.run(
        [clearway, *arguments],
        cwd=folder,
        env=environment(),
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return time.perf_counter() - begin_s


def median(clearway: Path, arguments: Sequence[str], folder: Path) -> float:
    """Wall time of a command, the median of some runs."""
    return statistics.median(seconds(clearway, arguments, folder) for _ in range(REPEATS))


def seconds_to_driving(clearway: Path, folder: Path) -> float:
    """From the start of a simulated run to its first line that says that the robot drives."""
    shutil.copytree(TOP / "configs", folder / "configs")
    begin_s = time.perf_counter()
    with subprocess.Popen(
        [clearway, "run", "configs/simulation.yaml", "--once", "--no-dashboard"],
        cwd=folder,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    ) as process:
        assert process.stdout is not None
        told = []
        for line in process.stdout:
            told.append(line)
            if DRIVING.search(line):
                took_s = time.perf_counter() - begin_s
                process.terminate()
                process.stdout.read()
                return took_s
    raise SystemExit(f"clearway run never drove: {b''.join(told).decode()}")


if __name__ == "__main__":
    sys.exit(main())
