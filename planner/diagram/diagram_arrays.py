"""Arrays about the diagram that kernels share: its mesh, its vertices, its chains.

Rules and units
- Scene's units, except ``FlatMesh.xy``. Triangles and half-edges are named as in
  :mod:`planner.delaunay.insertion_kernels`; there are t slots for triangles, two for each site.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class FlatMesh(NamedTuple):
    """Triangulated sites, as :func:`.mesh_kernels.nearest_piece` searches them.

    ``xy`` (2 ghost + 2,) are the sites in units of ``up``, a power of two, ``tri`` (8 t,) the
    triangles, ``label`` and ``also`` (ghost,) each site's piece and the next site at its place.
    ``stamp`` (ghost + 2,) and ``queue`` (ghost,) are working space; ``sag`` is that of
    :func:`.mesh.largest_sag`.
    """

    xy: NDArray[np.float64]
    tri: NDArray[np.uint32]
    label: NDArray[np.int32]
    also: NDArray[np.int32]
    stamp: NDArray[np.int32]
    queue: NDArray[np.int64]
    up: float
    sag: float


class MeshSites(NamedTuple):
    """The mesh's sites, ``used`` of which are taken.

    ``tri`` (8 t,) and per site ``alias``, the site that represents it, ``label``, its piece or -1,
    ``refined``, True if it was added around a vertex, and ``also``, the next at its place.
    """

    tri: NDArray[np.uint32]
    alias: NDArray[np.int64]
    label: NDArray[np.int32]
    refined: NDArray[np.bool_]
    also: NDArray[np.int32]
    used: int


class Triangles(NamedTuple):
    """State of every triangle, a vertex of the sampled diagram.

    ``seen`` (t, 3) are the sites it was computed for, ``at`` (t, 2) its circle's centre. ``place``
    (t, 2), ``rho`` (t,) and ``state`` (t,) are the vertex on the borders themselves, its clearance
    and its status, see :mod:`planner.diagram.vertex_kernels`. ``side`` (t,) is FREE or BLOCKED,
    ``mask`` (t,) its valid edges, and ``stale`` (t,) marks that chains through it must be traced
    again.
    """

    seen: NDArray[np.uint32]
    at: NDArray[np.float64]
    place: NDArray[np.float64]
    rho: NDArray[np.float64]
    state: NDArray[np.int8]
    side: NDArray[np.int8]
    mask: NDArray[np.uint8]
    stale: NDArray[np.bool_]


class DiagramTolerances(NamedTuple):
    """Half a spacing, the least relevant clearance of chains, and the difference of equal
    distances.
    """

    half: float
    relevant: float
    equal: float


class Traced(NamedTuple):
    """Chains as links.

    ``node`` (n,) are the nodes' triangles, ``ends`` (c, 2) each chain's nodes, ``first`` (c + 1,)
    the chains' offsets into ``link`` (l,), the half-edges crossed from inside; ``mask`` (t,) are
    the valid edges at that time.
    """

    mask: NDArray[np.uint8]
    node: NDArray[np.int32]
    ends: NDArray[np.int32]
    first: NDArray[np.int32]
    link: NDArray[np.int64]


class Bent(NamedTuple):
    """Geometry of chains.

    ``points`` (p, 3) are x, y and exact clearance, ``pieces`` (p, 2) those left and right of the
    next link (-1 at a chain's last point), ``start`` (c + 1,) the chains' offsets, and ``proved``
    (p,) is True if the next link is on its pieces' bisector.
    """

    points: NDArray[np.float64]
    pieces: NDArray[np.int32]
    start: NDArray[np.int32]
    proved: NDArray[np.bool_]


class KnownRuns(NamedTuple):
    """Chains as in :class:`Bent` whose points are found by their place.

    ``bits`` (p, 3) are the points as integers, ``table`` the points by their place's hash.
    """

    points: NDArray[np.float64]
    bits: NDArray[np.int64]
    pieces: NDArray[np.int32]
    proved: NDArray[np.bool_]
    table: NDArray[np.int32]


class ChainArrays(NamedTuple):
    """Measured chains, see :class:`planner.diagram.agvd.Chains`: p points in c chains."""

    points: NDArray[np.float64]
    first: NDArray[np.int32]
    pieces: NDArray[np.int32]
    proved: NDArray[np.bool_]
    rho: NDArray[np.float64]
    gap: NDArray[np.float64]
    step: NDArray[np.float64]
    ends: NDArray[np.int32]
    length: NDArray[np.float64]
    clearance: NDArray[np.float64]
