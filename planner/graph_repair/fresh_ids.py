"""Ids for the nodes and edges that a repair adds: in the format's own kind."""

from __future__ import annotations

from collections import Counter
from itertools import count

from planner.graph_files.route_graph import GraphId, RouteEdge, RouteGraph


class FreshIds:
    """Ids that no node or edge of a graph has."""

    def __init__(self, graph: RouteGraph) -> None:
        self._taken = {node.id for node in graph.nodes}
        self._taken |= {edge.id for edge in graph.edges if edge.id is not None}
        numbers = [one for one in self._taken if isinstance(one, int)]
        self._numbered = len(numbers) == len(self._taken)
        self._next = count(max([-1, *numbers]) + 1)
        # Open-RMF's vertices and lanes are numbered within their level
        self._levels = [str(part.get("name", "")) for part in graph.parts]
        self._by_place = graph.format == "rmf"
        self._nodes = Counter(node.part for node in graph.nodes)
        self._edges = Counter(edge.part for edge in graph.edges)

    def node(self, part: int, near: GraphId) -> GraphId:
        """Id of a new node, added last."""
        if self._by_place:
            self._nodes[part] += 1
            return f"{self._levels[part]}/{self._nodes[part] - 1}"
        return self._free(near)

    def edge(self, whole: RouteEdge) -> GraphId | None:
        """Id of a further piece of an edge, added last; None if edges have none."""
        if self._by_place:
            self._edges[whole.part] += 1
            return f"{self._levels[whole.part]}/lane {self._edges[whole.part] - 1}"
        return None if whole.id is None else self._free(whole.id)

    def _free(self, near: GraphId) -> GraphId:
        if self._numbered:
            return next(self._next)
        fresh = next(name for k in count(1) if (name := f"{near}.{k}") not in self._taken)
        self._taken.add(fresh)
        return fresh
