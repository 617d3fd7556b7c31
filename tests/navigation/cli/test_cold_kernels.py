"""A command that has to compile first says so, counts the kernels, and can be ended meanwhile."""

from __future__ import annotations

import os
import pty
import re
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from navigation.cli import cold_kernels
from navigation.cli.pictures import sources
from planner.shared import kernel_locator
from tests.support.waiting import wait_until
from tests.system.test_ended_while_compiling import processes_with
from vision.outline.fitting_kernels import fit_borders
from vision.outline.separated_border_kernels import fit_separated_borders

SQUARE = Path(__file__).parents[2] / "golden" / "square.txt"
PROGRAM = str(Path(sys.executable).with_name("clearway"))
PLAN = [PROGRAM, "plan", str(SQUARE), "--start", "10,10", "--goal", "90,90", "--radius", "3"]
LONG_S = 120.0


def test_at_a_terminal_the_kernels_are_counted_and_ctrl_c_ends_it(tmp_path: Path) -> None:
    ours, theirs = pty.openpty()
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    with subprocess.Popen(
        PLAN, env=environment, stdout=subprocess.PIPE, stderr=theirs, start_new_session=True
    ) as process:
        os.close(theirs)
        told = b""
        until_s = time.monotonic() + LONG_S
        while not re.search(rb"[1-9]\d* of \d+ kernels", told) and time.monotonic() < until_s:
            if select.select([ours], [], [], 0.5)[0]:
                told += os.read(ours, 4096)
        assert b"compiling the kernels, once on this machine: " in told
        assert re.search(rb"[1-9]\d* of \d+ kernels", told)
        os.killpg(process.pid, signal.SIGINT)
        began_s = time.monotonic()
        assert process.wait(LONG_S) == 130
        assert time.monotonic() - began_s < 5.0
        assert process.stdout is not None
        assert process.stdout.read() == b""
    os.close(ours)
    assert wait_until(lambda: not processes_with(tmp_path), 8.0), "an orphan goes on"


def test_in_a_log_it_is_said_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cold_kernels, "_is_cold", lambda part: part == "planner")
    monkeypatch.setattr(cold_kernels, "_work_of", lambda _: os.getpid)
    cold_kernels.compile_what_is_missing("eye", "planner")
    out, err = capsys.readouterr()
    assert out == ""
    assert err == "compiling the kernels, once on this machine: some minutes\n"


@pytest.mark.parametrize("missing", [fit_borders, fit_separated_borders])
def test_a_picture_is_seen_by_the_kernels_for_a_camera_and_for_a_drawing(
    missing: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernel_locator, "is_compiled", lambda _: True)
    assert not cold_kernels._is_cold("eye")
    monkeypatch.setattr(kernel_locator, "is_compiled", lambda kernel: kernel is not missing)
    assert cold_kernels._is_cold("eye")


@pytest.mark.parametrize(
    ("name", "content", "parts"),
    [
        ("a.txt", b"P (1,1)\n", ("planner",)),
        ("a.png", b"", ("eye", "planner")),
        ("a", b"\x89PNG\r\n", ("eye", "planner")),
    ],
)
def test_a_picture_needs_the_eye_too(
    name: str,
    content: bytes,
    parts: tuple[str, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[tuple[str, ...]] = []
    monkeypatch.setattr(sources, "compile_what_is_missing", lambda *p: asked.append(p))
    (tmp_path / name).write_bytes(content)
    sources.compile_for(tmp_path / name)
    assert asked == [parts]
