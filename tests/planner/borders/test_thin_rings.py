"""A picture of thin rings with gaps: its holes are full of needles and of arcs that cross."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import planner

RINGS = Path(__file__).parents[2] / "golden" / "thin_rings.txt"


@pytest.mark.parametrize("radius", [2.0, 8.0, 8.3, 8.318, 8.5])
def test_needles_and_crossing_arcs_do_not_halve_their_bisectors_for_ever(radius):
    roadmap = planner.build_roadmap(planner.load_scene(RINGS), radius)
    assert 0 < len(roadmap.chains.points) < 5_000
    for _, _, data in roadmap.graph.edges(data=True):
        line = np.asarray(data["polyline"])
        chords = np.linspace(line[:-1], line[1:], 9).reshape(-1, 2)
        assert roadmap.clearance(line).min() >= data["clearance"] - 1e-6
        assert roadmap.clearance(chords).min() >= data["clearance"] - 0.05 * roadmap.spacing
        assert data["clearance"] >= radius
