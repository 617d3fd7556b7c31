"""Goals that a robot must reach from the graph."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from planner.borders.ground import Ground
from planner.graph_audit.edge_lines import EdgeLines
from planner.graph_audit.findings import FindingList
from planner.graph_audit.unsafe import RADIUS_SLACK
from planner.path import NoPath
from planner.roadmap.roadmap import build_roadmap
from planner.scene import Scene, Vec


def check_goals(goals: Sequence[Sequence[float]]) -> list[Vec]:
    """Goals as places; ``ValueError`` if one is not finite."""
    places: list[Vec] = []
    for number, goal in enumerate(goals):
        x, y = (float(value) for value in goal[:2])
        if not (math.isfinite(x) and math.isfinite(y)):
            raise ValueError(f"goals[{number}] = ({x:g}, {y:g}): must be finite")
        places.append((x, y))
    return places


def judge_goals(
    goals: Sequence[Vec],
    lines: EdgeLines,
    part: set[int],
    scene: Scene,
    ground: Ground,
    radius: float,
    findings: FindingList,
) -> None:
    """Add findings on goals to which no path leads from the nearest safe node."""
    nodes = sorted(part)
    places = lines.places[nodes].reshape(-1, 2)
    places = places[ground.signed(places) >= radius * (1.0 - RADIUS_SLACK)]
    roadmap = None
    for goal in goals:
        reason = "no node of its largest part is safe"
        if len(places):
            if roadmap is None:
                roadmap = build_roadmap(scene, radius * (1.0 - RADIUS_SLACK))
            x, y = places[np.argmin(np.hypot(*(places - goal).T))].tolist()
            answer = roadmap.plan((x, y), goal)
            if not isinstance(answer, NoPath):
                continue
            reason = answer.reason
        findings.add("goal_unreachable", "goal", f"({goal[0]:g}, {goal[1]:g})", goal, other=reason)
