"""Approximate generalized Voronoi diagram: the generators' diagram without invalid edges.

Rules and units
- ``mode="paper"`` omits the edges between generators of one object, as the paper does.
- ``mode="exact"`` omits only those within one piece of a border, so that the free space inside a U,
  or in a room whose wall is one object, keeps its diagram.
- A chain is a maximal run of valid edges between nodes. Its clearances are exact distances to the
  borders.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from planner.borders.generators import BoolArray, Borders, Generators, Mode
from planner.delaunay.voronoi_diagram import DiagramArrays, voronoi_arrays
from planner.diagram import agvd_kernels as kernels
from planner.diagram.chains import chain_kernels
from planner.diagram.diagram_arrays import Bent, ChainArrays
from planner.diagram.mesh import (
    Mesh,
    generators_of,
    lay_straight,
    mark,
    no_chains,
    ordinary,
    solve,
)
from planner.diagram.vertex_kernels import EXACT, UNUSED
from planner.scene import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class Agvd:
    """Generators, their diagram, and its valid edges.

    There is no ``mesh`` if all generators are on one line.
    """

    borders: Borders
    spacing: float
    mesh: Mesh | None
    _made: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)

    @property
    def generators(self) -> Generators:
        """All generators, including those added by refinement."""
        if "generators" not in self._made:
            assert self.mesh is not None
            self._made["generators"] = generators_of(self.mesh, self.borders, self.spacing)
        return self._made["generators"]  # type: ignore[no-any-return]

    @property
    def ordinary(self) -> DiagramArrays:
        """The generators' ordinary Voronoi diagram."""
        return self._diagram()[0]

    @property
    def valid(self) -> BoolArray:
        """(m,) True for edges of the ordinary diagram in the generalized one's free part."""
        return self._diagram()[1]

    def _diagram(self) -> tuple[DiagramArrays, BoolArray]:
        if "diagram" not in self._made:
            if self.mesh is None:
                sites = voronoi_arrays(self.generators.sites)
                self._made["diagram"] = sites, np.zeros(len(sites.edges), np.bool_)
            else:
                self._made["diagram"] = ordinary(self.mesh)
        return self._made["diagram"]  # type: ignore[no-any-return]

    @property
    def counts(self) -> tuple[int, int]:
        """Numbers of generators and Voronoi vertices."""
        if self.mesh is None:
            return len(self.generators.sites), len(self.ordinary.vertices)
        return self.mesh.used - len(self.mesh.vacant), int(np.isfinite(self.mesh.at[:, 0]).sum())

    def vertices_proved(self, radius: float) -> tuple[int, int]:
        """Number of proved exact vertices at least ``radius`` wide, and number of all such.

        The others, whose pieces are almost parallel or touch, stay where they were sampled; links
        to them are measured, not proved.
        """
        if self.mesh is None:
            return 0, 0
        wide = (self.mesh.state != UNUSED) & (self.mesh.rho >= radius)
        return int((wide & (self.mesh.state == EXACT)).sum()), int(wide.sum())


@dataclass(frozen=True, slots=True)
class Chains:
    """Valid edges as measured chains between nodes.

    Chain c runs from node ``ends[c, 0]`` to ``ends[c, 1]`` through ``points[first[c] : first[c +
    1]]``. Per point: ``rho``, its exact clearance; ``gap`` and ``step``, clearance and length of
    the next link (inf and 0 at a chain's last); ``pieces`` (p, 2), the pieces beside that link;
    ``proved`` (p,), True if that link follows their bisector and is as wide as its narrower end;
    other links are straight lines, measured. Per chain: ``length`` and ``clearance``. A node
    without chains has a chain of a single point.
    """

    points: FloatArray
    first: IntArray
    pieces: IntArray
    rho: FloatArray
    gap: FloatArray
    step: FloatArray
    ends: IntArray
    length: FloatArray
    clearance: FloatArray
    node_xy: FloatArray
    node_rho: FloatArray
    proved: BoolArray

    def __len__(self) -> int:
        return len(self.ends)

    @property
    def arrays(self) -> ChainArrays:
        """The chains' arrays for kernels."""
        return ChainArrays(
            self.points, self.first, self.pieces, self.proved, self.rho, self.gap, self.step,
            self.ends, self.length, self.clearance,
        )  # fmt: skip


def omit_invalid(mesh: Mesh | None, generators: Generators, mode: Mode) -> Agvd:
    """Mark the edges of the generators' mesh in the diagram's free part. O(n)."""
    borders, spacing = generators.borders, generators.spacing
    if mesh is None:
        return Agvd(borders, spacing, None, {"generators": generators})
    mark(mesh, borders, spacing, mode)
    return Agvd(borders, spacing, mesh)


def join_chains(agvd: Agvd) -> Chains:
    """Measured chains of straight links along the valid edges. O(n log k)."""
    mesh, borders = agvd.mesh, agvd.borders
    (traced, bent), node_xy = no_chains(), np.empty((0, 2))
    if mesh is not None:
        points, pieces, first, traced = lay_straight(mesh)
        places = np.c_[points, borders.distances(points)[0]]
        bent = Bent(places, pieces, first, np.zeros(len(points), np.bool_))
        node_xy = mesh.at[traced.node]
    return _measured(borders, bent, traced.ends, node_xy)


def solve_chains(mesh: Mesh | None, generators: Generators) -> tuple[Agvd, Chains]:
    """Exact diagram of the generators' borders, and its chains along the bisectors.

    ``mesh`` is the generators' and becomes the diagram's.
    """
    if mesh is None:
        agvd = omit_invalid(None, generators, "exact")
        return agvd, join_chains(agvd)
    agvd = Agvd(generators.borders, generators.spacing, mesh)
    return agvd, mesh_chains(mesh, generators.borders, generators.spacing)


def mesh_chains(mesh: Mesh, borders: Borders, spacing: float) -> Chains:
    """Solve a mesh, refining it if needed, and measure its chains."""
    solve(mesh, borders, spacing)
    return _measured(borders, mesh.bent, mesh.traced.ends, mesh.place[mesh.traced.node])


def _measured(borders: Borders, bent: Bent, ends: IntArray, node_xy: FloatArray) -> Chains:
    points, pieces, first, proved = bent
    lonely: FloatArray = kernels.lonely_centres(
        borders.pieces, borders.tree, borders.closed, borders.box, points, 1e-7 * borders.extent
    )
    if len(lonely):
        alone = np.arange(len(lonely), dtype=np.int32)
        ends = np.concatenate([ends, len(node_xy) + alone[:, None].repeat(2, 1)])
        first = np.concatenate([first, first[-1] + 1 + alone])
        points = np.concatenate([points, lonely])
        pieces = np.concatenate([pieces, np.full((len(lonely), 2), -1, np.int32)])
        proved = np.concatenate([proved, np.zeros(len(lonely), np.bool_)])
        node_xy = np.concatenate([node_xy, lonely[:, :2]])
    xy, rho, gap, step, length, clearance, node_rho = chain_kernels.measure_chains(
        borders.tree, points, proved, first, ends, len(node_xy)
    )
    return Chains(
        points=xy,
        first=first,
        pieces=pieces,
        rho=rho,
        gap=gap,
        step=step,
        ends=ends,
        length=length,
        clearance=clearance,
        node_xy=node_xy,
        node_rho=node_rho,
        proved=proved,
    )
