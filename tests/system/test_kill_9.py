"""A robot in another process; `clearway run` is killed with SIGKILL and started again."""

from __future__ import annotations

import json
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path
from subprocess import PIPE

import pytest

from tests.support.processes.forked import Program
from tests.support.runs.light_camera import with_light_camera

pytestmark = pytest.mark.timed  # a robot in another process drives in real time

CONFIGS = Path(__file__).parents[2] / "configs"
STAY_S = 5.0
"""At the second station: a kill after the first that a busy machine makes late comes before it."""


GIVE_UP_S = 100.0
"""Of the mission: a busy machine may keep the robot from its path for more than the usual 30 s."""


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """A folder in which the robot of configs/hardware_in_the_loop.yaml runs."""
    shutil.copytree(CONFIGS, tmp_path / "configs")
    config = tmp_path / "configs" / "hardware_in_the_loop.yaml"
    text = with_light_camera(config.read_text())
    text = text.replace("y_m: 1.60, dwell_s: 0.5", f"y_m: 1.00, dwell_s: {STAY_S}")
    config.write_text(
        text.replace("{x_m: 0.60, y_m: 1.58, heading_deg: 0}", "{x_m: 0.2, y_m: 0.8}")
    )
    with config.open("a") as more:
        more.write(f"\nsafety: {{give_up_s: {GIVE_UP_S}}}\n")
    arguments = ["--link", "runs/robot", "--poses", "runs/robot.pose", "--start", "0.2,0.2,90"]
    with Program(["robot", *arguments], cwd=tmp_path, stdout=PIPE) as robot:
        assert robot.stdout is not None
        robot.stdout.readline()  # its port: it is there
        robot.stdout.readline()  # its state: link and pose are told
        yield tmp_path
        robot.terminate()


def run(folder: Path) -> Program:
    config = "configs/hardware_in_the_loop.yaml"
    arguments = ["--once", "--no-dashboard", "--socket", "c.sock", "--report", "report.json"]
    return Program(["run", config, *arguments], cwd=folder, stdout=PIPE)


def kill_when_said(process: Program, words: str) -> list[str]:
    said = []
    assert process.stdout is not None
    for line in process.stdout:
        said.append(line)
        if words in line:
            process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdout.close()
    assert process.returncode == -signal.SIGKILL, said
    return said


def test_a_killed_run_goes_on_where_it_was(folder: Path) -> None:
    kill_when_said(run(folder), "driving")
    again = kill_when_said(run(folder), "station 1/3")
    assert any("continues: 0 of 3 stations were visited" in line for line in again)
    with run(folder) as last:
        said, _ = last.communicate(timeout=120)
    assert last.returncode == 0, said
    assert "continues: 1 of 3 stations were visited" in said
    report = json.loads((folder / "report.json").read_text())
    assert (report["state"], report["stations_visited"]) == ("done", 3)
    assert report["goal_error_m"] < 0.02
