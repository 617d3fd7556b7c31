"""The audit: a route graph against a scene, keep-out zones and a robot's radius."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from planner.borders.ground import Ground
from planner.formats.mask_files import SpeedLevel
from planner.graph_audit.edge_lines import EdgeLines, lay_out
from planner.graph_audit.findings import FindingList, GraphFinding, Severity
from planner.graph_audit.frame_fit import FrameFit
from planner.graph_audit.frame_search import find_frame
from planner.graph_audit.goals import check_goals, judge_goals
from planner.graph_audit.nearby import find_nearby
from planner.graph_audit.passing import find_narrow
from planner.graph_audit.slow_zones import find_fast
from planner.graph_audit.structure import find_doubles, find_lengths, find_reach, find_taken_ids
from planner.graph_audit.turns import find_tight_turns
from planner.graph_audit.unsafe import judge_edges, judge_nodes, judge_zones
from planner.graph_files.route_graph import RouteEdge, RouteGraph
from planner.scene import FloatArray, Scene
from planner.shared.arguments import as_positive


@dataclass(frozen=True, slots=True)
class GraphAudit:
    """Findings, the worst first, and the measured edges.

    ``lines`` are the edges' lines as robots drive them, ``clearances`` (m,) their exact clearances,
    ``places`` (m, 2) where these are least, ``zone_clearances`` (m,) the same to keep-out zones, or
    None. Edges that name a missing node are not measured. ``frame_fit`` puts a graph of another
    frame onto the map, or is None. Lengths are in the scene's ``units``.
    """

    radius: float
    units: str
    graph: RouteGraph
    findings: tuple[GraphFinding, ...]
    edges: tuple[RouteEdge, ...]
    lines: tuple[FloatArray, ...]
    clearances: FloatArray
    places: FloatArray
    zone_clearances: FloatArray | None
    frame_fit: FrameFit | None = None

    @property
    def safe(self) -> bool:
        """True if no finding is unsafe."""
        return not self.of("unsafe")

    def of(self, severity: Severity) -> tuple[GraphFinding, ...]:
        """Return the findings of a severity."""
        return tuple(one for one in self.findings if one.severity == severity)

    def __repr__(self) -> str:
        counts = ", ".join(f"{len(self.of(s))} {s}" for s in ("unsafe", "error", "warning"))
        return f"<GraphAudit of {len(self.edges)} edges: {counts}>"


def audit(
    graph: RouteGraph,
    scene: Scene,
    radius: float,
    *,
    keepout: Scene | None = None,
    speed: Sequence[SpeedLevel] = (),
    max_speed_m_s: float | None = None,
    passing: bool = False,
    turning_radius: float | None = None,
    goals: Sequence[Sequence[float]] = (),
    frame: str | None = None,
) -> GraphAudit:
    """Measure every edge of a route graph exactly, and find what is wrong with the graph.

    ``radius`` > 0 is the robot's, in the scene's units; the graph has the same frame and units. The
    robot's body must not enter the objects of ``keepout``, see :func:`planner.load_mask`. ``speed``
    are areas with speed limits that edges must not exceed, see :func:`planner.load_speed_mask`;
    ``max_speed_m_s`` > 0 is the robot's, to compare limits in percent with those in m/s. With
    ``passing``, stretches are reported on which two robots cannot pass. ``turning_radius`` is that
    of the tightest bend that the robot can drive. ``goals`` are places (x, y) that a robot must
    reach from the graph. A graph of several frames needs the ``frame`` of the scene. Raises
    ``ValueError`` for a senseless radius, speed, goal or frame. O(n log n) for n edges that lie
    near few others.
    """
    size, places = as_positive("radius", radius), check_goals(goals)
    top_speed = None if max_speed_m_s is None else as_positive("max_speed_m_s", max_speed_m_s)
    turning = as_positive("turning_radius", turning_radius or 0.0, zero=True)
    graph = _one_frame(graph, frame)
    findings = FindingList(scene.units)
    find_taken_ids(graph, findings)
    lines = lay_out(graph, size, findings)
    ground = Ground.of(scene, bounds=scene.bounds_given)
    clearances, at = ground.clearances(lines.lines)
    frame_fit = _judge_frame(lines, scene, ground, size, findings)
    judge_edges(lines, scene, ground, clearances, at, size, findings)
    judge_nodes(lines, scene, ground, size, findings)
    zone_clearances, solid = None, ground
    if keepout is not None:
        zones = Ground.of(keepout, bounds=False)
        zone_clearances, near = zones.clearances(lines.lines)
        judge_zones(lines, zones, zone_clearances, near, size, findings)
        solid = replace(ground, zones=zones)
    find_fast(lines, speed, top_speed, findings)
    find_doubles(lines, findings)
    find_lengths(lines, size, findings)
    find_nearby(lines, size, findings)
    find_tight_turns(lines, solid, size, turning, findings)
    if passing:
        find_narrow(lines, solid, size, findings)
    part = find_reach(lines, findings)
    if places:
        judge_goals(places, lines, part, scene, ground, size, findings)
    for array in (clearances, at, *lines.lines):
        array.setflags(write=False)
    return GraphAudit(
        size,
        scene.units,
        graph,
        findings.in_order(),
        lines.edges,
        lines.lines,
        clearances,
        at,
        zone_clearances,
        frame_fit,
    )


def _one_frame(graph: RouteGraph, frame: str | None) -> RouteGraph:
    frames = graph.frames
    if frame is None and len(frames) > 1:
        raise ValueError(f"the graph has the frames {', '.join(map(repr, frames))}: name the map's")
    if frame is not None and frames and frame not in frames:
        raise ValueError(
            f"frame {frame!r}: the graph has no node in it: must be one of"
            f" {', '.join(map(repr, frames))}"
        )
    return graph if frame is None else graph.within(frame)


def _judge_frame(
    lines: EdgeLines, scene: Scene, ground: Ground, radius: float, findings: FindingList
) -> FrameFit | None:
    """Add a finding if another frame puts most of the graph into free space; return the fit."""
    fit = find_frame(lines, scene, ground, radius)
    if fit is None:
        return None
    words = f"{fit}: {100.0 * fit.after:.0f} %, and the next best {100.0 * fit.runner_up:.0f} %"
    before = float(round(100.0 * fit.before))
    findings.add("graph_wrong_frame", "graph", "", None, before, 100.0 * fit.after, words)
    return fit
