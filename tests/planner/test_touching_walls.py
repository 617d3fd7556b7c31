"""Walls that are objects of their own and touch: exact as one wall with corners is."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import planner
from planner.path import NoPath, Path
from planner.scene import Bounds, Scene, SegmentRecord, Vec
from tests.support.planner_scenes import box, scene_of

HALF = 13.86
BEND = [(100.0, 100.0), (300.0, 100.0), (300.0, 300.0)]
INNER = [(0.0, 127.72), (100.0, 127.72), (272.28, 127.72), (272.28, 300.0)]


def walls(*lines: list[Vec], turned: bool = False) -> Scene:
    made = [SegmentRecord(a, b) for line in lines for a, b in pairwise(line)]
    return scene_of(*(made[::-1] if turned else made), bounds=Bounds(0.0, 0.0, 400.0, 300.0))


@pytest.mark.parametrize("part", [0.3, 0.41, 0.7, 0.99, 0.9999999])
def test_a_corridor_between_touching_walls_is_exact_where_it_bends(part: float) -> None:
    """Where a wall ends at the next one no vertex was solved: the end's normal leads to it."""
    roadmap = planner.build_roadmap(walls(BEND, INNER), part * HALF)
    proved, wide = roadmap.agvd.vertices_proved(roadmap.radius)
    assert proved == wide
    least = min(d["clearance"] for *_, d in roadmap.graph.edges(data=True))
    assert least == pytest.approx(HALF, rel=1e-9)
    path = roadmap.plan((60, 60), (300 - HALF, 300 - HALF - 1), prefer="clearance")
    assert path.min_clearance == pytest.approx(HALF, rel=2e-6)


@pytest.mark.parametrize("radius", [13.9, 15.0, 20.0, 27.0])
def test_the_widest_robot_between_touching_walls_does_not_depend_on_the_radius(
    radius: float,
) -> None:
    answer = planner.build_roadmap(walls(BEND, INNER), radius).plan((60, 60), (300 - HALF, 280))
    assert isinstance(answer, NoPath)
    assert answer.widest_radius == pytest.approx(HALF, rel=1e-6)


def maze(seed: int) -> tuple[list[list[Vec]], float]:
    """Walls of a grid of cells, each an object of its own, and half a passage's width."""
    rng = np.random.default_rng(seed)
    cell, columns, rows = 40.0, 8, 6
    free = {((0, 0), (0, 0))}
    seen, stack = {(0, 0)}, [(0, 0)]
    while stack:
        x, y = stack[-1]
        near = [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)]
        near = [n for n in near if n not in seen and 0 <= n[0] < columns and 0 <= n[1] < rows]
        if not near:
            stack.pop()
            continue
        there = near[int(rng.integers(len(near)))]
        free |= {((x, y), there), (there, (x, y))}
        seen.add(there)
        stack.append(there)
    lines: list[list[Vec]] = []
    for x in range(columns):
        for y in range(rows):
            if x + 1 < columns and ((x, y), (x + 1, y)) not in free:
                lines.append([((x + 1) * cell, y * cell), ((x + 1) * cell, (y + 1) * cell)])
            if y + 1 < rows and ((x, y), (x, y + 1)) not in free:
                lines.append([(x * cell, (y + 1) * cell), ((x + 1) * cell, (y + 1) * cell)])
    return lines, 0.5 * cell


@pytest.mark.parametrize("seed", range(8))
def test_a_maze_takes_every_robot_that_fits_whatever_the_order_of_its_walls(seed: int) -> None:
    lines, half = maze(seed)
    frame = Bounds(0.0, 0.0, 320.0, 240.0)
    for turned in (False, True):
        made = [SegmentRecord(*line) for line in (lines[::-1] if turned else lines)]
        scene = scene_of(*made, bounds=frame)
        for radius in (half * (1.0 - 1e-7), 0.6 * half):
            path = planner.build_roadmap(scene, radius).plan((20, 20), (300, 220))
            assert isinstance(path, Path)
            assert path.min_clearance >= radius * (1.0 - 1e-9)
        for radius in (half * (1.0 + 1e-6), 1.3 * half):
            answer = planner.build_roadmap(scene, radius).plan((20, 20), (300, 220))
            assert isinstance(answer, NoPath)
            assert answer.widest_radius == pytest.approx(half, rel=1e-6)


def test_a_wall_that_ends_on_another_ones_side_is_exact_beside_it() -> None:
    """A tip on a side: their bisector is the normal there, which no diagram needs."""
    frame = Bounds(0.0, 0.0, 200.0, 160.0)
    tee = scene_of(
        SegmentRecord((20.0, 100.0), (180.0, 100.0)),
        SegmentRecord((100.0, 100.0), (100.0, 160.0)),
        box(60, 40, 140, 60),
        bounds=frame,
    )
    roadmap = planner.build_roadmap(tee, 5.0)
    proved, wide = roadmap.agvd.vertices_proved(5.0)
    assert proved == wide
    path = roadmap.plan((10, 80), (190, 80), prefer="clearance")
    assert path.min_clearance == pytest.approx(10.0)
