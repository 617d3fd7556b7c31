"""The names of sides and half-edges."""

from __future__ import annotations

from planner.delaunay.triangle_kernels import next_side, previous_side, side_of, triangle_of


def test_sides_follow_each_other_round_the_triangle() -> None:
    assert [next_side.py_func(k) for k in range(3)] == [1, 2, 0]
    assert [previous_side.py_func(k) for k in range(3)] == [2, 0, 1]


def test_a_half_edge_is_a_side_of_its_triangle() -> None:
    for triangle in (0, 8, 8_000_000_000):
        for side in range(3):
            assert triangle_of.py_func(triangle + side) == triangle
            assert side_of.py_func(triangle + side) == side
