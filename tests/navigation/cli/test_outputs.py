"""What commands write: never over what they read, one sentence where the disk is full."""

from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path

import click
import cv2
import numpy as np
import pytest

from navigation.cli.main import run
from navigation.cli.outputs import Stopwatch, keep_apart, tell_times

PLAN = ["--start", "10,10", "--goal", "80,80", "--radius", "3"]


@pytest.fixture
def picture(tmp_path: Path) -> Path:
    image = np.full((100, 100), 215, np.uint8)
    cv2.circle(image, (50, 50), 20, 40, -1)
    path = tmp_path / "a.png"
    cv2.imwrite(str(path), image)
    return path


@pytest.mark.parametrize(
    ("command", "option"),
    [
        (["extract"], "-o"),
        (["extract"], "--render"),
        (["plan", *PLAN], "-o"),
        (["plan", *PLAN], "--render"),
        (["roadmap", "--radius", "3", "-o", "r.json"], "--render"),
    ],
)
def test_a_command_never_overwrites_what_it_reads(
    command: list[str],
    option: str,
    picture: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(picture.parent)
    before = picture.read_bytes()
    (picture.parent / "link.png").symlink_to(picture)
    for name in ("a.png", "link.png", f"../{picture.parent.name}/a.png"):
        assert run([*command, str(picture), option, name]) == 2
        assert f"{name}: would overwrite {picture}, which is read" in capsys.readouterr().err
    assert picture.read_bytes() == before


def test_two_answers_do_not_share_a_file(tmp_path: Path) -> None:
    one = tmp_path / "one.svg"
    with pytest.raises(click.UsageError, match=r"--render .*would overwrite the file of --output"):
        keep_apart((("--output", one), ("--render", one)), ())
    keep_apart((("--output", one), ("--render", tmp_path / "two.svg")), (None,))
    keep_apart((("--output", Path("/dev/null")), ("--render", Path("/dev/null"))), ())


def test_standard_input_is_read_once() -> None:
    stream = Path("-")
    keep_apart((), (stream, None, Path("a.png")))
    with pytest.raises(click.UsageError, match="-: only one input can be standard input"):
        keep_apart((), (stream, None, stream))


def test_stages_are_measured_from_one_to_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    now_s = iter([10.0, 10.5, 12.0, 12.25, 12.5, 13.0])
    monkeypatch.setattr("navigation.cli.outputs.time.perf_counter", lambda: next(now_s))
    times_ms = Stopwatch()
    times_ms.end("load")
    times_ms.begin()
    times_ms.end("plan")
    times_ms.end("load")
    times_ms.end_all()
    assert times_ms == {"load": 750.0, "plan": 250.0, "total": 3000.0}


def test_a_full_disk_is_one_sentence(picture: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["extract", str(picture), "-o", "/dev/full"]) == 2
    said = capsys.readouterr().err
    assert said == "clearway: error: /dev/full: cannot be written: No space left on device\n"
    program = Path(sys.executable).with_name("clearway")
    with Path("/dev/full").open("wb") as full:
        told = subprocess.run(
            [str(program), "extract", str(picture)],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            timeout=120,
        )
    assert told.returncode == 1
    assert told.stderr == (
        "clearway: error: the answer cannot be written: No space left on device\n"
    )


@pytest.mark.parametrize("command", [["extract"], ["plan", *PLAN]])
def test_an_empty_name_is_not_the_present_folder(
    command: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([*command, ""]) == 2
    assert "the name is empty: must be a file" in capsys.readouterr().err


@pytest.mark.parametrize("at_terminal", [True, False])
def test_times_are_told_at_a_terminal_only(
    monkeypatch: pytest.MonkeyPatch, at_terminal: bool
) -> None:
    stream = io.StringIO()
    monkeypatch.setattr(stream, "isatty", lambda: at_terminal)
    monkeypatch.setattr(sys, "stderr", stream)
    tell_times({"load": 1.25, "total": 3.0})
    assert stream.getvalue() == ("ms: load 1.2, total 3.0\n" if at_terminal else "")
