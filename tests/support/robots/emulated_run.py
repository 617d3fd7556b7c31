"""A shortened `clearway run` whose robot is an emulated processor."""

from __future__ import annotations

import json
import re
import shlex
import shutil
from collections.abc import Sequence
from pathlib import Path

from navigation.config import load_config
from tests.support.pictures import call
from tests.support.runs.light_camera import with_light_camera

CONFIGS = Path(__file__).parents[3] / "configs"
MISSION = """mission:
  stations:
    - {x_m: 0.20, y_m: 0.75}
    - {x_m: 0.20, y_m: 1.40, heading_deg: 90}
"""
GIVE_UP_S = 100.0
"""Of the mission: a busy machine may keep the robot from its path for more than the usual 30 s."""


def short_configuration(folder: Path, command: Sequence[str]) -> Path:
    """The shipped simulation with two near stations and the emulator ``command``."""
    shutil.copytree(CONFIGS, folder, dirs_exist_ok=True)
    text = with_light_camera((CONFIGS / "simulation.yaml").read_text())
    text = re.sub(r"^mission:\n(?:  .*\n)+", MISSION, text, flags=re.MULTILINE)
    text = text.replace("runs_dir: runs", f"runs_dir: {folder / 'runs'}")
    text = text.replace("safety:\n", f"safety:\n  give_up_s: {GIVE_UP_S}\n")
    emulator = json.dumps(shlex.join(command))
    text = re.sub(r"(    motor_time_s: .*\n)", rf"\1    emulator: {emulator}\n", text)
    file = folder / "emulated.yaml"
    file.write_text(text)
    assert load_config(file).simulation is not None
    return file


def assert_run_reaches_its_goal(folder: Path, command: Sequence[str]) -> None:
    """A whole run, to both stations and exactly.

    A run with an emulator goes by the wall's clock and can be late on a busy machine: a new plan,
    after the robot has proved itself, then leaves waypoints of the old one.
    """
    file = short_configuration(folder, command)
    told = call("run", file, "--once", "--report", folder / "report.json")
    assert (told.code, told.err) == (0, ""), told
    report = json.loads((folder / "report.json").read_text())
    assert (report["state"], report["stations_visited"]) == ("done", 2)
    assert report["waypoints_executed"] >= 4
    if report["replans"] == 0:
        assert report["waypoints_executed"] == report["waypoints_sent"]
    assert report["ground_truth"]
    assert report["goal_error_m"] < 0.02
    assert report["min_clearance_m"] > 0.09
