"""Open-RMF navigation graphs: YAML with levels of vertices and lanes.

A vertex is [x, y, {name, ...}], a lane [first vertex, last vertex, {speed_limit, ...}]; a level's
vertices are numbered from 0, and a lane leads one way. A vertex's id here is ``level/number``, its
frame the level.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import yaml

from planner.graph_files.file_place import FilePlace, take_number
from planner.graph_files.route_graph import ExchangeError, GraphId, RouteEdge, RouteGraph, RouteNode


def read_rmf(text: str, file: str) -> RouteGraph:
    """Parse a navigation graph; :class:`ExchangeError` with the place of an error."""
    root = FilePlace(file)
    document = root.mapping(_parse(text, file))
    levels = root.at("levels").mapping(root.needed(document, "levels"))
    nodes: list[RouteNode] = []
    edges: list[RouteEdge] = []
    parts: list[dict[str, Any]] = []
    for i, (key, value) in enumerate(levels.items()):
        level = str(key)
        here = root.at("levels").at(level)
        rest = here.mapping(value)
        for k, vertex in enumerate(here.at("vertices").sequence(rest.pop("vertices", []))):
            nodes.append(_node(here.at("vertices").at(k), vertex, f"{level}/{k}", level, i))
        for k, lane in enumerate(here.at("lanes").sequence(rest.pop("lanes", []))):
            edges.append(_edge(here.at("lanes").at(k), lane, f"{level}/lane {k}", level, i))
        parts.append({"name": key, "fields": rest})
    return RouteGraph(tuple(nodes), tuple(edges), "rmf", document, tuple(parts))


def _parse(text: str, file: str) -> object:
    try:
        return yaml.safe_load(text)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        place = f":{mark.line + 1}:{mark.column + 1}" if mark else ""
        raise ExchangeError(f"{file}{place}: not YAML: {error.problem}") from None
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        raise ExchangeError(f"{file}: not YAML: {str(error).splitlines()[0]}") from None


def _node(here: FilePlace, value: Any, number: str, level: str, part: int) -> RouteNode:
    row = [_plain(item) for item in here.sequence(value)]
    (x, y), rest = here.place(row)
    return RouteNode(number, x, y, level, _fields(here, rest), part)


def _edge(here: FilePlace, value: Any, number: str, level: str, part: int) -> RouteEdge:
    row = here.sequence(value)
    if len(row) < 2:
        raise here.error("must be [first vertex, last vertex]")
    ends = []
    for i, vertex in enumerate(row[:2]):
        if isinstance(vertex, bool) or not isinstance(vertex, int):
            raise here.at(i).error(f"{vertex!r:.40}: must be the number of a vertex")
        ends.append(f"{level}/{vertex}")
    fields = _fields(here, row[2:])
    if "speed_limit" in fields:
        fields["speed_limit"] = _plain(fields["speed_limit"])
    speed = take_number(fields, "speed_limit")
    return RouteEdge(number, ends[0], ends[1], speed_m_s=speed, fields=fields, part=part)


def _fields(here: FilePlace, rest: list[Any]) -> dict[str, Any]:
    if len(rest) > 1:
        raise here.error(f"{2 + len(rest)} values: must be two and an object at most")
    return here.at(2).mapping(rest[0]) if rest and rest[0] is not None else {}


def _plain(value: object) -> object:
    """A number to YAML 1.2 and C++, as 1e-5, is text to YAML 1.1."""
    if isinstance(value, str):
        try:
            return float(value)
        except ValueError:
            return value
    return value


def write_rmf(graph: RouteGraph) -> str:
    """Write a graph with this format's fields.

    Raises :class:`ExchangeError` if a lane leads to no vertex of its level.
    """
    levels: dict[Any, Any] = {}
    for i, part in enumerate(graph.parts):
        nodes = [node for node in graph.nodes if node.part == i]
        number: dict[GraphId, int] = {}
        for k, node in enumerate(nodes):
            number.setdefault(node.id, k)
        vertices = [[node.x, node.y, dict(node.fields)] for node in nodes]
        level = str(part["name"])
        lanes = [_lane(edge, number, level) for edge in graph.edges if edge.part == i]
        levels[part["name"]] = {**part["fields"], "vertices": vertices, "lanes": lanes}
    document = {**graph.fields, "levels": levels}
    text: str = yaml.safe_dump(
        document, sort_keys=False, default_flow_style=None, allow_unicode=True
    )
    return text


def _lane(edge: RouteEdge, number: Mapping[GraphId, int], level: str) -> list[Any]:
    limit = {} if edge.speed_m_s is None else {"speed_limit": edge.speed_m_s}
    ends = [_vertex(edge, node, number, level) for node in (edge.start, edge.end)]
    return [*ends, {**limit, **edge.fields}]


def _vertex(edge: RouteEdge, node: GraphId, number: Mapping[GraphId, int], level: str) -> int:
    """Number of a vertex; a missing one keeps that of the file it was read from."""
    if node in number:
        return number[node]
    part, _, last = str(node).rpartition("/")
    if part == level and last.lstrip("-").isdigit() and int(last) not in range(len(number)):
        return int(last)
    raise ExchangeError(f"lane {edge.name}: {node!r}: must be a vertex of level {level!r}")
