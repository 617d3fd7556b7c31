"""With the last plan at hand the next one stays on it, unless another is better by a margin."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import planner
from planner.motion.smooth import smooth_path
from planner.path import Path
from planner.route.hysteresis import STAY
from planner.scene import CircleRecord, FloatArray, Scene
from planner.search.homotopy import anchors, word
from tests.support.scenes.planner_scenes import box, random_scene, scene_of

RADIUS = 4.0
START, GOAL = (10.0, 59.5), (150.0, 59.5)


def _wall(shift: float) -> Scene:
    """A box in the middle: the ways above and below it are as long but for ``shift``."""
    return scene_of(box(60.0, 40.0 + shift, 100.0, 79.0 + shift))


def _plan(scene: Scene, start: tuple[float, float] = START, **options: object) -> Path:
    path = planner.build_roadmap(scene, RADIUS).plan(start, GOAL, **options)  # type: ignore[arg-type]
    assert isinstance(path, Path)
    assert path.min_clearance >= RADIUS - 1e-6
    return path


def _is_above(path: Path) -> bool:
    y = np.interp(80.0, path.points[:, 0], path.points[:, 1])
    return bool(y > 59.5)


def _away(path: Path, line: FloatArray) -> float:
    """The farthest of the path's places from a polyline, by samples."""
    t = np.linspace(0.0, len(path.points) - 1.0, 2000)
    n = np.arange(len(path.points))
    at = np.c_[np.interp(t, n, path.points[:, 0]), np.interp(t, n, path.points[:, 1])]
    a, step = line[:-1], np.diff(line, axis=0)
    part = np.clip(
        ((at[:, None] - a) * step).sum(-1) / np.maximum((step**2).sum(-1), 1e-12), 0.0, 1.0
    )
    return float(np.hypot(*(at[:, None] - a - part[..., None] * step).T).min(axis=0).max())


@pytest.mark.parametrize("prefer", ["length", "balanced", "clearance"])
def test_noise_does_not_change_the_side(prefer: str) -> None:
    sides = [_is_above(_plan(_wall(s), prefer=prefer)) for s in (-0.05, 0.05)]
    assert sides[0] != sides[1]
    for before, after in ((-0.05, 0.05), (0.05, -0.05)):
        last = _plan(_wall(before), prefer=prefer)
        stayed = _plan(_wall(after), prefer=prefer, near=last)
        assert _is_above(stayed) == _is_above(last)


def test_a_way_that_is_much_better_is_taken() -> None:
    last = _plan(_wall(-0.05))
    moved = _wall(15.0 if _is_above(last) else -15.0)
    assert _is_above(_plan(moved, near=last)) != _is_above(last)


def test_a_robot_on_its_way_keeps_the_rest_of_it() -> None:
    last = _plan(_wall(-0.05))
    at = 0.7 * last.points[0] + 0.3 * last.points[1]
    rest = _plan(_wall(0.05), start=(float(at[0]), float(at[1])), near=last)
    assert _away(rest, last.points) <= 1e-6
    assert rest.length == pytest.approx(last.length - float(np.hypot(*(at - last.points[0]))))


def test_a_robot_beside_its_way_comes_back_to_it() -> None:
    last = _plan(_wall(-0.05))
    step = last.points[1] - last.points[0]
    at = last.points[0] + 0.3 * step + 0.8 * np.array([-step[1], step[0]]) / np.hypot(*step)
    path = _plan(_wall(0.05), start=(float(at[0]), float(at[1])), near=last)
    assert _is_above(path) == _is_above(last)
    assert _away(path, last.points) <= 0.8 + 1e-6
    turn = np.diff(np.unwrap(np.arctan2(*np.diff(path.points, axis=0).T[::-1])))
    assert np.abs(turn[0]) < 0.6


def test_a_blocked_way_is_left_for_one_on_the_same_side() -> None:
    last = _plan(_wall(-0.05))
    middle = last.points[np.argmin(np.abs(last.points[:, 0] - 80.0))]
    y = float(middle[1] + (8.0 if _is_above(last) else -8.0))
    blocked = scene_of(_wall(-0.05).objects[0].records[0], CircleRecord((80.0, y), 5.0))
    roadmap = planner.build_roadmap(blocked, RADIUS)
    assert roadmap.path_clearance(last.points).distance < RADIUS
    best = roadmap.plan(START, GOAL)
    stayed = roadmap.plan(START, GOAL, near=last)
    assert isinstance(best, Path)
    assert isinstance(stayed, Path)
    assert stayed.min_clearance >= RADIUS - 1e-6
    if _is_above(best) != _is_above(last):
        assert stayed.length <= best.length * 1.1


def test_another_goal_is_another_way() -> None:
    last = _plan(_wall(-0.05))
    roadmap = planner.build_roadmap(_wall(-0.05), RADIUS)
    alone = roadmap.plan(START, (20.0, 110.0))
    beside = roadmap.plan(START, (20.0, 110.0), near=last)
    assert isinstance(alone, Path)
    assert isinstance(beside, Path)
    assert beside.length <= alone.length * 1.05


def test_stations_that_are_behind_are_forgotten() -> None:
    roadmap = planner.build_roadmap(_wall(-0.05), RADIUS)
    last = roadmap.plan(START, GOAL, via=[(30.0, 20.0), (120.0, 20.0)])
    assert isinstance(last, Path)
    legs = np.split(last.points, last.stations[1:-1])
    here = (float(legs[1][0, 0]), float(legs[1][0, 1]))
    rest = roadmap.plan(here, GOAL, via=[(120.0, 20.0)], near=last)
    assert isinstance(rest, Path)
    assert _away(rest, last.points) <= 1e-6


def test_stations_on_one_spot_and_smoothed_paths_can_be_stayed_near() -> None:
    roadmap = planner.build_roadmap(_wall(-0.05), RADIUS)
    last = roadmap.plan(START, GOAL, via=[START, GOAL])
    assert isinstance(last, Path)
    again = roadmap.plan(START, GOAL, via=[START, GOAL], near=last)
    assert isinstance(again, Path)
    assert again.length == pytest.approx(last.length)
    smooth = smooth_path(last, roadmap.path_clearance, roadmap.clearance, keep=RADIUS)
    for path in (smooth, dataclasses.replace(last, stations=(0, 0, *last.stations[2:]))):
        near = roadmap.plan(START, GOAL, near=path)
        assert isinstance(near, Path)
        assert near.length <= last.length * (1.0 + STAY)


@pytest.mark.parametrize("seed", range(12))
def test_the_answer_is_never_worse_than_the_margin_nor_nearer_than_the_radius(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene, radius = random_scene(rng), float(rng.uniform(2.0, 6.0))
    roadmap = planner.build_roadmap(scene, radius)
    box_ = scene.bounds
    places = rng.uniform([box_.x_min, box_.y_min], [box_.x_max, box_.y_max], (80, 2))
    places = places[roadmap.clearance(places) >= radius]
    fewer = dataclasses.replace(scene, objects=scene.objects[:-1])
    before = planner.build_roadmap(fewer, radius)
    for a, b, c in zip(places[:12:3], places[1:12:3], places[2:12:3], strict=False):
        last = before.plan(tuple(a), tuple(b))
        if not isinstance(last, Path):
            continue
        for start in (a, c):
            best = roadmap.plan(tuple(start), tuple(b), prefer="length")
            stayed = roadmap.plan(tuple(start), tuple(b), prefer="length", near=last)
            assert isinstance(best, Path) == isinstance(stayed, Path)
            if isinstance(best, Path) and isinstance(stayed, Path):
                assert stayed.min_clearance >= radius - 1e-6
                assert stayed.length <= best.length * (1.0 + STAY) + 1e-9
                assert tuple(stayed.points[0]) == tuple(start)
                assert tuple(stayed.points[-1]) == tuple(b)


def test_alternatives_differ_from_the_way_that_is_stayed_on() -> None:
    last = _plan(_wall(-0.05))
    roadmap = planner.build_roadmap(_wall(0.05), RADIUS)
    path = roadmap.plan(START, GOAL, near=last, alternatives=1)
    assert isinstance(path, Path)
    assert len(path.alternatives) == 1
    places = anchors(roadmap.borders)
    assert word(places, path.points) == word(places, last.points)
    assert word(places, path.alternatives[0].points) != word(places, last.points)
