"""Findings of an audit: each kind with its severity, its sentence and its cure."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

from planner.scene import Vec
from planner.shared.figures import placed, sized

Severity: TypeAlias = Literal["unsafe", "error", "warning"]
Subject: TypeAlias = Literal["edge", "node", "goal", "graph"]
SEVERITIES: tuple[Severity, ...] = ("unsafe", "error", "warning")
"""A robot that drives this touches or enters something; the graph does not do what it should; it
may be meant."""


class FindingKind(NamedTuple):
    """Severity, sentence and cure of a kind.

    The sentence takes {value} and {limit}, lengths with units, {number}, the value as it is, and
    {other}, another node or edge.
    """

    severity: Severity
    sentence: str
    cure: str


KINDS: dict[str, FindingKind] = {
    "edge_in_obstacle": FindingKind(
        "unsafe",
        "runs {value} through an obstacle",
        "Move its nodes, or lead it round the obstacle.",
    ),
    "edge_in_unknown": FindingKind(
        "unsafe",
        "runs {value} through cells that the map does not know",
        "Map this area, or lead the edge round it.",
    ),
    "edge_off_map": FindingKind(
        "unsafe",
        "runs {value} outside the map",
        "Move its nodes onto the map, or compare the graph's frame with the map's.",
    ),
    "edge_in_keepout": FindingKind(
        "unsafe",
        "runs {value} through a keep-out zone",
        "Lead it round the zone, or change the zone.",
    ),
    "edge_near_obstacle": FindingKind(
        "unsafe",
        "comes within {value} of an obstacle: must be {limit} or more",
        "Move it away from the obstacle.",
    ),
    "edge_near_keepout": FindingKind(
        "unsafe",
        "comes within {value} of a keep-out zone: must be {limit} or more",
        "Move it away from the zone, or shrink the zone if it is for the robot's centre.",
    ),
    "node_off_map": FindingKind(
        "unsafe",
        "is outside the map",
        "Move it onto the map, or compare the graph's frame with the map's.",
    ),
    "node_in_obstacle": FindingKind(
        "unsafe", "is {value} inside an obstacle", "Move it into free space."
    ),
    "node_in_unknown": FindingKind(
        "unsafe",
        "is in a cell that the map does not know",
        "Map this area, or move the node.",
    ),
    "node_in_keepout": FindingKind(
        "unsafe", "is {value} inside a keep-out zone", "Move it out of the zone."
    ),
    "node_near_obstacle": FindingKind(
        "unsafe",
        "is {value} from an obstacle: must be {limit} or more",
        "Move it away from the obstacle.",
    ),
    "node_near_keepout": FindingKind(
        "unsafe",
        "is {value} from a keep-out zone: must be {limit} or more",
        "Move it away from the zone.",
    ),
    "goal_unreachable": FindingKind(
        "error",
        "cannot be reached from the graph: {other}",
        "Choose another goal, or a smaller robot.",
    ),
    "graph_wrong_frame": FindingKind(
        "error",
        "is not in the map's frame: {number} % of its length is free; {other}",
        "Transform its places, or name the frame that the map has.",
    ),
    "edge_too_fast": FindingKind(
        "error",
        "runs {value} through an area with a limit of {other}",
        "Lower its limit, or divide it at the area's border.",
    ),
    "turn_too_tight": FindingKind(
        "error",
        "has a turn {other} of a radius of {value} at most: must be {limit} or more",
        "Move the node, put more room before the turn, or remove the connection.",
    ),
    "edge_bends_tightly": FindingKind(
        "error",
        "bends with a radius of {value} at most: must be {limit} or more",
        "Draw the bend wider.",
    ),
    "edge_without_passing": FindingKind(
        "warning",
        "is in a stretch of {value} on which two robots cannot pass: {other}",
        "Make it one-way, or let robots wait at its ends.",
    ),
    "edge_without_node": FindingKind(
        "error", "names node {other}, which does not exist", "Add the node, or correct the id."
    ),
    "node_id_taken": FindingKind(
        "error", "has the id of another node", "Give it an id of its own."
    ),
    "graph_in_parts": FindingKind(
        "error",
        "is in {number} parts between which robots cannot drive forth and back: must be 1",
        "Add edges, or ways back, between the parts.",
    ),
    "node_unreachable": FindingKind(
        "error",
        "cannot be reached from the largest part of the graph",
        "Add an edge that leads to it.",
    ),
    "node_dead_end": FindingKind(
        "error",
        "has edges that lead to it, and none that leads away",
        "Add an edge that leads away.",
    ),
    "node_without_return": FindingKind(
        "error",
        "leads to nodes from which no robot comes back",
        "Add an edge that leads back.",
    ),
    "edge_without_length": FindingKind(
        "error", "has no length", "Remove it, or move one of its nodes."
    ),
    "length_too_short": FindingKind(
        "error",
        "has a length of {value} in the file, and is {limit} long",
        "Correct its length: planners rely on none being too short.",
    ),
    "length_too_long": FindingKind(
        "warning", "has a length of {value} in the file, and is {limit} long", "Correct its length."
    ),
    "edge_id_taken": FindingKind(
        "warning", "has the id of another edge", "Give it an id of its own."
    ),
    "edge_doubled": FindingKind("warning", "is the same as edge {other}", "Remove one of them."),
    "node_doubled": FindingKind(
        "warning", "is at the place of node {other}", "Make them one node."
    ),
    "node_alone": FindingKind("warning", "has no edge", "Connect it, or remove it."),
    "edges_cross": FindingKind(
        "warning",
        "crosses edge {other} where there is no node",
        "Put a node there if robots may turn off, or have to give way.",
    ),
    "edge_passes_node": FindingKind(
        "warning",
        "passes node {other} at {value}, and is not connected to it",
        "Divide it at the node, or move the node.",
    ),
    "line_beside_node": FindingKind(
        "warning",
        "is drawn with a line that ends {value} beside its node {other}",
        "Draw the line from node to node.",
    ),
    "edge_has_trajectory": FindingKind(
        "warning",
        "has a trajectory, which is not measured: its straight line is",
        "Put nodes along the trajectory.",
    ),
    "line_not_straight": FindingKind(
        "warning",
        "is drawn with a bend of {value}, but robots drive it straight",
        "Put nodes at the bends.",
    ),
}
"""All kinds, in an audit's order within a severity."""
WRITTEN_AS_ZERO = 1e-12
"""Lengths up to this are written as 0."""
ORDER = {kind: number for number, kind in enumerate(KINDS)}


@dataclass(frozen=True, slots=True)
class GraphFinding:
    """One finding: its subject's name, its place (x, y) or None, and ``value`` against ``limit``.

    Lengths are in the scene's units. ``id`` is unique in an audit, and stays in the next one.
    """

    id: str
    kind: str
    severity: Severity
    subject: Subject
    name: str
    at: Vec | None
    value: float | None
    limit: float | None
    sentence: str
    cure: str

    def __str__(self) -> str:
        place = "" if self.at is None else f" at {placed(*self.at)}"
        name = "the graph" if self.subject == "graph" else f"{self.subject} {self.name}"
        return f"{name}{place} {self.sentence}"


class FindingList:
    """Collects findings, and gives each its id and sentence."""

    def __init__(self, units: str) -> None:
        self.units = units
        self.found: list[GraphFinding] = []
        self._ids: Counter[str] = Counter()

    def add(
        self,
        kind: str,
        subject: Subject,
        name: object,
        at: Vec | None = None,
        value: float | None = None,
        limit: float | None = None,
        other: object = "",
    ) -> None:
        """Add a finding of a kind."""
        severity, sentence, cure = KINDS[kind]
        begin = f"{kind}:{name}" if subject != "graph" else kind
        self._ids[begin] += 1
        again = self._ids[begin]
        words = sentence.format(
            value=self._sized(value, limit) if "{value}" in sentence else "",
            limit=self._sized(limit, value) if "{limit}" in sentence else "",
            number=f"{value:g}" if "{number}" in sentence else "",
            other=other,
        )
        self.found.append(
            GraphFinding(
                begin if again == 1 else f"{begin}#{again}",
                *(kind, severity, subject, str(name), at, value, limit, words, cure),
            )
        )

    def _sized(self, length: float | None, beside: float | None) -> str:
        if length is None:
            return ""
        return sized(length if length > WRITTEN_AS_ZERO else 0.0, self.units, beside)

    def in_order(self) -> tuple[GraphFinding, ...]:
        """Return the findings, the worst first."""
        rank = {severity: number for number, severity in enumerate(SEVERITIES)}
        found = sorted(self.found, key=lambda one: (rank[one.severity], ORDER[one.kind]))
        return tuple(found)
