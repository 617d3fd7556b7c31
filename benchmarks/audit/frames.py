"""Graphs of other frames: each sound graph is put into another frame, which the audit must undo."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

import planner
from benchmarks.audit.judge import Judge
from benchmarks.audit.planted import CELL_M, COLUMNS, RADIUS_M, ROWS, Case, Point

SIZE_M: Final = np.array((COLUMNS, ROWS)) * CELL_M
LOST: Final = 0.25
"""A graph with less of its length free must be found to be lost; the audit says so below 0.3, and
below 0.7 if it is sure."""
NEAR_M: Final = 0.5


def _turned(points: Point, angle: float) -> Point:
    cos, sin = math.cos(angle), math.sin(angle)
    return points @ np.array([[cos, sin], [-sin, cos]])


def _freely(points: Point, rng: np.random.Generator) -> Point:
    return _turned(points, rng.uniform(-math.pi, math.pi)) + rng.uniform(-SIZE_M, SIZE_M)


FRAMES: Final[dict[str, Callable[[Point, np.random.Generator], Point]]] = {
    "pixels, y down": lambda p, rng: (p * (1, -1) + (0, SIZE_M[1])) / CELL_M,
    "millimetres": lambda p, rng: p * 1000.0,
    "from the centre": lambda p, rng: p - SIZE_M / 2,
    "y down": lambda p, rng: p * (1, -1),
    "x and y swapped": lambda p, rng: p[:, ::-1],
    "shifted": lambda p, rng: p + rng.uniform(-SIZE_M, SIZE_M),
    "shifted and turned": _freely,
    "shifted, turned, mirrored": lambda p, rng: _freely(p * (1, -1), rng),
}


class FrameCounts:
    """What became of the graphs of each frame."""

    def __init__(self) -> None:
        self.counts: Counter[tuple[str, str]] = Counter()
        self.frames = list(FRAMES)

    def add(self, number: int, case: Case, judge: Judge, rng: np.random.Generator) -> None:
        """Put a sound graph into a frame, and audit it."""
        name = self.frames[number % len(self.frames)]
        points = np.array([(n.x, n.y) for n in case.nodes])
        if len(points) < 6:
            return
        moved = FRAMES[name](points, rng)
        nodes = tuple(
            replace(node, x=float(x), y=float(y))
            for node, (x, y) in zip(case.nodes, moved, strict=True)
        )
        fit = planner.audit(replace(case.graph, nodes=nodes), case.scene, RADIUS_M).frame_fit
        before, back = _free_share(case, judge, moved), None if fit is None else fit.placed(moved)
        self.counts[name, "graphs"] += 1
        self.counts[name, "lost"] += before < LOST
        if fit is None or back is None:
            self.counts[name, "missed"] += before < LOST
            return
        off = float(np.hypot(*(back - points).T).mean())
        self.counts[name, "offered"] += 1
        self.counts[name, "put back"] += off < NEAR_M
        self.counts[name, "free"] += _free_share(case, judge, back) >= 0.9
        self.counts[name, "sure"] += fit.sure
        self.counts[name, "sure and elsewhere"] += fit.sure and off >= NEAR_M

    def table(self) -> list[str]:
        """Lines of the table."""
        columns = ("graphs", "lost", "missed", "offered", "free", "put back", "sure")
        columns = (*columns, "sure and elsewhere")
        return [
            f"| frame | {' | '.join(columns)} |",
            "|---" * (len(columns) + 1) + "|",
            *(
                f"| {name} | {' | '.join(str(self.counts[name, one]) for one in columns)} |"
                for name in self.frames
            ),
        ]


def _free_share(case: Case, judge: Judge, places: Point) -> float:
    """Share of the edges' length whose points are at least the radius from obstacles."""
    index = {node.id: k for k, node in enumerate(case.nodes)}
    free, total = 0.0, 0.0
    for edge in case.edges:
        a, b = places[index[edge.start]], places[index[edge.end]]
        t = np.linspace(0.0, 1.0, 60)[:, None]
        points = a + t * (b - a)
        on = ((points > 0.0) & (points < SIZE_M)).all(axis=1)
        keeps = np.zeros(len(points), np.bool_)
        keeps[on] = judge.solid.between[judge.solid.index(points[on])] >= RADIUS_M
        length = math.dist(a, b)
        free, total = free + length * float(keeps.mean()), total + length
    return free / total if total else 1.0
