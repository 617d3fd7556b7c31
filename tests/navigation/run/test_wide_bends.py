"""Robots of a fleet that cannot turn on the spot, in whole runs in virtual time."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from navigation.config import Config, load_config
from navigation.run.run_report import RunReport
from navigation.run.virtual_run import run_virtually
from navigation.run.virtual_world import VirtualWorld
from tests.support.robots.obedient_fleet import HALL

pytestmark = pytest.mark.slow

CONFIGS = Path(__file__).parents[3] / "configs"
ALCOVE = load_config(CONFIGS / "alcove.yaml", {})
TURNING_M = 0.15
STARTS = {"a": (0.3, 0.3, 30.0), "b": (2.1, 0.3, 150.0)}
GOALS = {"a": (2.1, 1.5), "b": (0.3, 1.5)}


def crossing(starts: dict[str, tuple[float, float, float]], give_up_s: float) -> Config:
    """Two whose paths cross in an arena without obstacles, each beginning as it stands."""
    config = ALCOVE.model_dump(mode="json", exclude_none=True)
    config["robot"] |= {"turns_on_spot": False, "turning_radius_m": TURNING_M}
    config["robots"] = [{"name": name, "marker_id": i} for i, name in enumerate(starts, 1)]
    config["mission"]["robots"] = [
        {"name": name, "stations": [dict(zip(("x_m", "y_m"), GOALS[name], strict=True))]}
        for name in starts
    ]
    config["simulation"]["arena_text"] = HALL
    config["simulation"]["starts"] = [
        {"name": name, **dict(zip(("x_m", "y_m", "heading_deg"), start, strict=True))}
        for name, start in starts.items()
    ]
    config["safety"] |= {"give_up_s": give_up_s}
    return Config.model_validate(config, context={"folder": CONFIGS}, strict=False)


def driven(config: Config) -> tuple[RunReport, VirtualWorld]:
    worlds: list[VirtualWorld] = []

    def make_world(*arguments: Any, **named: Any) -> VirtualWorld:
        worlds.append(VirtualWorld(*arguments, **named))
        return worlds[0]

    return run_virtually(config, pictures=False, make_world=make_world), worlds[0]


def test_they_drive_bends_that_they_can_and_never_touch() -> None:
    report, world = driven(crossing(STARTS, give_up_s=30.0))
    assert report.state == "done", report.reason
    assert report.least_gap_m is not None
    assert report.least_gap_m > 0.0
    for name, truth in world.truths.items():
        time_s, x, y, heading = truth.track().T
        speeds = np.hypot(np.diff(x), np.diff(y)) / np.diff(time_s)
        rates = np.abs(np.diff(np.unwrap(heading))) / np.diff(time_s)
        drives = speeds > 0.05
        assert np.count_nonzero(drives) > 200
        assert np.max(rates[drives] / speeds[drives]) <= 1.1 / TURNING_M
        # at a goal the reference robot turns to the last millimetres, alone too
        on_its_way = np.hypot(x[1:] - GOALS[name][0], y[1:] - GOALS[name][1]) > 0.02
        assert np.max(rates[(speeds < 0.01) & on_its_way]) <= 0.2, "it never turns while it stands"


def test_one_that_would_have_to_turn_on_the_spot_holds_and_says_where() -> None:
    """The other one drives, and is done."""
    starts = {"a": (0.3, 0.3, 180.0), "b": STARTS["b"]}
    report, world = driven(crossing(starts, give_up_s=8.0))
    a, b = report.robots["a"], report.robots["b"]
    assert (a.state, b.state) == ("failed", "done"), report.reason
    assert "at (0.3" in a.reason
    assert "cannot turn on the spot" in a.reason
    track = world.truths["a"].track()
    assert math.isclose(np.ptp(track[:, 1]) + np.ptp(track[:, 2]), 0.0, abs_tol=1e-3)
