"""Arenas in a map's coordinates: as far from the origin as rounding allows, the same answers."""

from __future__ import annotations

import numpy as np
import pytest

import planner


def _arena(x: float, y: float) -> planner.Scene:
    """4 m by 3 m with its corner at (x, y); every coordinate is a whole number of quarters."""
    return planner.read_scene_text(
        f"""#@ clearway.scene/1
#@ units m
#@ bounds given {x!r} {y!r} {x + 4!r} {y + 3!r}
C ({x + 1.5!r},{y + 1.25!r}) 0.375
C ({x + 3!r},{y + 2!r}) 0.5
S ({x + 0.5!r},{y + 2.5!r}) ({x + 2!r},{y + 2.25!r})
L 3 ({x + 2.25!r},{y + 0.25!r})({x + 2.25!r},{y + 1!r})({x + 3.25!r},{y + 0.75!r})
"""
    )


@pytest.mark.parametrize("corner", [(1e3, 1e3), (1e5, 1e5), (-5e5, 5.5e6), (1e7, 1e7)])
def test_answers_far_from_the_origin_are_those_near_it(corner: tuple[float, float]) -> None:
    x, y = corner
    near, far = (planner.build_roadmap(_arena(*at), 0.1) for at in ((0.0, 0.0), corner))
    assert len(far.graph) == len(near.graph)
    assert far.graph.number_of_edges() == near.graph.number_of_edges()
    pieces = [p for *_, d in far.graph.edges(data=True) for p in d["geometry"]]
    assert all(piece.curve != "straight" for piece in pieces)
    proved, wide = far.agvd.vertices_proved(0.1)
    assert proved == wide
    finest = np.spacing(max(abs(x), abs(y)))
    for prefer in ("clearance", "balanced", "length"):
        paths = [
            roadmap.plan((a + 0.5, b + 0.5), (a + 3.5, b + 1.25), prefer=prefer)
            for roadmap, a, b in ((near, 0.0, 0.0), (far, x, y))
        ]
        assert all(isinstance(path, planner.Path) for path in paths)
        widths = [path.min_clearance for path in paths]
        assert widths[1] == pytest.approx(widths[0], abs=256.0 * finest + 1e-6)
        if prefer == "length":
            assert paths[1].length == pytest.approx(paths[0].length, abs=1e-3)
