"""The repair: unsafe nodes move, unsafe edges are led round, and an audit certifies the result.

Nodes and edges keep their ids and their other fields. What is safe stays, except for edges of nodes
that move. A graph of another frame is transformed first if the audit is sure of the transform;
otherwise it is not repaired.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from planner.graph_audit.audit import GraphAudit, audit
from planner.graph_audit.edge_lines import length_of
from planner.graph_audit.findings import GraphFinding
from planner.graph_audit.frame_fit import FrameFit
from planner.graph_files.route_graph import GraphId, RouteEdge, RouteGraph, RouteNode
from planner.graph_repair.detours import Detours
from planner.graph_repair.free_places import free_place
from planner.graph_repair.fresh_ids import FreshIds
from planner.graph_repair.solid_ground import SolidGround
from planner.scene import FloatArray, Scene, Vec

NOT_SURE = "the graph is in another frame, and no transform is sure: transform it first"
MISSING = "one of its nodes is unsafe"


@dataclass(frozen=True, slots=True)
class NodeMove:
    """A node that moved from a place to another, both (x, y)."""

    node: GraphId
    before: Vec
    after: Vec


@dataclass(frozen=True, slots=True)
class GraphRepair:
    """A repaired graph with its audit.

    ``moved`` nodes and ``detours``, names of edges led round, are changes after the transform
    ``frame_fit``, if any. ``unsolved`` has the id of each unsafe finding that remains, and why.
    """

    graph: RouteGraph
    audit: GraphAudit
    moved: tuple[NodeMove, ...]
    detours: tuple[str, ...]
    unsolved: Mapping[str, str]
    frame_fit: FrameFit | None = None

    def __repr__(self) -> str:
        done = f"{len(self.moved)} nodes moved, {len(self.detours)} edges led round"
        return f"<GraphRepair: {done}, {len(self.unsolved)} unsolved>"


def repair(
    graph: RouteGraph,
    scene: Scene,
    radius: float,
    *,
    keepout: Scene | None = None,
    frame: str | None = None,
) -> GraphRepair:
    """Repair what an audit finds unsafe in a route graph.

    Arguments and errors are those of :func:`planner.audit`. Unsafe nodes move to the nearest free
    places from which paths lead to their neighbours. Unsafe edges follow paths that keep the radius
    from obstacles and zones.
    """
    found = audit(graph, scene, radius, keepout=keepout, frame=frame)
    fit = found.frame_fit
    if fit is not None and not fit.sure:
        reasons = {one.id: NOT_SURE for one in found.of("unsafe")}
        return GraphRepair(graph, found, (), (), reasons)
    if fit is not None:
        inside = {id(node) for node in found.graph.nodes}
        graph = fit.apply(graph, lambda node: id(node) in inside)
        found = audit(graph, scene, radius, keepout=keepout, frame=frame)
    if found.safe:
        return GraphRepair(graph, found, (), (), {}, fit)
    ground = SolidGround.of(scene, keepout, radius, found.graph.nodes)
    work = _Work(graph, {id(node) for node in found.graph.nodes}, ground)
    work.move_nodes()
    work.lead_edges()
    result = work.result()
    after = audit(result, scene, radius, keepout=keepout, frame=frame)
    unsolved = {one.id: work.reason(one) for one in after.of("unsafe")}
    return GraphRepair(result, after, tuple(work.moved), tuple(work.led), unsolved, fit)


@dataclass(slots=True)
class _Work:
    """A repair under way; ``inside`` are the nodes of the repaired frame, by identity."""

    graph: RouteGraph
    inside: set[int]
    ground: SolidGround
    moved: list[NodeMove] = field(default_factory=list)
    led: list[str] = field(default_factory=list)
    nodes: list[RouteNode] = field(default_factory=list)
    edges: list[RouteEdge] = field(default_factory=list)
    extra: tuple[list[RouteNode], list[RouteEdge]] = ((), ())  # type: ignore[assignment]
    _reasons: dict[tuple[str, str], str] = field(default_factory=dict)

    def move_nodes(self) -> None:
        """Move unsafe nodes; those at one place stay at one."""
        own = [k for k, node in enumerate(self.graph.nodes) if id(node) in self.inside]
        places = np.array([(self.graph.nodes[k].x, self.graph.nodes[k].y) for k in own])
        free = self.ground.is_free(places.reshape(-1, 2))
        first: dict[GraphId, Vec] = {}
        for k in own:
            first.setdefault(self.graph.nodes[k].id, self.graph.nodes[k].at)
        safe = {k for k, is_free in zip(own, free.tolist(), strict=True) if is_free}
        sound = {self.graph.nodes[k].id for k in safe}
        self.nodes = list(self.graph.nodes)
        targets: dict[Vec, Vec | str] = {}
        neighbours = self._neighbours(first, sound)
        farthest = _extent(places)
        for k in own:
            node = self.graph.nodes[k]
            if k in safe:
                continue
            place = node.at
            if place not in targets:
                near = list(neighbours.get(place, ()))
                targets[place] = free_place(place, near, self.ground, farthest)
            target = targets[place]
            if isinstance(target, str):
                self._reasons["node", str(node.id)] = target
                continue
            self.nodes[k] = replace(node, x=target[0], y=target[1])
            self.moved.append(NodeMove(node.id, place, target))

    def _neighbours(
        self, first: Mapping[GraphId, Vec], sound: set[GraphId]
    ) -> dict[Vec, dict[Vec, None]]:
        found: dict[Vec, dict[Vec, None]] = {}
        for edge in self.graph.edges:
            for one, other in ((edge.start, edge.end), (edge.end, edge.start)):
                if one in first and one not in sound and other in sound:
                    found.setdefault(first[one], {})[first[other]] = None
        return found

    def lead_edges(self) -> None:
        """Lead unsafe edges along paths, and let lines end at the nodes that moved."""
        places: dict[GraphId, Vec] = {}
        for old, node in zip(self.graph.nodes, self.nodes, strict=True):
            if id(old) in self.inside:
                places.setdefault(node.id, node.at)
        detours = Detours(replace(self.graph, nodes=tuple(self.nodes)), FreshIds(self.graph))
        moved = {move.node for move in self.moved}
        paths: dict[tuple[Vec, Vec], FloatArray | str] = {}
        for edge in self.graph.edges:
            if edge.start not in places or edge.end not in places:
                self.edges.append(edge)
                continue
            kept = self._attached(edge, places) if {edge.start, edge.end} & moved else edge
            line = self._line(kept, places)
            if self.ground.is_safe(line):
                self.edges.append(kept)
                continue
            path = self._path(places[edge.start], places[edge.end], paths)
            if isinstance(path, str):
                self._reasons["edge", edge.name] = path
                self.edges.append(kept)
            else:
                self.edges.append(detours.led_along(kept, path, length_of(line)))
                self.led.append(edge.name)
        self.extra = (detours.nodes, detours.edges)

    def _path(
        self, a: Vec, b: Vec, paths: dict[tuple[Vec, Vec], FloatArray | str]
    ) -> FloatArray | str:
        """Path from a to b, the same in both directions."""
        if (a, b) not in paths:
            ends = np.array([a, b])
            if not self.ground.is_free(ends).all():
                paths[a, b] = paths[b, a] = MISSING
            else:
                path = self.ground.path(a, b)
                paths[a, b] = path
                paths[b, a] = path if isinstance(path, str) else path[::-1]
        return paths[a, b]

    def _attached(self, edge: RouteEdge, places: Mapping[GraphId, Vec]) -> RouteEdge:
        """Let an edge's line and length follow its nodes."""
        line = np.array(edge.line).reshape(-1, 2)
        if self.graph.bends and len(line):
            ends = np.array([places[edge.start], places[edge.end]])
            turned = np.hypot(*(line[[-1, 0]] - ends).T).sum()
            if edge.both_ways and turned < np.hypot(*(line[[0, -1]] - ends).T).sum():
                ends = ends[::-1]
            line = np.concatenate([ends[:1], line[1:-1], ends[1:]])
            kept = replace(edge, line=tuple((x, y) for x, y in line.tolist()))
        else:
            kept = replace(edge, line=())
        if edge.length is None:
            return kept
        return replace(kept, length=length_of(self._line(kept, places)))

    def _line(self, edge: RouteEdge, places: Mapping[GraphId, Vec]) -> FloatArray:
        ends = np.array([places[edge.start], places[edge.end]])
        inner = np.array(edge.line).reshape(-1, 2)[1:-1]
        if not self.graph.bends or not len(inner):
            return ends
        drawn = np.array(edge.line)
        straight, turned = (
            float(np.hypot(*(drawn[rows] - ends).T).sum()) for rows in ([0, -1], [-1, 0])
        )
        if edge.both_ways and turned < straight:
            inner = inner[::-1]
        return np.concatenate([ends[:1], inner, ends[1:]])

    def result(self) -> RouteGraph:
        """Return the repaired graph, additions last."""
        nodes, edges = self.extra
        return replace(self.graph, nodes=(*self.nodes, *nodes), edges=(*self.edges, *edges))

    def reason(self, finding: GraphFinding) -> str:
        if finding.subject == "edge" and ("edge", finding.name) in self._reasons:
            return self._reasons["edge", finding.name]
        return self._reasons.get((finding.subject, finding.name), MISSING)


def _extent(places: FloatArray) -> float:
    return float(np.ptp(places, axis=0).max()) if len(places) else 1.0
