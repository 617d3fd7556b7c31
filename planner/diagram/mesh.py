"""Exact generalized diagram: a triangulation of generators, solved and refined in place.

Rules and units
- The sampled topology is a proposal. Its vertices are solved on their pieces, and each must be
  proved by an empty circle; otherwise generators are added at the feet around it. Parts that they
  do not touch are not solved again.
- Clearances below half the spacing are not refined: no robot of the radius gets there.
- Only its maker changes a mesh, and only until it is passed on.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from planner.borders.generators import SAME_PLACE, BoolArray, Borders, Generators, Mode
from planner.delaunay import insertion_kernels
from planner.delaunay.triangle_kernels import DEAD
from planner.delaunay.voronoi_diagram import DiagramArrays
from planner.diagram import mesh_kernels, vertex_kernels
from planner.diagram.chains import chain_kernels, trace_kernels
from planner.diagram.chains.bisector_trace import bend_chains
from planner.diagram.diagram_arrays import (
    Bent,
    DiagramTolerances,
    FlatMesh,
    KnownRuns,
    MeshSites,
    Traced,
    Triangles,
)
from planner.scene import FloatArray, IntArray
from planner.scene.primitives import ARC, CIRCLE

GENERATOR_ROUNDS = 6
"""Most rounds of adding generators; one or two suffice on random scenes."""
DOUBTS = 2
"""Rounds in which unsolved vertices ask for generators, too."""
SPARE_SHARE = 0.125
"""Capacity for generators to add, as a share of those present."""
ROWS = {
    "tri": (16, DEAD), "circ": (8, np.nan), "label": (1, 0), "refined": (1, 0), "also": (1, -1),
    "seen": (2, DEAD), "at": (2, np.nan), "place": (2, 0.0), "rho": (2, 0.0), "state": (2, 0),
    "side": (2, 0), "mask": (2, 0), "stale": (2, 0),
}  # fmt: skip
"""The mesh's arrays that grow with it: rows per site, and their filling."""


@dataclass(slots=True)
class Mesh:
    """Triangulation of generators with spare space, and its solved vertices.

    ``xy``, ``tri``, ``circ``, ``alias`` are as in :mod:`planner.delaunay.insertion_kernels`,
    ``label`` and ``also`` as in :mod:`planner.diagram.mesh_kernels`; ``refined`` marks sites added
    at feet around vertices; ``used`` sites are taken, of which ``vacant`` were removed again. The
    arrays of triangles are those of :class:`planner.diagram.diagram_arrays.Triangles`. ``traced``
    are the last chains, and ``bent`` their geometry.
    """

    xy: FloatArray
    tri: NDArray[np.uint32]
    circ: FloatArray
    alias: NDArray[np.int64]
    label: IntArray
    refined: BoolArray
    also: IntArray
    used: int
    exponent: int
    seen: NDArray[np.uint32]
    at: FloatArray
    place: FloatArray
    rho: FloatArray
    state: NDArray[np.int8]
    side: NDArray[np.int8]
    mask: NDArray[np.uint8]
    stale: BoolArray
    vacant: list[int]
    traced: Traced
    bent: Bent

    @property
    def triangles(self) -> Triangles:
        """State of every triangle, for kernels."""
        return Triangles(
            self.seen, self.at, self.place, self.rho, self.state, self.side, self.mask, self.stale
        )

    @property
    def sites(self) -> MeshSites:
        """The sites, for kernels."""
        return MeshSites(self.tri, self.alias, self.label, self.refined, self.also, self.used)

    @property
    def ghost(self) -> int:
        """Site at infinity, which is also the capacity for sites."""
        return len(self.alias)

    @property
    def up(self) -> float:
        """Factor that scales coordinates back."""
        return 2.0**self.exponent


def make_mesh(generators: Generators) -> Mesh | None:
    """Triangulate the generators; None if all of them are on one line."""
    n = len(generators.sites)
    spare = 64 + int(SPARE_SHARE * n)
    if n < 3:
        return None
    if not np.isfinite(generators.sites).all():
        raise ValueError("generators: must be finite")
    traced, bent = no_chains()
    status, order, xy, tri, circ, alias, exponent, _ = insertion_kernels.triangulate(
        generators.sites, spare
    )
    if status:
        return None
    ghost = n + spare
    label = np.zeros(ghost, np.int32)
    label[:n] = generators.label[order]
    return Mesh(
        xy=xy,
        tri=tri,
        circ=circ,
        alias=alias,
        label=label,
        refined=np.zeros(ghost, np.bool_),
        also=mesh_kernels.link_coincident(alias, label, ghost),
        used=n,
        exponent=exponent,
        seen=np.full((2 * ghost, 3), DEAD, np.uint32),
        at=np.full((2 * ghost, 2), np.nan),
        place=np.empty((2 * ghost, 2)),
        rho=np.zeros(2 * ghost),
        state=np.zeros(2 * ghost, np.int8),
        side=np.zeros(2 * ghost, np.int8),
        mask=np.zeros(2 * ghost, np.uint8),
        stale=np.zeros(2 * ghost, np.bool_),
        vacant=[],
        traced=traced,
        bent=bent,
    )


def no_chains() -> tuple[Traced, Bent]:
    """Chains of a mesh before any are traced."""
    none = np.empty(0, np.int32)
    zero = np.zeros(1, np.int32)
    return (
        Traced(
            np.empty(0, np.uint8), none, np.empty((0, 2), np.int32), zero, np.empty(0, np.int64)
        ),
        Bent(np.empty((0, 3)), np.empty((0, 2), np.int32), zero, np.empty(0, np.bool_)),
    )


def largest_sag(borders: Borders, half: float) -> float:
    """Largest s^2 / R of round primitives, s the chord from a place to its nearest site."""
    radii = borders.data[(borders.kind == CIRCLE) | (borders.kind == ARC), 2]
    radii = radii[radii > 0.0]
    chords = np.minimum(half, 0.4 * radii)
    return float((chords * chords / radii).max(initial=0.0))


def solve(mesh: Mesh, borders: Borders, spacing: float) -> None:
    """Solve the vertices, refine at non-empty circles, and bend the chains."""
    half = 0.5 * spacing
    pieces, tolerances = borders.corners, DiagramTolerances(half, half, borders.equal)
    sag = largest_sag(borders, half)
    flat, triangles = _flat(mesh, sag), mesh.triangles
    for turn in range(GENERATOR_ROUNDS + 1):
        missing = vertex_kernels.solve_vertices(
            flat, mesh.circ, pieces, triangles, borders.closed, borders.box, turn < DOUBTS,
            tolerances, SAME_PLACE * borders.extent,
        )  # fmt: skip
        if not len(missing[0]) or turn == GENERATOR_ROUNDS:
            old = mesh.bent
            kept, *traced, table, longest = chain_kernels.trace_again(
                flat, pieces, triangles, mesh.traced, old, tolerances
            )
            new = mesh.traced = Traced(*traced)
            known = KnownRuns(old.points, old.points.view(np.int64), old.pieces, old.proved, table)
            bent, missing = bend_chains(
                new.first[len(kept) :], new.link, flat, pieces, triangles, tolerances, known,
                longest,
            )  # fmt: skip
            mesh.bent = trace_kernels.join_chains(kept, old, bent) if len(kept) else bent
            if not len(missing[0]) or turn == GENERATOR_ROUNDS:
                break
        add_sites(mesh, *missing)
        flat, triangles = _flat(mesh, sag), mesh.triangles


def mark(mesh: Mesh, borders: Borders, spacing: float, mode: Mode) -> None:
    """Mark the sampled diagram's valid edges; solve nothing."""
    vertex_kernels.mark_changed(
        _flat(mesh, 0.0), mesh.circ, borders.corners, mesh.triangles, borders.closed, borders.box,
        0.5 * spacing, SAME_PLACE * borders.extent, mode == "paper",
    )  # fmt: skip


def lay_straight(mesh: Mesh) -> tuple[FloatArray, IntArray, IntArray, Traced]:
    """Chains of the marked diagram as sampled: points, pieces, offsets; and as links."""
    _, *parts = trace_kernels.trace_chains(mesh.tri, mesh.mask, mesh.stale, mesh.traced)
    traced = Traced(mesh.mask, *parts)
    laid = trace_kernels.lay_straight(_flat(mesh, 0.0), mesh.at, traced.first, traced.link)
    return *laid, traced


def _flat(mesh: Mesh, sag: float) -> FlatMesh:
    """Arrays of the mesh for :func:`planner.diagram.mesh_kernels.nearest_piece`."""
    stamp, queue = np.zeros(mesh.ghost + 2, np.int32), np.empty(mesh.ghost, np.int64)
    return FlatMesh(mesh.xy, mesh.tri, mesh.label, mesh.also, stamp, queue, mesh.up, sag)


def add_sites(
    mesh: Mesh,
    places: FloatArray,
    labels: IntArray,
    where: NDArray[np.int64],
    *,
    refined: bool = True,
) -> None:
    """Insert sites, each searched for from triangle ``where``."""
    insert(mesh, _numbers(mesh, len(places)), places, labels, where, refined=refined)


def insert(
    mesh: Mesh,
    todo: IntArray,
    places: FloatArray,
    labels: IntArray,
    where: NDArray[np.int64],
    *,
    refined: bool = False,
) -> None:
    """Insert the sites ``todo``; they are new if ``places`` are given."""
    spare = mesh_kernels.insert_sites(
        mesh.xy, mesh.circ, mesh.sites, 1.0 / mesh.up, todo, places, labels, where, refined
    )
    mesh.vacant.extend(spare.tolist())


def _numbers(mesh: Mesh, count: int) -> IntArray:
    """Numbers for new sites: vacant ones first."""
    again, mesh.vacant = mesh.vacant[:count], mesh.vacant[count:]
    new = count - len(again)
    if mesh.used + new > mesh.ghost:
        grow(mesh, new + mesh.ghost // 2)
    mesh.used += new
    return np.array([*again, *range(mesh.used - new, mesh.used)], np.int32)


def grow(mesh: Mesh, more: int) -> None:
    """Add capacity for ``more`` sites."""
    ghost, capacity = mesh.ghost, mesh.ghost + more

    def longer(array: NDArray[Any], length: int, fill: float) -> NDArray[Any]:
        out = np.full((length, *array.shape[1:]), fill, array.dtype)
        out[: len(array)] = array
        return out

    for name, array in (("tri", mesh.tri), ("seen", mesh.seen)):
        moved = array.reshape(-1, 8)[:, :3] if name == "tri" else array
        moved[moved == ghost] = capacity
    mesh.xy = longer(mesh.xy[:-2], 2 * capacity + 2, np.nan)
    mesh.alias = np.concatenate([mesh.alias, np.arange(ghost, capacity)])
    for name, (rows, fill) in ROWS.items():
        setattr(mesh, name, longer(getattr(mesh, name), rows * capacity, fill))


def copy_mesh(mesh: Mesh) -> Mesh:
    """Copy of a mesh that may be changed."""
    arrays = {name: getattr(mesh, name).copy() for name in ("xy", "alias", *ROWS)}
    return replace(mesh, vacant=list(mesh.vacant), **arrays)


def generators_of(mesh: Mesh, borders: Borders, spacing: float) -> Generators:
    """The mesh's sites, including added ones, in its own order."""
    sites = mesh.xy[: 2 * mesh.used].reshape(-1, 2) * mesh.up
    here = np.ones(mesh.used, np.bool_)
    here[mesh.vacant] = False
    return Generators(sites[here], mesh.label[: mesh.used][here], spacing, borders)


def ordinary(mesh: Mesh) -> tuple[DiagramArrays, BoolArray]:
    """Diagram of the generators, and its valid edges.

    Sites are numbered as in :func:`generators_of`.
    """
    *arrays, valid = mesh_kernels.ordinary(
        mesh.xy, mesh.ghost, mesh.exponent, mesh.tri, mesh.circ, mesh.alias, mesh.used, mesh.mask,
        np.array(mesh.vacant, np.int32),
    )  # fmt: skip
    return DiagramArrays(*arrays), valid
