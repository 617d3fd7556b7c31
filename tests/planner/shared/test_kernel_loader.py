"""Compiled kernels are loaded without making numba ready to compile, and can still be built on."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from planner.shared import kernel_loader
from planner.shared.kernel_locator import ROOT

READY_TO_COMPILE = "numba.np.arraymath"
"""One of the modules that numba imports before it compiles."""

DISTANCES = """
import sys
import numpy as np
from planner.scene.primitive_kernels import CIRCLE, POINT, SEGMENT, distance

kind = np.array([POINT, SEGMENT, CIRCLE], np.uint8)
data = np.array([[1.0, 2, 0, 0, 0], [0, 0, 4, 0, 0], [5, 5, 2, 0, 0]])
found = [distance(kind, data, i, 3.0, 4.0) for i in range(3)]
"""


def run(code: str, cache: Path) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        cwd=ROOT,
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache)},
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache that holds the kernel ``distance``."""
    cache = tmp_path_factory.mktemp("cache")
    told = run(f"{DISTANCES}print({READY_TO_COMPILE!r} in sys.modules)", cache)
    assert told == "True\n"  # it was compiled
    return cache


def test_a_compiled_kernel_is_loaded_without_what_compiling_needs(compiled: Path) -> None:
    told = run(f"{DISTANCES}print({READY_TO_COMPILE!r} in sys.modules, found)", compiled)
    assert told == "False [2.8284271247461903, 4.0, 0.2360679774997898]\n"


def test_a_kernel_compiled_later_calls_one_that_was_loaded(compiled: Path) -> None:
    build_on_it = """
from numba import njit
from planner.scene.compile_options import BORROWING

@njit(**{**BORROWING, "cache": False})
def nearest(kind, data, x, y):
    best = np.inf
    for i in range(len(kind)):
        best = min(best, distance(kind, data, i, x, y))
    return best

assert sum(distance.stats.cache_hits.values()) == 1, distance.stats
assert nearest(kind, data, 3.0, 4.0) == min(found)
"""
    run(DISTANCES + build_on_it, compiled)


def test_functions_of_others_are_loaded_as_numba_loads_them(tmp_path: Path) -> None:
    (tmp_path / "strange.py").write_text(
        "from numba import njit\n\n@njit(cache=True)\ndef add(a, b):\n    return a + b\n"
    )
    code = f"""
import sys; sys.path.insert(0, {str(tmp_path)!r})
import planner.scene.compile_options
from strange import add
assert add(1, 2) == 3
[compiled] = add.overloads.values()
print(sum(add.stats.cache_hits.values()), type(compiled.library).__name__)
"""
    assert run(code, tmp_path / "cache") == "0 JITCodeLibrary\n"
    assert run(code, tmp_path / "cache") == "1 JITCodeLibrary\n"


def test_a_numba_that_lacks_what_is_used_loads_as_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    usual = kernel_loader.caching.FunctionCache.load_overload
    monkeypatch.setattr(kernel_loader, "NEEDED", ((object, ("no_such_name",)),))
    kernel_loader.load_lightly(object)
    assert kernel_loader.caching.FunctionCache.load_overload is usual
