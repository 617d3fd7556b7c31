"""The judge of stretches on which two robots cannot pass: their length, by samples with bounds."""

from __future__ import annotations

import numpy as np

import planner
from benchmarks.audit.distances import HALF_DIAGONAL, SIDE_M, Distances, samples
from benchmarks.audit.judge import Judge
from benchmarks.audit.planted import RADIUS_M, Case, Point


class StretchCounts:
    """Lengths that audits report, compared with the judge's bounds."""

    def __init__(self) -> None:
        self.graphs = self.within = self.stretches = 0
        self.length_m = 0.0

    def add(self, case: Case, judge: Judge, where: str) -> None:
        """Audit a graph, and compare the length of its narrow stretches."""
        found = planner.audit(
            case.graph, case.scene, RADIUS_M, keepout=case.keepout, passing=True
        ).findings
        lengths = [one.value or 0.0 for one in found if one.kind == "edge_without_passing"]
        low, high = narrow_length(case, judge.solid, judge.zones)
        self.graphs += 1
        self.stretches += len(lengths)
        self.length_m += sum(lengths)
        if low - 1e-6 <= sum(lengths) <= high + 1e-6:
            self.within += 1
        else:
            print(f"stretches: {where}: {sum(lengths):.3f} m, judged {low:.3f} to {high:.3f}")

    def sentence(self) -> str:
        """Sentence of the results."""
        return (
            f"{self.stretches} stretches of together {self.length_m:.0f} m on which two robots"
            f" cannot pass: in {self.within} of {self.graphs} graphs their length is within the"
            " judge's bounds."
        )


def narrow_length(case: Case, solid: Distances, zones: Distances) -> tuple[float, float]:
    """Bounds of the length on which two robots cannot pass: samples below twice the radius."""
    place: dict[object, Point] = {}
    for node in case.nodes:
        place.setdefault(node.id, np.array((node.x, node.y)))
    edges = [edge for edge in case.edges if edge.start in place and edge.end in place]
    lines = [(place[edge.start], place[edge.end]) for edge in edges]
    ways = {(tuple(a.tolist()), tuple(b.tolist())) for a, b in lines}
    low = high = 0.0
    for a, b in lines:
        ends = tuple(a.tolist()), tuple(b.tolist())
        if ends[0] >= ends[1] or ends[::-1] not in ways or ends not in ways:
            continue
        ways.discard(ends)
        points, step = samples(a, b)
        between = np.minimum(*(one.between[one.index(points)] for one in (solid, zones)))
        upper = np.where(between > 0.0, between - SIDE_M / 2 + HALF_DIAGONAL, 0.0)
        lower = between - 2.0 * HALF_DIAGONAL
        sure, perhaps = upper + 0.5 * step < 2.0 * RADIUS_M, lower - 0.5 * step < 2.0 * RADIUS_M
        low += step * float((sure[1:] & sure[:-1]).sum())
        high += step * float((perhaps[1:] | perhaps[:-1]).sum())
    return low, high
