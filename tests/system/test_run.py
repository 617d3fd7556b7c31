"""The whole loop on short missions: camera, planning, the wire, the robot, and every ending.

Time is the machine's own here: nothing may depend on its being fast.
"""

from __future__ import annotations

import json
import math
import re
import shutil
import signal
import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from pathlib import Path
from subprocess import PIPE
from typing import Any

import numpy as np
import pytest

from navigation.config import Config, load_config
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RobotSnapshot
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from navigation.run.kernels.warm_up import warm_up
from navigation.run.world import World
from planner.scene import Scene
from tests.support.pictures import call
from tests.support.processes.forked import Program
from tests.support.runs.light_camera import with_light_camera
from tests.support.waiting import wait_until

CONFIGS = Path(__file__).parents[2] / "configs"
MISSION = """mission:
  stations:
    - {x_m: 0.20, y_m: 0.75}
    - {x_m: 0.20, y_m: 1.40, heading_deg: 90}
"""
RADIUS_M = 0.09


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """Makes a short configuration, with texts replaced, beside copies of what it names."""
    shutil.copytree(CONFIGS, tmp_path, dirs_exist_ok=True)

    def write(*changes: tuple[str, str]) -> Path:
        text = with_light_camera((CONFIGS / "simulation.yaml").read_text())
        text = re.sub(r"^mission:\n(?:  .*\n)+", MISSION, text, flags=re.MULTILINE)
        text = text.replace("runs_dir: runs", f"runs_dir: {tmp_path / 'runs'}")
        for old, new in changes:
            assert old in text
            text = text.replace(old, new, 1)
        file = tmp_path / "short.yaml"
        file.write_text(text)
        return file

    return write


def the_run(folder: Path) -> Path:
    """The one folder that a run left."""
    (run,) = (folder / "runs").iterdir()
    return run


# The command.


def test_a_run_reaches_its_goal_and_leaves_its_report_and_picture(
    tmp_path: Path, write: Callable[..., Path]
) -> None:
    told = call("run", write(), "--once", "--report", tmp_path / "report.json")
    assert (told.code, told.err) == (0, ""), told
    report = json.loads((tmp_path / "report.json").read_text())
    assert json.loads((the_run(tmp_path) / "report.json").read_text()) == report
    assert_report_is_whole(report)
    assert (report["state"], report["stations"]) == ("done", 2)
    assert report["waypoints_sent"] >= report["waypoints_executed"] >= 4
    # beside much other work the robot may have held, and its path was sent once more
    assert report["replans"] > 0 or report["waypoints_executed"] == report["waypoints_sent"]
    assert report["goal_error_m"] < 0.02
    assert report["goal_error_deg"] < 5.0
    assert report["min_clearance_m"] >= RADIUS_M
    assert 0.0 < report["tracking_error_m"]["rms"] <= report["tracking_error_m"]["max"] < 0.05
    assert 3.0 < report["duration_s"] < 60.0
    assert report["frames"]["processed"] <= report["frames"]["captured"]
    assert report["frames"]["processed"] > 30
    assert report["link"]["frames"] > 30
    assert report["link"]["crc_errors"] == 0
    root = ElementTree.fromstring((the_run(tmp_path) / "track.svg").read_text())
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    for words in ("driving", "done", "least clearance", str(the_run(tmp_path))):
        assert words in told.out


def assert_report_is_whole(report: dict[str, Any]) -> None:
    """Every field of the design is there, with its type."""
    assert isinstance(report["reason"], str)
    for name in ("stations", "waypoints_sent", "waypoints_executed", "replans"):
        assert isinstance(report[name], int)
    for name in ("min_clearance_m", "goal_error_m", "goal_error_deg", "duration_s"):
        assert isinstance(report[name], float | None)
    assert set(report["tracking_error_m"]) == {"rms", "max"}
    assert set(report["link"]) == {"frames", "bytes", "retransmits", "crc_errors", "rtt_ms"}
    assert set(report["frames"]) == {"captured", "dropped", "processed"}
    assert set(report["latency_ms"]["capture_to_wire"]) == {"p50", "p99"}
    p50, p99 = (report["latency_ms"]["capture_to_wire"][p] for p in ("p50", "p99"))
    assert p50 is None or 0.0 < p50 <= p99


def test_a_goal_that_nobody_can_reach_ends_with_code_3_and_the_reason(
    tmp_path: Path, write: Callable[..., Path]
) -> None:
    """The goal lies in the U, whose mouth a bar closes."""
    arena = tmp_path / "arenas" / "laboratory.txt"
    bar = "\n#@ object 7\nL 4 (1.02,0.86) (1.60,0.86) (1.60,0.80) (1.02,0.80)\n"
    config = write(
        ("{x_m: 0.20, y_m: 1.40, heading_deg: 90}", "{x_m: 1.31, y_m: 0.55}"),
        ("safety:\n", "safety:\n  give_up_s: 3\n"),
    )
    arena.write_text(arena.read_text() + bar)
    told = call("run", config, "--once", "--report", tmp_path / "report.json")
    assert told.code == 3, told
    report = json.loads((tmp_path / "report.json").read_text())
    assert_report_is_whole(report)
    assert report["state"] == "failed"
    assert report["waypoints_executed"] == 0
    assert "no path" in report["reason"]
    assert "no path" in told.out
    assert "Traceback" not in told.err


def test_an_order_is_answered_with_what_it_led_to(write: Callable[..., Path]) -> None:
    file = write()
    socket = file.parent / "c.sock"

    def order(name: str) -> str:
        told = call(name, "--socket", socket)
        assert told.code == 0, told
        return told.out.split(":")[0]

    with Program(["run", file, "--no-dashboard", "--socket", socket], stdout=PIPE) as process:
        try:
            assert process.stdout is not None
            lines = iter(process.stdout.readline, "")
            assert any(re.search(r"driving +at ", line) for line in lines), "it never drove"
            assert order("pause") == "holding"
            # it brakes from the pause: "stopped" is said when the robot is known to stand
            assert order("stop") in ("stopped", "stopping")
            assert wait_until(lambda: order("status") == "stopped")
        finally:
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=30)


def test_ctrl_c_in_mid_run_ends_it_in_order(tmp_path: Path, write: Callable[..., Path]) -> None:
    report_file = tmp_path / "report.json"
    arguments = ("run", write(), "--once", "--report", report_file)
    with Program(arguments, stdout=PIPE, stderr=PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        lines = iter(process.stdout.readline, "")
        assert any(re.search(r"driving +at ", line) for line in lines), "it never drove"
        process.send_signal(signal.SIGINT)
        rest, err = process.communicate(timeout=30)
    assert process.returncode == 1
    assert "Traceback" not in err
    report = json.loads(report_file.read_text())
    assert (report["state"], report["reason"]) == ("stopped", "interrupted")
    assert report["waypoints_executed"] < report["waypoints_sent"]
    assert "interrupted" in rest
    assert (the_run(tmp_path) / "track.svg").exists()


# The daemon.


def test_a_computer_that_stands_still_meanwhile_makes_a_simulated_run_longer_and_not_wrong(
    tmp_path: Path, write: Callable[..., Path]
) -> None:
    report_file = tmp_path / "report.json"
    arguments = ("run", write(), "--once", "--report", report_file)
    with Program(arguments, stdout=PIPE) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if "driving" in line:
                break
        for _ in range(3):
            process.send_signal(signal.SIGSTOP)
            time.sleep(1.5)  # the computer is at a stop
            process.send_signal(signal.SIGCONT)
            time.sleep(0.5)  # it runs again, and the robot drives on
        said = process.stdout.read()
    report = json.loads(report_file.read_text())
    assert report["state"] == "done", report["reason"]
    assert "holding" not in said
    assert "slower than the wall's clock" in said


@pytest.fixture
def config(write: Callable[..., Path]) -> Config:
    loaded = load_config(write())
    warm_up(loaded, print)
    return loaded


@pytest.fixture
def world(config: Config) -> World:
    return World(config)


@pytest.fixture
def daemon(config: Config, world: World) -> Iterator[Daemon]:
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        yield daemon


def cycle_until(
    daemon: Daemon,
    reached: Callable[[RobotSnapshot], bool],
    each: Callable[[RobotSnapshot], None] = lambda _: None,
    patience_s: float = 40.0,
) -> RobotSnapshot:
    """Cycle until ``reached``, calling ``each`` after every cycle."""
    until_s = time.monotonic() + patience_s
    while True:
        now = daemon.cycle().only
        each(now)
        if reached(now):
            return now
        assert time.monotonic() < until_s, f"not within {patience_s} s: {now.sentence}"


def hide(
    world: World, is_hidden: Callable[[], bool]
) -> Callable[[str], tuple[float, float, float]]:
    """Let the camera see the robot far away while it is hidden; the true pose by its name."""
    simulation = world.simulation
    assert simulation is not None
    true = simulation.pose_at
    simulation.pose_at = (  # type: ignore[method-assign]
        lambda name, at_s: (-5.0, -5.0, 0.0) if is_hidden() else true(name, at_s)
    )
    return lambda name: true(name, world.clock())


def is_driving(now: RobotSnapshot) -> bool:
    return now.mission.state is State.DRIVING and now.link.executed >= 1


def centre(scene: Scene, index: int) -> tuple[float, float]:
    """The middle of the extent of an object's border."""
    rows = scene.primitives(include_bounds=False)
    data = rows.data[rows.owner == index, :2]
    low, high = data.min(axis=0), data.max(axis=0)
    return tuple((low + high) / 2.0)


def test_every_scene_seen_on_the_way_holds_the_arena_and_never_the_robot(
    daemon: Daemon, world: World
) -> None:
    truth = world.truths[""]
    drawn = truth.arena.scene
    scenes: dict[int, Scene] = {}

    def look(_now: RobotSnapshot) -> None:
        if daemon.scene is not None:
            scenes[id(daemon.scene)] = daemon.scene

    ended = cycle_until(daemon, lambda now: now.mission.is_over, look)
    assert ended.mission.state is State.DONE
    assert scenes
    for scene in scenes.values():
        assert scene.units == "m"
        assert len(scene.objects) == len(drawn.objects) == 7
        wanted = sorted(centre(drawn, k) for k in range(7))
        np.testing.assert_allclose(sorted(centre(scene, k) for k in range(7)), wanted, atol=0.03)
    track = truth.track()
    assert truth.arena.track_clearance(track[:, 1:3])[0] >= RADIUS_M
    assert math.dist(track[-1, 1:3], (0.20, 1.40)) < 0.02


def test_leaving_in_mid_run_leaves_a_robot_that_stands(config: Config, world: World) -> None:
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        cycle_until(daemon, is_driving)
        moving = world.truths[""].track()
    assert math.dist(moving[-1, 1:3], moving[0, 1:3]) > 0.005, "it had set off"
    track = world.truths[""].track()
    last = track[track[:, 0] > track[-1, 0] - 0.05]
    assert len(last) >= 2
    assert np.ptp(last[:, 1:3], axis=0).max() < 0.002
    assert math.dist(track[-1, 1:3], (0.20, 1.40)) > 0.1, "well before its goal"


def test_a_robot_that_is_not_in_view_is_held_and_that_is_said(config: Config, world: World) -> None:
    hide(world, lambda: True)
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        frames = cycle_until(daemon, lambda now: daemon.view.processed >= 20)
        assert frames.mission.state in (State.HOLDING, State.PLANNING)
        told = cycle_until(daemon, lambda now: now.mission.state is State.HOLDING)
        assert re.search(r"marker|robot", told.sentence)
        assert told.pose is None
    track = world.truths[""].track()
    assert np.ptp(track[:, 1:3], axis=0).max() < 1e-6, "it never moved"
