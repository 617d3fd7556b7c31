"""Arrays about borders that kernels share: the pieces, and the tree that finds the nearest.

Rules and units
- All lengths are in the scene's units. A piece is a primitive of the scene or a corner point;
  pieces 0 to k - 1 are the primitives, and k to k + c - 1 the corner points.
- Kernels take named tuples at no cost.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Tree(NamedTuple):
    """The box tree of :func:`planner.borders.box_tree_kernels.build_tree` with its pieces.

    ``kind`` (n,) and ``data`` (n, 9) are the pieces, see :class:`Pieces`. ``order`` (k,) lists the
    primitives along a curve past their boxes; the first ``large`` of them are in no box. ``boxes``
    (2 leaves, 4) are x_min, y_min, x_max, y_max of every node.
    """

    kind: NDArray[np.int8]
    data: NDArray[np.float64]
    order: NDArray[np.int32]
    large: int
    boxes: NDArray[np.float64]


class Corners(NamedTuple):
    """The part of :class:`Pieces` that the diagram needs, and the primitives that meet in corners.

    A call passes on every array of a tuple, which slows the hottest loops.
    """

    kind: NDArray[np.int8]
    data: NDArray[np.float64]
    owner: NDArray[np.int32]
    before: NDArray[np.int32]
    after: NDArray[np.int32]


class Pieces(NamedTuple):
    """The pieces, and how they join.

    ``kind`` (k + c,) is POINT, SEGMENT, CIRCLE or ARC, ``data`` (k + c, 9) the rows of
    :func:`planner.scene.primitive_kernels.with_middles`, ``owner`` (k + c,) the object, -1 for the
    bounds. ``backwards`` (k,) marks arcs that run against their border; ``following``,
    ``preceding`` (k,) are the neighbours along it or -1; ``solid`` (k,) is +1 if the solid lies
    left of travel, -1 if right, 0 if both sides are free. ``before``, ``after`` (c,) are the
    primitives that meet in a corner point, -1 where a chain ends.
    """

    kind: NDArray[np.int8]
    data: NDArray[np.float64]
    owner: NDArray[np.int32]
    backwards: NDArray[np.bool_]
    following: NDArray[np.int32]
    preceding: NDArray[np.int32]
    solid: NDArray[np.int8]
    before: NDArray[np.int32]
    after: NDArray[np.int32]
