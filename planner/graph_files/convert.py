"""A route graph for another format: what its edges can say, and ids that it takes.

- Of ``fields``, numbers, texts and truth values are kept, but LIF has no room for them.
- Nav2, LIF and Open-RMF have one-way, straight edges: an edge that leads both ways becomes two, one
  that bends a chain with nodes at its bends.
- Nav2 and Open-RMF number nodes and edges: other ids are kept as ``name``. Frames become levels.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import count, pairwise
from typing import Any

from planner.graph_files import GraphFormat
from planner.graph_files.route_graph import (
    BENT,
    GraphId,
    RouteEdge,
    RouteGraph,
    RouteNode,
)
from planner.scene import Vec

LIF_VERSION = "1.0.0"
LIF_VEHICLE = "robot"
MOST_NUMBER = 2**32 - 1
"""Nav2's ids have 32 bits; this one means that there is no id."""


def converted(graph: RouteGraph, target: GraphFormat) -> RouteGraph:
    """Return the graph in the target's format."""
    if graph.format == target:
        return graph
    nodes, edges = list(graph.nodes), list(graph.edges)
    if target not in BENT:
        taken = {node.id for node in nodes}
        nodes, edges = _straightened(nodes, edges, taken) if graph.bends else (nodes, edges)
        edges = [one for edge in edges for one in _one_way(edge)]
    nodes = [replace(n, fields=_carried(n.fields, graph.format, target), part=0) for n in nodes]
    edges = [replace(e, fields=_carried(e.fields, graph.format, target), part=0) for e in edges]
    fields = _graph_fields(graph, target)
    parts: tuple[Mapping[str, Any], ...] = ()
    match target:
        case "nav2":
            nodes, edges = _numbered(nodes, edges)
        case "lif":
            nodes, edges, parts = _in_layout(nodes, edges)
        case "rmf":
            nodes, edges, parts = _on_levels(graph, nodes, edges)
    return RouteGraph(tuple(nodes), tuple(edges), target, fields, parts)


def _graph_fields(graph: RouteGraph, target: GraphFormat) -> dict[str, Any]:
    """Return fields that both formats have, and what the target needs."""
    inner = graph.fields.get("graph") if graph.format == "node-link" else graph.fields
    own = _scalars(inner) if isinstance(inner, Mapping) and graph.format in BENT else {}
    directed = graph.fields.get("directed", not all(edge.both_ways for edge in graph.edges))
    own.pop("directed", None)
    match target:
        case "nav2":
            return {"type": "FeatureCollection"}
        case "lif":
            names = ("projectIdentification", "creator")
            meta = dict.fromkeys(names, "clearway") | {"lifVersion": LIF_VERSION}
            return {"metaInformation": meta}
        case "rmf":
            return {"building_name": "clearway"}
        case "node-link":
            return {"directed": directed, "multigraph": False, "graph": own}
        case "graphml":
            return {"directed": True, **own} if directed and not graph.edges else own


def _in_layout(
    nodes: list[RouteNode], edges: list[RouteEdge]
) -> tuple[list[RouteNode], list[RouteEdge], tuple[Mapping[str, Any], ...]]:
    """Put all into one layout, for one type of vehicles; ids become text."""
    vehicle = {"vehicleTypeId": LIF_VEHICLE}
    fields = {"vehicleTypeNodeProperties": [vehicle]}
    places = [replace(n, id=str(n.id), fields=fields) for n in nodes]
    ways = []
    for e in _named(edges):
        limit = {} if e.speed_m_s is None else {"maxSpeed": e.speed_m_s}
        own = {"vehicleTypeEdgeProperties": [{**vehicle, "rotationAllowed": True, **limit}]}
        start, end = str(e.start), str(e.end)
        ways.append(replace(e, id=str(e.id), start=start, end=end, line=(), fields=own))
    return places, ways, ({"layoutId": "clearway"},)


def _on_levels(
    graph: RouteGraph, nodes: list[RouteNode], edges: list[RouteEdge]
) -> tuple[list[RouteNode], list[RouteEdge], tuple[Mapping[str, Any], ...]]:
    """Put every frame's nodes on a level, and edges where they begin; ids become names."""
    frames = graph.frames or ("L1",)
    part = {node.id: frames.index(graph.frame_of(node)) for node in nodes}
    placed = [replace(n, part=part[n.id], fields={"name": str(n.id), **n.fields}) for n in nodes]
    lanes = [
        replace(
            e,
            part=part.get(e.start, 0),
            line=(),
            fields=e.fields if e.id is None else {"name": str(e.id), **e.fields},
        )
        for e in edges
    ]
    return placed, lanes, tuple({"name": one or "L1", "fields": {}} for one in frames)


def _straightened(
    nodes: list[RouteNode], edges: list[RouteEdge], taken: set[GraphId]
) -> tuple[list[RouteNode], list[RouteEdge]]:
    by_id = {node.id: node for node in nodes}
    more, pieces = list(nodes), []
    for k, edge in enumerate(edges):
        bends = _inner(edge, by_id)
        if not bends:
            pieces.append(replace(edge, line=()))
            continue
        first = by_id.get(edge.start)
        frame = first.frame if first else ""
        row: list[GraphId] = [edge.start]
        for i, (x, y) in enumerate(bends):
            fresh = next(n for n in (f"{k}.{i}" + "'" * j for j in count()) if n not in taken)
            taken.add(fresh)
            more.append(RouteNode(fresh, x, y, frame))
            row.append(fresh)
        row.append(edge.end)
        for i, (start, end) in enumerate(pairwise(row)):
            own = None if edge.id is None else f"{edge.id}.{i}"
            # cost and length are the whole edge's
            pieces.append(
                replace(edge, id=own, start=start, end=end, line=(), cost=None, length=None)
            )
    return more, pieces


def _inner(edge: RouteEdge, by_id: Mapping[GraphId, RouteNode]) -> list[Vec]:
    """Points of an edge's line between its nodes."""
    line = list(edge.line)
    if edge.start in by_id and line and line[0] == by_id[edge.start].at:
        line = line[1:]
    if edge.end in by_id and line and line[-1] == by_id[edge.end].at:
        line = line[:-1]
    return line


def _one_way(edge: RouteEdge) -> Iterator[RouteEdge]:
    yield replace(edge, both_ways=False)
    if edge.both_ways:
        own = None if edge.id is None else f"{edge.id} back"
        line = edge.line[::-1]
        yield replace(edge, id=own, start=edge.end, end=edge.start, line=line, both_ways=False)


def _carried(fields: Mapping[str, Any], source: GraphFormat, target: GraphFormat) -> dict[str, Any]:
    plain = fields.get("properties", {}).get("metadata", {}) if source == "nav2" else fields
    values = _scalars(plain, lists=target in BENT) if isinstance(plain, Mapping) else {}
    return _as_feature(values) if target == "nav2" else values


def _as_feature(metadata: Mapping[str, Any]) -> dict[str, Any]:
    properties = {"metadata": metadata} if metadata else {}
    return {"type": "Feature", "properties": properties}


def _scalars(fields: Mapping[str, Any], *, lists: bool = False) -> dict[str, Any]:
    """Return the numbers, texts and truth values, and with ``lists`` flat lists of them."""
    plain = str | int | float
    return {
        key: value
        for key, value in fields.items()
        if isinstance(value, plain)
        or (lists and isinstance(value, list) and all(isinstance(one, plain) for one in value))
    }


def _numbered(
    nodes: list[RouteNode], edges: list[RouteEdge]
) -> tuple[list[RouteNode], list[RouteEdge]]:
    """Number nodes and edges unless all have different numbers that Nav2 takes."""
    ids = [*(node.id for node in nodes), *(edge.id for edge in edges)]
    if len(set(ids)) == len(ids) and all(_is_number(one) for one in ids):
        return nodes, edges
    number: dict[GraphId, GraphId] = {}
    for k, node in enumerate(nodes):
        number.setdefault(node.id, k)
    fresh = count(len(nodes))
    missing: dict[GraphId, int] = {}

    def end(node: GraphId) -> GraphId:
        if node in number:
            return number[node]
        return missing.setdefault(node, MOST_NUMBER - 1 - len(missing))

    named = [replace(n, id=k, fields=_with_name(n.fields, n.id)) for k, n in enumerate(nodes)]
    lines = [
        replace(
            edge,
            id=next(fresh),
            start=end(edge.start),
            end=end(edge.end),
            fields=edge.fields if edge.id is None else _with_name(edge.fields, edge.id),
        )
        for edge in edges
    ]
    return named, lines


def _is_number(value: GraphId | None) -> bool:
    return isinstance(value, int) and 0 <= value < MOST_NUMBER


def _with_name(fields: Mapping[str, Any], name: GraphId) -> dict[str, Any]:
    metadata = fields.get("properties", {}).get("metadata", {})
    return _as_feature({"name": name, **metadata})


def _named(edges: list[RouteEdge]) -> list[RouteEdge]:
    taken = {edge.id for edge in edges}
    fresh = (f"e{k}" for k in count() if f"e{k}" not in taken)
    return [replace(edge, id=next(fresh)) if edge.id is None else edge for edge in edges]
