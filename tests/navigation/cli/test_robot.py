"""``clearway robot --kind``: a twin in a process of its own, on a link, until a signal."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from navigation.config.known_robots import KNOWN_ROBOTS
from navigation.link.drivers.recognise import recognise
from tests.support.pictures import call
from tests.support.waiting import wait_until

PROGRAM = Path(sys.executable).with_name("clearway")


@pytest.mark.parametrize("kind", tuple(KNOWN_ROBOTS))
def test_each_kind_answers_its_driver_and_takes_its_link_away(kind: str, tmp_path: Path) -> None:
    link = tmp_path / "robot"
    arguments = [PROGRAM, "robot", "--kind", kind, "--link", link, "--start", "1,2,90"]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert wait_until(link.exists, 30.0)
            found = recognise(str(link), KNOWN_ROBOTS[kind].baud, kind)
            assert found.name == kind, found
        finally:
            process.send_signal(signal.SIGTERM)
        said, _ = process.communicate(timeout=30)
    assert process.returncode == 128 + signal.SIGTERM
    assert "its wheels are at rest, at (1.000, 2.000) m, 90.0 deg" in said
    assert not link.is_symlink()


def test_faults_that_another_robot_s_line_cannot_have_are_refused() -> None:
    told = call("robot", "--kind", "create2", "--faults", "dup=0.1")
    assert told.code == 2
    assert "fault dup: is about the frames of Clearway's own line" in told.err
    assert "Traceback" not in told.err


def test_a_sweep_says_that_a_driver_needs_real_time(tmp_path: Path) -> None:
    file = tmp_path / "create2.yaml"
    assert call("init", file, "--robot", "create2").code == 0
    told = call("sweep", file, "--runs", "1", "-o", tmp_path / "rows.csv")
    assert told.code == 2
    assert "robot.driver create2 drives in real time only; a sweep needs clearway" in told.err
