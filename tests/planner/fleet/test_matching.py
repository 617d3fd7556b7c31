"""Matchings of least cost, against all that there are."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.fleet.search.matching import match_for_last, match_for_sum


@st.composite
def costs(draw: st.DrawFn) -> Any:
    rows, columns = draw(st.integers(0, 5)), draw(st.integers(0, 5))
    # few different numbers give ties, and pairs that cannot be are drawn often
    number = st.one_of(st.sampled_from([0.0, 1.0, 2.0, np.inf]), st.floats(0.0, 1e3))
    values = draw(st.lists(number, min_size=rows * columns, max_size=rows * columns))
    return np.array(values, np.float64).reshape(rows, columns)


def all_matchings(table: Any) -> Any:
    """The costs of each matching of as many rows as can be matched."""
    rows, columns = table.shape
    found = []
    for chosen in itertools.product(range(-1, columns), repeat=rows):
        used = [(i, j) for i, j in enumerate(chosen) if j >= 0]
        if len({j for _, j in used}) == len(used) and all(np.isfinite(table[p]) for p in used):
            found.append([float(table[p]) for p in used])
    most = max(map(len, found))
    return [matching for matching in found if len(matching) == most]


def paid(table: Any, chosen: Any) -> list[float]:
    used = [(i, j) for i, j in enumerate(chosen.tolist()) if j >= 0]
    assert len({j for _, j in used}) == len(used)
    return [float(table[p]) for p in used]


@settings(max_examples=300, deadline=None)
@given(costs())
def test_the_sum_is_least_of_all_matchings(table: Any) -> None:
    found, every = paid(table, match_for_sum(table)), all_matchings(table)
    assert len(found) == len(every[0])
    assert sum(found) == pytest.approx(min(map(sum, every)), abs=1e-9)


@settings(max_examples=300, deadline=None)
@given(costs())
def test_the_last_is_least_and_then_the_sum(table: Any) -> None:
    found, every = paid(table, match_for_last(table)), all_matchings(table)
    assert len(found) == len(every[0])
    last = min(max(matching, default=0.0) for matching in every)
    assert max(found, default=0.0) == last
    best = min(sum(m) for m in every if max(m, default=0.0) == last)
    assert sum(found) == pytest.approx(best, abs=1e-9)
