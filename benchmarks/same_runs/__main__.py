"""Runs in virtual time, kept before a change and compared call by call after it.

    python -m benchmarks.same_runs --keep FILE       # before a change of the code
    python -m benchmarks.same_runs --compare FILE    # after it: each run that has become another
    python -m benchmarks.same_runs --show NAME       # all that happens in one run

``--quick`` takes a sample of about two minutes, ``--only TEXT`` the runs whose name contains it.
A run is the same on one machine only: with another processor or library a number's last bit may
differ. To see what a run did before, show it in a checkout of the old code too, and compare the
two with ``diff``. Ends with 1 where a run differs.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from benchmarks.same_runs.cases import Case, all_cases, sample
from benchmarks.same_runs.kept import Kept, KeptError, machine, play, play_and_compare, read, write
from navigation.machine.child import FRESH, end_with_parent

SEEDS = 20


def main(words: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.same_runs", description=__doc__)
    does = parser.add_mutually_exclusive_group(required=True)
    does.add_argument("--keep", type=Path, metavar="FILE", help="write one line a run there")
    does.add_argument("--compare", type=Path, metavar="FILE", help="play its runs again")
    does.add_argument("--show", metavar="NAME", help="print all that happens in one run")
    does.add_argument("--list", action="store_true", help="name the runs and end")
    parser.add_argument("--seeds", type=int, default=SEEDS, help=f"of each; without it {SEEDS}")
    parser.add_argument("--only", default="", metavar="TEXT", help="runs whose name contains this")
    parser.add_argument("--workers", type=int, default=1, help="runs at a time")
    parser.add_argument("--quick", action="store_true", help="a sample of two minutes")
    options = parser.parse_args(words)
    cases = all_cases(options.seeds)
    cases = [one for one in (sample(cases) if options.quick else cases) if options.only in one.name]
    if options.list:
        print("\n".join(one.name for one in cases))
        return 0
    if options.show is not None:
        return _show(options.show, options.seeds)
    if options.keep is not None:
        began_s = time.monotonic()
        count = write(options.keep, (one for one, _ in _played(cases, {}, options.workers)))
        print(f"{count} runs kept in {options.keep}, {time.monotonic() - began_s:.0f} s")
        return 0
    try:
        return _compare(options.compare, cases, options.workers)
    except KeptError as error:
        print(error, file=sys.stderr)
        return 2


def _show(name: str, seeds: int) -> int:
    for case in all_cases(seeds):
        if case.name == name:
            kept, trace = play(case)
            print("\n".join(str(line) for line in trace.lines))
            print(f"{kept.name}: {kept.state} after {kept.duration_s:.2f} s, {kept.hashes}")
            return 0
    print(f"{name}: no run has this name; --list names them", file=sys.stderr)
    return 2


def _compare(file: Path, cases: Sequence[Case], workers: int) -> int:
    kept_on, before = read(file)
    if kept_on != machine():
        print(f"kept with {kept_on}, played with {machine()}: last bits may differ")
    chosen = [one for one in cases if one.name in before]
    differ = 0
    for _, words in _played(chosen, before, workers):
        differ += bool(words)
        if words:
            print("\n".join(words), flush=True)
    print(f"{len(chosen)} runs compared, {differ} differ")
    if len(chosen) < len(cases):
        print(f"{len(cases) - len(chosen)} runs are not in {file}: not compared")
    return int(differ > 0 or not chosen)


def _played(
    cases: Sequence[Case], before: dict[str, Kept], workers: int
) -> Iterator[tuple[Kept, list[str]]]:
    """Each run, in the order of the cases, and how it differs from the one before."""
    one_of = partial(play_and_compare, before)
    if workers <= 1:
        yield from map(one_of, cases)
        return
    with ProcessPoolExecutor(workers, mp_context=FRESH, initializer=end_with_parent) as pool:
        yield from pool.map(one_of, cases)


if __name__ == "__main__":
    sys.exit(main())
