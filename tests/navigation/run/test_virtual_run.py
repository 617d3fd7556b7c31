"""A whole run in virtual time: the real eye, pilot, planner, host's end and robot's end.

Most of these runs draw no picture. Those that do say what only pictures show.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from navigation.config import Config, limits_of, load_config
from navigation.loop.daemon import Daemon
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from navigation.run.run_folder import write_run
from navigation.run.run_report import summarise_run
from navigation.run.virtual_run import run_virtually
from navigation.run.virtual_world import VirtualWorld
from navigation.simulator.happenings import tracks_of
from tests.support.oracles.bends import bends_of
from tests.support.runs.light_camera import in_small_pictures
from tests.support.runs.virtual import CONFIGS, cycle_until, is_driving, short_config

pytestmark = pytest.mark.slow

NEAR = [{"x_m": 0.20, "y_m": 0.60}, {"x_m": 0.20, "y_m": 1.00, "heading_deg": 90.0}]


def test_a_run_in_virtual_time_reaches_its_goal_as_one_in_real_time_does() -> None:
    """With pictures: that the eye finds marker and obstacles as well as the truth tells them."""
    report = run_virtually(short_config(NEAR)).only
    assert (report.state, report.stations_visited) == ("done", 2)
    assert report.goal_error_m is not None
    assert report.goal_error_m < 0.005
    assert report.goal_error_deg is not None
    assert report.goal_error_deg < 1.0
    assert report.min_clearance_m is not None
    assert report.min_clearance_m >= 0.09
    assert report.tracking_error_m.rms is not None
    assert report.tracking_error_m.rms < 0.01
    assert report.waypoints_executed == report.waypoints_sent > 4
    assert report.frames.dropped == 0


def test_a_run_under_a_fisheye_reaches_its_goal_as_well() -> None:
    """A lens of 175 degrees, 1.2 m above the floor; the robot is seen at 50 degrees to its view.

    With pictures: that the marker is read and the obstacles are outlined through such a lens.
    """
    base = short_config(NEAR)
    assert base.simulation is not None
    lens = {"lens_model": "fisheye", "distortion": (-0.02, 0.004, -0.002, 0.0003)}
    camera = {
        **base.simulation.camera.model_dump(), **lens,
        "focal_px": 420.0, "centre_offset_px": (5.3, -3.8), "position_m": (1.155, 0.975, 1.2),
    }  # fmt: skip
    report = run_virtually(
        short_config(
            NEAR,
            simulation={"camera": camera},
            camera={"size_px": (1280, 960)},
            robot={"marker_size_m": 0.12},
        )
    ).only
    assert (report.state, report.stations_visited) == ("done", 2)
    assert report.goal_error_m is not None
    assert report.goal_error_m < 0.005
    assert report.min_clearance_m is not None
    assert report.min_clearance_m >= 0.09


@pytest.mark.parametrize("pictures", [True, False])
def test_a_run_in_virtual_time_is_the_same_every_time(pictures: bool) -> None:
    """With pictures too: what is drawn, binarised and outlined depends on nothing else."""
    config = short_config(NEAR[:1])
    one, again = (run_virtually(config, pictures=pictures) for _ in range(2))
    assert one.to_json() == again.to_json()


def test_another_seed_is_another_run_with_the_same_end() -> None:
    one, two = (
        run_virtually(short_config(NEAR[:1], simulation={"seed": n}), pictures=False)
        for n in (4, 5)
    )
    assert one.state == two.state == "done"
    assert one.to_json() != two.to_json()


def test_without_a_simulation_there_is_no_virtual_run() -> None:
    config = short_config(NEAR).model_copy(update={"simulation": None})
    with pytest.raises(ValueError, match="section 'simulation'"):
        run_virtually(config)


def test_time_stands_still_while_nobody_waits() -> None:
    world = VirtualWorld(short_config(NEAR), pictures=False)
    begun_s = world.clock()
    with Daemon(world.config, world, first_mission_id=7) as daemon:
        assert world.clock() == begun_s
        daemon.cycle()
        assert 0.0 < world.clock() - begun_s < 0.1


def test_the_driven_track_keeps_the_limits_of_turning_on_the_spot_and_on_arcs() -> None:
    """From the true headings every 20 ms, wherever the robot turns, drives or begins an arc."""
    config = short_config(
        [{"x_m": 0.15, "y_m": 1.15}, {"x_m": 0.60, "y_m": 1.60, "heading_deg": -90.0}]
    )
    world, limits = VirtualWorld(config, pictures=False), limits_of(config)
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        cycle_until(daemon, lambda now: now.mission.is_over)
    time_s, _, _, heading = world.truths[""].track().T
    rates = np.diff(np.unwrap(heading)) / np.diff(time_s)
    accelerations = np.diff(rates) / np.diff(time_s)[1:]
    assert 1.0 < np.abs(rates).max() <= 1.05 * limits.angular_rate_rad_s
    assert 3.0 < np.abs(accelerations).max() <= 1.05 * limits.angular_acceleration_rad_s2


def test_a_robot_that_turns_slowly_is_not_taken_to_come_no_nearer() -> None:
    values = short_config([{"x_m": 2.2, "y_m": 0.2}]).model_dump()
    values["simulation"]["start"]["heading_deg"] = 180.0
    values["robot"]["angular_rate_rad_s"] = 0.05
    report = run_virtually(Config.model_validate(values), pictures=False)
    assert report.state == "done", report.reason


def test_a_robot_that_cannot_turn_on_the_spot_drives_no_bend_tighter_than_it_can() -> None:
    """In the plan by its own waypoints, and on the ground by turning rate over speed.

    With pictures: outlines as they are fitted to a picture give this way; along the true ones the
    smoothed path bends too tightly and the mission is given up.
    """
    config = in_small_pictures(load_config(CONFIGS / "wide_bends.yaml", {}))
    world, tightest = VirtualWorld(config), 1.0 / config.robot.turning_radius_m
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        ended = cycle_until(daemon, lambda now: now.mission.is_over)
    assert ended.mission.state is State.DONE, ended.sentence
    (plan,) = daemon.robot.plans
    assert plan.trajectory is not None
    bends = bends_of(plan.trajectory)
    assert 0.5 * tightest < max(bends) <= 1.02 * tightest
    time_s, x, y, heading = world.truths[""].track().T
    speeds = np.hypot(np.diff(x), np.diff(y)) / np.diff(time_s)
    rates = np.abs(np.diff(np.unwrap(heading))) / np.diff(time_s)
    drives = speeds > 0.05
    assert np.count_nonzero(drives) > 300
    assert np.max(rates[drives] / speeds[drives]) <= 1.1 * tightest
    stands = speeds < 0.01  # on the spot it would turn with up to 2 rad/s
    assert np.max(rates[stands]) <= 0.1 + 0.01 * tightest, "it never turns while it stands"


def test_where_only_a_turn_on_the_spot_would_help_the_mission_ends_with_the_place() -> None:
    config = short_config(
        NEAR[1:],
        robot={"turns_on_spot": False, "turning_radius_m": 0.3},
        simulation={"start": {"x_m": 0.2, "y_m": 0.2, "heading_deg": 180.0}},
        safety={"give_up_s": 3.0},
    )
    world = VirtualWorld(config, pictures=False)
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        ended = cycle_until(daemon, lambda now: now.mission.is_over)
    assert ended.mission.state is State.FAILED
    assert "at (0.2" in ended.sentence
    assert "cannot turn on the spot" in ended.sentence
    track = world.truths[""].track()
    assert np.max(np.abs(np.unwrap(track[:, 3]) - track[0, 3])) < 0.01, "the robot was not moved"


def test_an_obstacle_appears_at_its_time_and_the_way_leads_around_it() -> None:
    """The way between wall and bucket is closed by another while the robot is on it."""
    bucket = {"record": "C (0.10,1.16) 0.08", "from_s": 3.0}
    config = short_config(
        [{"x_m": 0.20, "y_m": 1.60}],
        simulation={
            "obstacles": (bucket,),
        },
    )
    world = VirtualWorld(config, pictures=False)
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        cycle_until(daemon, is_driving)
        before = len(daemon.scene.objects) if daemon.scene else 0
        ended = cycle_until(daemon, lambda now: now.mission.is_over)
        assert ended.mission.state is State.DONE, ended.sentence
        assert daemon.scene is not None
        assert len(daemon.scene.objects) == before + 1
        assert daemon.robot.pilot.replans >= 1
    track = world.truths[""].track()
    assert world.truths[""].track_clearance(track) >= 0.09
    assert math.dist(track[-1, 1:3], (0.20, 1.60)) < 0.02


def test_the_planners_news_are_acted_on_at_once_not_with_the_next_picture() -> None:
    """With eight pictures a second a wait for one, or for the longest cycle, would show."""
    bucket = {"record": "C (0.10,1.16) 0.08", "from_s": 4.0}
    config = short_config(
        [{"x_m": 0.20, "y_m": 1.60}],
        simulation={"obstacles": (bucket,)},
        camera={"rate_hz": 8.0},
        safety={"pose_stale_s": 0.4, "frame_stale_s": 0.4},
    )
    world = VirtualWorld(config, pictures=False)
    slack_s = 0.015
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        cycle_until(daemon, is_driving)
        plans = daemon.robot.pilot.plans
        before = daemon.scene
        seen = cycle_until(daemon, lambda now: daemon.scene is not before)
        held = cycle_until(daemon, lambda now: now.mission.state is not State.DRIVING)
        planned = cycle_until(daemon, lambda now: daemon.robot.pilot.plans > plans)
        sent_s = planned.time_s - seen.time_s
        assert held.time_s - seen.time_s < world.times.scene_s + slack_s
        assert sent_s < world.times.scene_s + world.times.plan_s + slack_s


def test_a_vanished_obstacle_leaves_the_scene() -> None:
    """With pictures: that the watch over changes finds the floor where the obstacle was."""
    bucket = {"record": "C (1.30,1.00) 0.10", "until_s": 2.0}
    config = short_config(NEAR, simulation={"obstacles": (bucket,)})
    world = VirtualWorld(config)
    with Daemon(config, world, first_mission_id=7) as daemon:
        cycle_until(daemon, lambda now: daemon.scene is not None)
        assert daemon.scene is not None
        assert len(daemon.scene.objects) == 8
        cycle_until(daemon, lambda now: daemon.scene is not None and len(daemon.scene.objects) == 7)


def test_the_configuration_with_moving_robots_runs_to_done(tmp_path: Path) -> None:
    """One robot is let pass, one that stays is driven around, a bucket is planned around."""
    config = load_config(CONFIGS / "moving_obstacle.yaml", {})
    world = VirtualWorld(config, pictures=False)
    said: list[str] = []
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        ended = cycle_until(
            daemon, lambda now: now.mission.is_over, 90.0, lambda now: said.append(now.sentence)
        )
    assert ended.mission.state is State.DONE, ended.sentence
    assert any("robot 8 comes too near" in sentence for sentence in said)
    assert any("an obstacle leaves the path" in sentence for sentence in said)
    track = world.truths[""].track()
    assert world.truths[""].track_clearance(track) >= config.robot.radius_m
    scripted, began_s = tracks_of(config), world.truths[""].began_s
    for other in config.other_robots:
        for time_s, x, y, _ in track:
            there = scripted[other.marker_id].pose(time_s - began_s)[:2]
            assert math.dist((x, y), there) >= config.robot.radius_m + other.radius_m
    assert daemon.scene is not None
    assert len(daemon.scene.objects) == 8, "the other robots are not in the scene"
    for other in config.other_robots:
        seen = daemon.view.others.tracks[other.marker_id]
        time_s, *last = seen.rows()[-1]
        assert math.dist(last[:2], scripted[other.marker_id].pose(time_s - began_s)[:2]) < 0.01
    report = summarise_run(daemon, ended.mission.state, ended.sentence, ended.time_s)
    write_run(tmp_path, daemon, report)
    picture = (tmp_path / "track.svg").read_text()
    assert "robot 8" in picture
    assert "other robots (2), as seen last" in picture
