"""Long work at a terminal is told, and Ctrl-C ends it at once."""

from __future__ import annotations

import io
import os
import pty
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from navigation.cli import progress
from tests.support.waiting import wait_until

LONG_S = 60.0


@pytest.fixture
def noise(tmp_path: Path) -> Path:
    """Coin flips: hundreds of thousands of borders, which takes long."""
    file = tmp_path / "noise.png"
    flips = np.random.default_rng(1).integers(0, 2, (1500, 1500)).astype(np.uint8) * 255
    cv2.imwrite(str(file), flips)
    return file


@pytest.mark.timed  # says how soon Ctrl-C ends it
def test_at_a_terminal_long_work_is_told_and_ctrl_c_ends_it(noise: Path, tmp_path: Path) -> None:
    ours, theirs = pty.openpty()
    arguments = ["roadmap", str(noise), "--radius", "0.1", "-o", str(tmp_path / "out.json")]
    program = Path(sys.executable).with_name("clearway")
    with subprocess.Popen(
        [str(program), *arguments], stdout=subprocess.DEVNULL, stderr=theirs
    ) as process:
        os.close(theirs)
        told = b""
        until_s = time.monotonic() + LONG_S
        while b" s" not in told and time.monotonic() < until_s:
            if select.select([ours], [], [], 0.5)[0]:
                told += os.read(ours, 4096)
        assert b"looking for obstacles ... " in told
        process.send_signal(signal.SIGINT)
        began_s = time.monotonic()
        assert process.wait(LONG_S) == -signal.SIGINT
        assert time.monotonic() - began_s < 2.0
    os.close(ours)
    assert not (tmp_path / "out.json").exists()


class Terminal(io.StringIO):
    """A stderr that is a terminal."""

    def isatty(self) -> bool:
        return True


def test_the_line_names_the_stage_and_is_gone_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(progress, "PATIENCE_S", 0.01)
    monkeypatch.setattr(progress, "EVERY_S", 0.01)
    with progress.long_work("one") as begin:
        assert wait_until(lambda: "one ... 0 s" in stream.getvalue())
        begin("two")
        assert wait_until(lambda: "two ... 0 s" in stream.getvalue())
        assert signal.getsignal(signal.SIGINT) is signal.SIG_DFL
    assert stream.getvalue().endswith(progress.CLEAR_LINE)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_short_work_and_a_file_are_told_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal, file = Terminal(), io.StringIO()
    monkeypatch.setattr(progress, "EVERY_S", 0.001)
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress.long_work("one"):
        pass
    monkeypatch.setattr(progress, "PATIENCE_S", 0.0)
    monkeypatch.setattr(sys, "stderr", file)
    with progress.long_work("one"):
        assert not wait_until(lambda: file.getvalue() != "", 0.05)
    assert (terminal.getvalue(), file.getvalue()) == ("", "")


def test_another_s_handler_of_ctrl_c_stays() -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with progress.long_work("one"):
            assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize(("term", "live"), [("xterm", True), ("dumb", False)])
def test_a_dumb_terminal_gets_no_line_that_is_renewed(
    monkeypatch: pytest.MonkeyPatch, term: str, live: bool
) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("TERM", term)
    monkeypatch.setattr(progress, "PATIENCE_S", 0.0)
    with progress.long_work("drawing"):
        assert wait_until(lambda: not live or "drawing" in terminal.getvalue())
    assert bool(terminal.getvalue()) == live
