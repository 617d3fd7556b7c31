"""What a run leaves behind: the stretches of its plans that were driven."""

from __future__ import annotations

import math

import numpy as np
import pytest

from navigation.loop.run_state import DrivenPlan
from navigation.run.run_folder import driven_stretches
from planner.formats.scene_io import read_scene_text
from planner.path import Path
from planner.roadmap.roadmap import build_roadmap

ROOM = read_scene_text("#@ clearway.scene/1\n#@ units m\n#@ bounds given 0 0 4 3\nC (2,1.2) 0.5\n")


def plan(*places: tuple[float, float]) -> Path:
    found = build_roadmap(ROOM, 0.2).plan(places[0], places[-1], via=places[1:-1], prefer="length")
    assert isinstance(found, Path)
    return found


def drive(points: np.ndarray, since_s: float, until_s: float) -> np.ndarray:
    """Rows of a track along ``points`` at even steps of time."""
    times = np.linspace(since_s, until_s, len(points))
    return np.c_[times, points, np.zeros(len(points))]


def test_a_replaced_plan_ends_where_the_robot_was():
    first, second = plan((0.5, 2.5), (3.5, 2.5)), plan((1.5, 2.5), (3.5, 0.5))
    line = np.c_[np.linspace(0.5, 1.5, 21), np.full(21, 2.5)]
    rest = np.asarray(second.points)
    track = np.vstack([drive(line, 10.0, 12.0), drive(rest, 12.01, 15.0)])
    plans = [DrivenPlan(first, None, 10.0), DrivenPlan(second, None, 12.0)]
    (stretch,) = driven_stretches(plans, track, 1.0)
    assert stretch[0] == pytest.approx((0.5, 2.5))
    assert math.dist(stretch[-1], (1.5, 2.5)) < 0.006
    assert np.abs(stretch[:, 1] - 2.5).max() < 1e-9


def test_one_plan_leaves_nothing_replaced():
    only = plan((0.5, 2.5), (3.5, 2.5))
    assert driven_stretches([DrivenPlan(only, None, 0.0)], drive(only.points, 0.0, 5.0), 1.0) == []


def test_a_plan_that_returns_to_its_beginning_is_cut_at_the_first_pass():
    tour = plan((0.5, 2.5), (3.5, 2.5), (0.6, 2.5))
    line = np.c_[np.linspace(0.5, 0.7, 9), np.full(9, 2.5)]
    after = plan((0.7, 2.5), (0.5, 0.5))
    plans = [DrivenPlan(tour, None, 0.0), DrivenPlan(after, None, 2.0)]
    (stretch,) = driven_stretches(plans, drive(line, 0.0, 2.0), 1.0)
    assert len(stretch) < 50
    assert math.dist(stretch[-1], (0.7, 2.5)) < 0.006
