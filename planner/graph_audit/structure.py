"""Findings that need no map: ids, doubles, lengths, and where robots can drive on the graph.

Only the graph's directions count, unsafe edges included. The largest part is the largest set of
nodes between which robots can drive forth and back, of equal ones the first.
"""

from __future__ import annotations

import numpy as np

from planner.graph_audit.edge_lines import EdgeLines
from planner.graph_audit.findings import FindingList
from planner.graph_files.route_graph import RouteEdge, RouteGraph
from planner.scene import FloatArray, Vec

SAME_PLACE = 1e-9
"""Places nearer than this share of the graph's extent are one."""
LENGTH_DIGITS = 1e-3
"""Lengths may differ by this part of them and by ``LENGTH_RADII``: files round."""
LENGTH_RADII = 0.01


def find_taken_ids(graph: RouteGraph, findings: FindingList) -> None:
    """Add findings on ids that several nodes or edges have."""
    nodes: set[object] = set()
    for node in graph.nodes:
        if node.id in nodes:
            findings.add("node_id_taken", "node", node.id, node.at)
        nodes.add(node.id)
    edges: set[object] = set()
    for edge in graph.edges:
        if edge.id is not None and edge.id in edges:
            findings.add("edge_id_taken", "edge", edge.name)
        edges.add(edge.id)


def find_doubles(lines: EdgeLines, findings: FindingList) -> None:
    """Add findings on nodes at one place, and on edges that exist twice."""
    same = _same_place(lines)
    order = np.lexsort(lines.places.T[::-1])
    before: list[int] = []
    for k in order.tolist():
        x, y = lines.places[k].tolist()
        before = [j for j in before if x - lines.places[j, 0] <= same]
        twin = next((j for j in before if abs(y - lines.places[j, 1]) <= same), None)
        if twin is None:
            before.append(k)
        else:
            findings.add(
                "node_doubled", "node", lines.node_names[k], (x, y), other=lines.node_names[twin]
            )
    first: dict[tuple[int, int, bytes], RouteEdge] = {}
    for edge, line, (a, b) in zip(lines.edges, lines.lines, lines.ends.tolist(), strict=True):
        ways = [(a, b, line.tobytes())]
        if edge.both_ways:
            ways.append((b, a, np.ascontiguousarray(line[::-1]).tobytes()))
        twin_edge = next((first[way] for way in ways if way in first), None)
        if twin_edge is not None:
            findings.add("edge_doubled", "edge", edge.name, middle(line), other=twin_edge.name)
        for way in ways:
            first.setdefault(way, edge)


def _same_place(lines: EdgeLines) -> float:
    return SAME_PLACE * float(np.ptp(lines.places, axis=0).max()) if len(lines.places) else 0.0


def find_lengths(lines: EdgeLines, radius: float, findings: FindingList) -> None:
    """Add findings on edges without length, and on wrong lengths in the file."""
    same = _same_place(lines)
    rows = zip(lines.edges, lines.lines, lines.lengths.tolist(), strict=True)
    for edge, line, length in rows:
        if length <= same:
            findings.add("edge_without_length", "edge", edge.name, middle(line), length)
        if edge.length is None:
            continue
        slack = LENGTH_DIGITS * length + LENGTH_RADII * radius
        if abs(edge.length - length) > slack:
            kind = "length_too_short" if edge.length < length else "length_too_long"
            findings.add(kind, "edge", edge.name, middle(line), edge.length, length)


def find_reach(lines: EdgeLines, findings: FindingList) -> set[int]:
    """Add findings on nodes that robots cannot reach or leave; return the largest part's nodes."""
    import networkx as nx  # late: it takes 0.2 s

    ways: nx.DiGraph[int] = nx.DiGraph()
    ways.add_nodes_from(range(len(lines.places)))
    for edge, (a, b) in zip(lines.edges, lines.ends.tolist(), strict=True):
        ways.add_edge(a, b)
        if edge.both_ways:
            ways.add_edge(b, a)
    alone = {n for n in ways if ways.degree(n) == 0}
    parts = [part for part in nx.strongly_connected_components(ways) if not part <= alone]
    for n in sorted(alone):
        _add(findings, "node_alone", lines, n)
    if not parts:
        return set()
    largest = max(parts, key=lambda part: (len(part), -min(part)))
    if len(parts) > 1:
        findings.add("graph_in_parts", "graph", "", None, float(len(parts)), 1.0)
    root = min(largest)
    reached = largest | nx.descendants(ways, root)
    back = largest | nx.ancestors(ways, root)
    for n in sorted(set(ways) - alone - largest):
        if ways.out_degree(n) == 0:
            _add(findings, "node_dead_end", lines, n)
        if n not in reached:
            _add(findings, "node_unreachable", lines, n)
        elif n not in back and ways.out_degree(n):
            _add(findings, "node_without_return", lines, n)
    return set(largest)


def _add(findings: FindingList, kind: str, lines: EdgeLines, node: int) -> None:
    x, y = lines.places[node].tolist()
    findings.add(kind, "node", lines.node_names[node], (x, y))


def middle(line: FloatArray) -> Vec:
    """Point halfway along a line's vertices, or between two of them."""
    a, b = line[(len(line) - 1) // 2], line[len(line) // 2]
    return float(0.5 * (a[0] + b[0])), float(0.5 * (a[1] + b[1]))
