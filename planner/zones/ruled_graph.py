"""A route graph by the zones' rules: directions, speeds and costs of its edges."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from planner.graph_files.route_graph import GraphId, RouteEdge, RouteGraph
from planner.scene import FloatArray
from planner.zones.rules import Rules


def ruled_graph(graph: RouteGraph, rules: Rules) -> RouteGraph:
    """Return the graph with each edge's speed and cost by zones, and without those they forbid.

    Edges through keep-out zones go, as do directions against one-way zones. The lowest speed on an
    edge is its limit; its cost is its length weighed by lanes. Edges whose nodes do not exist stay
    as they are.
    """
    places = {node.id: node.at for node in reversed(graph.nodes)}
    edges = (one for edge in graph.edges for one in _ruled(edge, places, rules))
    return replace(graph, edges=tuple(edges))


def _ruled(
    edge: RouteEdge, places: dict[GraphId, tuple[float, float]], rules: Rules
) -> Iterator[RouteEdge]:
    if edge.start not in places or edge.end not in places:
        yield edge
        return
    points = edge.line or (places[edge.start], places[edge.end])
    line = np.array(points, dtype=np.float64)
    if any(one.clearance(line) < rules.radius * (1.0 - 1e-6) for one in rules.of("keep_out")):
        return
    ways = [(edge.start, edge.end, line)]
    if edge.both_ways:
        ways.append((edge.end, edge.start, np.ascontiguousarray(line[::-1])))
    free = [way for way in ways if not rules.against(way[2])]
    if len(free) == 2:
        yield _priced(edge, line, rules)
    elif free:
        start, end, driven = free[0]
        turned = tuple((x, y) for x, y in driven.tolist()) if edge.line else ()
        one = replace(edge, start=start, end=end, line=turned, both_ways=False)
        yield _priced(one, driven, rules)


def _priced(edge: RouteEdge, line: FloatArray, rules: Rules) -> RouteEdge:
    lanes = replace(rules, speed=None)
    cost = lanes.cost(line) if rules.of("lane") else edge.cost
    limit = float(rules.caps(line).min(initial=np.inf))
    speed = edge.speed_m_s
    if np.isfinite(limit):
        speed = limit if speed is None else min(speed, limit)
    return replace(edge, cost=cost, speed_m_s=speed)
