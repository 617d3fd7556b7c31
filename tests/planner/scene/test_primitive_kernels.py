"""The small operations on primitives that everything else is made of."""

from __future__ import annotations

import math

import numpy as np
import pytest

from planner.scene import ARC, CIRCLE, POINT, SEGMENT
from planner.scene.primitive_kernels import (
    circles_cross,
    grown,
    has_ends,
    is_round,
    on_circle,
    predecessor,
    put_rows,
    successor,
    with_middles,
)
from planner.scene.primitives import ROUND


def test_kinds_are_told_apart_by_name() -> None:
    kinds = (POINT, SEGMENT, CIRCLE, ARC)
    assert [k for k in kinds if is_round.py_func(k)] == list(ROUND) == [CIRCLE, ARC]
    assert [k for k in kinds if has_ends.py_func(k)] == [SEGMENT, ARC]


def test_a_ring_closes_at_both_ends() -> None:
    assert [successor.py_func(i, 3) for i in range(3)] == [1, 2, 0]
    assert [predecessor.py_func(i, 3) for i in range(3)] == [2, 0, 1]


def test_an_array_grows_at_its_end() -> None:
    array = np.arange(6.0).reshape(3, 2)
    more = grown.py_func(array, 5)
    assert more.shape == (5, 2)
    assert np.array_equal(more[:3], array)


def test_rows_of_any_number_of_columns_are_put_behind_others() -> None:
    for shape in ((), (2,), (2, 3)):
        into = np.zeros((5, *shape), np.int32)
        rows = np.arange(1, 2 * into[0].size + 1, dtype=np.int32).reshape(2, *shape)
        put_rows(into, 2, rows)
        assert np.array_equal(into[2:4], rows)
        assert not into[:2].any()
        assert not into[4:].any()


def test_a_point_of_a_circle_is_a_radius_from_its_centre() -> None:
    data = np.array([[3.0, -2.0, 5.0, 0.0, 0.0, 0.0]])
    x, y = on_circle.py_func(data, 0, 1.2)
    assert math.hypot(x - 3.0, y + 2.0) == pytest.approx(5.0)
    assert math.atan2(y + 2.0, x - 3.0) == pytest.approx(1.2)


def test_arcs_cross_where_both_sweep_over_a_common_point() -> None:
    kind = np.array([ARC, ARC, ARC], np.int8)
    rows = np.array(
        [
            (0.0, 0.0, 5.0, 0.0, 0.5 * math.pi, 0.0),
            (6.0, 0.0, 5.0, 0.5 * math.pi, 0.5 * math.pi, 0.0),
            (6.0, 0.0, 5.0, math.pi, 0.5 * math.pi, 0.0),
        ]
    )
    data = with_middles.py_func(kind, rows)
    assert circles_cross(data, 0, 1)
    assert not circles_cross(data, 0, 2)
