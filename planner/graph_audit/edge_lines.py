"""The edges of a route graph as lines in the plane.

An edge that names a missing node is left out. Of several nodes with one id the first counts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from planner.borders.polyline import arc_lengths
from planner.graph_audit.findings import FindingList
from planner.graph_files.route_graph import GraphId, RouteEdge, RouteGraph
from planner.scene import FloatArray, IntArray, Vec

DRAWN = 0.01
"""Largest invisible bend, or distance from its nodes, of a drawn line, in robot radii."""


@dataclass(frozen=True, slots=True)
class EdgeLines:
    """Lines of the ``edges``: ``lines`` are (n, 2) each, ``ends`` (m, 2) the nodes' indices."""

    edges: tuple[RouteEdge, ...]
    lines: tuple[FloatArray, ...]
    ends: IntArray
    places: FloatArray
    """(k, 2) of the nodes."""
    node_names: tuple[GraphId, ...]
    lengths: FloatArray
    """(m,) of the lines."""

    def once(self) -> list[int]:
        """Return the edges without those along an earlier one's line, in either direction."""
        first: dict[bytes, int] = {}
        for k, line in enumerate(self.lines):
            back = np.ascontiguousarray(line[::-1]).tobytes()
            first.setdefault(min(line.tobytes(), back), k)
        return sorted(first.values())

    def pieces(self) -> tuple[FloatArray, IntArray]:
        """Return the straight pieces (p, 4) of all lines, and the edge (p,) of each."""
        counts = [len(line) - 1 for line in self.lines]
        rows = [np.hstack([line[:-1], line[1:]]) for line in self.lines]
        owner = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
        return np.concatenate([np.empty((0, 4)), *rows]), owner


def lay_out(graph: RouteGraph, radius: float, findings: FindingList) -> EdgeLines:
    """Lay out the edges; add findings on missing nodes and on lines that are not driven."""
    index: dict[GraphId, int] = {}
    for k, node in enumerate(graph.nodes):
        index.setdefault(node.id, k)
    places = np.array([node.at for node in graph.nodes]).reshape(-1, 2)
    edges, lines, ends = [], [], []
    for edge in graph.edges:
        missing = [end for end in (edge.start, edge.end) if end not in index]
        for absent in dict.fromkeys(missing):
            findings.add("edge_without_node", "edge", edge.name, other=absent)
        if missing:
            continue
        if _has_trajectory(edge):
            findings.add("edge_has_trajectory", "edge", edge.name)
        a, b = index[edge.start], index[edge.end]
        edges.append(edge)
        ends.append((a, b))
        lines.append(_line(graph, edge, places[[a, b]], DRAWN * radius, findings))
    pairs = np.array(ends, np.int32).reshape(-1, 2)
    names = tuple(node.id for node in graph.nodes)
    lengths = np.array([length_of(line) for line in lines])
    return EdgeLines(tuple(edges), tuple(lines), pairs, places, names, lengths)


def _has_trajectory(edge: RouteEdge) -> bool:
    """True if an edge of a LIF is a curve for some type of vehicles."""
    rows = edge.fields.get("vehicleTypeEdgeProperties")
    return isinstance(rows, list) and any(
        isinstance(row, dict) and row.get("trajectory") for row in rows
    )


def _line(
    graph: RouteGraph, edge: RouteEdge, ends: FloatArray, tolerance: float, findings: FindingList
) -> FloatArray:
    """Line that robots drive, with the drawn bends where the format has any."""
    if not edge.line:
        return ends
    drawn = np.array(edge.line)
    # a drawing of an edge that leads both ways may begin at either node
    if edge.both_ways and _gap(drawn[::-1], ends) < _gap(drawn, ends):
        drawn = drawn[::-1]
    for k, node in ((0, edge.start), (-1, edge.end)):
        beside = float(np.hypot(*(drawn[k] - ends[k])))
        if beside > tolerance:
            at = vec_of(drawn[k])
            findings.add("line_beside_node", "edge", edge.name, at, beside, other=node)
    if graph.bends:
        inner = drawn[1:-1] if len(drawn) > 1 else drawn[:0]
        return np.concatenate([ends[:1], inner, ends[1:]])
    off = _off_chord(drawn)
    far = int(np.argmax(off))
    if off[far] > tolerance:
        findings.add("line_not_straight", "edge", edge.name, vec_of(drawn[far]), float(off[far]))
    return ends


def _gap(drawn: FloatArray, ends: FloatArray) -> float:
    return float(np.hypot(*(drawn[[0, -1]] - ends).T).sum())


def _off_chord(drawn: FloatArray) -> FloatArray:
    begin, chord = drawn[0], drawn[-1] - drawn[0]
    square = float(chord @ chord)
    part = (
        np.clip((drawn - begin) @ chord / square, 0.0, 1.0)
        if square > 0.0
        else np.zeros(len(drawn))
    )
    off: FloatArray = np.hypot(*(drawn - begin - part[:, None] * chord).T)
    return off


def vec_of(point: FloatArray) -> Vec:
    """A point (2,) as plain numbers."""
    return float(point[0]), float(point[1])


def length_of(line: FloatArray) -> float:
    """Length of a line."""
    return math.hypot(*(line[1] - line[0])) if len(line) == 2 else float(arc_lengths(line)[-1])
