"""Ways exactly as wide as the robot: found, and never narrower than that but for rounding."""

from __future__ import annotations

import numpy as np
import pytest

import planner
from planner.formats.map_files import parse_movingai
from planner.formats.scene_io import read_scene_text
from planner.path import NoPath, Path
from planner.scene import CircleRecord, Scene, SegmentRecord
from tests.support.scenes.planner_scenes import scene_of, slow_distance, with_hole

PREFERENCES = ["length", "balanced", "clearance"]
ROUNDING = 1e-12
"""Of the scene's size."""
CHORDS = 1e-9
"""Of the radius: a way round exactly as wide is followed in chords, which lie inside it."""
CORNERS = 1e-14
"""Of the scene's size: rounding where a bend of straight walls is followed in corners."""


def maze(seed: int, size: int = 31) -> Scene:
    """Passages one cell wide, with loops, from the cell (1, 1) to all that are odd."""
    rng = np.random.default_rng(seed)
    free = np.zeros((size, size), np.bool_)
    free[1, 1] = True
    stack = [(1, 1)]
    while stack:
        y, x = stack[-1]
        ways = [
            (y + 2 * dy, x + 2 * dx)
            for dy, dx in ((0, 1), (1, 0), (0, -1), (-1, 0))
            if 0 < y + 2 * dy < size and 0 < x + 2 * dx < size and not free[y + 2 * dy, x + 2 * dx]
        ]
        if not ways:
            stack.pop()
            continue
        v, u = ways[int(rng.integers(len(ways)))]
        free[(y + v) // 2, (x + u) // 2] = free[v, u] = True
        stack.append((v, u))
    loops = rng.random((size, size)) < 0.08
    loops[::2, ::2] = loops[[0, -1]] = loops[:, [0, -1]] = False
    rows = ["".join(".@"[not cell] for cell in row) for row in free | loops]
    return parse_movingai(f"type octile\nheight {size}\nwidth {size}\nmap\n" + "\n".join(rows), "")


@pytest.mark.parametrize("prefer", PREFERENCES)
@pytest.mark.parametrize("seed", range(6))
def test_passages_of_one_cell_take_a_robot_one_cell_wide(seed: int, prefer: str) -> None:
    """Clearances 2e-8 below the radius were answered, of a straight line put in across."""
    scene = maze(seed)
    path = planner.build_roadmap(scene, 0.5).plan((1, 1), (29, 29), prefer=prefer)
    assert isinstance(path, Path)
    # corners outside the bends keep it all
    assert path.min_clearance >= 0.5 - 31 * CORNERS
    wider = planner.build_roadmap(scene, 0.5 + 1e-6).plan((1, 1), (29, 29), prefer=prefer)
    assert isinstance(wider, NoPath)
    assert wider.widest_radius == pytest.approx(0.5, rel=1e-9)


@pytest.mark.parametrize("prefer", PREFERENCES)
@pytest.mark.parametrize("inner", [12.0, 30.0])
def test_a_round_passage_exactly_as_wide_takes_the_robot_but_for_its_chords(
    prefer: str, inner: float
) -> None:
    wall = with_hole(CircleRecord((80.0, 60.0), 58.0), CircleRecord((80.0, 60.0), inner + 20.0))
    roadmap = planner.build_roadmap(scene_of(wall, CircleRecord((80.0, 60.0), inner)), 10.0)
    path = roadmap.plan((80.0 - inner - 10.0, 60), (80.0 + inner + 10.0, 60), prefer=prefer)
    assert isinstance(path, Path)
    assert path.min_clearance >= 10.0 * (1.0 - CHORDS) - 160 * ROUNDING
    assert path.length == pytest.approx(np.pi * (inner + 10.0), rel=1e-6)


@pytest.mark.parametrize("prefer", PREFERENCES)
@pytest.mark.parametrize("cell", [0.05, 0.5, 1.0])
@pytest.mark.parametrize("corner", [0.0, 0.1, -3.3, 1.2345678, 4.98765])
def test_a_passage_of_one_cell_keeps_the_radius_wherever_its_map_lies(
    corner: float, cell: float, prefer: str
) -> None:
    """Chords across its bends were up to 5e-10 of the radius too near the inner corner."""
    x, y = corner, corner
    boxed = f"({x + cell!r},{y + cell!r})({x + cell!r},{y + 2 * cell!r})"
    boxed += f"({x + 5 * cell!r},{y + 2 * cell!r})({x + 5 * cell!r},{y + cell!r})"
    scene = read_scene_text(
        "#@ clearway.scene/1\n#@ units m\n"
        f"#@ bounds given {x!r} {y!r} {x + 6 * cell!r} {y + 3 * cell!r}\nL 4 {boxed}\n"
    )
    start, goal = (x + cell / 2, y + cell / 2), (x + 5.5 * cell, y + 2.5 * cell)
    path = planner.build_roadmap(scene, cell / 2).plan(start, goal, prefer=prefer)
    assert isinstance(path, Path)
    assert path.min_clearance >= cell / 2 - 1e-14


@pytest.mark.parametrize("prefer", PREFERENCES)
def test_no_way_is_narrower_than_a_station_that_stands_nearer_by_rounding(prefer: str) -> None:
    scene = scene_of(
        SegmentRecord((80.0, -0.5), (80.0, 50.0)), SegmentRecord((80.0, 70.0), (80.0, 119.5))
    )
    start, goal = (80.0 - 1e-8, 60.0), (20.0, 9.5 - 1e-8)
    path = planner.build_roadmap(scene, 10.0).plan(start, goal, prefer=prefer)
    assert isinstance(path, Path)
    standing = slow_distance(scene, np.array([start, goal])).min()
    assert standing < 10.0
    assert path.min_clearance >= standing - 160 * ROUNDING


NARROWEST = {
    "between a tip and a wall": "S (200,0) (200,110)\nS (0,150) (400,150)\n",
    "between slanting walls": "S (140,0) (200,110)\nS (0,180) (400,130)\n",
    "between two tips": "S (200,0) (200,110)\nS (207,300) (210,150)\n",
    "between a circle and a wall": "C (200,60) 50\nS (0,150) (400,150)\n",
}


@pytest.mark.parametrize("part", [0.3, 0.7, 0.95])
@pytest.mark.parametrize("name", list(NARROWEST))
def test_the_widest_ways_chords_do_not_make_it_narrow(name: str, part: float) -> None:
    """They cut the curve where it is narrowest: 0.8 % of the clearance was lost there."""
    scene = read_scene_text(
        f"#@ clearway.scene/1\n#@ units px\n#@ bounds given 0 0 400 300\n{NARROWEST[name]}"
    )
    fine = planner.build_roadmap(scene, 1.0).plan((60, 70), (340, 70), prefer="clearance")
    roadmap = planner.build_roadmap(scene, part * fine.min_clearance)
    path = roadmap.plan((60, 70), (340, 70), prefer="clearance")
    assert path.min_clearance >= fine.min_clearance * (1.0 - 1.5e-4)
