"""Detours: an edge that is led round obstacles, as a bent line or as a chain of straight edges.

A chain's first piece keeps the id, and all keep the speed and the other fields. Edges between the
same two nodes, in either direction, share its nodes. A length in the file becomes the true one; a
cost grows with it, and is divided like it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from planner.graph_audit.edge_lines import length_of
from planner.graph_files.route_graph import GraphId, RouteEdge, RouteGraph, RouteNode
from planner.graph_repair.fresh_ids import FreshIds
from planner.scene import FloatArray


@dataclass(slots=True)
class Detours:
    """Nodes and edges that detours add to a graph."""

    graph: RouteGraph
    ids: FreshIds
    nodes: list[RouteNode] = field(default_factory=list)
    edges: list[RouteEdge] = field(default_factory=list)
    _first: dict[GraphId, RouteNode] = field(init=False)
    _bends: dict[tuple[GraphId, GraphId], tuple[GraphId, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        # of several nodes with one id the first counts, as in the audit
        self._first = {node.id: node for node in reversed(self.graph.nodes)}

    def led_along(self, edge: RouteEdge, line: FloatArray, before: float) -> RouteEdge:
        """Return an edge along a line, or its chain's first piece; ``before`` was its length."""
        total = length_of(line)
        grown = replace(
            edge,
            line=(),
            length=None if edge.length is None else total,
            cost=None if edge.cost is None else edge.cost * (total / before if before else 1.0),
        )
        if self.graph.bends:
            return replace(grown, line=tuple((x, y) for x, y in line.tolist()))
        bends = self._nodes_at(edge, line)
        row = [edge.start, *bends, edge.end]
        pieces = []
        for k, (start, end) in enumerate(pairwise(row)):
            share = float(np.hypot(*(line[k + 1] - line[k]))) / total
            own = edge.id if k == 0 else self.ids.edge(edge)
            pieces.append(
                replace(
                    grown,
                    id=own,
                    start=start,
                    end=end,
                    length=None if grown.length is None else grown.length * share,
                    cost=None if grown.cost is None else grown.cost * share,
                )
            )
        self.edges += pieces[1:]
        return pieces[0]

    def _nodes_at(self, edge: RouteEdge, line: FloatArray) -> tuple[GraphId, ...]:
        """Nodes at the bends of a line, in its order; made once for both directions."""
        key, back = (edge.start, edge.end), (edge.end, edge.start)
        if key not in self._bends:
            start = self._first[edge.start]
            made = [
                RouteNode(
                    self.ids.node(start.part, edge.start),
                    x,
                    y,
                    start.frame,
                    _plain_fields(start, self.graph.format),
                    start.part,
                )
                for x, y in line[1:-1].tolist()
            ]
            self.nodes += made
            self._bends[key] = tuple(node.id for node in made)
            self._bends[back] = self._bends[key][::-1]
        return self._bends[key]


def _plain_fields(near: RouteNode, form: str) -> Mapping[str, Any]:
    """Fields that a node of the format must have."""
    if form == "nav2":
        return {"type": "Feature", "properties": {}}
    rows = near.fields.get("vehicleTypeNodeProperties")
    if form == "lif" and isinstance(rows, list):
        types = [row.get("vehicleTypeId") for row in rows if isinstance(row, dict)]
        return {"vehicleTypeNodeProperties": [{"vehicleTypeId": one} for one in types]}
    return {}
