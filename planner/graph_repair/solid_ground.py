"""A map joined with its keep-out zones: what a repaired graph must keep the radius from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from planner.borders.ground import Ground
from planner.graph_audit.unsafe import RADIUS_SLACK
from planner.graph_files.route_graph import RouteNode
from planner.path import Path
from planner.roadmap.roadmap import Roadmap, build_roadmap
from planner.scene import Bounds, FloatArray, Scene, Vec

EASE = 0.1
"""Part of the radius that paths keep more than that, where there is room: their bends can then
be fewer (measured: for Nav2's three graphs and radii of 0.5, 0.35 and 0.8 m detours have 87 new
nodes; 266 without it, as many from 0.05 to 0.2)."""
DETOUR_RADII = 20.0
"""Room for detours around a graph on a map without bounds (chosen)."""


@dataclass(frozen=True, slots=True)
class SolidGround:
    """Obstacles with zones, and the roadmap that avoids both."""

    ground: Ground
    roadmap: Roadmap
    radius: float

    @classmethod
    def of(
        cls, scene: Scene, keepout: Scene | None, radius: float, nodes: Sequence[RouteNode]
    ) -> SolidGround:
        """Join a scene with zones; one without bounds gets some around the nodes."""
        ground = Ground.of(scene, bounds=scene.bounds_given)
        if keepout is not None:
            ground = replace(ground, zones=Ground.of(keepout, bounds=False))
        bounds = scene.bounds if scene.bounds_given else _around(scene, radius, nodes)
        objects = [*scene.objects, *(() if keepout is None else keepout.objects)]
        numbered = tuple(replace(one, id=k) for k, one in enumerate(objects))
        joined = replace(scene, objects=numbered, bounds=bounds, unknown=None)
        # paths lead from nodes at the limit of what an audit allows
        return cls(ground, build_roadmap(joined, radius * (1.0 - RADIUS_SLACK)), radius)

    def is_free(self, points: FloatArray) -> NDArray[np.bool_]:
        """Mark the points (n, 2) that keep the radius."""
        free: NDArray[np.bool_] = self.ground.signed(points) >= self.radius * (1.0 - RADIUS_SLACK)
        return free

    def is_safe(self, line: FloatArray) -> bool:
        """True if a line (n, 2) keeps the radius, exactly."""
        return float(self.ground.clearances([line])[0][0]) >= self.radius * (1.0 - RADIUS_SLACK)

    def path(self, start: Vec, goal: Vec) -> FloatArray | str:
        """Return a path (n, 2) with few bends from start to goal, or why there is none."""
        for ease in (EASE * self.radius, 0.0):
            plan = self.roadmap.plan(start, goal, prefer="length", margin=ease, relaxed=ease > 0.0)
            if isinstance(plan, Path):
                line = np.array(plan.points)
                line[0], line[-1] = start, goal
                few = self._with_few_bends(line)
                if self.is_safe(few):
                    return few
        if isinstance(plan, Path):
            return "the path along the obstacles' borders cannot be drawn in straight pieces"
        return plan.reason

    def _with_few_bends(self, line: FloatArray) -> FloatArray:
        """Leave out points while straight pieces keep the radius; greedy."""
        kept, k = [0], 0
        while k < len(line) - 1:
            step = len(line) - 1 - k
            while step > 1 and not self.is_safe(line[[k, k + step]]):
                step -= max(1, step // 8)
            k += step
            kept.append(k)
        return line[kept]


def _around(scene: Scene, radius: float, nodes: Sequence[RouteNode]) -> Bounds:
    b, margin = scene.bounds, DETOUR_RADII * radius
    xs = [b.x_min, b.x_max, *(node.x for node in nodes)]
    ys = [b.y_min, b.y_max, *(node.y for node in nodes)]
    return Bounds(min(xs) - margin, min(ys) - margin, max(xs) + margin, max(ys) + margin)
