"""GeoJSON route graphs of Nav2's route server (nav2_route, GeoJsonGraphFileLoader).

A Point is a node, with ``id`` and perhaps ``frame`` among its properties; a LineString or
MultiLineString is an edge, with ``id``, ``startid``, ``endid`` and perhaps ``cost``. An edge leads
one way, straight from node to node: its line is for pictures. Its ``metadata`` may have
``speed_limit`` (percent), ``abs_speed_limit`` (m/s) and ``length``. Other features are kept.

``fields`` are the feature's other members and ``properties``, its ``geometry`` without the
coordinates, ``lines``, the number of points of each of several lines, and ``heights``, what
coordinates have besides x and y.
"""

from __future__ import annotations

from typing import Any

from planner.graph_files.file_place import FilePlace, json_text, parse_json, take_number
from planner.graph_files.route_graph import RouteEdge, RouteGraph, RouteNode
from planner.scene import Vec

LINES = ("LineString", "MultiLineString")


def read_geojson(text: str, file: str) -> RouteGraph:
    """Parse a route graph; :class:`ExchangeError` with the place of an error."""
    root = FilePlace(file)
    document = {"type": "FeatureCollection"} | parse_json(text, file)
    nodes: list[RouteNode] = []
    edges: list[RouteEdge] = []
    others: list[Any] = []
    features = root.at("features").sequence(root.needed(document, "features"))
    for i, value in enumerate(features):
        here = root.at("features").at(i)
        feature = {"type": "Feature"} | here.mapping(value)
        geometry = feature.pop("geometry", None)
        kind = geometry.get("type") if isinstance(geometry, dict) else None
        if kind == "Point":
            nodes.append(_node(here, feature, geometry))
        elif kind in LINES:
            edges.append(_edge(here, feature, geometry))
        else:
            others.append(value)
    fields = document | ({"other_features": others} if others else {})
    return RouteGraph(tuple(nodes), tuple(edges), "nav2", fields)


def _node(here: FilePlace, feature: dict[str, Any], geometry: dict[str, Any]) -> RouteNode:
    inside = here.at("properties")
    properties = inside.mapping(feature.get("properties"))
    number = inside.at("id").identity(inside.needed(properties, "id"))
    frame = properties.pop("frame", "")
    if not isinstance(frame, str):
        raise inside.at("frame").error("must be a string")
    at = here.at("geometry").at("coordinates")
    (x, y), height = at.place(geometry.get("coordinates"))
    fields = feature | {"properties": properties} | ({"heights": height} if height else {})
    if rest := {key: geometry[key] for key in geometry if key not in ("type", "coordinates")}:
        fields["geometry"] = rest
    return RouteNode(number, x, y, frame, fields)


def _edge(here: FilePlace, feature: dict[str, Any], geometry: dict[str, Any]) -> RouteEdge:
    inside = here.at("properties")
    properties = inside.mapping(feature.get("properties"))
    number, start, end = (
        inside.at(key).identity(inside.needed(properties, key))
        for key in ("id", "startid", "endid")
    )
    cost = inside.at("cost").number(properties.pop("cost")) if "cost" in properties else None
    metadata = inside.at("metadata").mapping(properties.get("metadata", {}))
    length, speed, percent = (
        take_number(metadata, key) for key in ("length", "abs_speed_limit", "speed_limit")
    )
    if "metadata" in properties:
        properties["metadata"] = metadata
    fields = feature | {"properties": properties}
    line = _line(here.at("geometry").at("coordinates"), geometry, fields)
    return RouteEdge(number, start, end, False, line, cost, length, speed, percent, fields)


def _line(here: FilePlace, geometry: dict[str, Any], fields: dict[str, Any]) -> tuple[Vec, ...]:
    """Points of the geometry; its rest goes into ``fields``."""
    rows = here.sequence(geometry.get("coordinates"))
    fields["geometry"] = {key: geometry[key] for key in geometry if key != "coordinates"}
    if geometry["type"] == "LineString":
        lines = [(here, rows)]
    else:
        lines = [(here.at(i), here.at(i).sequence(one)) for i, one in enumerate(rows)]
        if len(lines) != 1:
            fields["lines"] = [len(one) for _, one in lines]
    found = [at.at(i).place(row) for at, one in lines for i, row in enumerate(one)]
    if any(height for _, height in found):
        fields["heights"] = [height for _, height in found]
    return tuple(point for point, _ in found)


def write_geojson(graph: RouteGraph) -> str:
    """Write a graph with this format's fields."""
    document = dict(graph.fields)
    others = document.pop("other_features", [])
    places = {node.id: node.at for node in graph.nodes}
    document["features"] = [
        *(_point(node) for node in graph.nodes),
        *(_lines(edge, places) for edge in graph.edges),
        *others,
    ]
    return json_text(document)


def _point(node: RouteNode) -> dict[str, Any]:
    fields = dict(node.fields)
    properties, height = fields.pop("properties", {}), fields.pop("heights", [])
    frame = {"frame": node.frame} if node.frame else {}
    geometry = {"type": "Point", **fields.pop("geometry", {})}
    return {
        **fields,
        "properties": {"id": node.id, **frame, **properties},
        "geometry": geometry | {"coordinates": [node.x, node.y, *height]},
    }


def _lines(edge: RouteEdge, places: dict[Any, Vec]) -> dict[str, Any]:
    fields = dict(edge.fields)
    properties = dict(fields.pop("properties", {}))
    geometry = dict(fields.pop("geometry", {"type": "MultiLineString"}))
    sizes = fields.pop("lines", None)
    heights = fields.pop("heights", [])
    given = {
        "length": edge.length,
        "abs_speed_limit": edge.speed_m_s,
        "speed_limit": edge.speed_percent,
    }
    limits = {key: value for key, value in given.items() if value is not None}
    if limits:
        properties["metadata"] = limits | properties.get("metadata", {})
    ends = {"startid": edge.start, "endid": edge.end}
    cost = {} if edge.cost is None else {"cost": edge.cost}
    straight = [places[n] for n in (edge.start, edge.end) if n in places]
    rows: list[Any] = [list(point) for point in edge.line or straight]
    if len(heights) == len(rows):
        rows = [[*row, *height] for row, height in zip(rows, heights, strict=True)]
    one = geometry["type"] == "LineString"
    geometry["coordinates"] = rows if one else _split(rows, sizes or [len(rows)])
    return {
        **fields,
        "properties": {"id": edge.id, **ends, **cost, **properties},
        "geometry": geometry,
    }


def _split(rows: list[Any], sizes: list[int]) -> list[list[Any]]:
    """Rows as lines of the given sizes, or one line if their number has changed."""
    if sum(sizes) != len(rows):
        return [rows]
    ends = [sum(sizes[: i + 1]) for i in range(len(sizes))]
    return [rows[end - size : end] for size, end in zip(sizes, ends, strict=True)]
