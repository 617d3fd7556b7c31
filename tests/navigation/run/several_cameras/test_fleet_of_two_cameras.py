"""Three robots under two cameras: in virtual time by ground truth, and as a whole program."""

from __future__ import annotations

import json
import math
from pathlib import Path
from subprocess import PIPE, STDOUT
from typing import Any

import numpy as np
import pytest
import yaml

from navigation.config import Config, load_config
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RunState
from navigation.run.calibrations import floor_plan_of
from navigation.run.virtual_run import run_virtually
from tests.support.processes.forked import Program
from tests.support.runs.troubled_world import TroubledWorld
from tests.support.runs.virtual import CONFIGS

pytestmark = pytest.mark.slow

RADIUS_M = 0.07
AWAY_S = 7.0
BRAKED_S = 0.35 + 0.3 + 0.5 + 0.5
"""A camera is lost, three pictures of the other one, the lease, and the brakes."""


def values() -> dict[str, Any]:
    """configs/two_cameras_fleet.yaml with pictures of half the size."""
    base = load_config(CONFIGS / "two_cameras_fleet.yaml", {}).model_dump()
    base["camera"]["size_px"] = (640, 480)
    base["simulation"]["camera"].update(focal_px=617.5, centre_offset_px=(2.6, -1.9))
    for one in base["robots"]:
        one["marker_size_m"] = 0.09
    return base


def near() -> Config:
    """Short ways, of which one crosses the seam."""
    base = values()
    goals = {"ada": (0.2, 0.8), "bob": (2.2, 0.8), "cleo": (1.7, 1.62)}
    base["mission"]["robots"] = [
        {"name": name, "stations": [{"x_m": x, "y_m": y}]} for name, (x, y) in goals.items()
    ]
    return Config.model_validate(base)


def test_robots_cross_the_seam_and_never_touch() -> None:
    """With pictures: that two cameras' pictures make one scene and one pose of each robot."""
    config = Config.model_validate(values())
    report = run_virtually(config)
    assert report.state == "done", report.reason
    assert {one.state for one in report.robots.values()} == {"done"}
    assert report.least_gap_m is not None
    assert report.least_gap_m > 0.005
    assert report.min_clearance_m is not None
    assert report.min_clearance_m > config.robot.radius_m
    assert all((one.goal_error_m or 1.0) < 0.01 for one in report.robots.values())


def test_a_lost_camera_holds_the_robots_and_they_finish_when_it_is_back() -> None:
    config = Config.model_validate(values())
    plan = floor_plan_of(config)
    assert plan is not None
    closed = plan.unknown((True, False))
    assert closed is not None
    lost_s: list[float] = []
    where: list[list[tuple[float, float]]] = []
    troubles: set[str] = set()

    def meet(world: TroubledWorld, since_s: float) -> None:
        places = [body.pose()[:2] for body in world.bodies.values()]
        if not lost_s and since_s > 3.0 and places[0][0] > 2.02:  # ada, where only one camera sees
            lost_s.append(since_s)
        away_s = since_s - lost_s[0] if lost_s else 0.0
        world.cameras["right"].camera_lost = 0.0 < away_s < AWAY_S
        if BRAKED_S + 0.1 * len(where) < away_s < AWAY_S:
            where.append(places)

    def look(_daemon: Daemon, now: RunState) -> bool:
        for one in now.robots.values():
            troubles.update(one.troubles)
        return False

    report = run_virtually(config, meet=meet, look=look, pictures=False, make_world=TroubledWorld)
    assert any("camera right is lost" in one for one in troubles)
    tracks = np.array(where).swapaxes(0, 1)
    within = [plan.is_unknown(closed, *track[0], RADIUS_M) for track in tracks]
    assert within[0]
    for track, is_within in zip(tracks, within, strict=True):
        if is_within:
            assert np.hypot(*(track - track[0]).T).max() < 0.005, "stands in what nobody sees"
        else:
            assert not any(plan.is_unknown(closed, x, y, RADIUS_M) for x, y in track)
    assert report.state == "done", report.reason
    assert report.least_gap_m is not None
    assert report.least_gap_m > 0.0
    assert report.min_clearance_m is not None
    assert report.min_clearance_m > config.robot.radius_m


def test_a_knock_of_one_camera_holds_all_robots() -> None:
    base = near().model_dump()
    tilt_deg = math.degrees(math.atan(4.0 / 617.5))
    base["simulation"]["cameras"][1]["knocks"] = [
        {"from_s": 2.0, "until_s": 5.0, "tilt_deg": (tilt_deg, 0.0)}
    ]
    held: dict[str, float] = {}

    def look(_daemon: Daemon, now: RunState) -> bool:
        for name, one in now.robots.items():
            if "camera right has moved" in " ".join(one.verdict.reasons):
                held.setdefault(name, now.time_s)
        return False

    report = run_virtually(Config.model_validate(base), look=look)
    assert set(held) == {"ada", "bob", "cleo"}
    assert all(2.0 < at_s < 3.0 for at_s in held.values())
    assert report.state == "done", report.reason


def test_the_whole_program_drives_them(tmp_path: Path) -> None:
    """Both cameras, three links and the planner in real time: how robots cross each other's ways is
    tested above."""
    base = near().model_dump(mode="json", exclude_none=True)
    base["simulation"]["arena"] = str(CONFIGS / "arenas" / "laboratory.txt")
    (tmp_path / "fleet.yaml").write_text(yaml.safe_dump(base))
    arguments = ["--once", "--no-dashboard", "--socket", "c.sock", "--report", "report.json"]
    program = Program(["run", "fleet.yaml", *arguments], cwd=tmp_path, stdout=PIPE, stderr=STDOUT)
    said, _ = program.communicate(timeout=200)
    assert program.returncode == 0, said
    assert "cameras left simulated, right simulated" in said
    report = json.loads((tmp_path / "report.json").read_text())
    assert {one["state"] for one in report["robots"].values()} == {"done"}
    assert report["least_gap_m"] > 0.0
