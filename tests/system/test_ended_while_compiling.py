"""A run that is ended while its kernels compile: at once, in order, and without an orphan."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.waiting import wait_until

CONFIGS = Path(__file__).parents[2] / "configs"
ENDED_WITHIN_S = 8.0
"""A service manager waits for ten."""
ORPHANS_END_WITHIN_S = 30.0
"""A child loads its modules before it watches its parent; to compile takes minutes."""


@pytest.fixture
def compiling(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A run whose cache of kernels is empty, after it has said that it compiles."""
    shutil.copytree(CONFIGS, tmp_path, dirs_exist_ok=True)
    cache = tmp_path / "cache"
    cache.mkdir()
    arguments = ["run", "simulation.yaml", "--no-dashboard", "--socket", str(tmp_path / "socket")]
    with subprocess.Popen(
        [str(Path(sys.executable).with_name("clearway")), *arguments],
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache)},
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            assert process.stdout is not None
            assert "compiling the kernels" in process.stdout.readline()
            assert wait_until(lambda: len(processes_with(cache)) >= 3), "no child compiles"
            yield process
        finally:
            process.kill()
    assert wait_until(lambda: not processes_with(cache), ORPHANS_END_WITHIN_S), (
        "a compiling process outlives the run"
    )


def processes_with(cache: Path) -> list[int]:
    """The processes whose environment names this folder for the kernels."""
    wanted = f"NUMBA_CACHE_DIR={cache}".encode()
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            environment = (folder / "environ").read_bytes()
        except OSError:  # it has ended meanwhile, or is another user's
            continue
        if wanted in environment.split(b"\0"):
            found.append(int(folder.name))
    return found


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_it_ends_in_order_and_at_once(
    number: signal.Signals, compiling: subprocess.Popen[str], tmp_path: Path
) -> None:
    compiling.send_signal(number)
    out, err = compiling.communicate(timeout=ENDED_WITHIN_S)
    assert (compiling.returncode, err) == (0, "")
    assert re.search(r"state +stopped: interrupted before anything was driven", out)
    (file,) = (tmp_path / "runs").glob("*/report.json")
    report = json.loads(file.read_text())
    assert (report["state"], report["stations"], report["stations_visited"]) == ("stopped", 3, 0)


def test_its_children_end_with_it_when_it_is_killed(compiling: subprocess.Popen[str]) -> None:
    compiling.kill()  # the fixture looks for orphans
