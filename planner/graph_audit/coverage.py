"""Coverage: the share of the free space that a graph serves.

- Free space is where the robot's centre may be. It is counted in square cells as large as the
  radius, by their centres, or in ``MOST_MAP_CELLS`` larger ones.
- A cell is within reach if a robot can drive from it to the graph, through free cells, by a path of
  at most ``reach``. Paths lead from cell to cell in eight directions: they are up to 8 % longer
  than the shortest. Unsafe edges and nodes serve nobody.
- SWAGGER's measures (nvidia-isaac) are those of its documentation, for the same cells: the share of
  the free space whose connected region has a node; the mean and the largest straight distance from
  these regions' cells to the nearest node; the share per node; and the share of pairs of nodes
  between which there is a path, here of all pairs.
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner.borders.ground import Ground
from planner.borders.polyline import arc_lengths, points_at
from planner.graph_audit.audit import GraphAudit
from planner.graph_audit.unsafe import RADIUS_SLACK
from planner.scene import FloatArray, Scene
from planner.shared.arguments import as_float

REACH_RADII = 10.0
"""In robot radii (chosen: two metres for many robots)."""
MOST_MAP_CELLS = 60_000
"""Cells on the map at most (chosen: 0.5 s)."""
DISTANCES_AT_ONCE = 4_000_000
"""Distances computed in one step (indifferent)."""
CellMask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class GraphCoverage:
    """Shares in 0..1 of the free space near a graph; lengths and areas in the scene's units.

    ``covered`` is the share within ``reach``; ``farthest`` the longest path to the graph, None if
    some free place has none. ``region_share``, ``mean_to_node`` and ``farthest_to_node`` (None
    without a node in free space), ``share_per_node`` and ``connected_pairs`` are SWAGGER's.
    """

    reach: float
    cell: float
    free_area: float
    covered: float
    farthest: float | None
    region_share: float
    mean_to_node: float | None
    farthest_to_node: float | None
    share_per_node: float
    connected_pairs: float


def measure_coverage(audit: GraphAudit, scene: Scene, reach: float | None = None) -> GraphCoverage:
    """Measure the coverage of the free space by an audited graph.

    ``reach`` > 0 is in the scene's units, by default ten radii; ``ValueError`` otherwise. O(c log
    c) for c cells.
    """
    far = REACH_RADII * audit.radius if reach is None else as_float("reach", reach)
    if not (math.isfinite(far) and far > 0.0):
        raise ValueError(f"reach = {reach}: must be > 0 and finite")
    grid = _Grid.of(scene, audit.radius)
    count = int(grid.free.sum())
    ways = grid.distances(_served(audit, grid.cell))[grid.free]
    own = np.array([(n.x, n.y) for n in audit.graph.nodes]).reshape(-1, 2)
    nodes = own[grid.ground.signed(own) >= audit.radius * (1.0 - RADIUS_SLACK)]
    region = np.isfinite(grid.distances(nodes)) & grid.free
    to_node = _to_nearest(grid.centres()[region.ravel()], nodes)
    share = float(region.sum() / count) if count else 0.0
    return GraphCoverage(
        reach=far,
        cell=grid.cell,
        free_area=count * grid.cell**2,
        covered=float((ways <= far).mean()) if count else 0.0,
        farthest=float(ways.max()) if count and np.isfinite(ways).all() else None,
        region_share=share,
        mean_to_node=float(to_node.mean()) if len(to_node) else None,
        farthest_to_node=float(to_node.max()) if len(to_node) else None,
        share_per_node=share / len(own) if len(own) else 0.0,
        connected_pairs=_connected_pairs(audit),
    )


def _served(audit: GraphAudit, cell: float) -> FloatArray:
    """Points on the safe edges, no farther apart than half a cell, and the safe nodes."""
    unsafe = {one.name for one in audit.of("unsafe") if one.subject == "edge"}
    unsafe_places = {one.at for one in audit.of("unsafe") if one.subject == "node"}
    nodes = [(n.x, n.y) for n in audit.graph.nodes if (n.x, n.y) not in unsafe_places]
    places = [np.array(nodes).reshape(-1, 2)]
    for edge, line in zip(audit.edges, audit.lines, strict=True):
        # an edge without length is judged as its node
        if edge.name in unsafe or (line[0, 0], line[0, 1]) in unsafe_places:
            continue
        lengths = arc_lengths(line)
        steps = max(1, math.ceil(2.0 * float(lengths[-1]) / cell))
        places.append(points_at(line, lengths, np.linspace(0.0, float(lengths[-1]), steps + 1)))
    return np.concatenate(places)


def _to_nearest(places: FloatArray, nodes: FloatArray) -> FloatArray:
    if not len(nodes) or not len(places):
        return np.empty(0)
    step = max(1, DISTANCES_AT_ONCE // len(nodes))
    squares = np.empty(len(places))
    for k in range(0, len(places), step):
        off = places[k : k + step, None] - nodes[None]
        squares[k : k + step] = (off[..., 0] ** 2 + off[..., 1] ** 2).min(axis=1)
    return np.sqrt(squares)


def _connected_pairs(audit: GraphAudit) -> float:
    import networkx as nx  # late: it takes 0.2 s

    ways: nx.DiGraph[object] = nx.DiGraph()
    ways.add_nodes_from(node.id for node in audit.graph.nodes)
    for edge in audit.edges:
        ways.add_edge(edge.start, edge.end)
        if edge.both_ways:
            ways.add_edge(edge.end, edge.start)
    count = len(ways)
    parts = nx.condensation(ways)
    sizes = {part: len(members) for part, members in parts.nodes(data="members")}
    pairs = 0
    for part, size in sizes.items():
        pairs += size * (size - 1)
        pairs += size * sum(sizes[other] for other in nx.descendants(parts, part))
    return pairs / (count * (count - 1)) if count > 1 else 0.0


@dataclass(frozen=True, slots=True)
class _Grid:
    """Free cells (rows, columns), row 0 the least y; the cell's side, and the least corner."""

    free: CellMask
    cell: float
    low: FloatArray
    ground: Ground

    @classmethod
    def of(cls, scene: Scene, radius: float) -> _Grid:
        ground = Ground.of(scene, bounds=True)
        b = scene.bounds
        cell = max(radius, math.sqrt(b.width * b.height / MOST_MAP_CELLS))
        shape = max(1, math.ceil(b.height / cell)), max(1, math.ceil(b.width / cell))
        empty = cls(np.zeros(shape, np.bool_), cell, np.array([b.x_min, b.y_min]), ground)
        free = ground.signed(empty.centres()) >= radius * (1.0 - RADIUS_SLACK)
        return cls(free.reshape(shape), cell, empty.low, ground)

    def centres(self) -> FloatArray:
        rows, columns = self.free.shape
        x, y = np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5)
        centres: FloatArray = self.low + self.cell * np.stack([x.ravel(), y.ravel()], axis=1)
        return centres

    def distances(self, places: FloatArray) -> FloatArray:
        """Shortest path (rows, columns) from each free cell to one of the places, or infinite.

        A place counts for its own cell and the eight around it.
        """
        rows, columns = self.free.shape
        found = np.full(rows * columns, np.inf)
        free = self.free.ravel().tolist()
        at = (places - self.low) / self.cell
        index = np.floor(at).astype(np.int64)
        for dx in (-1, 0, 1):
            for dy in (-1, 0, 1):
                near = index + np.array([dx, dy])
                on = ((near >= 0) & (near < (columns, rows))).all(axis=1)
                off = np.hypot(*(at[on] - near[on] - 0.5).T) * self.cell
                np.minimum.at(found, near[on, 1] * columns + near[on, 0], off)
        found[~self.free.ravel()] = np.inf
        best: list[float] = found.tolist()
        heap = [(d, k) for k, d in enumerate(best) if d < math.inf]
        heapq.heapify(heap)
        steps = [(dx, dy, self.cell * math.hypot(dx, dy)) for dx, dy in _AROUND]
        while heap:
            d, k = heapq.heappop(heap)
            if d > best[k]:
                continue
            row, column = divmod(k, columns)
            for dx, dy, length in steps:
                if not (0 <= column + dx < columns and 0 <= row + dy < rows):
                    continue
                other = k + dy * columns + dx
                if d + length < best[other] and free[other]:
                    best[other] = d + length
                    heapq.heappush(heap, (d + length, other))
        return np.array(best).reshape(rows, columns)


_AROUND = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1))
