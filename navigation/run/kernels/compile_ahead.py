"""Compile every kernel into a folder that a wheel carries.

    NUMBA_CPU_NAME=x86-64-v3 python -m navigation.run.kernels.compile_ahead FOLDER

``.ci/compile-wheel`` calls this for each processor.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Collection
from pathlib import Path

from numba.extending import is_jitted

from navigation.machine.child import start_child
from navigation.run.kernels.compiling import compile_parts
from navigation.run.kernels.rehearsal import rehearse_eye, rehearse_planner
from planner.shared.kernel_locator import (
    CONFIG,
    PACKAGES,
    ROOT,
    cache_folder,
    loaded_files,
    write_label,
)


def main(folder: Path, known: Path | None) -> int:
    """Fill the folder; return the exit code. ``known``: a checkout with reusable kernels."""
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
        used = set()
        for part, (work, _) in parts.items():
            kept = Path(cache) / f"{part}.used"
            child = start_child(note_what_is_loaded, work, kept)
            child.join()
            if child.exitcode != 0:
                print(f"{part}: the kernels could not be loaded", file=sys.stderr)
                return 1
            used |= {Path(name) for name in kept.read_text(encoding="utf-8").splitlines()}
        keep_only(used, cache_folder(ROOT))
        write_label(cache_folder(ROOT))
        shutil.copytree(cache_folder(ROOT), folder, dirs_exist_ok=True)
    return 0


def copy_kernels(checkout: Path) -> None:
    """Copy kernels from beside a checkout's sources; numba checks whether they fit."""
    for package in PACKAGES:
        for kept in (checkout / package).rglob("__pycache__/*.nb[ci]"):
            folder = cache_folder(ROOT / kept.parent.parent.relative_to(checkout))
            folder.mkdir(parents=True, exist_ok=True)
            shutil.copy2(kept, folder)


def note_what_is_loaded(work: Callable[[], None], into: Path) -> None:
    """Do the work from the compiled kernels, and list the files that it loads.

    Kernels called only by kernels are compiled into those: their own files are never opened.
    """
    work()
    files = []
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] in PACKAGES:
            for kernel in list(vars(module).values()):
                if is_jitted(kernel) and kernel.py_func.__module__ == name:
                    files += loaded_files(kernel)
    into.write_text("\n".join(map(str, files)), encoding="utf-8")


def keep_only(used: Collection[Path], folder: Path) -> None:
    """Remove all compiled code but the named files, and the indices left without any."""
    for code in folder.rglob("*.nbc"):
        if code not in used:
            code.unlink()
    for index in folder.rglob("*.nbi"):
        if not any(index.parent.glob(f"{index.stem}.*.nbc")):
            index.unlink()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--known", type=Path)
    options = parser.parse_args()
    sys.exit(main(options.folder, options.known))
