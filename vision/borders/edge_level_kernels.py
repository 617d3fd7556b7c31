"""The plateaus beside every crack of a border: how dark the obstacle is there, and how light it is.

Rules and units
- As in ``vision.borders.edge_kernels``: grey values, rows of ``work`` with a column a crack.
- A plateau is averaged over a stretch of the border, so that noise does not move the edge while
  uneven light does not either.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from planner.scene import FloatArray
from planner.scene.compile_options import LEAF, SUMS
from vision.shared.typed_numbers import NO, NONE, ONE, YES

STRETCH = 64
"""Cracks to either side over which the plateaus are averaged."""
SAME_GREY = 1e-9
"""A rounding of grey values."""


class Kind(NamedTuple):
    """The rows of one kind of plateau, dark or light; sums run up to every crack."""

    own: FloatArray
    """Every crack's plateau."""
    level: FloatArray
    """Its stretch's: what is looked for."""
    total: FloatArray
    """The sum of the plateaus."""
    number: FloatArray
    """How many there are."""
    others: FloatArray
    """How many of the other kind: without those there is no level either."""


@njit(**SUMS, forceinline=True)
def find_plateaus(n, work, sums):
    """Dark and light for every crack, from what lies within STRETCH of it.

    Near a corner the plateaus are not reached, so that the second round leaves out what is
    lighter or darker than the first round's mean. A crack whose stretch has none keeps its own.
    ``sums`` (4, n + 1) is room to work in.
    """
    reach = min(STRETCH, (n - 1) // 2)
    dark = Kind(work.dark, work.dark_level, sums[0], sums[1], sums[3])
    light = Kind(work.light, work.light_level, sums[2], sums[3], sums[1])
    # at first no plateau is too light or too dark
    dark.level[:n] = np.inf
    light.level[:n] = -np.inf
    for _ in range(2):
        _add_up(n, work.clear, dark, light)
        for kind in (dark, light):
            _set_level(NONE, reach, reach + 1, n - reach, YES, n, kind)
            _set_level(reach, n - reach, 2 * reach + 1, NONE, NO, n, kind)
            _set_level(n - reach, n, ONE, n - 2 * reach, YES, n, kind)


@njit(**LEAF, forceinline=True)
def _add_up(n, clear, dark, light):
    """Up to every crack: what is dark and how many, what is light and how many.

    Without what is lighter than the dark level known so far, or darker than the light one. Sums of
    whole and half grey values, and so exact: the same wherever a border begins.
    """
    a = 0.0
    b = 0.0
    c = 0.0
    d = 0.0
    for i in range(n):
        counts = clear[i] if dark.own[i] <= dark.level[i] + SAME_GREY else 0.0
        a += counts * dark.own[i]
        b += counts
        counts = clear[i] if light.own[i] >= light.level[i] - SAME_GREY else 0.0
        c += counts * light.own[i]
        d += counts
        dark.total[i + 1] = a
        dark.number[i + 1] = b
        light.total[i + 1] = c
        light.number[i + 1] = d


@njit(**SUMS)
def _set_level(begin, end, ahead, behind, around, n, kind):
    """The means of the stretches of cracks ``begin`` .. ``end`` - 1, dark or light.

    The stretch of the first one ends before crack ``ahead`` and begins at crack ``behind``;
    ``around``: past the border's end.
    One kind at a time: a loop that writes two rows works on one crack at a time.
    """
    cracks = end - begin
    own = kind.own[begin:end]
    level = kind.level[begin:end]
    total, count, others = kind.total, kind.number, kind.others
    total_ahead = total[ahead : ahead + cracks]
    count_ahead = count[ahead : ahead + cracks]
    others_ahead = others[ahead : ahead + cracks]
    total_behind = total[behind : behind + cracks]
    count_behind = count[behind : behind + cracks]
    others_behind = others[behind : behind + cracks]
    whole = 1.0 if around else 0.0
    whole_total = whole * total[n]
    whole_count = whole * count[n]
    whole_others = whole * others[n]
    for i in range(cracks):
        counted = count_ahead[i] - count_behind[i] + whole_count
        known = (counted > 0.0) & (others_ahead[i] - others_behind[i] + whole_others > 0.0)
        mean = (total_ahead[i] - total_behind[i] + whole_total) / max(counted, 1.0)
        level[i] = mean if known else own[i]
