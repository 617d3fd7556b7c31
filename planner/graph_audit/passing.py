"""Stretches on which two robots cannot pass each other: clearances below two radii.

Only edges driven both ways count. Narrow parts that meet at a node are one stretch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.borders.ground import Ground
from planner.borders.polyline import arc_lengths, points_at
from planner.graph_audit.edge_lines import EdgeLines
from planner.graph_audit.findings import FindingList
from planner.graph_audit.unsafe import NOTICED, RADIUS_SLACK
from planner.scene import Vec

MOST_NAMED = 6
"""Edges that a sentence names; the rest are counted (chosen)."""


@dataclass(frozen=True, slots=True)
class _Part:
    """A narrow part of an edge, and the nodes that it reaches."""

    edge: int
    length: float
    middle: Vec
    nodes: tuple[int, ...]


def find_narrow(lines: EdgeLines, ground: Ground, radius: float, findings: FindingList) -> None:
    """Add a finding for every stretch that is too narrow for two robots."""
    level = 2.0 * radius
    parts = _parts(lines, ground, level * (1.0 - RADIUS_SLACK))
    for stretch in _stretches(parts):
        longest = max(stretch, key=lambda part: part.length)
        length = sum(part.length for part in stretch)
        names = list(dict.fromkeys(str(lines.edges[part.edge].name) for part in stretch))
        words = ("edge " if len(names) == 1 else "edges ") + ", ".join(names[:MOST_NAMED])
        if len(names) > MOST_NAMED:
            words += f" and {len(names) - MOST_NAMED} more"
        name = lines.edges[longest.edge].name
        findings.add("edge_without_passing", "edge", name, longest.middle, length, level, words)


def _parts(lines: EdgeLines, ground: Ground, level: float) -> list[_Part]:
    edges = driven_both_ways(lines)
    chosen = [lines.lines[k] for k in edges]
    owner, begin, end = ground.parts_below(chosen, level)
    parts = []
    rows = zip(owner.tolist(), begin.tolist(), end.tolist(), strict=True)
    for number, low, high in rows:
        k, line = edges[number], chosen[number]
        total = float(lines.lengths[k])
        if high - low <= NOTICED * total:
            continue
        a, b = lines.ends[k].tolist()
        reached = [(low <= NOTICED * total, a), (high >= (1.0 - NOTICED) * total, b)]
        nodes = tuple(node for reaches, node in reached if reaches)
        at = points_at(line, arc_lengths(line), np.array([0.5 * (low + high)]))[0]
        parts.append(_Part(k, high - low, (float(at[0]), float(at[1])), nodes))
    return parts


def driven_both_ways(lines: EdgeLines) -> list[int]:
    """Edges that lead both ways, or have one along their line back; each line once."""
    ways = [(line.tobytes(), np.ascontiguousarray(line[::-1]).tobytes()) for line in lines.lines]
    driven = {own for own, _ in ways}
    driven |= {back for edge, (_, back) in zip(lines.edges, ways, strict=True) if edge.both_ways}
    both: dict[bytes, int] = {}
    for k, (own, back) in enumerate(ways):
        if {own, back} <= driven and back not in both:
            both.setdefault(own, k)
    return sorted(both.values())


def _stretches(parts: list[_Part]) -> list[list[_Part]]:
    import networkx as nx  # late: it takes 0.2 s

    first: dict[int, int] = {}
    met: nx.Graph[int] = nx.Graph()
    for k, part in enumerate(parts):
        met.add_node(k)
        met.add_edges_from((k, first.setdefault(node, k)) for node in part.nodes)
    return [[parts[k] for k in sorted(group)] for group in nx.connected_components(met)]
