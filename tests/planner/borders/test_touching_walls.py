"""Walls of several objects that end at one another: where one ends, the diagram turns exactly."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import planner
from planner.scene import Scene

HALF_WIDTH = 13.86


def _walls(*lines: str) -> Scene:
    head = "#@ clearway.scene/1\n#@ units px\n#@ bounds given 0 0 400 300\n"
    return planner.read_scene_text(head + "".join(f"S {line}\n" for line in lines))


def _bent_corridor(turn: tuple[int, ...] = (0, 1, 2, 3, 4)) -> Scene:
    """A corridor between single segments, bent once, ``2 HALF_WIDTH`` wide all along."""
    near, far = 100 + 2 * HALF_WIDTH, 300 - 2 * HALF_WIDTH
    lines = (
        "(100,100) (300,100)",
        "(300,100) (300,300)",
        f"(100,{near}) ({far},{near})",
        f"({far},{near}) ({far},300)",
        f"(0,{near}) (100,{near})",
    )
    return _walls(*(lines[i] for i in turn))


@pytest.mark.parametrize("share", [0.3, 0.45, 0.6, 0.77, 0.9, 0.99, 1.0 - 1e-7])
def test_corridor_of_touching_walls_is_as_wide_as_it_is(share: float) -> None:
    roadmap = planner.build_roadmap(_bent_corridor(), HALF_WIDTH * share)
    clearances = [d["clearance"] for *_, d in roadmap.graph.edges(data=True)]
    assert min(clearances, default=HALF_WIDTH) == pytest.approx(HALF_WIDTH, abs=1e-6)
    path = roadmap.plan((60, 60), (300 - HALF_WIDTH, 285), prefer="clearance")
    assert isinstance(path, planner.Path)
    assert path.min_clearance == pytest.approx(HALF_WIDTH, rel=2e-4)


@pytest.mark.parametrize("radius", [13.87, 14.0, 17.0, 25.0])
def test_widest_robot_of_a_corridor_of_touching_walls_is_told(radius: float) -> None:
    told = planner.build_roadmap(_bent_corridor(), radius).plan((60, 60), (286.14, 285))
    assert isinstance(told, planner.NoPath)
    assert told.widest_radius == pytest.approx(HALF_WIDTH, rel=1e-6)


def test_touching_walls_may_come_in_any_order() -> None:
    lengths = set()
    for turn in itertools.islice(itertools.permutations(range(5)), 0, 120, 7):
        roadmap = planner.build_roadmap(_bent_corridor(turn), 8.0)
        edges = [d for *_, d in roadmap.graph.edges(data=True)]
        lengths.add((len(edges), round(sum(d["length"] for d in edges), 3)))
    assert len(lengths) == 1


@pytest.mark.parametrize(
    "second", ["(150,200) (150,290)", "(250,200) (150,200)", "(150,200) (90,260)"]
)
def test_vertices_beside_an_end_on_another_wall_are_exact(second: str) -> None:
    """An end on another wall's side, on its end and against its direction; a wall opposite."""
    scene = _walls("(60,200) (150,200)", second, "(40,160) (300,160)", "(100,200) (100,290)")
    roadmap = planner.build_roadmap(scene, 9.0)
    proved, wide = roadmap.agvd.vertices_proved(9.0)
    assert proved == wide


def test_points_on_walls_and_on_one_another_change_no_clearance() -> None:
    plain = _walls("(60,200) (250,200)", "(40,160) (300,160)")
    dotted = planner.read_scene_text(
        "#@ clearway.scene/1\n#@ units px\n#@ bounds given 0 0 400 300\n"
        "S (60,200) (250,200)\nS (40,160) (300,160)\nP (120,200)\nP (60,200)\nP (120,200)\n"
    )
    places = np.column_stack([np.linspace(70, 240, 40), np.full(40, 180.0)])
    for radius in (5.0, 9.0, 19.99):
        widths = []
        for scene in (plain, dotted):
            path = planner.build_roadmap(scene, radius).plan((20, 180), (330, 180), prefer=1.0)
            assert isinstance(path, planner.Path)
            widths.append(path.min_clearance)
        assert math.isclose(*widths, rel_tol=2e-4)
    assert planner.build_roadmap(dotted, 5.0).clearance(places) == pytest.approx(20.0)
