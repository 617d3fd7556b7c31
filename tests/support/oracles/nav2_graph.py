"""A reader of route graphs with the rules of Nav2's GeoJsonGraphFileLoader.

Written from its documentation and from what it accepts: features are nodes where their geometry
is a Point and edges where it is a LineString or MultiLineString; others are passed over. A graph
without nodes or without edges is refused. Numbers of nodes and edges are unsigned; an edge names
its ends in ``startid`` and ``endid``, which must be nodes. ``frame``, ``cost``, ``overridable``,
``metadata`` and ``operations`` may be missing. Metadata holds numbers, truth values, strings,
lists of those, and objects of the same kind; an operation has a ``type`` and a ``trigger``.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any

TRIGGERS = {"NODE", "ON_ENTER", "ON_EXIT"}


class NoValidGraphError(ValueError):
    """What the server would refuse to load."""


@dataclass
class Edge:
    number: int
    end: Node
    cost: float
    overridable: bool
    metadata: dict[str, Any]


@dataclass
class Node:
    number: int
    frame: str
    x: float
    y: float
    metadata: dict[str, Any]
    leaving: list[Edge] = field(default_factory=list)


def load_graph(text: str) -> dict[int, Node]:
    """The nodes by number, with the edges that leave them."""
    features = json.loads(text)["features"]
    points = [f for f in features if f["geometry"]["type"] == "Point"]
    lines = [f for f in features if f["geometry"]["type"] in ("LineString", "MultiLineString")]
    if not points or not lines:
        raise NoValidGraphError("does not contain nodes or edges")
    nodes: dict[int, Node] = {}
    numbers: set[int] = set()
    for feature in points:
        properties = feature["properties"]
        number = _fresh(properties["id"], numbers)
        x, y, *_ = feature["geometry"]["coordinates"]
        _check_operations(properties)
        frame = properties.get("frame", "map")
        nodes[number] = Node(number, frame, float(x), float(y), _metadata(properties))
    for feature in lines:
        properties = feature["properties"]
        number = _fresh(properties["id"], numbers)
        start, end = _unsigned(properties["startid"]), _unsigned(properties["endid"])
        if start not in nodes or end not in nodes:
            raise NoValidGraphError(f"edge {number}: start or end does not exist")
        _check_operations(properties)
        edge = Edge(
            number,
            nodes[end],
            float(properties.get("cost", 0.0)),
            properties.get("overridable", True) is True,
            _metadata(properties),
        )
        nodes[start].leaving.append(edge)
    return nodes


def _unsigned(value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < 2**32:
        raise NoValidGraphError(f"{value!r}: must be an unsigned number of 32 bits")
    return value


def _fresh(value: Any, numbers: set[int]) -> int:
    number = _unsigned(value)
    if number in numbers:
        raise NoValidGraphError(f"{number}: nodes and edges must have numbers of their own")
    numbers.add(number)
    return number


def _metadata(properties: dict[str, Any], key: str = "metadata") -> dict[str, Any]:
    found = {}
    for name, value in properties.get(key, {}).items():
        if isinstance(value, dict):
            found[name] = _metadata(properties[key], name)
            continue
        for item in value if isinstance(value, list) else [value]:
            if not isinstance(item, int | float | str):
                raise NoValidGraphError(f"{name}: cannot be converted")
        found[name] = value
    return found


def _check_operations(properties: dict[str, Any]) -> None:
    for operation in properties.get("operations", []):
        if operation["trigger"] not in TRIGGERS or not isinstance(operation["type"], str):
            raise NoValidGraphError(f"operation {operation}: no such trigger or type")
