"""Ordinary Voronoi diagram of points: from sites to flat arrays, or to half-edges.

Rules
- Sites are rows of an (n, 2) array, in any unit, read as x right, y up. A cell's border runs
  counter-clockwise in that sense (clockwise on the screen for pictures, y down).
- Coincident sites share one cell; `representative` names the first row of each group.
- The common vertex of four or more sites on one empty circle appears once per triangle of some
  triangulation of them, joined by edges without length, which are flagged. All but the choice of
  triangulation is exact.
- Coordinates are read to 2^-268 of the largest: sites closer than that coincide.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from planner.delaunay.diagram_kernels import diagram
from planner.delaunay.half_edges import HalfEdges, read_sites
from planner.shared.arguments import as_numbers

Arrays: TypeAlias = tuple[NDArray[Any], ...]

LARGEST_SITE = 1e150
"""Coordinates beyond which vertices leave float64's range."""
MOST_SITES = 130_000_000
"""Sites whose half-edges fit 32-bit numbers."""


@dataclass(frozen=True, slots=True)
class DiagramArrays:
    """Voronoi diagram as raw, writable arrays; see `voronoi_arrays`."""

    vertices: NDArray[np.float64]
    vertex_sites: NDArray[np.int32]
    edges: NDArray[np.int32]
    zero_length: NDArray[np.bool_]
    representative: NDArray[np.int32]


def voronoi(sites: ArrayLike) -> HalfEdges:
    """Compute the Voronoi diagram of `sites` as half-edges.

    Sites: (n, 2) finite numbers of at most 1e150, n >= 0; a sequence or an array, which is not
    changed. Linear time on average; thread-safe, and releases the interpreter lock.

    Raises ValueError if the shape is wrong or a coordinate is not finite or too large.

    Method: K. Sugihara and M. Iri, "Construction of the Voronoi diagram for one million generators
    in single-precision arithmetic", Proc. IEEE 80 (1992).
    """
    points = _checked(sites)
    vertices, vertex_sites, edges, zero_length, representative, after, before = _compute(
        points, linked=True
    )
    return HalfEdges(
        sites=points.copy(),
        vertices=vertices,
        vertex_sites=vertex_sites,
        origin=edges[:, 2:].reshape(-1),
        next=after,
        prev=before,
        cell=edges[:, :2].reshape(-1),
        zero_length=zero_length,
        representative=representative,
    )


def voronoi_arrays(sites: ArrayLike) -> DiagramArrays:
    """Compute the Voronoi diagram of `sites` as edges only, for hot paths.

    Arrays as of `HalfEdges` and its ``edges``. Input, errors and method as in `voronoi`.
    """
    return DiagramArrays(*_compute(_checked(sites), linked=False)[:5])


def _checked(sites: ArrayLike) -> NDArray[np.float64]:
    try:
        points = np.ascontiguousarray(sites, dtype=np.float64)
    except (TypeError, ValueError):
        points = as_numbers("sites", sites, "places (n, 2)")
    if points.size == 0 and points.ndim <= 2:
        return np.empty((0, 2))
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(f"sites: shape {points.shape}: must be (n, 2)")
    if len(points) > MOST_SITES:
        raise ValueError(f"sites: {len(points)} rows: at most {MOST_SITES}")
    if not points.flags.writeable:
        # numba compiles again for read-only arrays; a copy is cheaper
        points = points.copy()
    good = (np.abs(points) <= LARGEST_SITE).all(axis=1)
    if not good.all():
        bad = int(np.argmin(good))
        raise ValueError(
            f"sites[{bad}] = ({points[bad, 0]}, {points[bad, 1]}): "
            f"must be finite and within +-{LARGEST_SITE:g}"
        )
    return points


def _compute(points: NDArray[np.float64], linked: bool) -> Arrays:
    if len(points) > 2:
        status, *arrays = diagram(points, linked)
        if status == 0:
            return tuple(arrays)
    return _on_one_line(points)


def _on_one_line(points: NDArray[np.float64]) -> Arrays:
    """Parallel edges from infinity to infinity."""
    n = len(points)
    exponent = int(np.frexp(np.abs(points).max(initial=0.0))[1])
    scaled = read_sites(points, exponent)
    order = np.lexsort((np.arange(n), scaled[:, 1], scaled[:, 0]))
    along = scaled[order]
    new = np.ones(n, dtype=bool)
    new[1:] = (along[1:] != along[:-1]).any(axis=1)
    first = order[new].astype(np.int32)
    representative = np.empty(n, dtype=np.int32)
    representative[order] = first[np.cumsum(new) - 1] if n else 0
    k = max(len(first) - 1, 0)
    edges = np.full((k, 4), -1, dtype=np.int32)
    edges[:, 0], edges[:, 1] = first[:-1], first[1:]
    # half-edge 2 i has site i on its left, 2 i + 1 has site i + 1: a middle cell has two
    before = np.arange(2 * k, dtype=np.int32)
    before[1:-1:2], before[2:-1:2] = before[2:-1:2].copy(), before[1:-1:2].copy()
    return (
        np.empty((0, 2)),
        np.empty((0, 3), dtype=np.int32),
        edges,
        np.zeros(k, dtype=np.bool_),
        representative,
        before.copy(),
        before,
    )
