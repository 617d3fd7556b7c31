"""Half-edges: the Voronoi diagram of points as flat, read-only arrays, with its self-check.

Rules
- Edge j is the half-edges 2 j and 2 j + 1; the twin of half-edge e is e ^ 1.
- A half-edge runs from its `origin` to its twin's, with the site `cell` on its left, where x points
  right and y up; `next` and `prev` go counter-clockwise around that cell. An origin of -1 is at
  infinity; `next` passes over it, so every cell is a closed cycle.
- Edges without length (`zero_length`) connect the vertices of cocircular sites; the sites beside
  them are not neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner.delaunay.diagram_kernels import NOT_CONVEX, NOT_EMPTY, TURNED, WRONG_FLAG, certify
from planner.delaunay.site_order_kernels import TINY_COORDINATE

CHECK_TOLERANCE = 1e-9
"""Tolerance of a vertex's coordinates, in parts of the scene's size or its circle."""

_FAULTS = {
    TURNED: "vertex_sites[{}]: must turn counter-clockwise",
    NOT_EMPTY: "edge {}: a circle is not empty",
    WRONG_FLAG: "edge {}: zero_length is not what exact arithmetic says",
    NOT_CONVEX: "half-edge {}: the unbounded cells do not form a convex ring",
}


class DiagramError(AssertionError):
    """A broken invariant of a Voronoi diagram; the message gives it and its place."""


@dataclass(frozen=True, slots=True)
class HalfEdges:
    """Voronoi diagram with n sites, m vertices, k edges. Made by `planner.voronoi`.

    sites (n, 2); vertices (m, 2), the finite ones; vertex_sites (m, 3), the rows of each vertex's
    sites, counter-clockwise; origin, next, prev, cell (2 k,); zero_length (k,); representative
    (n,), the row of coincident sites that has their cell.
    """

    sites: NDArray[np.float64]
    vertices: NDArray[np.float64]
    vertex_sites: NDArray[np.int32]
    origin: NDArray[np.int32]
    next: NDArray[np.int32]
    prev: NDArray[np.int32]
    cell: NDArray[np.int32]
    zero_length: NDArray[np.bool_]
    representative: NDArray[np.int32]

    def __post_init__(self) -> None:
        for name in self.__slots__:
            getattr(self, name).setflags(write=False)

    def edges(self) -> NDArray[np.int32]:
        """(k, 4): site on the left, site on the right, vertex it comes from, vertex it goes to.

        A vertex of -1 is at infinity. Edges without length are included.
        """
        return np.hstack((self.cell.reshape(-1, 2), self.origin.reshape(-1, 2)))

    def neighbours(self) -> NDArray[np.int32]:
        """(., 2): sorted pairs i < j of sites whose cells share an edge with a length.

        Sites are named by their representatives.
        """
        pairs = self.cell.reshape(-1, 2)[~self.zero_length].astype(np.int64)
        keys = np.sort((pairs.min(axis=1) << 32) | pairs.max(axis=1))
        return np.column_stack((keys >> 32, keys & 0xFFFFFFFF)).astype(np.int32)

    def check(self) -> None:
        """Raise DiagramError if an invariant of Voronoi diagrams is broken.

        Twins, cycles, Euler's formula, equidistant vertices, convex cells and, exactly, empty
        circles. O(n log n).
        """
        _check_links(self)
        _check_cycles(self)
        _check_vertices(self)
        fault, where = certify(
            self.sites, self.vertex_sites, self.origin, self.prev, self.cell, self.zero_length
        )
        _require(fault == 0, _FAULTS.get(fault, "").format(where))
        _check_cover(self)
        _check_convex(self)


def _require(holds: bool | np.bool_, message: str) -> None:
    if not holds:
        raise DiagramError(message)


def _check_links(d: HalfEdges, simple: bool = True) -> None:
    n, m, h = len(d.sites), len(d.vertices), len(d.origin)
    e = np.arange(h)
    _require(h % 2 == 0, f"{h} half-edges: must be even")
    for name, array, lo, hi in (
        ("origin", d.origin, -1, m),
        ("next", d.next, 0, h),
        ("prev", d.prev, 0, h),
        ("cell", d.cell, 0, n),
        ("vertex_sites", d.vertex_sites, 0, n),
        ("representative", d.representative, 0, n),
    ):
        _require(((array >= lo) & (array < hi)).all(), f"{name}: must be in [{lo}, {hi})")
    _require(len(d.next) == len(d.prev) == len(d.cell) == h, "next, prev, cell: one per half-edge")
    _require(len(d.zero_length) == h // 2, "zero_length: one per edge")
    _require((d.cell != d.cell[e ^ 1]).all(), "twins must have different cells")
    _require((d.prev[d.next] == e).all(), "prev must undo next")
    _require((d.cell[d.next] == d.cell).all(), "next must stay in the cell")
    _require((d.origin[d.next] == d.origin[e ^ 1]).all(), "next must start where the edge ends")
    pairs = np.sort(d.cell.reshape(-1, 2), axis=1)
    _require(
        not simple or len(np.unique(pairs, axis=0)) == len(pairs),
        "two cells must share one edge only",
    )
    finite = d.origin >= 0
    uses = np.bincount(d.origin[finite], minlength=m)
    _require((uses == 3).all(), "three half-edges must start at each vertex")
    own = (d.vertex_sites[d.origin[finite]] == d.cell[finite, None]).sum(axis=1)
    _require((own == 1).all(), "a half-edge's cell must be one of its origin's sites")
    rep = d.representative
    _require((rep[rep] == rep).all() and (rep <= np.arange(n)).all(), "representative: first row")
    sites, _ = _unit(d)
    _require((sites[rep] == sites).all(), "representative: must coincide with its site")


def _check_cycles(d: HalfEdges) -> None:
    cells = np.flatnonzero(d.representative == np.arange(len(d.sites)))
    label, jump = np.arange(len(d.next)), d.next.astype(np.int64)
    for _ in range(max(len(d.next), 1).bit_length()):
        label, jump = np.minimum(label, label[jump]), jump[jump]
    cycles = d.cell[label == np.arange(len(label))]
    if len(cells) < 2:
        _require(len(d.origin) == 0 and len(d.vertices) == 0, "one cell has no border")
        return
    _require(
        len(cycles) == len(cells) and (np.sort(cycles) == cells).all(),
        "each cell must be one cycle",
    )
    euler = len(d.vertices) + 1 - len(d.origin) // 2 + len(cells)
    _require(euler == 2, f"vertices + 1 - edges + cells = {euler}: must be 2")


def _unit(d: HalfEdges) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sites and vertices scaled (by a power of two) to at most 1, sites rounded as when read."""
    exponent = int(np.frexp(np.abs(d.sites).max(initial=0.0))[1])
    return read_sites(d.sites, exponent), np.ldexp(d.vertices, -exponent)


def _tolerance(d: HalfEdges) -> float:
    """CHECK_TOLERANCE, or float64's finest step for sites that are hardly larger."""
    exponent = int(np.frexp(np.abs(d.sites).max(initial=0.0))[1])
    return max(CHECK_TOLERANCE, float(np.ldexp(4.0, -1074 - exponent)))


def read_sites(sites: NDArray[np.float64], exponent: int) -> NDArray[np.float64]:
    """Sites as the kernel sees them: times 2^-exponent, to multiples of 2^-268."""
    scaled = np.ldexp(sites, -exponent)
    return np.where(
        np.abs(scaled) < TINY_COORDINATE, (scaled + TINY_COORDINATE) - TINY_COORDINATE, scaled
    )


def _check_vertices(d: HalfEdges) -> None:
    sites, vertices = _unit(d)
    distance = np.hypot(*np.moveaxis(sites[d.vertex_sites] - vertices[:, None], 2, 0))
    spread = distance.max(axis=1, initial=0.0) - distance.min(axis=1, initial=np.inf)
    fair = spread <= _tolerance(d) * (1.0 + distance.max(axis=1, initial=0.0))
    for v in np.flatnonzero(~fair)[:1]:
        raise DiagramError(f"vertices[{v}]: not equidistant to its sites")


def _check_cover(d: HalfEdges) -> None:
    """Check that the vertices' triangles cover the sites' hull once, by area."""
    sites, _ = _unit(d)
    corner = sites[d.vertex_sites] - (sites[0] if len(sites) else 0.0)
    a, b, c = corner[:, 0], corner[:, 1], corner[:, 2]
    inner = _cross(b - a, c - a).sum()
    rays = np.flatnonzero(d.origin < 0)
    start = sites[0] if len(sites) else 0.0
    hull = _cross(sites[d.cell[rays]] - start, sites[d.cell[rays ^ 1]] - start).sum()
    _require(abs(inner - hull) <= CHECK_TOLERANCE, "the triangles must cover the hull once")


def _check_convex(d: HalfEdges) -> None:
    _, vertices = _unit(d)
    h = len(d.origin)
    e = np.arange(h)
    finite = (d.origin >= 0) & (d.origin[e ^ 1] >= 0)
    e = e[finite & finite[d.next]] if h else e
    p, q = vertices[d.origin[e]], vertices[d.origin[d.next[e]]]
    r = vertices[d.origin[d.next[e] ^ 1]]
    one, two = q - p, r - q
    reach = 1.0 + np.abs(np.concatenate((p, q, r), axis=1)).max(axis=1, initial=0.0)
    size = np.hypot(one[:, 0], one[:, 1]) + np.hypot(two[:, 0], two[:, 1])
    slack = _tolerance(d) * reach
    left = _cross(one, two) >= -slack * (size + slack)
    for i in np.flatnonzero(~left)[:1]:
        raise DiagramError(f"cell {d.cell[e[i]]}: not convex at vertex {d.origin[d.next[e[i]]]}")


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    result: NDArray[np.float64] = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return result
