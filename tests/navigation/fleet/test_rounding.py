"""Rounded corners: nobody comes nearer than planned, waits stay, and hardly anybody has to stop."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import planner
from navigation.config import limits_of, load_config
from navigation.config.several.each_robot import each_robot
from navigation.fleet import planning
from navigation.fleet.planning import rules_of
from navigation.fleet.request import FleetAnswer, FleetRequest, Traveller
from navigation.fleet.rounding import CHORD_M, CutTrack, legs_of, rounded, split_track, thinned
from navigation.loop.stages import stations_of
from navigation.loop.traffic.fleet_planner import FleetPlanner
from navigation.simulator.arena import load_arena
from navigation.simulator.settings import true_start_of
from tests.navigation.fleet.test_fleet_promises import RADIUS_M, places, scene_of
from tests.support.oracles.fleet_judge import least_gap

CONFIGS = Path(__file__).parents[3] / "configs"
PIECE_M = 0.05


def planned(seed: int) -> tuple[planner.Roadmap, planner.FleetPlan, list[float]]:
    rng = np.random.default_rng(seed)
    roadmap = planner.build_roadmap(scene_of(), RADIUS_M)
    count = int(rng.integers(3, 7))
    starts, goals = (places(rng, roadmap, count).tolist() for _ in range(2))
    plan = planner.plan_fleet(roadmap, starts, goals, radii=RADIUS_M)
    assert isinstance(plan, planner.FleetPlan)
    return roadmap, plan, [RADIUS_M] * count


def waits(track: np.ndarray) -> list[tuple[float, float, float, float]]:
    """x, y, from, until of every wait."""
    return [(b[1], b[2], a[0], b[0]) for a, b in pairwise(track) if (a[1:] == b[1:]).all()]


@pytest.mark.parametrize("seed", range(8))
def test_nobody_comes_nearer_to_robots_or_walls_and_ends_and_waits_stay(seed: int) -> None:
    roadmap, plan, sizes = planned(seed)
    cut = [CutTrack.of(track, PIECE_M) for track in plan.tracks]
    smooth = rounded(
        roadmap,
        cut,
        sizes,
        PIECE_M,
        dict.fromkeys(range(len(cut)), 0.0),
        rules_of(roadmap, [()] * len(cut), sizes),
    )
    assert least_gap([one.targets for one in smooth], sizes) >= -1e-7
    for before, after in zip(plan.tracks, smooth, strict=True):
        for track in (after.fine, after.targets):
            assert roadmap.path_clearance(track[:, 1:]).distance >= RADIUS_M - CHORD_M
            assert (np.diff(track[:, 0]) >= 0.0).all()
            np.testing.assert_allclose(track[[0, -1]], before[[0, -1]])
            np.testing.assert_allclose(waits(track), waits(before))


def promised() -> FleetAnswer:
    """What the six of configs/fleet.yaml are promised."""
    config = load_config(CONFIGS / "fleet.yaml", {})
    alone = each_robot(config)
    fleet = FleetPlanner(alone)
    fleet.see(load_arena(config).scene, 1)
    asked = [
        Traveller(
            name, tuple(true_start_of(one)), stations_of(one)[0], one.robot.radius_m,
            limits_of(one),
        )
        for name, one in alone.items()
    ]  # fmt: skip
    answer = fleet.answer(FleetRequest(1, 1, tuple(asked)))
    assert answer.promises.keys() == alone.keys()
    return answer


def stops_and_seconds(answer: FleetAnswer) -> tuple[int, float]:
    """Of all robots: stops before their goals, and how long they would drive."""
    promises = answer.promises.values()
    driven_s = sum(one.trajectory.duration_s for one in promises if one.trajectory is not None)
    return sum(t.stops for one in promises for t in one.targets[:-1]), driven_s


def test_who_drives_round_corners_stops_at_few_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    stops, driven_s = stops_and_seconds(promised())
    monkeypatch.setattr(planning, "rounded", lambda _here, tracks, *_: tracks)
    stops_before, driven_before_s = stops_and_seconds(promised())
    assert stops_before >= 15
    assert stops <= 0.3 * stops_before
    assert driven_s < 0.85 * driven_before_s


def test_a_track_is_cut_where_it_waits() -> None:
    track = np.array([(0, 0, 0), (1, 1, 0), (2, 1, 0), (3, 1, 1), (4, 1, 1), (5, 2, 1)], float)
    assert [leg[:, 0].tolist() for leg in legs_of(track)] == [[0, 1], [2, 3], [4, 5]]


def test_thinned_targets_leave_the_track_by_no_more_than_the_cameras_error() -> None:
    turn = np.linspace(0.0, np.pi, 400)
    arc = np.column_stack([turn, 0.2 * np.cos(turn), 0.2 * np.sin(turn)])
    wait = np.vstack([arc, [[4.0, *arc[-1, 1:]], [5.0, -0.5, 0.0]]])
    fine = split_track(wait, PIECE_M)
    rows = thinned(fine, PIECE_M)
    kept = fine[rows]
    assert {0, 399, 400, len(fine) - 1} <= set(rows.tolist())
    steps = np.hypot(*np.diff(kept[:, 1:], axis=0).T)
    assert steps.max() <= PIECE_M + 1e-9
    assert len(rows) < 40
    for a, b in pairwise(rows):
        between = fine[a : b + 1, 1:]
        chord = between[-1] - between[0]
        if np.hypot(*chord) > 0.0:
            off = between - between[0]
            across = np.abs(off[:, 0] * chord[1] - off[:, 1] * chord[0]) / np.hypot(*chord)
            assert across.max() <= CHORD_M + 1e-12
