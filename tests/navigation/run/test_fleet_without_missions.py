"""Robots whose mission is over, or that have none: they get tasks, and step aside for others."""

import math
from pathlib import Path

from navigation.config import Config, load_config
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RunState
from navigation.mission.mission import State
from navigation.run.virtual_run import run_virtually
from tests.support.runs.fleet_kills import drive_fleet_under_fire

CONFIGS = Path(__file__).parents[3] / "configs"
ALCOVE = load_config(CONFIGS / "alcove.yaml", {})
CLOSE_M = 0.02


def changed(config: Config, **sections: object) -> Config:
    body = config.model_dump(mode="json", exclude_none=True)
    for name, section in sections.items():
        body[name] = {**body[name], **section} if isinstance(section, dict) else section
    return Config.model_validate(body, context={"folder": CONFIGS}, strict=False)


def test_one_that_stands_in_the_corridor_steps_into_the_niche_and_comes_back() -> None:
    config = changed(
        ALCOVE,
        mission={"robots": [{"name": "left", "stations": [{"x_m": 2.2, "y_m": 0.9}]}]},
        simulation={
            "starts": [
                {"name": "left", "x_m": 0.2, "y_m": 0.9, "heading_deg": 0},
                {"name": "right", "x_m": 1.2, "y_m": 0.9, "heading_deg": 180},
            ]
        },
    )
    highest_m = 0.0
    ended_m = (0.0, 0.0)

    def look(daemon: Daemon, _now: RunState) -> bool:
        nonlocal highest_m, ended_m
        pose = daemon.robots["right"].pose
        highest_m = max(highest_m, 0.0 if pose is None else pose.y)
        ended_m = ended_m if pose is None else (pose.x, pose.y)
        return False

    report = run_virtually(config, look=look, pictures=False)
    assert report.robots["left"].state == "done"
    assert report.robots["right"].state == "done"
    assert highest_m > 1.05  # in the niche
    assert math.dist(ended_m, (1.2, 0.9)) < CLOSE_M  # back where it stood
    assert report.robots["right"].stations == 0
    assert report.least_gap_m is not None
    assert report.least_gap_m > 0.0


TOURS = {
    "robots": [
        {"name": "left", "stations": [{"x_m": 0.7, "y_m": 0.9}, {"x_m": 1.2, "y_m": 0.9}]},
        {
            "name": "right",
            "stations": [{"x_m": 2.2, "y_m": 0.9, "dwell_s": 10.0}, {"x_m": 0.2, "y_m": 0.9}],
        },
    ]
}
"""``left`` ends below the niche, in the path of ``right``, which stays where it is until then."""


def test_one_that_has_finished_its_mission_and_steps_aside_keeps_it() -> None:
    was_over, highest_m = False, 0.0

    def look(daemon: Daemon, now: RunState) -> bool:
        nonlocal was_over, highest_m
        left, pose = now.robots["left"].mission, daemon.robots["left"].pose
        was_over |= left.state is State.DONE
        assert len(left.stations) == 2
        if was_over:
            assert left.visited == 2
            highest_m = max(highest_m, 0.0 if pose is None else pose.y)
        return False

    report = run_virtually(changed(ALCOVE, mission=TOURS), look=look, pictures=False)
    assert highest_m > 1.05  # it has been in the niche
    for one in report.robots.values():
        assert (one.state, one.stations, one.stations_visited) == ("done", 2, 2)
        assert one.goal_error_m is not None
        assert one.goal_error_m < CLOSE_M


def test_a_kill_while_one_steps_aside_costs_it_neither_its_mission_nor_its_place(
    tmp_path: Path,
) -> None:
    journal = {"journal": str(tmp_path / "journal")}
    killed = False

    def look(daemon: Daemon, now: RunState) -> None:
        nonlocal killed
        pose = daemon.robots["left"].pose
        in_niche = pose is not None and pose.y > 1.0
        if in_niche and not killed and now.robots["left"].mission.visited == 2:
            killed = True
            daemon.world.reaper.arm(1)  # type: ignore[attr-defined]

    told = drive_fleet_under_fire(
        changed(ALCOVE, mission=TOURS, recording=journal), 1, 0, look=look
    )
    assert told.kills == 1
    assert "left continues: 2 of 2 stations were visited" in told.said
    assert told.states == {"left": State.DONE, "right": State.DONE}
    assert told.visits["left"] == [1, 1]  # it has come back
    assert told.least_gap_m > 0.0


def test_tasks_go_where_the_drive_is_short_not_where_the_air_is() -> None:
    """``right`` stands nearer to the task, on the other side of a wall."""
    wall = "L 4 (1.10,0.30) (1.10,1.79) (1.16,1.79) (1.16,0.30)"
    config = changed(
        ALCOVE,
        mission={"robots": []},
        tasks=[{"x_m": 0.95, "y_m": 1.5}],
        simulation={
            "arena_text": f"#@ clearway.scene/1\n#@ units m\n{wall}\n",
            "starts": [
                {"name": "left", "x_m": 0.2, "y_m": 1.5, "heading_deg": 0},
                {"name": "right", "x_m": 1.4, "y_m": 1.5, "heading_deg": 180},
            ],
        },
    )
    given: dict[str, int] = {}

    def look(daemon: Daemon, _now: RunState) -> bool:
        given.update({n: len(s.pilot.mission.stations) for n, s in daemon.robots.items()})
        return any(given.values())

    run_virtually(config, look=look, pictures=False)
    assert given == {"left": 1, "right": 0}
