"""Bends the chains onto their bisectors into newly allocated arrays.

Compiled as a part of a kernel that makes the arrays, bending takes 1.3 times as long.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from planner.borders.border_arrays import Corners
from planner.diagram.chains import chain_kernels
from planner.diagram.chains.bend_kernels import (
    RUN_HALVINGS,
    BendArrays,
    ChainPoints,
    ChainStations,
    MissingSites,
    Stack,
)
from planner.diagram.diagram_arrays import Bent, DiagramTolerances, FlatMesh, KnownRuns, Triangles
from planner.scene import FloatArray, IntArray

POINTS_AT_FIRST, MISSING_AT_FIRST = 64, 64
"""Initial capacity in points, and in missing sites."""


def bend_chains(
    first: IntArray,
    link: NDArray[np.int64],
    mesh: FlatMesh,
    pieces: Corners,
    triangles: Triangles,
    tolerances: DiagramTolerances,
    known: KnownRuns,
    longest: int,
) -> tuple[Bent, tuple[FloatArray, IntArray, NDArray[np.int64]]]:
    """Bend the chains onto their bisectors, with the narrowest place of every run.

    Chain c has the links ``first[c]`` to ``first[c + 1]`` of
    :func:`planner.diagram.chains.trace_kernels.trace_chains`; ``first`` need not begin at 0, and
    the longest chain has ``longest`` links. ``known`` runs
    (:mod:`planner.diagram.chains.kept_run_kernels`) are not bent again. Returns the chains, and the
    missing sites as :func:`planner.diagram.vertex_kernels.solve_vertices` does.
    """
    chains, most = len(first) - 1, longest + 1
    place = np.empty((most, 4))
    stations = ChainStations(
        place, place.view(np.int64), np.empty((most, 2), np.int32), np.empty((most, 2), np.int64)
    )
    depth = RUN_HALVINGS + 2
    stack = Stack(
        np.empty((depth, 2)), np.empty(depth, np.int64), np.zeros(depth, np.bool_),
        np.zeros(depth, np.bool_),
    )  # fmt: skip
    capacity, more = 2 * int(first[-1] - first[0] + chains) + POINTS_AT_FIRST, MISSING_AT_FIRST
    while True:
        out = ChainPoints(
            np.empty((capacity, 3)), np.empty((capacity, 2), np.int32),
            np.zeros(capacity, np.bool_), np.zeros(chains + 1, np.int32),
            np.empty(capacity, np.bool_), np.empty(capacity, np.bool_),
        )  # fmt: skip
        extra = MissingSites(
            np.empty((more, 2)), np.empty(more, np.int32), np.empty(more, np.int64)
        )
        n, missing = chain_kernels.bend(
            mesh, pieces, triangles, first, link, tolerances, known,
            BendArrays(out, extra, stations, stack),
        )  # fmt: skip
        if n >= 0 and missing >= 0:
            bent = Bent(out.points[:n], out.pieces[:n], out.start, out.proved[:n])
            place, label, where = extra
            return bent, (place[:missing], label[:missing], where[:missing])
        # rare: repeat it all with twice the space
        capacity, more = capacity * (1 + (n < 0)), more * (1 + (missing < 0))
