"""Robots without a mission of their own: they get tasks, and step aside for those that have one."""

from pathlib import Path

from navigation.config import Config, load_config
from navigation.loop.fleet.fleet_daemon import FleetDaemon
from navigation.loop.fleet.fleet_state import FleetState
from navigation.run.fleet.fleet_virtual_run import run_fleet_virtually

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

    def look(daemon: FleetDaemon, _now: FleetState) -> bool:
        nonlocal highest_m
        pose = daemon.seats["right"].pose
        highest_m = max(highest_m, 0.0 if pose is None else pose.y)
        return False

    report = run_fleet_virtually(config, look=look, pictures=False)
    assert report.robots["left"].state == "done"
    assert report.robots["right"].state == "done"
    assert highest_m > 1.05  # in the niche
    error_m = report.robots["right"].goal_error_m
    assert error_m is not None
    assert error_m < CLOSE_M  # back where it stood
    assert report.least_gap_m is not None
    assert report.least_gap_m > 0.0


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

    def look(daemon: FleetDaemon, _now: FleetState) -> bool:
        given.update({n: len(s.pilot.mission.stations) for n, s in daemon.seats.items()})
        return any(given.values())

    run_fleet_virtually(config, look=look, pictures=False)
    assert given == {"left": 1, "right": 0}
