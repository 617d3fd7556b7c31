"""The memory that one border after the other is fitted in.

Rules and units
- Sizes are in points or cracks; a border never has more edges than those.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from vision.outline.corners.blurred_corner_kernels import CORNER_ROOM
from vision.outline.fit.moment_kernels import ROOM
from vision.outline.outline_types import (
    BorderPoints,
    CornerRoom,
    Cracks,
    Fillet,
    FinishedEdges,
    Gains,
    Outline,
    Review,
    Search,
    StretchFit,
    Work,
)


@njit(cache=True, nogil=True)
def make_work(longest, exact):
    """Memory to fit borders of up to ``longest`` points, and cracks where they are ``exact``."""
    most = longest + 1
    twice = 2 * most if exact else 1
    near = np.empty((2, most + 1), np.float64)
    return Work(
        BorderPoints(np.empty(2 * most, np.float64), np.empty(2 * most, np.float64), longest),
        Cracks(
            np.empty(twice, np.float64),
            np.empty(twice, np.float64),
            np.empty(twice, np.float64),
            np.empty(twice, np.float64),
            longest,
        ),
        np.empty(most, np.int64),
        make_outline(most),
        FinishedEdges(
            np.empty(most, np.int8), np.empty((most, 6), np.float64), np.empty(most, np.int64)
        ),
        Review(np.empty(most, np.bool_), np.empty(most, np.float64), np.empty(most, np.bool_)),
        Search(
            np.empty(most, np.int64),
            np.empty(most, np.float64),
            np.empty(most, np.float64),
            np.empty(most, np.int64),
            np.empty(most, np.bool_),
        ),
        StretchFit(
            np.zeros(ROOM, np.float64), np.empty(4, np.float64), np.empty(3, np.float64), near
        ),
        make_corner_room(most),
        np.empty(most, np.int64),
        np.empty(most, np.int64),
        np.empty(most, np.int64),
        np.empty(most, np.bool_),
        np.empty(most, np.bool_),
        np.empty(most, np.bool_),
        np.empty((most + 1, 2), np.int64),
        near,
        np.empty((2 * most, 6), np.float64),
        np.empty(3, np.float64),
        np.empty(3, np.float64),
        np.empty((2, 2), np.float64),
    )


@njit(cache=True, nogil=True)
def make_outline(most):
    """An outline of up to so many edges, still to be filled; none of them is a fillet."""
    return Outline(
        np.empty(most, np.int64),
        np.empty(most, np.bool_),
        np.zeros(most, np.bool_),
        np.empty((most, 5), np.float64),
        np.empty((most, 2), np.float64),
        np.empty((most, 2), np.int64),
        np.empty((most, 2), np.bool_),
        np.empty(most, np.int64),
    )


@njit(cache=True, nogil=True)
def make_corner_room(most):
    """Room to look at the corners of up to so many edges or points."""
    return CornerRoom(
        Fillet(
            np.empty(4, np.float64),
            np.empty(4, np.float64),
            np.empty(7, np.float64),
            np.empty(4, np.int64),
        ),
        Gains(np.empty(most, np.float64), np.empty(most, np.int64), np.empty((most, 2), np.int64)),
        np.empty((most, CORNER_ROOM), np.float64),
        np.empty(2 * most + 1, np.float64),
        np.empty(7, np.float64),
        np.empty(most, np.bool_),
        np.empty(most, np.bool_),
        np.empty(most, np.bool_),
        np.empty(most, np.int64),
        np.empty((most, 2), np.int64),
        np.empty(2 * most, np.int64),
        np.empty(2 * most, np.bool_),
        np.empty(2 * most, np.bool_),
    )
