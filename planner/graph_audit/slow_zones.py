"""Edges whose own speed limit is faster than that of an area that they run through.

An area's limit counts for the robot's centre, as in Nav2's SpeedFilter. Limits in percent and in
m/s are compared by the robot's largest speed, if it is given. An edge without a limit is left to
the speed filter.
"""

from __future__ import annotations

from collections.abc import Sequence

from planner.borders.ground import Ground
from planner.formats.mask_files import SpeedLevel
from planner.graph_audit.edge_lines import EdgeLines
from planner.graph_audit.findings import FindingList
from planner.graph_audit.structure import middle
from planner.graph_audit.unsafe import NOTICED
from planner.graph_files.route_graph import RouteEdge

FASTER = 1e-9
"""Limits that differ by less than this part are equal: files round."""


def find_fast(
    lines: EdgeLines,
    levels: Sequence[SpeedLevel],
    max_speed_m_s: float | None,
    findings: FindingList,
) -> None:
    """Add findings on edges that are faster than an area allows, with the length in it."""
    for level in levels:
        faster = [k for k, edge in enumerate(lines.edges) if _is_faster(edge, level, max_speed_m_s)]
        if not faster:
            continue
        chosen = [lines.lines[k] for k in faster]
        ground = Ground.of(level.area, bounds=False)
        lengths = ground.lengths_inside(chosen)
        for k, line, length in zip(faster, chosen, lengths.tolist(), strict=True):
            edge = lines.edges[k]
            if length > NOTICED * float(lines.lengths[k]):
                words = f"{level}: its own limit is {_limit_text(edge)}"
                findings.add("edge_too_fast", "edge", edge.name, middle(line), length, other=words)


def _is_faster(edge: RouteEdge, level: SpeedLevel, max_speed_m_s: float | None) -> bool:
    own = _in_units_of(level, edge, max_speed_m_s)
    return own is not None and own > level.limit * (1.0 + FASTER)


def _in_units_of(level: SpeedLevel, edge: RouteEdge, max_speed_m_s: float | None) -> float | None:
    """The edge's limit in the area's unit, the slower of two; None if it has none."""
    percent, speed = edge.speed_percent, edge.speed_m_s
    if level.speed_percent is not None:
        other = None if speed is None or max_speed_m_s is None else 100.0 * speed / max_speed_m_s
        given = (percent, other)
    else:
        other = None
        if percent is not None and max_speed_m_s is not None:
            other = 0.01 * percent * max_speed_m_s
        given = (speed, other)
    return min((limit for limit in given if limit is not None), default=None)


def _limit_text(edge: RouteEdge) -> str:
    given = ((edge.speed_percent, "%"), (edge.speed_m_s, "m/s"))
    return " and ".join(f"{limit:.4g} {unit}" for limit, unit in given if limit is not None)
