"""LIF, the VDMA's layout interchange format, for masters that speak VDA 5050.

``layouts`` hold ``nodes`` (``nodeId``, ``nodePosition``, perhaps ``mapId``, the frame) and
``edges`` (``edgeId``, ``startNodeId``, ``endNodeId``). An edge leads one way. Its speed is the
least ``maxSpeed`` of its ``vehicleTypeEdgeProperties``. Stations and all else stay in ``fields``
and ``parts``.
"""

from __future__ import annotations

from typing import Any

from planner.graph_files.file_place import FilePlace, as_number, json_text, parse_json
from planner.graph_files.route_graph import RouteEdge, RouteGraph, RouteNode


def read_lif(text: str, file: str) -> RouteGraph:
    """Parse a LIF; :class:`ExchangeError` with the place of an error."""
    root = FilePlace(file)
    document = parse_json(text, file)
    nodes: list[RouteNode] = []
    edges: list[RouteEdge] = []
    parts: list[dict[str, Any]] = []
    for i, value in enumerate(root.at("layouts").sequence(root.needed(document, "layouts"))):
        here = root.at("layouts").at(i)
        layout = here.mapping(value)
        for k, node in enumerate(here.at("nodes").sequence(layout.pop("nodes", []))):
            nodes.append(_node(here.at("nodes").at(k), node, i))
        for k, edge in enumerate(here.at("edges").sequence(layout.pop("edges", []))):
            edges.append(_edge(here.at("edges").at(k), edge, i))
        parts.append(layout)
    return RouteGraph(tuple(nodes), tuple(edges), "lif", document, tuple(parts))


def _node(here: FilePlace, value: Any, part: int) -> RouteNode:
    fields = here.mapping(value)
    number = here.at("nodeId").identity(here.needed(fields, "nodeId"))
    at = here.at("nodePosition")
    position = at.mapping(here.needed(fields, "nodePosition"))
    x, y = (at.at(key).number(at.needed(position, key)) for key in ("x", "y"))
    if position:
        fields["nodePosition"] = position
    frame = fields.pop("mapId") if isinstance(fields.get("mapId"), str) else ""
    return RouteNode(number, x, y, frame, fields, part)


def _edge(here: FilePlace, value: Any, part: int) -> RouteEdge:
    fields = here.mapping(value)
    number, start, end = (
        here.at(key).identity(here.needed(fields, key))
        for key in ("edgeId", "startNodeId", "endNodeId")
    )
    return RouteEdge(number, start, end, speed_m_s=_speed(fields), fields=fields, part=part)


def _speed(fields: dict[str, Any]) -> float | None:
    rows = fields.get("vehicleTypeEdgeProperties")
    found = [as_number(row.get("maxSpeed")) for row in _objects(rows)]
    return min((speed for speed in found if speed is not None), default=None)


def _objects(rows: object) -> list[dict[str, Any]]:
    return [row for row in rows if isinstance(row, dict)] if isinstance(rows, list) else []


def write_lif(graph: RouteGraph) -> str:
    """Write a graph with this format's fields."""
    layouts: list[dict[str, Any]] = []
    for i, part in enumerate(graph.parts):
        nodes = [_node_record(node) for node in graph.nodes if node.part == i]
        edges = [_edge_record(edge) for edge in graph.edges if edge.part == i]
        layouts.append({**part, "nodes": nodes, "edges": edges})
    return json_text({**graph.fields, "layouts": layouts})


def _node_record(node: RouteNode) -> dict[str, Any]:
    fields = dict(node.fields)
    position = {"x": node.x, "y": node.y, **fields.pop("nodePosition", {})}
    frame = {"mapId": node.frame} if node.frame else {}
    return {"nodeId": node.id, **frame, "nodePosition": position, **fields}


def _edge_record(edge: RouteEdge) -> dict[str, Any]:
    ends = {"startNodeId": edge.start, "endNodeId": edge.end}
    return {"edgeId": edge.id, **ends, **edge.fields}
