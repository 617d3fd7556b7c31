"""A shortened `clearway run` whose robot is an emulated processor."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from unittest.mock import patch

from navigation.config import load_config
from navigation.run.devices import simulated, world_clock
from navigation.simulator.drive_model import DriveModel
from tests.support.pictures import call
from tests.support.robots.emulated_twin import EmulatedTwin
from tests.support.runs.light_camera import with_light_camera

CONFIGS = Path(__file__).parents[3] / "configs"
MISSION = """mission:
  stations:
    - {x_m: 0.20, y_m: 0.75}
    - {x_m: 0.20, y_m: 1.40, heading_deg: 90}
"""
GIVE_UP_S = 100.0
"""Of the mission: a busy machine may keep the robot from its path for more than the usual 30 s."""


def short_configuration(folder: Path) -> Path:
    """The shipped simulation with two near stations."""
    shutil.copytree(CONFIGS, folder, dirs_exist_ok=True)
    text = with_light_camera((CONFIGS / "simulation.yaml").read_text())
    text = re.sub(r"^mission:\n(?:  .*\n)+", MISSION, text, flags=re.MULTILINE)
    text = text.replace("runs_dir: runs", f"runs_dir: {folder / 'runs'}")
    text = text.replace("safety:\n", f"safety:\n  give_up_s: {GIVE_UP_S}\n")
    file = folder / "emulated.yaml"
    file.write_text(text)
    assert load_config(file).simulation is not None
    return file


@contextmanager
def emulated(command: Sequence[str], *, has_own_time: bool) -> Iterator[None]:
    """Simulated robots of ours are on the emulator ``command``.

    One with its own time does not wait for the run, and the run goes by the wall's clock.
    """
    with ExitStack() as until:

        def twin(_settings: object, *, model: DriveModel, boot_ids: object) -> EmulatedTwin:
            return until.enter_context(closing(EmulatedTwin(command, model=model)))

        until.enter_context(patch.object(simulated, "ClearwayTwin", twin))
        if has_own_time:
            until.enter_context(patch.object(world_clock, "is_all_simulated", lambda _: False))
        yield


def assert_run_reaches_its_goal(
    folder: Path, command: Sequence[str], *, has_own_time: bool = False
) -> None:
    """A whole run, to both stations and exactly.

    A new plan, after the robot has proved itself on a busy machine, leaves waypoints of the old.
    """
    file = short_configuration(folder)
    with emulated(command, has_own_time=has_own_time):
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
