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
from numpy.typing import NDArray

from planner import agvd_kernels as kernels
from planner import bisector_kernels
from planner.generators import SAME_PLACE, BoolArray, Borders, Generators, Mode
from planner.scene import FloatArray, IntArray
from planner.voronoi_diagram import DiagramArrays, voronoi_arrays


@dataclass(frozen=True, slots=True)
class Agvd:
    """The diagram of the generators and which of its edges are valid (m,)."""

    generators: Generators
    ordinary: DiagramArrays
    valid: BoolArray


@dataclass(frozen=True, slots=True)
class Places:
    """Where the vertices of valid edges are: ``xy`` (v, 2), exact clearance ``rho`` (v,).

    ``state`` (v,) is UNUSED, EXACT (equidistant to its pieces, and its circle is empty), KEPT
    (near-parallel pieces: as sampled) or INTRUDED (the topology is not yet right there), see
    :mod:`planner.bisector_kernels`.
    """

    xy: FloatArray
    rho: FloatArray
    state: NDArray[np.int8]


@dataclass(frozen=True, slots=True)
class Chains:
    """The valid edges as chains between nodes, measured.

    Chain c runs from node ``ends[c, 0]`` to ``ends[c, 1]`` through the points
    ``points[first[c] : first[c + 1]]``. Per point ``rho``, its exact clearance; ``gap`` and
    ``step``, the clearance and length of the link to the next point (inf and 0 at a chain's
    last); ``pieces`` (p, 2), the two pieces that link lies between. Per chain ``length`` and
    ``clearance``. A node that no chain meets has a chain of a single point. ``proved`` (p,):
    the link to the next point follows the bisector of its two pieces, and is as wide as its
    narrower end; other links are straight lines, measured.
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


def diagram(generators: Generators) -> DiagramArrays:
    """The ordinary Voronoi diagram of the generators."""
    return voronoi_arrays(generators.sites)


def omit_invalid(ordinary: DiagramArrays, generators: Generators, mode: Mode) -> Agvd:
    """Mark the edges that belong to the generalized diagram's free part. O(m)."""
    borders = generators.borders
    valid = kernels.valid_edges(
        ordinary.edges,
        ordinary.vertices,
        generators.sites,
        generators.label,
        borders.kind,
        borders.data,
        borders.owner,
        borders.solid,
        borders.before,
        borders.after,
        borders.box,
        generators.spacing,
        SAME_PLACE * borders.extent,
        mode == "paper",
    )
    return Agvd(generators, ordinary, valid)


def join_chains(agvd: Agvd, places: Places | None = None) -> Chains:
    """Join the valid edges into chains and measure them against the borders. O(m log k).

    Without ``places`` the chains follow the generators' diagram; with them, the bisectors.
    """
    edges, label = agvd.ordinary.edges, agvd.generators.label
    borders = agvd.generators.borders
    xy = agvd.ordinary.vertices if places is None else places.xy
    node_vertex, ends, first, link, along = kernels.trace_chains(edges, agvd.valid, len(xy))
    points, pieces, first, at = kernels.chain_points(edges, xy, label, first, link, along)
    if places is not None:
        points, pieces, rho, first, proved = bisector_kernels.bend_chains(
            *borders.tree,
            points,
            pieces,
            first,
            at,
            places.rho,
            places.state,
            agvd.ordinary.vertex_sites,
            label,
            agvd.generators.spacing,
            SAME_PLACE * borders.extent,
        )
    lonely = _centres_alone(borders, points)
    alone = np.arange(len(lonely), dtype=np.int32)
    ends = np.concatenate([ends, len(node_vertex) + alone[:, None].repeat(2, 1)])
    first = np.concatenate([first, first[-1] + 1 + alone])
    points = np.concatenate([points, lonely])
    pieces = np.concatenate([pieces, np.full((len(lonely), 2), -1, np.int32)])
    if places is None:
        rho, gap, step, length, clearance = kernels.measure_chains(*borders.tree, points, first)
        proved = np.zeros(len(points), np.bool_)
    else:
        rho = np.concatenate([rho, borders.distances(lonely)[0]])
        proved = np.concatenate([proved, np.zeros(len(lonely), np.bool_)])
        gap, step, length, clearance = bisector_kernels.measure_bisectors(
            *borders.tree, points, rho, proved, first
        )
    node_xy = np.concatenate([xy[node_vertex], lonely])
    node_rho = np.empty(len(node_xy))
    node_rho[ends[:, 0]] = rho[first[:-1]]
    node_rho[ends[:, 1]] = rho[first[1:] - 1]
    return Chains(
        points=points,
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
