"""The daemon is killed at any moment, another one started: the mission goes on where it was."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from navigation.journal.journal import Journal, owner_of
from navigation.mission.mission import State
from tests.support.runs.kills import drive_under_fire, stands
from tests.support.runs.virtual import short_config

TOUR = [
    {"x_m": 0.20, "y_m": 0.60, "dwell_s": 0.5},
    {"x_m": 0.15, "y_m": 1.15, "dwell_s": 0.5},
    {"x_m": 0.20, "y_m": 1.60, "dwell_s": 0.5},
]


@pytest.mark.parametrize(("seed", "power_cycles"), [(1, 0.0), (3, 0.5)])
def test_each_station_is_visited_once_however_often_the_program_is_killed(
    tmp_path: Path, seed: int, power_cycles: float
) -> None:
    told = drive_under_fire(short_config(TOUR), tmp_path / "journal", seed, 8, power_cycles)
    assert told.kills >= 4
    assert told.state is State.DONE, told.reason
    assert told.visits == [0, 1, 2]
    assert told.least_clearance_m >= 0.09


def test_after_the_end_nothing_is_left_to_go_on_with(tmp_path: Path) -> None:
    config = short_config(TOUR[:1])
    drive_under_fire(config, tmp_path / "journal", 4, 1)
    with Journal(tmp_path / "journal", owner_of(config)) as journal:
        assert journal.unfinished() is None


def test_stays_are_counted_once_and_passing_is_no_stay() -> None:
    config = short_config(TOUR)
    way = [(0.2, 0.2), *[(0.2, 0.6)] * 50, (0.2, 0.7), *[(0.2, 0.6)] * 50, (0.15, 1.15), (0.2, 1.3)]
    track = np.array([(0.02 * i, x, y, 0.0) for i, (x, y) in enumerate(way)])
    assert stands(track, config) == [0, 0]
