"""A transform that puts a graph of another frame onto its map, and the frames that have names.

A place p of the graph goes to scale * turn * (p, mirrored at the x axis if ``mirrored``) + shift.
People note a map's places in the named frames.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from planner.graph_files.route_graph import RouteEdge, RouteGraph, RouteNode
from planner.scene import FloatArray, Scene, Vec

NEAR_FIT = 0.02
"""Fits that differ by this share of the graph are equally good (chosen)."""
UNIT_SCALES = (1.0, 0.01, 0.001, 100.0, 1000.0)
"""Scales of metres, centimetres and millimetres, and of a graph in metres on a map in those."""


@dataclass(frozen=True, slots=True)
class FrameFit:
    """A transform that puts most of a graph into free space, and how sure it is.

    ``before`` and ``after`` are the shares of the graph's length that keep the radius, and
    ``runner_up`` is that of the best transform to other places. ``named`` is the frame's name, or
    "".
    """

    scale: float
    turn_rad: float
    mirrored: bool
    shift: Vec
    before: float
    after: float
    runner_up: float
    named: str = ""

    @property
    def sure(self) -> bool:
        """True if no transform to other places fits nearly as well."""
        return self.after - self.runner_up > NEAR_FIT

    def placed(self, points: FloatArray) -> FloatArray:
        """Return places (n, 2) of the graph's frame in that of the map."""
        return placed(points, self)

    def apply(
        self, graph: RouteGraph, chosen: Callable[[RouteNode], bool] = lambda node: True
    ) -> RouteGraph:
        """Return the graph with the chosen nodes in the map's frame, and their edges' lines."""
        nodes = [self._moved(node) if chosen(node) else node for node in graph.nodes]
        ids = {node.id for node in graph.nodes if chosen(node)}
        edges = [
            self._along(edge) if {edge.start, edge.end} <= ids else edge for edge in graph.edges
        ]
        return replace(graph, nodes=tuple(nodes), edges=tuple(edges))

    def _moved(self, node: RouteNode) -> RouteNode:
        ((x, y),) = self.placed(np.array([node.at])).tolist()
        return replace(node, x=x, y=y)

    def _along(self, edge: RouteEdge) -> RouteEdge:
        line = self.placed(np.array(edge.line).reshape(-1, 2)).tolist()
        length = None if edge.length is None else edge.length * self.scale
        return replace(edge, line=tuple((x, y) for x, y in line), length=length)

    def __str__(self) -> str:
        parts = ["mirror y"] if self.mirrored else []
        if abs(self.scale - 1.0) > 1e-9:
            parts.append(f"scale by {self.scale:.6g}")
        if abs(self.turn_rad) > 1e-9:
            parts.append(f"turn by {math.degrees(self.turn_rad):.4g} degrees")
        if math.hypot(*self.shift) > 1e-9:
            parts.append(f"shift by ({self.shift[0]:.4g}, {self.shift[1]:.4g})")
        words = ", ".join(parts) or "leave it"
        return f"{words} ({self.named})" if self.named else words


def placed(points: FloatArray, fit: FrameFit) -> FloatArray:
    """Return places (n, 2) of the graph's frame in that of the map."""
    cos, sin = fit.scale * math.cos(fit.turn_rad), fit.scale * math.sin(fit.turn_rad)
    x, y = points[:, 0], points[:, 1] * (-1.0 if fit.mirrored else 1.0)
    return np.stack([cos * x - sin * y + fit.shift[0], sin * x + cos * y + fit.shift[1]], axis=1)


def map_cell(scene: Scene) -> float | None:
    """Side of a ROS map's cells, None if the scene is none."""
    return scene.unknown.resolution if scene.unknown is not None else None


def named_frames(still: FrameFit, scene: Scene) -> Iterator[FrameFit]:
    """Yield the frames in which people note a map's places."""
    b = scene.bounds
    corner, top = (b.x_min, b.y_min), (b.x_min, b.y_max)
    middle = (0.5 * (b.x_min + b.x_max), 0.5 * (b.y_min + b.y_max))
    cell = map_cell(scene)
    units = {"": 1.0, "centimetres": 0.01, "millimetres": 0.001}
    if cell is not None:
        units["pixels"] = cell
    for unit, scale in units.items():
        one = replace(still, scale=scale)
        of = f"{unit or 'metres'} from the map's"
        if unit:
            yield replace(one, named=unit)
        yield replace(one, shift=corner, named=f"{of} lower left corner")
        yield replace(one, mirrored=True, shift=top, named=f"{of} upper left corner, y down")
        yield replace(one, shift=middle, named=f"{of} centre")
        yield replace(one, mirrored=True, shift=middle, named=f"{of} centre, y down")
    yield replace(still, mirrored=True, named="y down")
    yield replace(still, mirrored=True, turn_rad=0.5 * math.pi, named="x and y swapped")
    for turn in (0.5 * math.pi, math.pi, -0.5 * math.pi):
        yield replace(still, turn_rad=turn, named="a quarter turn" if turn < 3.0 else "a half turn")
