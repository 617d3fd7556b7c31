"""GraphML with places in the attributes ``x`` and ``y``, or ``pos`` ("x,y").

Edges have the attributes of node-link JSON, see ``node_link.py``; a ``polyline`` is "x,y x,y ...".
``directed`` of the graph or of an edge says whether an edge leads one way. Nested graphs,
hyperedges and ports are refused.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree
from xml.sax.saxutils import escape, quoteattr

from planner.graph_files.file_place import FilePlace
from planner.graph_files.node_link import limits_of, node_fields, take_limits, take_text
from planner.graph_files.route_graph import ExchangeError, RouteEdge, RouteGraph, RouteNode
from planner.scene import Vec

WHOLE, REAL = ("int", "long"), ("float", "double")
NAMESPACE = "http://graphml.graphdrawing.org/xmlns"


@dataclass(frozen=True, slots=True)
class AttributeKey:
    """A declared attribute: its name, its type, and its default or None."""

    name: str
    type: str
    default: str | None
    of: str


def read_graphml(text: str, file: str) -> RouteGraph:
    """Parse GraphML; :class:`ExchangeError` with the place of an error."""
    if "<!DOCTYPE" in text:
        raise ExchangeError(f"{file}: has a document type: must have none")
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        line, column = error.position
        what = str(error).partition(":")[0]
        raise ExchangeError(f"{file}:{line}:{column + 1}: not XML: {what}") from None
    graphs = [one for one in root if _tag(one) == "graph"]
    if _tag(root) != "graphml" or len(graphs) != 1:
        raise ExchangeError(f"{file}: {len(graphs)} graphs: must be GraphML with one graph")
    keys = {one.get("id", ""): _key(one) for one in root if _tag(one) == "key"}
    graph = graphs[0]
    nodes: list[RouteNode] = []
    edges: list[RouteEdge] = []
    one_way = graph.get("edgedefault", "undirected") == "directed"
    for one in graph:
        if _tag(one) == "node":
            nodes.append(_node(FilePlace(file, f"node {len(nodes)}"), one, keys))
        elif _tag(one) == "edge":
            edges.append(_edge(FilePlace(file, f"edge {len(edges)}"), one, keys, one_way))
        elif _tag(one) not in ("data", "desc"):
            raise ExchangeError(
                f"{file}: <{_tag(one)[:40]}> is in the graph: must hold nodes and edges"
            )
    fields = _data(FilePlace(file, "graph"), graph, keys, "graph")
    if one_way and all(edge.both_ways for edge in edges):
        fields["directed"] = True
    return RouteGraph(tuple(nodes), tuple(edges), "graphml", fields)


def _tag(element: ElementTree.Element) -> str:
    return element.tag.rpartition("}")[2]


def _key(element: ElementTree.Element) -> AttributeKey:
    default = next((one.text or "" for one in element if _tag(one) == "default"), None)
    name = element.get("attr.name", element.get("id", ""))
    return AttributeKey(
        name, element.get("attr.type", "string"), default, element.get("for", "all")
    )


def _data(
    here: FilePlace, element: ElementTree.Element, keys: Mapping[str, AttributeKey], of: str
) -> dict[str, Any]:
    """Attributes of an element, defaults included."""
    texts = {k: v.default for k, v in keys.items() if v.default is not None and v.of in (of, "all")}
    for one in element:
        if _tag(one) == "data":
            number = one.get("key", "")
            if number not in keys:
                raise here.error(f"the key {number[:40]!r} is not declared")
            if len(one):
                raise here.error(f"{keys[number].name[:40]} holds elements: must be text")
            texts[number] = one.text or ""
        elif _tag(one) not in ("desc", "node", "edge"):
            raise here.error(f"<{_tag(one)[:40]}>: must hold data only")
    return {keys[k].name: _value(here.at(keys[k].name), keys[k].type, v) for k, v in texts.items()}


def _value(here: FilePlace, kind: str, text: str) -> Any:
    words = text.strip()
    try:
        if kind in WHOLE:
            return int(words)
        if kind in REAL:
            return here.number(float(words))
    except ValueError as error:
        if isinstance(error, ExchangeError):
            raise
        raise here.error(f"{text[:40]!r}: must be of type {kind}") from None
    if kind == "boolean":
        if words.lower() not in ("true", "false", "0", "1"):
            raise here.error(f"{text[:40]!r}: must be true or false")
        return words.lower() in ("true", "1")
    return text


def _node(
    here: FilePlace, element: ElementTree.Element, keys: Mapping[str, AttributeKey]
) -> RouteNode:
    number = element.get("id")
    if number is None:
        raise here.error("has no id: must have one")
    fields = _data(here, element, keys, "node")
    if "x" not in fields and isinstance(fields.get("pos"), str):
        ((x, y),) = _points(here.at("pos"), fields.pop("pos").replace(" ", ""), 1)
    else:
        x, y = (here.at(k).number(_number(here.needed(fields, k))) for k in ("x", "y"))
    return RouteNode(number, x, y, take_text(fields, "frame"), fields)


def _number(value: Any) -> Any:
    try:
        return float(value) if isinstance(value, str) else value
    except ValueError:
        return value


def _edge(
    here: FilePlace, element: ElementTree.Element, keys: Mapping[str, AttributeKey], one_way: bool
) -> RouteEdge:
    ends = [element.get("source"), element.get("target")]
    if ends[0] is None or ends[1] is None:
        raise here.error("must have a source and a target")
    fields = _data(here, element, keys, "edge")
    line: tuple[Vec, ...] = ()
    if isinstance(fields.get("polyline"), str):
        line = _points(here.at("polyline"), fields.pop("polyline"))
    directed = element.get("directed")
    both_ways = not one_way if directed is None else directed.lower() not in ("true", "1")
    limits = take_limits(fields)
    number = element.get("id")
    return RouteEdge(number, ends[0], ends[1], both_ways, line, fields=fields, **limits)


def _points(here: FilePlace, text: str, count: int | None = None) -> tuple[Vec, ...]:
    points = []
    for word in text.split():
        try:
            x, y = (here.number(float(part)) for part in word.strip("()[]").split(","))
        except ValueError as error:
            if isinstance(error, ExchangeError):
                raise
            raise here.error(f"{word[:40]!r}: must be x,y") from None
        points.append((x, y))
    if count is not None and len(points) != count:
        raise here.error("must be x,y")
    return tuple(points)


def write_graphml(graph: RouteGraph) -> str:
    """Write a graph with this format's fields; lists and other such values become text."""
    keys: dict[tuple[str, str], tuple[str, str]] = {}
    fields = dict(graph.fields)
    directed = fields.pop("directed", not all(edge.both_ways for edge in graph.edges))
    body = [f'  <graph edgedefault="{"directed" if directed else "undirected"}">']
    body += _lines(keys, "graph", fields)
    for node in graph.nodes:
        body.append(f"    <node id={quoteattr(str(node.id))}>")
        body += [*_lines(keys, "node", node_fields(node)), "    </node>"]
    for edge in graph.edges:
        own = "" if edge.id is None else f" id={quoteattr(str(edge.id))}"
        mixed = ' directed="false"' if directed and edge.both_ways else ""
        ends = f"source={quoteattr(str(edge.start))} target={quoteattr(str(edge.end))}"
        body.append(f"    <edge {ends}{own}{mixed}>")
        line = {"polyline": " ".join(f"{x!r},{y!r}" for x, y in edge.line)} if edge.line else {}
        values = {**limits_of(edge), **edge.fields, **line}
        body += [*_lines(keys, "edge", values), "    </edge>"]
    head = [
        f'  <key id="{number}" for="{of}" attr.name={quoteattr(name)} attr.type="{kind}"/>'
        for (of, name), (number, kind) in keys.items()
    ]
    begin = ["<?xml version='1.0' encoding='utf-8'?>", f'<graphml xmlns="{NAMESPACE}">']
    return "\n".join([*begin, *head, *body, "  </graph>", "</graphml>"]) + "\n"


def _lines(
    keys: dict[tuple[str, str], tuple[str, str]], of: str, values: Mapping[str, Any]
) -> list[str]:
    """Data elements of the values; declares the keys that they need."""
    lines = []
    for name, value in values.items():
        kind, text = _typed(value)
        at = (of, name)
        number, before = keys.setdefault(at, (f"d{len(keys)}", kind))
        if before != kind:
            keys[at] = (number, "double" if {before, kind} == {"long", "double"} else "string")
        lines.append(f'      <data key="{number}">{escape(_printed(text))}</data>')
    return lines


def _typed(value: Any) -> tuple[str, str]:
    if isinstance(value, bool):
        return "boolean", str(value).lower()
    if isinstance(value, int):
        return "long", str(value)
    if isinstance(value, float):
        return "double", repr(value)
    if isinstance(value, list | tuple):
        return "string", " ".join(map(str, value))
    return "string", str(value)


def _printed(text: str) -> str:
    return re.sub(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "?", text)
