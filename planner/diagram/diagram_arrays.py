"""What kernels pass on about the diagram: its mesh, its vertices, its chains.

Rules and units
- All places and clearances are in the scene's units, but for ``FlatMesh.xy``. Triangles and
  half-edges are named as in :mod:`planner.delaunay.insertion_kernels`; there is room for t
  triangles, two for each site.
- The classes are tuples of arrays, as in :mod:`planner.borders.border_arrays`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class FlatMesh(NamedTuple):
    """The triangulated sites, and what :func:`.mesh_kernels.nearest_piece` needs to search them.

    ``xy`` (2 ghost + 2,) are the sites in units of ``up``, a power of two, ``tri`` (8 t,) the
    triangles, ``label`` and ``also`` (ghost,) each site's piece and the next site at its place.
    ``stamp`` (ghost + 2,) and ``queue`` (ghost,) are working space; ``sag`` is that of
    :func:`.mesh_kernels.largest_sag`.
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
    """The mesh's sites as they come and go, ``used`` of which are taken.

    ``tri`` (8 t,) and per site ``alias``, the one that stands for it, ``label``, its piece or
    -1, ``refined``, whether it was added around a vertex, and ``also``, the next at its place.
    """

    tri: NDArray[np.uint32]
    alias: NDArray[np.int64]
    label: NDArray[np.int32]
    refined: NDArray[np.bool_]
    also: NDArray[np.int32]
    used: int


class Triangles(NamedTuple):
    """What is known of every triangle, which is a vertex of the sampled diagram.

    ``seen`` (t, 3) are the sites it was computed for, ``at`` (t, 2) its circle's centre.
    ``place`` (t, 2), ``rho`` (t,) and ``state`` (t,) are the vertex on the borders themselves,
    its clearance and what is known of it, see :mod:`planner.diagram.vertex_kernels`. ``side``
    (t,) says whether it is free, ``mask`` (t,) holds its valid edges, and ``stale`` (t,) says
    that chains through it are to be traced again.
    """

    seen: NDArray[np.uint32]
    at: NDArray[np.float64]
    place: NDArray[np.float64]
    rho: NDArray[np.float64]
    state: NDArray[np.int8]
    side: NDArray[np.int8]
    mask: NDArray[np.uint8]
    stale: NDArray[np.bool_]


class Tolerances(NamedTuple):
    """``half`` a spacing; the clearance from which on chains are ``relevant``; and how far apart
    ``equal`` distances may be."""

    half: float
    relevant: float
    equal: float


class Traced(NamedTuple):
    """Chains as links.

    ``node`` (n,) are the nodes' triangles, ``ends`` (c, 2) each chain's nodes, ``first`` (c + 1,)
    the chains' offsets into ``link`` (l,), the half-edges crossed from inside; ``mask`` (t,)
    are the valid edges as they were then.
    """

    mask: NDArray[np.uint8]
    node: NDArray[np.int32]
    ends: NDArray[np.int32]
    first: NDArray[np.int32]
    link: NDArray[np.int64]


class Bent(NamedTuple):
    """Where chains run.

    ``points`` (p, 3) are x, y and exact clearance, ``pieces`` (p, 2) those left and right of the
    link that follows (-1 at a chain's last point), ``start`` (c + 1,) the chains' offsets, and
    ``proved`` (p,) says whether the link that follows is on the bisector of its pieces.
    """

    points: NDArray[np.float64]
    pieces: NDArray[np.int32]
    start: NDArray[np.int32]
    proved: NDArray[np.bool_]


class KnownRuns(NamedTuple):
    """Chains as in :class:`Bent` whose points are found by their place.

    ``bits`` (p, 3) are the points' own as integers, ``table`` the points by their place's hash.
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
