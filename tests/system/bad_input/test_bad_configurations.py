"""Configurations, ports and cameras that cannot be used, told at their place; the real process."""

from __future__ import annotations

import fcntl
import os
import re
import subprocess
import sys
import termios
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.pictures import Told, call
from tests.system.bad_input.refusals import assert_refused


def replaced(text: str, *changes: tuple[str, str]) -> str:
    """The text with the first of each pair, which has to be there, replaced by the second."""
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return text


def place_of(text: str, part: str) -> str:
    """``line:column`` of ``part``, as an editor counts."""
    before = text[: text.index(part)]
    return f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"


def both(config: Path) -> Iterator[Told]:
    """What `check` and `run` say of a configuration: `run` drives no robot on a bad one."""
    yield call("check", config)
    yield call("run", config, "--once")


def test_every_wrong_key_and_value_is_told_at_once_with_line_and_column(
    tmp_path: Path, text: str
) -> None:
    text = replaced(
        text,
        ("radius_m: 0.09", "radius_m: -3"),
        ("rate_hz: 30", "rate_hz: fast"),
        ("baud: 115200", "bauds: 115200"),
        ("marker_id: 7", "marker_id: 7.5"),
        ("polarity: dark", "polarity: [1]"),
        ("lease_s: 0.5", "lease_s: .nan"),
    )
    file = tmp_path / "wrong.yaml"
    file.write_text(text)
    wanted = {
        "robot.radius_m": ("-3  ", "> 0"),
        "camera.rate_hz": ("fast", "number"),
        "serial.bauds": ("bauds", "baud"),
        "robot.marker_id": ("7.5", "whole"),
        "vision.polarity": ("[1]", "dark"),
        "safety.lease_s": (".nan", "finite"),
    }
    for told in both(file):
        assert (told.code, told.out) == (78, "")
        assert "6 errors" in told.err
        for key, (value, words) in wanted.items():
            line = next(line for line in told.err.splitlines() if f" {key}: " in line)
            assert line.startswith(f"{file}:{place_of(text, value)}: "), line
            assert words in line
        assert "Traceback" not in told.err


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("bounds_m: [0.0, 0.0, 2.4, 1.8]", "bounds_m: [0.0, 0.0, 2.4"), ["not YAML"]),
        (("  polarity: dark", "\tpolarity: dark"), ["not YAML"]),
        (("radius_m: 0.09", "radius_m: .nan"), ["robot.radius_m", "finite"]),
        (("radius_m: 0.09", "radius_m: 0"), ["robot.radius_m", "> 0"]),
        (("radius_m: 0.09", "radius_m: 9"), ["robot.radius_m"]),
        (("x_m: 0.72", "x_m: 7.2"), ["mission.stations[0].x_m", "7.2"]),
        (("arena:\n", "arenas:\n"), ["did you mean 'arena'"]),
        (("serial:\n", "robot:\n"), ["second time"]),
        (("port: simulated", "port: [1, 2]"), ["serial.port"]),
    ],
)
def test_a_wrong_configuration_is_refused_at_its_place(
    tmp_path: Path, text: str, change: tuple[str, str], words: list[str]
) -> None:
    file = tmp_path / "wrong.yaml"
    file.write_text(replaced(text, change))
    for told in both(file):
        assert (told.code, told.out) == (78, "")
        assert re.search(rf"^(clearway: error: )?{re.escape(str(file))}:\d+:\d+: ", told.err, re.M)
        for word in words:
            assert word in told.err


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (("x_m: 0.72", "x_m: 72"), "mission.stations[0].x_m: must be in 0.09..2.31"),
        (("bounds_m: [0.0, 0.0, 2.4, 1.8]", "bounds_m: [2.4, 0.0, 0.0, 1.8]"), "arena.bounds_m: "),
    ],
)
def test_one_mistake_is_one_error(
    tmp_path: Path, text: str, change: tuple[str, str], where: str
) -> None:
    file = tmp_path / "wrong.yaml"
    file.write_text(replaced(text, change))
    told = call("check", file)
    assert told.code == 78
    assert where in told.err
    assert " errors" not in told.err


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        (("laboratory.txt", "gone.txt"), "simulation.arena", "No such file"),
        (
            ("x_m: 1.42, y_m: 0.95", "x_m: 0.42, y_m: 1.16"),
            "mission.stations[1]",
            "clearance",
        ),
        (("x_m: 0.20, y_m: 0.20", "x_m: 0.42, y_m: 1.16"), "simulation.start", "clearance"),
    ],
)
def test_check_finds_what_only_the_named_files_can_show(
    tmp_path: Path, text: str, change: tuple[str, str], key: str, words: str
) -> None:
    file = tmp_path / "wrong.yaml"
    file.write_text(replaced(text, change))
    told = call("check", file)
    assert (told.code, told.out) == (78, "")
    assert key in told.err
    assert words in told.err


def test_a_run_that_can_make_no_folder_names_the_key(tmp_path: Path, text: str) -> None:
    (tmp_path / "taken").write_text("a file")
    file = tmp_path / "wrong.yaml"
    file.write_text(replaced(text, ("runs_dir: runs ", f"runs_dir: {tmp_path / 'taken'} ")))
    told = call("run", file, "--once", "--no-dashboard")
    assert told.code == 2
    assert f"recording.runs_dir = {tmp_path / 'taken'}: Not a directory" in told.err


def test_a_run_without_its_arena_is_refused_before_anything_begins(
    tmp_path: Path, text: str
) -> None:
    file = tmp_path / "wrong.yaml"
    file.write_text(replaced(text, ("laboratory.txt", "gone.txt"), ("_dir: runs", "_dir: here")))
    told = call("run", file, "--once")
    assert told.code == 78
    assert "gone.txt" in told.err
    assert told.out == ""


@pytest.mark.parametrize("content", ["", "\n# a remark\n", "- 1\n", "7\n", "a: b: c\n", "\0", "é"])
def test_a_file_that_is_no_configuration_is_refused(tmp_path: Path, content: str) -> None:
    file = tmp_path / "wrong.yaml"
    file.write_text(content)
    for told in both(file):
        assert (told.code, told.out) == (78, "")
        assert str(file) in told.err


def test_a_configuration_that_is_not_there_is_refused(tmp_path: Path) -> None:
    for told in both(tmp_path / "gone.yaml"):
        assert_refused(told, 78, "gone.yaml", "No such file")
    for told in both(tmp_path):
        assert_refused(told, 78, str(tmp_path), "directory")


# Serial ports and cameras.


def run_with(tmp_path: Path, text: str, *changes: tuple[str, str]) -> Told:
    file = tmp_path / "run.yaml"
    file.write_text(replaced(text, ("runs_dir: runs", f"runs_dir: {tmp_path / 'runs'}"), *changes))
    return call("run", file, "--once", "--quiet")


def test_a_run_on_a_missing_port_or_on_no_port_is_refused(tmp_path: Path, text: str) -> None:
    for port, words in ((tmp_path / "ttyUSB0", "no such device"), (tmp_path, "no serial port")):
        told = run_with(tmp_path, text, ("port: simulated", f"port: {port}"))
        assert_refused(told, 2, str(port), words)


def test_a_run_on_a_busy_port_is_refused(tmp_path: Path, text: str) -> None:
    host, robot = os.openpty()
    port = os.ttyname(robot)
    fcntl.ioctl(robot, termios.TIOCEXCL)
    fcntl.flock(robot, fcntl.LOCK_EX | fcntl.LOCK_NB)
    try:
        told = run_with(tmp_path, text, ("port: simulated", f"port: {port}"))
        assert_refused(told, 2, port, "in use")
        assert_refused(call("robot", "--port", port), 2, port, "in use")
    finally:
        os.close(robot)
        os.close(host)


def test_a_report_that_cannot_be_written_is_refused_before_the_run(
    tmp_path: Path, text: str
) -> None:
    file = tmp_path / "run.yaml"
    file.write_text(text)
    told = call("run", file, "--once", "--report", tmp_path / "gone" / "report.json")
    assert_refused(told, 2, "gone")


# The real process.


def clearway(*arguments: object) -> subprocess.CompletedProcess[str]:
    """Run the installed program."""
    program = Path(sys.executable).with_name("clearway")
    return subprocess.run(
        [str(program), *map(str, arguments)], capture_output=True, text=True, timeout=120
    )


def test_the_program_itself_says_one_sentence_without_the_libraries_chatter(folder: Path) -> None:
    for name in ("half.png", "head_only.png"):
        done = clearway("extract", folder / name)
        assert_refused(Told(done.returncode, done.stdout, done.stderr), 2, name)


def test_debug_shows_the_traceback_wherever_it_stands(folder: Path) -> None:
    for arguments in (["--debug", "extract", "gone.png"], ["extract", "gone.png", "--debug"]):
        done = clearway(*arguments)
        assert done.returncode == 2
        assert "Traceback (most recent call last)" in done.stderr
        assert done.stderr.splitlines()[-1].startswith("clearway: error: gone.png: ")
        assert done.stdout == ""


def test_a_missing_port_ends_the_program_cleanly(tmp_path: Path, text: str) -> None:
    file = tmp_path / "run.yaml"
    runs = ("runs_dir: runs", f"runs_dir: {tmp_path / 'runs'}")
    file.write_text(replaced(text, runs, ("port: simulated", "port: no-such-port")))
    done = clearway("run", file, "--once", "--quiet")
    assert_refused(Told(done.returncode, done.stdout, done.stderr), 2, "no-such-port")
