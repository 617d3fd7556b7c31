"""Node-link JSON, as ``networkx.node_link_data`` makes it.

A node has ``id``, its place in ``x`` and ``y`` or ``pos``, and perhaps ``frame``. An edge has
``source``, ``target``, and perhaps ``id``, ``polyline`` ([[x, y], ...]), ``length``, ``cost``,
``speed`` (m/s) and ``speed_percent``. The list of edges is ``edges``, or ``links`` from earlier
networkx versions. In a file that is not ``directed`` every edge leads both ways.
"""

from __future__ import annotations

from typing import Any

from planner.graph_files.file_place import FilePlace, json_text, parse_json, take_number
from planner.graph_files.route_graph import RouteEdge, RouteGraph, RouteNode

_LIMITS = {
    "cost": "cost",
    "length": "length",
    "speed": "speed_m_s",
    "speed_percent": "speed_percent",
}
"""Attributes of an edge's limits, and their fields of `RouteEdge`."""


def read_node_link(text: str, file: str) -> RouteGraph:
    """Parse node-link JSON; :class:`ExchangeError` with the place of an error."""
    root = FilePlace(file)
    document = parse_json(text, file)
    nodes = root.at("nodes").sequence(root.needed(document, "nodes"))
    key = "links" if "links" in document and "edges" not in document else "edges"
    edges = root.at(key).sequence(root.needed(document, key))
    document = {"directed": False, "multigraph": False, "graph": {}} | document
    if not isinstance(document["directed"], bool):
        raise root.at("directed").error("must be true or false")
    both_ways = not document["directed"]
    return RouteGraph(
        tuple(_node(root.at("nodes").at(i), node) for i, node in enumerate(nodes)),
        tuple(_edge(root.at(key).at(i), edge, both_ways) for i, edge in enumerate(edges)),
        "node-link",
        document,
    )


def _node(here: FilePlace, value: Any) -> RouteNode:
    fields = here.mapping(value)
    number = here.at("id").identity(here.needed(fields, "id"))
    if "pos" in fields and "x" not in fields:
        (x, y), _ = here.at("pos").place(fields.pop("pos"))
    else:
        x, y = (here.at(k).number(here.needed(fields, k)) for k in ("x", "y"))
    return RouteNode(number, x, y, take_text(fields, "frame"), fields)


def _edge(here: FilePlace, value: Any, both_ways: bool) -> RouteEdge:
    fields = here.mapping(value)
    start, end = (here.at(k).identity(here.needed(fields, k)) for k in ("source", "target"))
    number = here.at("id").identity(fields.pop("id")) if "id" in fields else None
    rows = here.at("polyline").sequence(fields.pop("polyline", []))
    line = tuple(here.at("polyline").at(i).place(row)[0] for i, row in enumerate(rows))
    limits = take_limits(fields)
    return RouteEdge(number, start, end, both_ways, line, fields=fields, **limits)


def take_text(fields: dict[str, Any], key: str) -> str:
    """Remove a string and return it; "" if there is none, leaving any other value."""
    return fields.pop(key) if isinstance(fields.get(key), str) else ""


def take_limits(fields: dict[str, Any]) -> dict[str, Any]:
    """Remove an edge's limits and return them as fields of `RouteEdge`."""
    return {field: take_number(fields, key) for key, field in _LIMITS.items()}


def limits_of(edge: RouteEdge) -> dict[str, float]:
    """Return an edge's limits, as far as they are given."""
    values = {key: getattr(edge, field) for key, field in _LIMITS.items()}
    return {key: value for key, value in values.items() if value is not None}


def node_fields(node: RouteNode) -> dict[str, Any]:
    """Return a node's place, frame and other fields."""
    frame = {"frame": node.frame} if node.frame else {}
    return {"x": node.x, "y": node.y, **frame, **node.fields}


def write_node_link(graph: RouteGraph) -> str:
    """Write a graph with this format's fields."""
    directed = graph.fields.get("directed", not all(edge.both_ways for edge in graph.edges))
    edges: list[dict[str, Any]] = []
    for edge in graph.edges:
        own = {} if edge.id is None else {"id": edge.id}
        line = {"polyline": [list(point) for point in edge.line]} if edge.line else {}
        record = {**own, **limits_of(edge), **edge.fields, **line}
        edges.append({"source": edge.start, "target": edge.end, **record})
        if directed and edge.both_ways:
            back = line and {"polyline": line["polyline"][::-1]}
            edges.append({"source": edge.end, "target": edge.start, **record, **back})
    document = {
        "directed": directed,
        "multigraph": False,
        "graph": {},
        **graph.fields,
        "nodes": [{"id": node.id, **node_fields(node)} for node in graph.nodes],
        "edges": edges,
    }
    return json_text(document)
