"""The approximate generalized Voronoi diagram: the generators' diagram without invalid edges.

Rules and units
- ``mode="paper"`` omits the edges between generators of one object, as the paper does.
- ``mode="exact"`` omits those within one piece of a border only, so that the free space
  inside a U, or in a room whose wall is one object, keeps its diagram.
- A chain is a maximal run of valid edges; its ends are nodes. Its clearances are exact: they
  are distances to the borders, not to the generators.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner import agvd_kernels as kernels
from planner.generators import SAME_PLACE, BoolArray, Borders, Generators, Mode
from planner.scene import FloatArray, IntArray
from planner.voronoi_diagram import DiagramArrays, voronoi_arrays


@dataclass(frozen=True, slots=True)
class Agvd:
    """The diagram of the generators and which of its edges are valid.

    ``edges`` (m, 4) int32: site, site, vertex, vertex (-1 = at infinity); ``vertices`` (v, 2);
    ``valid`` (m,) bool.
    """

    generators: Generators
    vertices: FloatArray
    edges: IntArray
    valid: BoolArray


@dataclass(frozen=True, slots=True)
class Chains:
    """The valid edges as chains between nodes, measured.

    Chain c runs from node ``ends[c, 0]`` to ``ends[c, 1]`` through the points
    ``points[first[c] : first[c + 1]]``. Per point ``rho``, its exact clearance; ``gap`` and
    ``step``, the clearance and length of the link to the next point (inf and 0 at a chain's
    last); ``pieces`` (p, 2), the two pieces that link lies between. Per chain ``length`` and
    ``clearance``. A node that no chain meets has a chain of a single point.
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

    def __len__(self) -> int:
        return len(self.ends)


def diagram(generators: Generators) -> DiagramArrays:
    """The ordinary Voronoi diagram of the generators."""
    return voronoi_arrays(generators.sites)


def omit_invalid(ordinary: DiagramArrays, generators: Generators, mode: Mode) -> Agvd:
    """Mark the edges that belong to the generalized diagram's free part. O(m)."""
    borders = generators.borders
    edges, vertices = ordinary.edges, ordinary.vertices
    valid, _, _ = kernels.valid_edges(
        edges,
        vertices,
        generators.sites,
        generators.label,
        borders.kind,
        borders.data,
        borders.owner,
        borders.backwards,
        borders.following,
        borders.preceding,
        borders.solid,
        borders.before,
        borders.after,
        borders.box,
        SAME_PLACE * borders.extent,
        mode == "paper",
    )
    return Agvd(generators, vertices, edges, valid)


def join_chains(agvd: Agvd) -> Chains:
    """Join the valid edges into chains and measure them against the borders. O(m log k)."""
    node_vertex, ends, first, link, along = kernels.trace_chains(
        agvd.edges, agvd.valid, len(agvd.vertices)
    )
    generators, borders = agvd.generators, agvd.generators.borders
    points, pieces, first = kernels.chain_points(
        agvd.edges, agvd.vertices, generators.label, first, link, along
    )
    lonely = _centres_alone(borders, points)
    ends = np.concatenate(
        [ends, len(node_vertex) + np.arange(len(lonely), dtype=np.int32)[:, None].repeat(2, 1)]
    )
    first = np.concatenate([first, first[-1] + 1 + np.arange(len(lonely), dtype=np.int32)])
    points = np.concatenate([points, lonely])
    pieces = np.concatenate([pieces, np.full((len(lonely), 2), -1, np.int32)])
    rho, gap, step, length, clearance = kernels.measure_chains(*borders.tree, points, first)
    node_xy = np.concatenate([agvd.vertices[node_vertex], lonely])
    node_rho = np.empty(len(node_xy))
    node_rho[ends[:, 0]] = rho[first[:-1]]
    node_rho[ends[:, 1]] = rho[first[1:] - 1]
    return Chains(points, first, pieces, rho, gap, step, ends, length, clearance, node_xy, node_rho)


def _centres_alone(borders: Borders, points: FloatArray) -> FloatArray:
    """Centres of circles and arcs with nothing nearer than the radius and no chain through.

    Within one such border nothing else is equidistant to two places, but the clearance is
    greatest there: the way from one place to another leads over it.
    """
    alone: FloatArray = kernels.lonely_centres(
        borders.kind,
        borders.data,
        borders.owner,
        borders.backwards,
        borders.solid,
        borders.order,
        borders.large,
        borders.boxes,
        borders.box,
        points,
        1e-7 * borders.extent,
    )
    return alone
