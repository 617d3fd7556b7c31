"""Repairs of graphs with planted faults, judged by the distance transform and by flooding cells."""

from __future__ import annotations

from collections import Counter

import cv2
import numpy as np
from numpy.typing import NDArray

import planner
from benchmarks.audit.distances import HALF_DIAGONAL
from benchmarks.audit.judge import Judge
from benchmarks.audit.planted import RADIUS_M, Case


class RepairCounts:
    """What repairs left, and what the judge says about it."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self.reasons: Counter[str] = Counter()

    def add(self, case: Case, judge: Judge, where: str) -> None:
        """Repair a graph, and judge the result."""
        done = planner.repair(case.graph, case.scene, RADIUS_M, keepout=case.keepout)
        before = planner.audit(case.graph, case.scene, RADIUS_M, keepout=case.keepout)
        count = self.counts
        count["graphs"] += 1
        count["unsafe before"] += len(before.of("unsafe"))
        count["unsafe left"] += len(done.unsolved)
        count["graphs with none left"] += not done.unsolved
        count["nodes moved"] += len(done.moved)
        count["edges led round"] += len(done.detours)
        for reason in done.unsolved.values():
            self.reasons[reason.split(":")[0].split(" (")[0]] += 1
        place = {}
        for node in done.graph.nodes:
            place.setdefault(node.id, np.array((node.x, node.y)))
        left = {(one.subject, one.name) for one in done.audit.of("unsafe")}
        pools = _pools(judge)
        for edge in done.graph.edges:
            if edge.start not in place or edge.end not in place:
                continue
            a, b = place[edge.start], place[edge.end]
            high = min(judge.solid.bounds(a, b)[1], judge.zones.bounds(a, b)[1])
            if ("edge", edge.name) in left:
                ends = [int(pools[judge.solid.index(p[None])][0]) for p in (a, b)]
                if 0 < ends[0] == ends[1]:
                    count["left although there is a path"] += 1
                    print(f"left: {where}: edge {edge.name}")
            elif high < RADIUS_M * (1.0 - 1e-6):
                count["unsafe by the judge"] += 1
                print(f"unsafe: {where}: edge {edge.name}")
        ids = {node.id for node in done.graph.nodes}
        kept = {node.id for node in case.nodes} <= ids
        kept &= {edge.id for edge in case.edges} <= {edge.id for edge in done.graph.edges}
        count["graphs that lost an id"] += not kept

    def table(self) -> list[str]:
        """Lines of the table."""
        names = ("graphs", "unsafe before", "unsafe left", "graphs with none left", "nodes moved")
        names = (*names, "edges led round", "unsafe by the judge", "left although there is a path")
        names = (*names, "graphs that lost an id")
        rows = [f"| {name} | {self.counts[name]} |" for name in names]
        rows += [f"| left: {reason} | {n} |" for reason, n in self.reasons.most_common()]
        return ["| | |", "|---|---|", *rows]


def _pools(judge: Judge) -> NDArray[np.int32]:
    """Numbers of the connected parts of the surely free small cells, 0 for all others."""
    between = np.minimum(judge.solid.between, judge.zones.between)
    # a step to a cell beside, along the grid, stays as far away as both of the cells' centres
    free = between - 2.0 * HALF_DIAGONAL - HALF_DIAGONAL > RADIUS_M
    _, pools = cv2.connectedComponents(free.astype(np.uint8), connectivity=4)
    return np.asarray(pools, np.int32)
