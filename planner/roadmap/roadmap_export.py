"""The roadmap as a route graph for other programs, and its text in their formats.

- Nav2's route server (nav2_route, GeoJsonGraphFileLoader) drives straight from node to node and
  reads an edge in one direction. So every edge is cut where it bends, each straight piece keeps the
  robot's radius, and both directions are written. Node and edge numbers are unsigned and distinct;
  ``cost`` is the length; a piece's clearance is in its ``metadata``, which may hold numbers but no
  nested lists. The server's frame is in metres, y up. No edge has length 0.
- LIF and Open-RMF get Nav2's graph, GraphML and node-link JSON the graph as it is.

Coordinates and lengths are in the scene's units; no text holds NaN or infinity.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from planner.borders.polyline import fewer_vertices
from planner.graph_files import GraphFormat
from planner.graph_files.graph_io import format_of, graph_text
from planner.graph_files.route_graph import (
    BENT,
    ExchangeError,
    RouteEdge,
    RouteGraph,
    RouteNode,
)
from planner.scene import FloatArray

if TYPE_CHECKING:
    import networkx as nx
    from numpy.typing import ArrayLike

    from planner.borders.generators import Borders

STRAIGHT_TOLERANCE = 0.02
"""Largest gap between the roadmap and a straight piece, as a part of the robot's radius."""

SAME_PLACE = 1e-9
"""Places nearer than this share of the scene's extent are one."""
NAV2_CRS = "urn:ogc:def:crs:EPSG::3857"
"""Coordinate system of Nav2's own graphs; the server takes coordinates as metres in its frame."""


class Exported(Protocol):
    """The part of a :class:`planner.Roadmap` that is written; that class imports this module."""

    @property
    def radius(self) -> float:
        """Radius of the robot."""

    @property
    def spacing(self) -> float:
        """Largest distance between generators."""

    @property
    def scene(self) -> object:
        """Scene of the roadmap."""

    @property
    def borders(self) -> Borders:
        """Borders of the scene."""

    @property
    def graph(self) -> nx.Graph[int]:
        """Nodes and edges."""

    def path_clearance(self, polyline: ArrayLike) -> Any:
        """Least ``distance`` of a polyline (n, 2) to any border."""


def as_text(
    roadmap: Exported, suffix: str, *, frame: str = "map", generated: str | None = None
) -> str:
    """Graph in the format of a file's suffix: .graphml, .geojson, .json, .lif, .yaml or .yml.

    ``frame`` is the TF frame of straight edges, ``generated`` Nav2's ``date_generated``, omitted
    if None. Raises :class:`ExchangeError` for another suffix, and for straight edges if the graph
    has none, which Nav2's route server refuses.
    """
    form = format_of(f"roadmap{suffix}")
    return graph_text(route_graph(roadmap, form, frame, generated), form)


def route_graph(
    roadmap: Exported, form: GraphFormat, frame: str = "map", generated: str | None = None
) -> RouteGraph:
    """Graph for a format; arguments as :func:`as_text`'s."""
    if form in BENT:
        return bent_graph(roadmap)
    return straight_graph(roadmap, frame, generated)


def to_networkx(roadmap: Exported) -> nx.Graph[int]:
    """Graph with numbers and text only; a polyline is "x,y x,y ...", owners are "1 2"."""
    import networkx as nx

    plain: nx.Graph[int] = nx.Graph(**_graph_fields(roadmap))
    for node, data in _nodes(roadmap):
        plain.add_node(node, **data | {"owners": _joined(data["owners"])})
    for u, v, data in _edges(roadmap):
        points = " ".join(f"{x!r},{y!r}" for x, y in data["polyline"])
        plain.add_edge(u, v, **data | {"owners": _joined(data["owners"]), "polyline": points})
    return plain


def bent_graph(roadmap: Exported) -> RouteGraph:
    """Return the graph as it is."""
    nodes = [
        RouteNode(node, data.pop("x"), data.pop("y"), fields=data) for node, data in _nodes(roadmap)
    ]
    edges = [
        RouteEdge(
            None,
            u,
            v,
            True,
            tuple((x, y) for x, y in data.pop("polyline")),
            length=data.pop("length"),
            fields=data,
        )
        for u, v, data in _edges(roadmap)
    ]
    fields = {"directed": False, "multigraph": False, "graph": _graph_fields(roadmap)}
    return RouteGraph(tuple(nodes), tuple(edges), "node-link", fields)


def straight_graph(
    roadmap: Exported, frame: str = "map", generated: str | None = None
) -> RouteGraph:
    """Return the graph in straight pieces, each in both directions; see :func:`as_text`."""
    same = SAME_PLACE * roadmap.borders.extent
    points: list[RouteNode] = []
    number = _numbered(roadmap, points, frame, same)
    pieces: list[tuple[int, int, FloatArray]] = []
    for u, v, data in _edges(roadmap):
        line = _from_to(roadmap, u, np.array(data["polyline"]))
        line = line[np.concatenate([[True], np.hypot(*np.diff(line, axis=0).T) > same])]
        if len(line) < 2:
            continue
        kept = line[_straight(roadmap, line)]
        ids = [number[u]]
        for x, y in kept[1:-1].tolist():
            ids.append(len(points))
            clearance = float(roadmap.path_clearance([(x, y)]).distance)
            points.append(_point(ids[-1], {"x": x, "y": y, "clearance": clearance}, frame))
        ids.append(number[v])
        pieces += zip(ids[:-1], ids[1:], np.stack([kept[:-1], kept[1:]], axis=1), strict=True)
    if not pieces:
        raise ExchangeError(
            f"the roadmap of radius {roadmap.radius:g} has no edges: Nav2's route server loads no "
            "empty graph"
        )
    edges: list[RouteEdge] = []
    for start, end, ends in pieces:
        clearance = float(roadmap.path_clearance(ends).distance)
        for a, b, way in ((start, end, ends), (end, start, ends[::-1])):
            edges.append(_piece(len(points) + len(edges), a, b, way, clearance))
    document = {
        "type": "FeatureCollection",
        "name": "clearway_roadmap",
        "crs": {"type": "name", "properties": {"name": NAV2_CRS}},
        **({} if generated is None else {"date_generated": generated}),
    }
    return RouteGraph(tuple(points), tuple(edges), "nav2", document)


def _numbered(
    roadmap: Exported, points: list[RouteNode], frame: str, same: float
) -> dict[int, int]:
    """Append the nodes; return their numbers, one for both ends of a zero-length edge."""
    first: dict[int, int] = {}

    def leader(node: int) -> int:
        while first.get(node, node) != node:
            node = first[node]
        return node

    for u, v, data in _edges(roadmap):
        if data["length"] <= same:
            first[leader(v)] = leader(u)
    number: dict[int, int] = {}
    for node, data in _nodes(roadmap):
        if leader(node) == node:
            number[node] = len(points)
            points.append(_point(len(points), data, frame))
    return {node: number[leader(node)] for node, _ in _nodes(roadmap)}


def _straight(roadmap: Exported, line: FloatArray) -> list[int]:
    """Vertices to keep, so that every straight piece keeps the robot's radius."""
    tolerance = STRAIGHT_TOLERANCE * roadmap.radius
    kept: list[int] = fewer_vertices(line, tolerance).tolist()
    result = kept[:1]
    for a, b in pairwise(kept):
        tight = roadmap.path_clearance(line[[a, b]]).distance < roadmap.radius
        result += range(a + 1, b + 1) if tight else [b]
    return result


def _from_to(roadmap: Exported, u: int, line: FloatArray) -> FloatArray:
    x, y = roadmap.graph.nodes[u]["pos"]
    ends = np.hypot(*(line[[0, -1]] - (x, y)).T)
    return line if ends[0] <= ends[1] else line[::-1]


def _point(number: int, data: dict[str, Any], frame: str) -> RouteNode:
    metadata = {"clearance": data["clearance"]}
    fields = {"type": "Feature", "properties": {"metadata": metadata}}
    return RouteNode(number, data["x"], data["y"], frame, fields)


def _piece(number: int, start: int, end: int, ends: FloatArray, clearance: float) -> RouteEdge:
    length = float(np.hypot(*(ends[1] - ends[0])))
    line = tuple((x, y) for x, y in ends.tolist())
    properties = {"overridable": True, "metadata": {"clearance": clearance}}
    fields = {"type": "Feature", "properties": properties}
    return RouteEdge(number, start, end, False, line, length, length, fields=fields)


def _graph_fields(roadmap: Exported) -> dict[str, Any]:
    units = getattr(roadmap.scene, "units", None)
    fields = {"radius": float(roadmap.radius), "spacing": float(roadmap.spacing)}
    return fields | ({"units": units} if units else {})


def _nodes(roadmap: Exported) -> Iterator[tuple[int, dict[str, Any]]]:
    for node, data in roadmap.graph.nodes(data=True):
        x, y = data["pos"]
        yield (
            int(node),
            {
                "x": _finite(x),
                "y": _finite(y),
                "clearance": _finite(data["clearance"]),
                "owners": [int(o) for o in data["owners"]],
            },
        )


def _edges(roadmap: Exported) -> Iterator[tuple[int, int, dict[str, Any]]]:
    for u, v, data in roadmap.graph.edges(data=True):
        yield (
            int(u),
            int(v),
            {
                "length": _finite(data["length"]),
                "clearance": _finite(data["clearance"]),
                "owners": [int(o) for o in data["owners"]],
                "polyline": np.asarray(data["polyline"], dtype=np.float64).tolist(),
            },
        )


def _finite(value: Any) -> float:
    number = float(value)
    if not np.isfinite(number):
        raise ExchangeError(f"the roadmap holds {number}: only finite numbers can be written")
    return number


def _joined(owners: list[int]) -> str:
    return " ".join(str(o) for o in owners)
