"""Where compiled kernels are found: shipped ones are unpacked once, and every kernel is covered."""

import os
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from numba.core import caching

from planner.shared import kernel_locator
from planner.shared.kernel_locator import LABEL, ROOT, VERSIONS, cache_folder, unpack_shipped

WALK = """
import importlib, pkgutil
import planner, vision
from numba.extending import is_jitted
from planner.shared.kernel_locator import KernelLocator

count, inheriting = 0, []
for package in (planner, vision):
    for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        for kernel in vars(importlib.import_module(module.name)).values():
            if not is_jitted(kernel):
                continue
            if "fastmath" not in kernel.targetoptions:
                inheriting.append(str(kernel))
            if kernel.py_func.__module__ == module.name:
                # numba has no public name for the locator that it chose
                locator = kernel._cache._impl.locator
                assert isinstance(locator, KernelLocator), (kernel, locator)
                count += 1
print(count, *inheriting, sep="\\n")
"""


@cache
def walk() -> tuple[int, list[str]]:
    """How many kernels there are, and those that inherit ``fastmath``."""
    told = subprocess.run(
        [sys.executable, "-c", WALK], capture_output=True, text=True, cwd=ROOT, timeout=120
    )
    assert told.returncode == 0, told.stderr
    count, *inheriting = told.stdout.splitlines()
    return int(count), inheriting


def test_every_kernel_is_kept_by_what_it_depends_on() -> None:
    assert walk()[0] > 400


@pytest.mark.parametrize("package", kernel_locator.PACKAGES)
def test_every_file_of_kernels_has_the_locator_set_up_before(package: str) -> None:
    files = [file for file in (ROOT / package).rglob("*.py") if "@njit" in file.read_text()]
    assert len(files) > 20
    bare = [file for file in files if "planner.scene.compile_options" not in file.read_text()]
    assert bare == []


@pytest.mark.parametrize("package", kernel_locator.PACKAGES)
def test_no_kernel_takes_anything_from_the_folder_that_stamps_leave_out(package: str) -> None:
    files = [file for file in (ROOT / package).rglob("*.py") if "@njit" in file.read_text()]
    assert [file for file in files if "planner.shared" in file.read_text()] == []


@pytest.fixture
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of two kernels compiled ahead, and an empty cache."""
    folder = tmp_path / "shipped" / "x86-64-v3"
    for name in ("planner/search/a-1.py311", "vision/markers/b-7.py311"):
        (folder / name).parent.mkdir(parents=True)
        (folder / f"{name}.nbi").write_bytes(b"index")
        (folder / f"{name}.1.nbc").write_bytes(b"code")
    (folder / LABEL).write_text(f"{VERSIONS}\n1234\n")
    monkeypatch.setattr(kernel_locator.CONFIG, "CACHE_DIR", str(tmp_path / "cache"))
    return folder


def kept(folder: Path) -> list[str]:
    return sorted(file.name for file in folder.rglob("*.nb[ci]"))


def test_shipped_kernels_are_unpacked_once(shipped: Path, tmp_path: Path) -> None:
    assert unpack_shipped(shipped) == 4
    assert kept(tmp_path / "cache") == kept(shipped)
    assert unpack_shipped(shipped) == 0


def test_those_of_a_newer_version_replace_them(shipped: Path) -> None:
    unpack_shipped(shipped)
    (shipped / LABEL).write_text(f"{VERSIONS}\n5678\n")
    (shipped / "vision/markers/b-7.py311.nbi").write_bytes(b"newer")
    assert unpack_shipped(shipped) == 4
    assert (cache_folder(ROOT / "vision" / "markers") / "b-7.py311.nbi").read_bytes() == b"newer"


@pytest.mark.parametrize("other", ["numba 0.1, llvmlite 0.1", VERSIONS + "1", ""])
def test_those_made_by_other_versions_are_left_where_they_are(shipped: Path, other: str) -> None:
    (shipped / LABEL).write_text(f"{other}\n1234\n")
    assert unpack_shipped(shipped) == 0


def test_where_none_are_shipped_there_is_nothing_to_do(tmp_path: Path) -> None:
    assert unpack_shipped(tmp_path / "nothing") == 0


def test_a_cache_that_cannot_be_written_keeps_the_program_running(
    shipped: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "cache").write_text("a file where the folder should be")
    monkeypatch.setattr(kernel_locator, "SHIPPED", shipped.parent)
    monkeypatch.setattr(kernel_locator, "choose_processor", lambda _: shipped.name)
    kernel_locator.prepare_kernels()


def test_no_kernels_arithmetic_depends_on_who_calls_it_first() -> None:
    """Numba lets a kernel that says nothing of ``fastmath`` inherit it from its first caller."""
    assert walk()[1] == []


def test_numba_does_not_remember_what_it_could_not_infer() -> None:
    """It takes for such what it could, deep in the fit of outlines, and refuses the kernel."""
    assert kernel_locator.CONFIG.DISABLE_TYPEINFER_FAIL_CACHE == 1


def test_numbas_usual_locators_follow_ours_in_its_order() -> None:
    # no public name: the manual lists them, and our list has to be the same
    usual = [locator.__name__ for locator in caching.CacheImpl._locator_classes]
    own, *others = kernel_locator.CONFIG.CACHE_LOCATOR_CLASSES.split(",")
    assert own == "planner.shared.kernel_locator.KernelLocator"
    assert others == usual


def test_kernels_prepared_twice_have_one_locator_and_keep_what_a_user_chose() -> None:
    told = subprocess.run(
        [sys.executable, "-c", TWICE],
        capture_output=True,
        text=True,
        cwd=ROOT,
        env={**os.environ, "NUMBA_CACHE_LOCATOR_CLASSES": "InTreeCacheLocator"},
        timeout=120,
    )
    assert told.stdout == "planner.shared.kernel_locator.KernelLocator,InTreeCacheLocator\n"


TWICE = """
import planner.scene.compile_options
from planner.shared.kernel_locator import CONFIG, prepare_kernels
prepare_kernels()
print(CONFIG.CACHE_LOCATOR_CLASSES)
"""


OWN_KERNELS = """
from typing import NamedTuple

from numba import njit

from planner.scene.compile_options import OWNING


class Earlier(NamedTuple):
    value: float


@njit(**OWNING)
def value_of(pair):
    return pair.value


if __name__ == "__main__":
    from planner import own_kernels

    print(own_kernels.value_of(own_kernels.Earlier(2.0)), *own_kernels.value_of.stats.cache_hits)
"""


def test_kernels_of_an_earlier_version_are_compiled_again_and_removed(tmp_path: Path) -> None:
    """A class that they name may be gone: numba cannot even read the old index."""
    shutil.copytree(
        ROOT / "planner",
        tmp_path / "planner",
        ignore=shutil.ignore_patterns("__pycache__", "*.nb?"),
    )
    source = tmp_path / "planner" / "own_kernels.py"

    def value(text: str) -> str:
        source.write_text(text)
        child = [sys.executable, str(source)]
        beside_the_source = {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": ""}
        environment = {**os.environ, **beside_the_source}
        told = subprocess.run(child, capture_output=True, text=True, env=environment, timeout=120)
        assert told.returncode == 0, told.stderr
        return told.stdout

    def names() -> set[str]:
        return {file.name for file in source.parent.rglob("own_kernels.value_of-*.nb?")}

    assert value(OWN_KERNELS) == "2.0\n"
    first = names()
    assert "(" in value(OWN_KERNELS)  # read from the cache
    assert names() == first
    assert value(OWN_KERNELS.replace("Earlier", "Later")) == "2.0\n"
    assert len(names()) == len(first) == 2
    assert not names() & first
