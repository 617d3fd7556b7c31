"""Sweeps over several robots: each robot a row for each run, with its name."""

from __future__ import annotations

import csv
import json
from itertools import combinations
from math import dist
from pathlib import Path

import pytest

from navigation.config import Config, load_config
from navigation.simulator.arena import load_arena
from navigation.sweep.runs import MOST_ATTEMPTS, Sweep
from navigation.sweep.variations import APART_M, MOST_SPREAD, variation, varied
from navigation.sweep.workers import local_executor
from tests.support.pictures import call
from tests.support.runs import sweeps

pytestmark = pytest.mark.slow

CONFIGS = Path(__file__).parents[3] / "configs"
HALL = """
arena: {bounds_m: [0.0, 0.0, 2.4, 1.8]}
camera: {source: simulated, size_px: [1280, 960], rate_hz: 15}
robot: {marker_id: 0, marker_size_m: 0.09, marker_height_m: 0.1, radius_m: 0.09, speed_m_s: 0.3}
robots:
  - {name: ada, marker_id: 1}
  - {name: bob, marker_id: 2}
  - {name: eve, marker_id: 3}
mission:
  robots:
    - {name: ada, stations: [{x_m: 0.8, y_m: 0.4}]}
    - {name: bob, stations: [{x_m: 1.6, y_m: 0.4}]}
simulation:
  arena_text: |
    #@ clearway.scene/1
    #@ units m
    C (1.2,1.4) 0.1
  starts:
    - {name: ada, x_m: 0.4, y_m: 0.4}
    - {name: bob, x_m: 2.0, y_m: 0.4, heading_deg: 180}
    - {name: eve, x_m: 0.4, y_m: 1.4}
  time_limit_s: 30
"""


@pytest.fixture
def crossing(tmp_path: Path) -> Config:
    """Eight robots side by side, with a folder of its own for marks."""
    loaded = load_config(CONFIGS / "crossing.yaml", {})
    changed = loaded.recording.model_copy(update={"runs_dir": tmp_path})
    return loaded.model_copy(update={"recording": changed})


def test_each_robot_has_a_start_and_wheels_of_its_own_and_all_one_camera(crossing: Config) -> None:
    one = variation(crossing, 5, 3)
    assert one == variation(crossing, 5, 3)
    assert list(one.robots) == [entry.name for entry in crossing.robots]
    drawn = one.robots.values()
    assert len({v.wheel_error_left for v in drawn}) == len(crossing.robots)
    assert len({(v.seed, v.noise_grey, v.blur_px) for v in drawn}) == 1
    _, bodies = varied(crossing, one)
    assert bodies is not None
    for name, body in bodies.items():
        assert body.simulation is not None
        assert body.simulation.robot.wheel_radius_error[0] == one.robots[name].wheel_error_left
    assert len({body.simulation.seed for body in bodies.values() if body.simulation}) == 8


def test_every_start_is_free_and_apart_from_all_others(crossing: Config) -> None:
    arena = load_arena(crossing)
    configured = variation(crossing, 2, 0, 0.0).robots
    moved = 0
    for run in range(30):
        whole, _ = varied(crossing, variation(crossing, 2, run, MOST_SPREAD))
        assert whole.simulation is not None
        places = {one.name: (one.x_m, one.y_m) for one in whole.simulation.starts}
        assert arena.clearances(list(places.values())).min() >= crossing.robot.radius_m
        for a, b in combinations(places, 2):
            before = dist(
                (configured[a].start_x_m, configured[a].start_y_m),
                (configured[b].start_x_m, configured[b].start_y_m),
            )
            least = min(before, 2 * crossing.robot.radius_m + APART_M)
            assert dist(places[a], places[b]) >= least - 1e-12
        moved += any(places[n][0] != configured[n].start_x_m for n in places)
    assert moved > 25
    type(crossing).model_validate(whole.model_dump(mode="json", exclude={"dashboard"}))


def test_a_run_that_kills_its_worker_has_a_row_for_each_robot(crossing: Config) -> None:
    chosen = [variation(crossing, 5, run) for run in range(5)]
    sweep = Sweep(crossing, chosen, lambda: local_executor(2), 2, sweeps.always_killed)
    rows = list(sweep.rows())
    assert len(rows) == 5 * len(crossing.robots)
    killed = [row for row in rows if row.state == "killed"]
    assert {row.run for row in killed} == {3}
    assert {row.robot for row in killed} == {entry.name for entry in crossing.robots}
    assert sweep.deaths == MOST_ATTEMPTS


def test_the_command_gives_each_robot_a_row_with_its_name(tmp_path: Path) -> None:
    file = tmp_path / "hall.yaml"
    file.write_text(HALL)
    table = tmp_path / "s.csv"
    told = call("sweep", file, "--runs", 2, "--workers", 1, "-o", table, "--format", "json")
    assert told.code == 0, told
    summary = json.loads(told.out)
    assert summary["runs"] == 2
    assert summary["states"] == {"done": 4, "idle": 2}
    assert summary["measures"]["least_gap_m"]["least"] > 0.0
    with table.open(newline="") as written:
        rows = list(csv.DictReader(written))
    assert [(row["run"], row["robot"]) for row in rows] == [
        (run, name) for run in "01" for name in ("ada", "bob", "eve")
    ]
    assert all(float(row["least_gap_m"]) > 0.0 for row in rows)
    assert len({row["start_x_m"] for row in rows}) == 6
