"""Whole runs of robots that speak their makers' protocols, on their twins, in real time.

Nothing may depend on the machine's being fast.
"""

from __future__ import annotations

import contextlib
import json
import re
import shutil
import signal
import time
from pathlib import Path
from subprocess import DEVNULL, PIPE, STDOUT

import pytest

from navigation.config import load_config
from navigation.config.known_robots import KNOWN_ROBOTS
from navigation.config.several.each_robot import each_robot
from tests.support.pictures import call
from tests.support.processes.forked import Program
from tests.support.runs.light_camera import with_light_camera
from tests.support.waiting import wait_until

CONFIGS = Path(__file__).parents[2] / "configs"
NEAR = {
    "create2": "{x_m: 0.40, y_m: 1.50, heading_deg: 90}",
    "turtlebot3": "{x_m: 0.20, y_m: 0.75, heading_deg: 90}",
    "epuck2": "{x_m: 0.08, y_m: 0.32, heading_deg: 90}",
    "waveshare": "{x_m: 0.40, y_m: 1.50, heading_deg: 90}",
}
"""A goal near the start of each shipped configuration, straight above it."""
PATIENCE_S = 60.0
GIVE_UP_S = 100.0
"""Of the mission: a busy machine may keep a robot from its path for more than the usual 30 s."""
drives = pytest.mark.timed
"""A maker's driver is a process that lives by the wall's clock."""


def shortened(name: str, folder: Path, *changes: tuple[str, str]) -> Path:
    """The shipped configuration with one near station."""
    shutil.copytree(CONFIGS, folder, dirs_exist_ok=True)
    text = with_light_camera((CONFIGS / f"{name}.yaml").read_text())
    text = re.sub(
        r"^  stations:\n(?:    .*\n)+",
        f"  stations:\n    - {NEAR[name]}\n",
        text,
        flags=re.MULTILINE,
    )
    for old, new in (("runs_dir: runs", f"runs_dir: {folder / 'runs'}"), *changes):
        assert old in text
        text = text.replace(old, new, 1)
    file = folder / "short.yaml"
    file.write_text(f"{text}\nsafety: {{give_up_s: {GIVE_UP_S}}}\n")
    return file


@drives
@pytest.mark.parametrize("name", tuple(KNOWN_ROBOTS))
def test_the_shipped_configuration_drives_its_robot_to_the_goal(name: str, tmp_path: Path) -> None:
    told = call("run", shortened(name, tmp_path), "--once", "--report", tmp_path / "report.json")
    assert (told.code, told.err) == (0, ""), told
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["state"] == "done"
    assert report["ground_truth"]
    assert report["goal_error_m"] <= 0.010
    assert report["goal_error_deg"] <= 2.0
    assert report["tracking_error_m"]["rms"] <= 0.015
    assert report["min_clearance_m"] >= load_config(tmp_path / "short.yaml", {}).robot.radius_m


@drives
def test_robots_of_two_makers_drive_together_and_never_touch(tmp_path: Path) -> None:
    shutil.copytree(CONFIGS, tmp_path, dirs_exist_ok=True)
    file = tmp_path / "fleet_of_epucks.yaml"
    lines = file.read_text().splitlines(keepends=True)  # two of the four: a light run
    text = "".join(line for line in lines if "{name: bob" not in line and "{name: cleo" not in line)
    for old, new in (
        ("runs_dir: runs", f"runs_dir: {tmp_path / 'runs'}"),
        ("safety:\n", f"safety:\n  give_up_s: {GIVE_UP_S}\n"),
    ):
        assert old in text
        text = text.replace(old, new)
    file.write_text(text)
    told = call("run", file, "--once", "--report", tmp_path / "report.json")
    assert (told.code, told.err) == (0, ""), told
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["least_gap_m"] > 0.0
    drivers = {name: one.robot.driver for name, one in each_robot(load_config(file, {})).items()}
    assert sorted(drivers.values()) == ["clearway", "epuck2"]
    for name in drivers:
        assert report["robots"][name]["state"] == "done"
        assert report["robots"][name]["goal_error_m"] <= 0.010


class Twin:
    """``clearway robot --kind`` in a process of its own, behind a link that stays."""

    def __init__(self, folder: Path, kind: str, start: str) -> None:
        arguments = ["--kind", kind, "--start", start, "--link", "robot", "--poses", "robot.pose"]
        self.process = Program(["robot", *arguments], cwd=folder, stdout=DEVNULL)

    def end(self) -> None:
        """The robot is unplugged: nothing is left of its port."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
            self.process.wait(20)


@drives
def test_a_robot_that_is_unplugged_in_mid_run_comes_back_and_the_mission_goes_on(
    tmp_path: Path,
) -> None:
    """The twin is another process; its link is a name as under /dev/serial/by-id."""
    simulated = ("port: simulated", "port: ./robot")
    poses = ("  camera:\n", "  robot: {poses: robot.pose}\n  camera:\n")
    far = ("{x_m: 0.40, y_m: 1.50, heading_deg: 90}", "{x_m: 0.40, y_m: 3.0}")
    file = shortened("create2", tmp_path, simulated, far)
    text = file.read_text()
    head, simulation = text.split("simulation:\n")
    file.write_text(f"{head}simulation:\n{simulation.replace(*poses, 1)}")
    (tmp_path / "robot.pose").touch()
    with contextlib.ExitStack() as until:
        said = tmp_path / "said"
        out = until.enter_context(said.open("w"))
        arguments = ("run", file, "--no-dashboard", "--socket", tmp_path / "s")
        program = Program(arguments, cwd=tmp_path, stdout=out, stderr=STDOUT)
        until.callback(program.wait)
        until.callback(program.kill)

        def says(pattern: str) -> None:
            assert wait_until(lambda: bool(re.search(pattern, said.read_text())), PATIENCE_S), (
                said.read_text()
            )

        says(r"serial port \./robot: there is no such device")
        first = Twin(tmp_path, "create2", "0.4,0.4,90")
        until.callback(first.end)
        says(r"driving +at \(\d\.\d+, [12]\.\d+\) m")
        first.end()
        says(r"holding .*the link to the robot is down: serial port \./robot")
        where = re.findall(r"at \((\d\.\d+), (\d\.\d+)\) m", said.read_text())[-1]
        time.sleep(1.0)  # a robot that is off for a while
        second = Twin(tmp_path, "create2", f"{where[0]},{where[1]},90")
        until.callback(second.end)
        says(r"done +the robot is at rest")
        assert program.poll() is None
        program.send_signal(signal.SIGINT)
        assert program.wait(30) == 0
        assert "Traceback" not in said.read_text()


def test_the_wrong_robot_on_the_port_is_named_and_nothing_is_driven(tmp_path: Path) -> None:
    file = shortened("waveshare", tmp_path, ("port: simulated", "port: robot"))
    twin = Twin(tmp_path, "epuck2", "0.4,0.4,90")
    try:
        assert wait_until((tmp_path / "robot").exists, PATIENCE_S)
        file.write_text(file.read_text().replace("port: robot", f"port: {tmp_path / 'robot'}"))
        arguments = ["--once", "--no-dashboard", "--socket", tmp_path / "s"]
        said = []
        with Program(["run", file, *arguments], stdout=PIPE) as run:
            assert run.stdout is not None
            for line in run.stdout:
                said.append(line)
                if "has an e-puck2 on it, not a Waveshare UGV: set robot.driver to epuck2" in line:
                    run.send_signal(signal.SIGINT)
        assert run.returncode == 1, said
        assert "driving" not in "".join(said)
        doctor = call("doctor", file)
        assert "e-puck2, Version 2.0" in doctor.out
        assert "-> set robot.driver to epuck2" in doctor.out
    finally:
        twin.end()
