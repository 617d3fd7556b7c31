"""Yes-or-no clearance of lines: the same answer as the least distance over every primitive."""

from __future__ import annotations

import numpy as np
import pytest

from planner.borders import box_tree_kernels, clear_kernels
from planner.borders.generators import Borders, gather_borders
from planner.scene import FloatArray, primitive_kernels
from tests.support.scenes.planner_scenes import hand_made, random_scene, slow_distance


def _least(borders: Borders, a: FloatArray, b: FloatArray) -> float:
    """The least distance of a segment, over all primitives one by one."""
    return min(
        primitive_kernels.segment_distance(borders.kind, borders.data, i, *a, *b)[0]
        for i in range(borders.primitive_count)
    )


def _borders(seed: int) -> tuple[Borders, np.random.Generator]:
    rng = np.random.default_rng(seed)
    return gather_borders(random_scene(rng)), rng


@pytest.mark.parametrize("seed", range(20))
def test_a_line_is_blocked_exactly_where_some_primitive_is_nearer(seed: int) -> None:
    borders, rng = _borders(seed)
    for _ in range(60):
        a, b = rng.uniform(-10.0, 170.0, (2, 2))
        if rng.random() < 0.2:  # level and upright lines, and lines without a length
            b = np.where(rng.random(2) < 0.5, a, b)
        least = _least(borders, a, b)
        for keep in (0.5 * least, least * (1 - 1e-9), least * (1 + 1e-9) + 1e-12, least + 7.0):
            guess = int(rng.integers(-1, borders.primitive_count))
            met = clear_kernels.blocker(borders.tree, *a, *b, keep, guess)
            assert (met >= 0) == (least < keep)
            if met >= 0:
                away = primitive_kernels.segment_distance(borders.kind, borders.data, met, *a, *b)
                assert away[0] < keep


@pytest.mark.parametrize("name", list(hand_made()))
def test_a_polyline_keeps_what_its_least_distance_is(name: str) -> None:
    borders = gather_borders(hand_made()[name])
    rng = np.random.default_rng(5)
    for count in (1, 2, 3, 9):
        line = rng.uniform(0.0, 119.0, (count, 2))
        least = box_tree_kernels.polyline_clearance(borders.tree, line)[0]
        assert clear_kernels.keeps(borders.tree, line, least)
        assert not clear_kernels.keeps(borders.tree, line, least * (1 + 1e-9) + 1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_spare_room_is_the_distance_as_far_as_it_matters(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = random_scene(rng)
    borders = gather_borders(scene)
    points = rng.uniform(-20.0, 180.0, (100, 2))
    for (x, y), away in zip(points, slow_distance(scene, points), strict=True):
        for most in (0.0, 3.0, 50.0, np.inf):
            found, _ = box_tree_kernels.nearest(borders.tree, x, y, most)
            assert found == pytest.approx(min(most, away), abs=1e-9)
