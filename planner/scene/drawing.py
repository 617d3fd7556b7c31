"""Drawings of scenes, roadmaps and paths: SVG in a notebook, or on Matplotlib axes.

Only ``plot`` needs Matplotlib; install the extra ``examples``, or Matplotlib itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from planner.scene.primitives import FloatArray
from planner.scene.records import (
    CircleRecord,
    Edge,
    PointRecord,
    PolygonRecord,
    Record,
    SceneObject,
    Segment,
    record_edges,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

OBSTACLE, ROAD, PATH, WALL = "#8d99a6", "#2a7fba", "#d1495b", "#3d4650"
"""Colours that stay distinct in grey and for colour-blind eyes."""
ARC_STEP_RAD = math.radians(3.0)
"""Between two points of a drawn arc: a chord leaves it by 0.04 % of the radius."""
WIDTH_PX, MARGIN = 480, 0.03
POINT_SIZE = 0.006
"""Radius of a drawn point, as a part of the view's larger side."""

View = tuple[float, float, float, float]


class StyledLines(NamedTuple):
    """Lines of one style: (k, 2) arrays; closed ones are filled, holes by the even-odd rule."""

    lines: Sequence[FloatArray]
    colour: str
    width: float = 1.5
    filled: bool = False


def obstacle_layers(objects: Iterable[SceneObject], view: View, y_down: bool) -> list[StyledLines]:
    """One layer for the solid of each object, and one for open chains and segments."""
    size = POINT_SIZE * max(view[2] - view[0], view[3] - view[1])
    solids, open_lines = [], []
    for one in objects:
        records = (*one.records, *(record for hole in one.holes for record in hole))
        closed = [_line_of(r, y_down, size) for r in records if _is_closed(r)]
        open_lines += [_line_of(r, y_down, size) for r in records if not _is_closed(r)]
        if closed:
            solids.append(StyledLines(closed, OBSTACLE, 0.8, filled=True))
    return [*solids, StyledLines(open_lines, OBSTACLE, 2.0)]


def wall_layer(view: View) -> StyledLines:
    """Layer of the bounds."""
    x0, y0, x1, y1 = view
    ring = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)])
    return StyledLines([ring], WALL, 1.0)


def to_svg(title: str, layers: Iterable[StyledLines], view: View, y_down: bool) -> str:
    """SVG picture of the layers; y grows upwards unless ``y_down``."""
    x0, y0, x1, y1 = view
    scale = WIDTH_PX * (1.0 - 2.0 * MARGIN) / max(x1 - x0, y1 - y0)
    left = MARGIN * WIDTH_PX
    width, height = scale * (x1 - x0) + 2.0 * left, scale * (y1 - y0) + 2.0 * left

    def data(line: FloatArray, end: str) -> str:
        x = left + scale * (line[:, 0] - x0)
        y = left + scale * (line[:, 1] - y0 if y_down else y1 - line[:, 1])
        places = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
        return f"M{places}{end}"

    shapes = []
    for layer in layers:
        if layer.lines:
            path = "".join(data(line, "Z" if layer.filled else "") for line in layer.lines)
            fill = "none"
            if layer.filled:
                fill = f'{layer.colour}" fill-opacity="0.6" fill-rule="evenodd'
            shapes.append(
                f'<path d="{path}" fill="{fill}" stroke="{layer.colour}"'
                f' stroke-width="{layer.width:g}" stroke-linejoin="round"/>'
            )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}"'
        f' viewBox="0 0 {width:.0f} {height:.0f}"><title>{title}</title>'
        f'<rect width="100%" height="100%" fill="#ffffff"/>{"".join(shapes)}</svg>'
    )


def plot(layers: Iterable[StyledLines], y_down: bool, axes: Axes | None = None) -> Axes:
    """Draw the layers on Matplotlib axes, new ones by default; return the axes.

    Raises ImportError if Matplotlib is not installed.
    """
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    if axes is None:
        from matplotlib import pyplot

        axes = pyplot.gca()
    for layer in layers:
        if layer.filled:
            rings = [Outline(line, closed=True) for line in layer.lines]
            outline = Outline.make_compound_path(*rings)
            patch = PathPatch(outline, facecolor=layer.colour, edgecolor=layer.colour, alpha=0.6)
            axes.add_patch(patch)
            continue
        for line in layer.lines:
            axes.plot(line[:, 0], line[:, 1], color=layer.colour, linewidth=layer.width)
    axes.set_aspect("equal")
    axes.autoscale_view()
    if y_down and not axes.yaxis_inverted():
        axes.invert_yaxis()
    return axes


def _is_closed(record: Record) -> bool:
    return isinstance(record, (PointRecord, CircleRecord, PolygonRecord))


def _line_of(record: Record, y_down: bool, point_size: float) -> FloatArray:
    match record:
        case PointRecord(at):
            return _circle(at, point_size)
        case CircleRecord(center, radius):
            return _circle(center, max(radius, point_size))
        case _:
            edges = record_edges(record)
            places = [edges[0].start, *(p for edge in edges for p in _after_start(edge, y_down))]
            return np.array(places, dtype=np.float64)


def _circle(center: tuple[float, float], radius: float) -> FloatArray:
    angle = np.arange(0.0, 2.0 * math.pi + ARC_STEP_RAD / 2.0, ARC_STEP_RAD)
    return np.column_stack((center[0] + radius * np.cos(angle), center[1] + radius * np.sin(angle)))


def _after_start(edge: Edge, y_down: bool) -> list[Any]:
    """Places along an edge after its start, ending with its end."""
    if isinstance(edge, Segment):
        return [edge.end]
    begin, sweep = edge.sweep(y_down)
    steps = math.ceil(abs(sweep) / ARC_STEP_RAD)
    angle = begin + sweep * np.arange(1, steps) / steps
    x = edge.center[0] + edge.radius * np.cos(angle)
    y = edge.center[1] + edge.radius * np.sin(angle)
    return [*zip(x.tolist(), y.tolist(), strict=True), edge.end]
