"""One run played, the line that is kept of it, and the comparison with a line kept before."""

from __future__ import annotations

import json
import platform
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

import cv2
import numba
import numpy as np

from benchmarks.same_runs.cases import NO_TROUBLE, Case
from benchmarks.same_runs.program import run
from benchmarks.same_runs.script import Script
from benchmarks.same_runs.trace import PARTS, Trace, first_difference
from benchmarks.same_runs.troubles import TROUBLES

LINGER_S: Final = 6.0
"""A mission that a stop has ended is resumed within this time."""
LONGEST_LINE: Final = 200
"""The length at which a line is cut where it is shown; `--show` prints it whole."""


class KeptError(ValueError):
    """A file of kept runs cannot be read; the message says why."""


@dataclass(frozen=True, slots=True)
class Kept:
    """The record of a run: ``hashes`` by part; ``by_block`` finds the first difference."""

    name: str
    state: str
    duration_s: float
    hashes: dict[str, str]
    by_block: str

    def line(self) -> str:
        """The record as one line of JSON."""
        return json.dumps(asdict(self))


def play(case: Case) -> tuple[Kept, Trace]:
    """Drive one run."""
    cv2.setNumThreads(1)  # no sum may depend on how many cores there are
    config, trouble, rng, trace = case.prepared(), TROUBLES[case.trouble], case.chance(), Trace()
    robot = rng.randrange(len(config.robots) or 1)
    script = Script(trouble.steps, robot, rng, trace)
    linger_s = 0.0 if case.trouble == NO_TROUBLE else LINGER_S
    end = run(config, trace, script.look, linger_s=linger_s, pictures=case.pictures)
    hashes = trace.hashes()
    return Kept(case.name, end.state, end.duration_s, hashes, trace.by_block()), trace


def play_and_compare(before: Mapping[str, Kept], case: Case) -> tuple[Kept, list[str]]:
    """Drive one run; how it differs from the one of its name that was kept before."""
    now, trace = play(case)
    kept = before.get(case.name)
    return now, [] if kept is None else differences(kept, now, trace)


def machine() -> dict[str, str]:
    """What a run's last bit may depend on besides the program."""
    return {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "numba": numba.__version__,
        "opencv": cv2.__version__,
        "processor": platform.processor() or platform.machine(),
    }


def write(file: Path, runs: Iterable[Kept]) -> int:
    """Keep runs in a file, as they come; the number of them."""
    count = 0
    with file.open("w") as out:
        out.write(json.dumps({"machine": machine()}) + "\n")
        for one in runs:
            out.write(one.line() + "\n")
            out.flush()
            count += 1
    return count


def read(file: Path) -> tuple[dict[str, str], dict[str, Kept]]:
    """The machine and the runs by name that a file keeps; ``KeptError``."""
    try:
        first, *lines = file.read_text().splitlines()
        runs = [Kept(**json.loads(line)) for line in lines]
        return json.loads(first)["machine"], {one.name: one for one in runs}
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise KeptError(f"{file}: {error}: not a file that --keep wrote") from None


def differences(before: Kept, now: Kept, trace: Trace) -> list[str]:
    """What differs, and what happens now where they part; empty where nothing differs."""
    parts = [part for part in PARTS if before.hashes.get(part) != now.hashes.get(part)]
    if not parts:
        return []
    found = [f"{now.name}: {', '.join(parts)} differ: {_end(before)} before, {_end(now)} now"]
    block = first_difference(before.by_block, now.by_block)
    if block is not None:
        found.append("  one of these is the first:")
        found += [f"    {line}"[:LONGEST_LINE] for line in trace.of_block(block)]
    return found


def _end(one: Kept) -> str:
    return f"{one.state} after {one.duration_s:.2f} s"
