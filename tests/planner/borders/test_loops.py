"""The roadmap's loops are the free space's: one for each group of obstacles to drive round.

Each scene tempts the sampling: borders that are nearer to each other than samples of one of them,
so that circles through the samples reach through a wall, and hairpins of a bisector that a chord
would cut off.
"""

from __future__ import annotations

import networkx as nx
import pytest

import planner

HEAD = "#@ clearway.scene/1\n#@ units px\n#@ bounds given 0 0 400 300\n#@ object 0\n"
NEEDLE = """L 3 (371.02,104.89)(364.27,141.45)(359.89,162.09)
#@ object 1
S (191.28,185.42)(321.31,128.74)
"""
THIN_CRESCENT = """L 4 (230.294,40.605)(201.873,147.742)(202.985,146.983)(230.884,41.815)
#@ arc 1 262.418 106.465 73.2765 cw
#@ arc 3 262.418 106.465 71.9305 ccw
"""
CRESCENT_AT_THE_BOUNDS = """L 4 (-1.925,72.601)(-63.801,127.342)(-61.549,127.817)(-1.729,74.894)
#@ arc 1 3.982 141.619 69.2715 cw
#@ arc 3 3.982 141.619 66.9695 ccw
"""
THIN_ROOM = """L 4 (276.7,91.4)(392.7,91.4)(392.7,146.4)(276.7,146.4)
#@ hole
L 4 (277.4,92.1)(277.4,145.7)(392.0,145.7)(392.0,92.1)
"""
POINT_INSIDE_AN_ARC = """P (81.62,70.41)
#@ object 1
A 2 (100.5159,-37.5795)(79.2608,-29.7348)
#@ arc 1 110.38338529 21.87404615 60.26681170 cw
"""
ARC_AND_POINT = """A 2 (285.6354194,220.4637302)(409.4000162,221.9668874)
#@ arc 1 347.9221651 187.9145628 70.27863820 cw
#@ object 1
P (344.80684387,116.51279844)
"""
POINT_FARTHER_OFF = """A 2 (54.0953017,263.4273412)(172.8082991,152.6760566)
#@ arc 1 116.0941105 210.8839600 81.26905442 cw
#@ object 1
P (90.85384978,131.14830693)
"""


@pytest.mark.parametrize(
    ("text", "radius", "loops"),
    [
        pytest.param(NEEDLE, 16.0, 1, id="a needle and a wall, with room round both"),
        pytest.param(THIN_CRESCENT, 18.3, 0, id="a thin crescent, too near the bounds"),
        pytest.param(CRESCENT_AT_THE_BOUNDS, 34.0, 0, id="a thin crescent across the bounds"),
        pytest.param(THIN_ROOM, 12.0, 0, id="a room with thin walls, too near the bounds"),
        pytest.param(POINT_INSIDE_AN_ARC, 13.0, 0, id="a point inside an arc"),
        pytest.param(ARC_AND_POINT, 3.045, 0, id="a point beside an arc"),
        pytest.param(ARC_AND_POINT, 6.09, 0, id="a point beside an arc, sampled coarsely"),
        pytest.param(POINT_FARTHER_OFF, 16.4, 1, id="a point beside an arc, with room round both"),
    ],
)
def test_there_is_a_loop_for_each_way_round_and_no_other(text, radius, loops):
    graph = planner.build_roadmap(planner.read_scene_text(HEAD + text), radius).graph
    components = nx.number_connected_components(graph)
    assert graph.number_of_edges() - graph.number_of_nodes() + components == loops
