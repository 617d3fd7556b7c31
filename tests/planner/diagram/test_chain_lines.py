"""An edge drawn from its exact geometry lies on the bisector, between its ends, within flatness."""

from __future__ import annotations

import numpy as np
import pytest

import planner
from planner.diagram.bisectors import edge_curve
from planner.scene import CircleRecord
from tests.support.scenes.planner_scenes import box, scene_of

FLATNESS = 0.05


@pytest.fixture(scope="module")
def roadmap() -> planner.Roadmap:
    scene = scene_of(box(30, 30, 50, 60), CircleRecord((100.0, 70.0), 18.0), box(70, 20, 75, 24))
    return planner.build_roadmap(scene, 4.0)


def test_a_curve_runs_from_end_to_end_of_its_edge(roadmap: planner.Roadmap) -> None:
    for u, v, data in roadmap.graph.edges(data=True):
        curve = edge_curve(roadmap.borders, data["geometry"], FLATNESS)
        ends = {tuple(np.round(p, 6)) for p in curve[[0, -1]]}
        nodes = roadmap.graph.nodes
        assert ends == {tuple(np.round(nodes[n]["pos"], 6)) for n in (u, v)}


def test_a_curve_keeps_the_edges_clearance_and_length(roadmap: planner.Roadmap) -> None:
    for *_, data in roadmap.graph.edges(data=True):
        curve = edge_curve(roadmap.borders, data["geometry"], FLATNESS)
        gap = roadmap.path_clearance(curve).distance
        assert gap == pytest.approx(data["clearance"], abs=2.0 * FLATNESS)
        length = np.hypot(*np.diff(curve, axis=0).T).sum()
        assert length == pytest.approx(data["length"], rel=0.02)


def test_middles_of_a_curves_chords_are_as_near_to_a_second_border(
    roadmap: planner.Roadmap,
) -> None:
    borders = roadmap.borders
    for *_, data in roadmap.graph.edges(data=True):
        curve = edge_curve(borders, data["geometry"], FLATNESS)
        middles = 0.5 * (curve[1:] + curve[:-1])
        for x, y in middles:
            box_, circle, small = (
                np.hypot(max(30 - x, 0, x - 50), max(30 - y, 0, y - 60)),
                np.hypot(x - 100, y - 70) - 18,
                np.hypot(max(70 - x, 0, x - 75), max(20 - y, 0, y - 24)),
            )
            walls = (x + 0.5, 159.5 - x, y + 0.5, 119.5 - y)
            nearest, second = sorted([box_, circle, small, *walls])[:2]
            assert second - nearest <= 4.0 * FLATNESS
