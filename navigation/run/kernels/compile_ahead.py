"""Compile every kernel into a folder that a wheel carries.

    NUMBA_CPU_NAME=x86-64-v3 python -m navigation.run.kernels.compile_ahead FOLDER

``.ci/compile-wheel`` calls this for each processor; what it makes is described in
``planner.shared.kernel_locator``.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
from pathlib import Path

from navigation.run.kernels.compiling import compile_parts
from navigation.run.kernels.rehearsal import rehearse_eye, rehearse_planner
from planner.shared.kernel_locator import (
    CONFIG,
    PACKAGES,
    ROOT,
    cache_folder,
    read_index,
    write_label,
)


def main(folder: Path, known: Path | None) -> int:
    """Fill the folder; the exit code. ``known`` is a checkout with kernels that may be of use."""
    processor = os.environ.get("NUMBA_CPU_NAME")
    if not processor:
        print("NUMBA_CPU_NAME: must name the processor to compile for", file=sys.stderr)
        return 2
    parts = {"eye": (rehearse_eye, ()), "planner": (rehearse_planner, ())}
    with tempfile.TemporaryDirectory() as cache:
        os.environ["NUMBA_CACHE_DIR"] = cache  # for the processes that compile
        CONFIG.CACHE_DIR = cache
        if known is not None:
            copy_kernels(known)
        for progress in compile_parts(parts):
            if progress.failed:
                print(f"{', '.join(progress.failed)}: not compiled", file=sys.stderr)
                return 1
        print(f"{processor}: {progress.done} kernels compiled, {progress.passed_s:.0f} s")
        drop_other_processors(cache_folder(ROOT), processor)
        write_label(cache_folder(ROOT))
        shutil.copytree(cache_folder(ROOT), folder, dirs_exist_ok=True)
    return 0


def copy_kernels(checkout: Path) -> None:
    """Take over what lies beside the sources of a checkout; numba checks whether it fits."""
    for package in PACKAGES:
        for kept in (checkout / package).rglob("__pycache__/*.nb[ci]"):
            folder = cache_folder(ROOT / kept.parent.parent.relative_to(checkout))
            folder.mkdir(parents=True, exist_ok=True)
            shutil.copy2(kept, folder)


def drop_other_processors(folder: Path, processor: str) -> None:
    """Leave what was compiled for one processor from these sources; the rest is of no use."""
    for index in folder.rglob("*.nbi"):
        kept = read_index(index, processor)
        for code in index.parent.glob(f"{index.stem}.*.nbc"):
            if code.name not in kept:
                code.unlink()
        if not kept:
            index.unlink()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--known", type=Path)
    options = parser.parse_args()
    sys.exit(main(options.folder, options.known))
