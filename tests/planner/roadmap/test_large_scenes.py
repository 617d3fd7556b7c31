"""Scenes that are large in one way: a maze's one long way, a plate with many holes, coin flips."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import planner
from planner.borders.polyline import fewer_vertices, points_at
from planner.formats.grid_maps import grid_scene
from planner.motion.smooth import smooth_path
from planner.motion.trajectory import default_limits, time_path
from planner.path import Path
from tests.support.scenes.mazes import Grid, maze, noise, plate
from tests.support.scenes.planner_scenes import slow_distance


@pytest.mark.parametrize(
    "grid", [plate(12), noise(48, np.random.default_rng(4)), maze(31, np.random.default_rng(2))]
)
def test_a_place_is_solid_where_its_cell_is_an_obstacle(grid: Grid) -> None:
    scene = grid_scene(grid)
    roadmap = planner.build_roadmap(scene, 0.4)
    places = np.random.default_rng(1).uniform(-0.49, len(grid) - 0.51, (4000, 2))
    places[1000:] = places[1000] + np.cumsum(0.1 * (places[1000:] % 1.0 - 0.5), axis=0)  # a walk
    places = np.clip(places, -0.49, len(grid) - 0.51)
    cells = np.floor(places + 0.5).astype(int)
    solid = grid[cells[:, 1], cells[:, 0]]
    clearance = roadmap.clearance(places)
    sure = np.abs(clearance) > 1e-9
    np.testing.assert_array_equal(clearance[sure] < 0.0, solid[sure])
    some = np.arange(0, len(places), 50)
    apart = slow_distance(scene, places[some])
    np.testing.assert_allclose(np.abs(clearance[some]), apart, atol=1e-9)


def test_a_long_path_through_a_maze_is_smoothed_and_timed() -> None:
    scene = grid_scene(maze(61, np.random.default_rng(1)))
    roadmap = planner.build_roadmap(scene, 0.3)
    path = roadmap.plan((1, 1), (59, 59))
    assert isinstance(path, Path)
    smooth = smooth_path(path, roadmap.path_clearance, roadmap.clearance, keep=0.3)
    assert smooth.min_clearance >= 0.3 - 1e-9
    assert smooth.length < path.length
    timed = time_path(smooth, default_limits(0.3), clearance=roadmap.clearance)
    waypoints = np.array([(w.x, w.y) for w in timed.waypoints])
    assert roadmap.path_clearance(waypoints).distance >= 0.3 - 1e-9


def test_points_along_a_polyline_are_those_of_linear_interpolation() -> None:
    rng = np.random.default_rng(3)
    line = rng.uniform(0.0, 9.0, (40, 2))
    line[7] = line[6]
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    at = np.concatenate([rng.uniform(-1.0, lengths[-1] + 1.0, 500), lengths])
    want = np.c_[np.interp(at, lengths, line[:, 0]), np.interp(at, lengths, line[:, 1])]
    np.testing.assert_allclose(points_at(line, lengths, at), want, atol=1e-12)
    np.testing.assert_array_equal(points_at(line, lengths, lengths)[[0, -1]], line[[0, -1]])


@pytest.mark.parametrize("spacing", [np.inf, 1.5])
def test_skipped_vertices_lie_near_their_chord(spacing: float) -> None:
    t = np.linspace(0.0, 9.0, 600)
    line = np.c_[t, np.sin(t)]
    kept = fewer_vertices(line, 0.01, spacing)
    assert kept[0] == 0
    assert kept[-1] == 599
    assert len(kept) < 60
    for a, b in pairwise(kept.tolist()):
        u = line[b] - line[a]
        off = line[a : b + 1] - line[a]
        assert np.abs(off[:, 0] * u[1] - off[:, 1] * u[0]).max() / np.hypot(*u) <= 0.01 + 1e-12
        assert np.hypot(*u) <= spacing
