"""A route graph: nodes with places, edges with directions, and what else their file says.

- Places are in the file's own frame and units: metres, y up, for Nav2, LIF and Open-RMF.
- An edge leads from ``start`` to ``end``; one with ``both_ways`` leads back as well. Its nodes need
  not exist.
- ``speed_m_s`` and ``speed_percent``, of the robot's own largest speed, are limits. ``fields``
  holds what the format has besides.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

from planner.graph_files import GraphFormat
from planner.scene import Vec, printable

GraphId: TypeAlias = str | int

BENT: tuple[GraphFormat, ...] = ("graphml", "node-link")
"""Formats whose edges may bend; robots drive others straight."""


class ExchangeError(ValueError):
    """A route graph cannot be read, converted or written; the message says why."""

    def __init__(self, message: str) -> None:
        super().__init__(printable(message))


@dataclass(frozen=True, slots=True)
class RouteNode:
    """A place; ``part`` is the level or layout of the file that holds it."""

    id: GraphId
    x: float
    y: float
    frame: str = ""
    fields: Mapping[str, Any] = field(default_factory=dict)
    part: int = 0

    @property
    def at(self) -> Vec:
        """(x, y)."""
        return self.x, self.y


@dataclass(frozen=True, slots=True)
class RouteEdge:
    """A connection of two nodes; ``line`` is its drawn line, if any."""

    id: GraphId | None
    start: GraphId
    end: GraphId
    both_ways: bool = False
    line: tuple[Vec, ...] = ()
    cost: float | None = None
    length: float | None = None
    speed_m_s: float | None = None
    speed_percent: float | None = None
    fields: Mapping[str, Any] = field(default_factory=dict)
    part: int = 0

    @property
    def name(self) -> str:
        """The edge's id, or its nodes'."""
        return f"{self.start}-{self.end}" if self.id is None else str(self.id)


@dataclass(frozen=True, slots=True)
class RouteGraph:
    """Nodes and edges in the order of the file.

    ``parts`` are the other fields of a LIF's layouts or an Open-RMF file's levels.
    """

    nodes: tuple[RouteNode, ...] = ()
    edges: tuple[RouteEdge, ...] = ()
    format: GraphFormat = "node-link"
    fields: Mapping[str, Any] = field(default_factory=dict)
    parts: tuple[Mapping[str, Any], ...] = ()

    def __repr__(self) -> str:
        return f"<RouteGraph ({self.format}) of {len(self.nodes)} nodes, {len(self.edges)} edges>"

    @property
    def bends(self) -> bool:
        """True if robots follow the edges' lines."""
        return self.format in BENT

    def frame_of(self, node: RouteNode) -> str:
        """Frame of a node; without one, "map" for Nav2, else ""."""
        return node.frame or ("map" if self.format == "nav2" else "")

    @property
    def frames(self) -> tuple[str, ...]:
        """Frames of the nodes, in the order of the file."""
        return tuple(dict.fromkeys(self.frame_of(node) for node in self.nodes))

    def within(self, frame: str) -> RouteGraph:
        """Nodes of one frame, and all edges that do not lead to or from another frame's node."""
        nodes = tuple(node for node in self.nodes if self.frame_of(node) == frame)
        others = {node.id for node in self.nodes} - {node.id for node in nodes}
        edges = (e for e in self.edges if e.start not in others and e.end not in others)
        return replace(self, nodes=nodes, edges=tuple(edges))
