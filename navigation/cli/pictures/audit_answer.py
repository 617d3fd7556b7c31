"""The answer of ``clearway audit``: JSON (``clearway.audit/1``), text, or GitHub's annotations.

In JSON every field is present, null if it does not apply. Lengths are in the map's units, timings
in milliseconds.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from planner.graph_audit.audit import GraphAudit
from planner.graph_audit.coverage import GraphCoverage
from planner.graph_audit.edge_lines import length_of
from planner.graph_audit.findings import SEVERITIES, GraphFinding, Severity
from planner.graph_audit.frame_fit import FrameFit
from planner.graph_repair.repair import GraphRepair
from planner.shared.figures import placed, sized

SCHEMA = "clearway.audit/1"
LEVELS: Mapping[Severity, str] = {"unsafe": "error", "error": "error", "warning": "warning"}
PLURALS: Mapping[Severity, str] = {"unsafe": "unsafe", "error": "errors", "warning": "warnings"}


@dataclass(frozen=True, slots=True)
class AuditOutput:
    """An audit, to be written in any form."""

    file: str
    audit: GraphAudit
    coverage: GraphCoverage
    timings_ms: Mapping[str, float]
    remarks: tuple[str, ...] = ()
    repair: GraphRepair | None = None

    @property
    def is_safe(self) -> bool:
        """True if every goal is reached, and the graph, repaired if it was to be, is safe."""
        if any(one.kind == "goal_unreachable" for one in self.audit.findings):
            return False
        return (self.audit if self.repair is None else self.repair.audit).safe

    def as_form(self, form: str) -> str:
        """The answer as ``text``, ``json`` or ``github``."""
        if form == "json":
            return json.dumps(self.as_object(), allow_nan=False, indent=1) + "\n"
        return "\n".join(self._annotations() if form == "github" else self._lines()) + "\n"

    def as_object(self) -> dict[str, Any]:
        """Fields of the JSON answer."""
        found = self.audit
        return {
            "schema": SCHEMA,
            "status": "ok" if found.safe else "unsafe",
            "units": found.units,
            "robot_radius": found.radius,
            "graph": {
                "file": self.file,
                "format": found.graph.format,
                "nodes": len(found.graph.nodes),
                "edges": len(found.graph.edges),
            },
            "counts": {severity: len(found.of(severity)) for severity in SEVERITIES},
            "findings": [_finding(one) for one in found.findings],
            "edges": [self._edge(k) for k in range(len(found.edges))],
            "coverage": asdict(self.coverage),
            "frame": None if found.frame_fit is None else _frame(found.frame_fit),
            "repair": None if self.repair is None else _repair(self.repair),
            "timings_ms": {name: round(ms, 3) for name, ms in self.timings_ms.items()},
            "remarks": list(self.remarks),
        }

    def _edge(self, k: int) -> dict[str, Any]:
        found, edge = self.audit, self.audit.edges[k]
        zones = found.zone_clearances
        clear = math.isfinite(found.clearances[k])
        return {
            "id": edge.id,
            "start": edge.start,
            "end": edge.end,
            "length": length_of(found.lines[k]),
            "clearance": float(found.clearances[k]) if clear else None,
            "at": found.places[k].tolist() if clear else None,
            "keepout_distance": _finite(zones[k]) if zones is not None else None,
        }

    def _lines(self) -> Iterator[str]:
        found = self.audit
        counts = ", ".join(f"{len(found.of(one))} {PLURALS[one]}" for one in SEVERITIES)
        graph = f"{len(found.graph.nodes)} nodes, {len(found.graph.edges)} edges"
        yield f"{self.file}: {graph}, robot radius {sized(found.radius, found.units)}: {counts}"
        if len(found.edges) and math.isfinite(found.clearances.min()):
            k = int(found.clearances.argmin())
            at = placed(*found.places[k].tolist())
            least = sized(float(found.clearances[k]), found.units, found.radius)
            yield f"least clearance {least}: edge {found.edges[k].name} at {at}"
        reach = sized(self.coverage.reach, found.units)
        yield f"within {reach} of the graph: {self.coverage.covered:.0%} of the free space"
        for one in found.findings:
            yield f"{one.severity + ':':<9}{one}"
            yield f"{'':9}{one.cure}"
        if self.repair is not None:
            yield from _repair_lines(self.repair)
        for remark in self.remarks:
            yield f"note: {remark}"

    def _annotations(self) -> Iterator[str]:
        for one in self.audit.findings:
            file, title = _escaped(self.file, ":,"), _escaped(one.id, ":,")
            text = _escaped(f"{one}. {one.cure}")
            yield f"::{LEVELS[one.severity]} file={file},title={title}::{text}"
        counts = ", ".join(f"{len(self.audit.of(s))} {PLURALS[s]}" for s in SEVERITIES)
        yield f"::notice file={_escaped(self.file, ':,')}::{counts}"


def _finding(one: GraphFinding) -> dict[str, Any]:
    return {
        "id": one.id,
        "kind": one.kind,
        "severity": one.severity,
        "edge": one.name if one.subject == "edge" else None,
        "node": one.name if one.subject == "node" else None,
        "at": None if one.at is None else list(one.at),
        "value": None if one.value is None else _finite(one.value),
        "limit": one.limit,
        "sentence": str(one),
        "cure": one.cure,
    }


def _frame(fit: FrameFit) -> dict[str, Any]:
    return {**asdict(fit), "shift": list(fit.shift), "sure": fit.sure, "sentence": str(fit)}


def _repair(done: GraphRepair) -> dict[str, Any]:
    return {
        "safe": done.audit.safe,
        "transformed": done.frame_fit is not None,
        "moved": [
            {"node": move.node, "from": list(move.before), "to": list(move.after)}
            for move in done.moved
        ],
        "detours": list(done.detours),
        "unsolved": [{"id": one, "reason": reason} for one, reason in done.unsolved.items()],
        "counts": {severity: len(done.audit.of(severity)) for severity in SEVERITIES},
    }


def _repair_lines(done: GraphRepair) -> Iterator[str]:
    if done.frame_fit is not None:
        yield f"repair:  {done.frame_fit}"
    left = len(done.unsolved)
    words = f"{left} unsafe left" if left else "nothing unsafe is left"
    yield f"repair:  {len(done.moved)} nodes moved, {len(done.detours)} edges led round: {words}"
    units = done.audit.units
    for move in done.moved:
        way = sized(math.dist(move.before, move.after), units)
        yield f"{'':9}node {move.node} from {placed(*move.before)} by {way}"
    for one in done.audit.of("unsafe"):
        yield f"{'':9}{one}: {done.unsolved[one.id]}"


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _escaped(text: str, more: str = "") -> str:
    """Text for a workflow command of GitHub: these characters would end its parts."""
    return "".join(f"%{ord(c):02X}" if c in "%\r\n" + more else c for c in text)
