"""The program of several robots is killed at any moment: every mission continues where it was."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from navigation.config import Config
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RunState
from navigation.mission.mission import State
from tests.support.runs.fleet_kills import drive_fleet_under_fire
from tests.support.runs.virtual import CONFIGS, alcove

STARTS = {"a": (0.3, 0.4), "b": (2.1, 0.4), "c": (1.2, 1.5)}
TOURS = {
    "a": [(0.3, 0.9), (0.9, 0.9)],
    "b": [(2.1, 0.9), (1.5, 0.9)],
    "c": [(1.6, 1.5), (0.9, 1.3)],
}


def hall(journal: Path, names: str, tasks: list[tuple[float, float]] | None = None) -> Config:
    """Robots in an empty hall, each with two stations, or with tasks for all of them."""
    body: dict[str, Any] = alcove().model_dump(mode="json", exclude_none=True)
    body["robots"] = [{"name": name, "marker_id": i + 1} for i, name in enumerate(names)]
    body["mission"]["robots"] = []
    if tasks is None:
        body["mission"]["robots"] = [
            {"name": n, "stations": [{"x_m": x, "y_m": y, "dwell_s": 0.5} for x, y in TOURS[n]]}
            for n in names
        ]
    body["tasks"] = [{"x_m": x, "y_m": y} for x, y in tasks or []]
    body["simulation"]["arena_text"] = (
        "#@ clearway.scene/1\n#@ units m\nL 3 (0.02,0.02) (0.02,0.06) (0.06,0.02)\n"
    )
    body["simulation"]["starts"] = [
        {"name": n, "x_m": STARTS[n][0], "y_m": STARTS[n][1]} for n in names
    ]
    body["recording"]["journal"] = str(journal)
    return Config.model_validate(body, context={"folder": CONFIGS}, strict=False)


@pytest.mark.parametrize(("seed", "power_cycles"), [(1, 0.0), (2, 0.4)])
def test_each_robot_visits_each_station_once_however_often_the_program_is_killed(
    tmp_path: Path, seed: int, power_cycles: float
) -> None:
    told = drive_fleet_under_fire(hall(tmp_path / "journal", "abc"), seed, 4, power_cycles)
    assert told.kills >= 3
    assert any("1 of 2 stations" in line for line in told.said), "some kill comes on the way"
    assert set(told.states.values()) <= {State.DONE, State.IDLE}, told.sentence
    assert told.visits == {"a": [0, 1], "b": [0, 1], "c": [0, 1]}
    assert told.least_gap_m > 0.0


def test_tasks_that_were_given_are_nobody_elses_after_a_kill(tmp_path: Path) -> None:
    config = hall(tmp_path / "journal", "abc", [(0.3, 1.4), (2.1, 1.4)])
    told = drive_fleet_under_fire(config, 3, 4)
    assert told.kills >= 2
    assert set(told.states.values()) <= {State.DONE, State.IDLE}, told.sentence
    assert sum("task" in line for line in told.said) == 2, told.said
    assert told.least_gap_m > 0.0


def test_one_that_was_stopped_stays_stopped_while_another_continues(tmp_path: Path) -> None:
    """A person has stopped one robot; the program dies and comes back for the other one only."""
    stopped: list[float] = []

    def look(daemon: Daemon, now: RunState) -> None:
        if not stopped and now.time_s > 1.5:
            stopped.append(now.time_s)
            daemon.people.stop("this one is to stay where it is", "b")
        elif len(stopped) == 1 and now.time_s > stopped[0] + 0.5:
            stopped.append(now.time_s)
            daemon.world.reaper.arm(1)  # type: ignore[attr-defined]

    told = drive_fleet_under_fire(hall(tmp_path / "journal", "ab"), 1, 0, look=look)
    assert told.kills == 1
    assert told.states["a"] is State.DONE
    assert told.visits["b"] == []
    assert any("b has nothing to continue: its mission was stopped" in line for line in told.said)
