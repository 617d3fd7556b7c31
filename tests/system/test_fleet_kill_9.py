"""`clearway run` of two robots is killed with SIGKILL and started again: both missions continue."""

from __future__ import annotations

import json
from pathlib import Path
from subprocess import PIPE

import pytest
import yaml

from navigation.recording.files import recordings_in
from navigation.recording.reader import read_recording
from tests.navigation.loop.test_fleet_kill import hall
from tests.support.processes.forked import Program
from tests.support.runs.light_camera import in_small_pictures
from tests.system.test_kill_9 import kill_when_said

pytestmark = pytest.mark.slow
STAY_S = 8.0
"""At their last stations: a kill that a busy machine makes late still comes before the end."""


def run(folder: Path) -> Program:
    arguments = ["--once", "--no-dashboard", "--socket", "c.sock", "--report", "report.json"]
    arguments += ["--record", "recordings"]
    return Program(["run", "hall.yaml", *arguments], cwd=folder, stdout=PIPE)


def test_a_killed_run_of_two_robots_continues_both_missions(tmp_path: Path) -> None:
    small = in_small_pictures(hall(tmp_path / "journal", "ab"))
    config = small.model_dump(mode="json", exclude_none=True)
    config["camera"]["rate_hz"] = 10.0  # which a busy machine keeps up with
    config["simulation"]["time_limit_s"] = 90.0
    for one in config["mission"]["robots"]:
        one["stations"][-1]["dwell_s"] = STAY_S
    (tmp_path / "hall.yaml").write_text(yaml.safe_dump(config))
    kill_when_said(run(tmp_path), "to 1 station,")
    with run(tmp_path) as last:
        said, _ = last.communicate(timeout=200)
    assert last.returncode == 0, said
    assert "a continues: " in said
    assert "b continues: " in said
    assert "continues: 1 of 2 stations were visited" in said
    report = json.loads((tmp_path / "report.json").read_text())
    assert {one["state"] for one in report["robots"].values()} == {"done"}
    assert {one["stations_visited"] for one in report["robots"].values()} == {2}
    assert report["least_gap_m"] > 0.0
    killed, whole = (read_recording(file) for file in recordings_in(tmp_path / "recordings"))
    assert (killed.cut, whole.cut) == (True, False)
    for recording in (killed, whole):
        assert {name for plan in recording.plans for name in plan.answer["robots"]} == {"a", "b"}
