"""The folders of the packages and who imports whom, as SVG.

A frame a package; in it a box for each of its folders, dashed for a module beside them, on floors:
everything a box imports is below it. An arrow that follows from two others is left out. Colours
follow the reader's light or dark theme.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import networkx as nx

from benchmarks.house.imports import child, folder_graph, module_graph
from benchmarks.house.layers import Layout, laid_out

ROWS = (("navigation", "vision"), ("planner", "firmware_protocol"))
"""The frames, from the top."""
LETTER_PX = 7.6
"""A letter of 13 px in the widest of the usual fonts, so that no text is cut."""
BOX_PX = 28.0
FLOOR_PX = 62.0
MARGIN_PX = 20.0
TITLE_PX = 58.0

STYLE = """
  text { font: 13px ui-sans-serif, system-ui, "Helvetica Neue", Arial, sans-serif; fill: #1f2328 }
  .title { font-weight: 600; font-size: 15px }
  .note { fill: #59636e; font-size: 12px }
  .frame { fill: none; stroke: #8c959f }
  .box { fill: #ddf4ff; stroke: #0969da }
  .module { stroke-dasharray: 4 3 }
  .arrow { fill: none; stroke: #59636e; stroke-width: 1.3 }
  .head { fill: #59636e }
  @media (prefers-color-scheme: dark) {
    text { fill: #e6edf3 }
    .note { fill: #9198a1 }
    .frame { stroke: #656c76 }
    .box { fill: #0c2d6b; stroke: #4493f8 }
    .arrow { stroke: #9198a1 }
    .head { fill: #9198a1 }
  }
"""


@dataclass(frozen=True, slots=True)
class Frame:
    """A package to be drawn: its boxes' labels, their places, and what it needs of others."""

    name: str
    labels: dict[str, str]
    layout: Layout
    needs: str

    @property
    def width_px(self) -> float:
        words = LETTER_PX * max(len(self.name) + 2, len(self.needs))
        return max(self.layout.width_px, words) + 2.0 * MARGIN_PX

    @property
    def height_px(self) -> float:
        floors = len(self.layout.floors)
        return TITLE_PX + FLOOR_PX * (floors - 1) + BOX_PX + MARGIN_PX


def drawn(packages: Sequence[str]) -> str:
    """The picture of these packages, all in ``ROWS``."""
    modules = module_graph(packages)
    y, parts, width = MARGIN_PX, [], 0.0
    for row in ([name for name in row if name in packages] for row in ROWS):
        x, height = MARGIN_PX, 0.0
        for name in row:
            frame = framed(name, modules)
            parts += frame_drawn(frame, x, y)
            x += frame.width_px + MARGIN_PX
            height = max(height, frame.height_px)
        width = max(width, x)
        y += height + MARGIN_PX if row else 0.0
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{y:.0f}" '
        f'viewBox="0 0 {width:.0f} {y:.0f}">'
    )
    marker = (
        '<defs><marker id="head" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" '
        'markerHeight="7" orient="auto"><path class="head" d="M0 0L8 4L0 8z"/></marker></defs>'
    )
    return "\n".join([head, f"<style>{STYLE}</style>", marker, *parts, "</svg>", ""])


def framed(name: str, modules: nx.DiGraph) -> Frame:
    graph = folder_graph(modules, name)
    folders = {module.rpartition(".")[0] for module in modules}
    labels = {part: part.rpartition(".")[2] + ("" if part in folders else ".py") for part in graph}
    widths = {part: LETTER_PX * len(label) + 16.0 for part, label in labels.items()}
    return Frame(name, labels, laid_out(graph, widths), needs_of(name, modules))


def needs_of(name: str, modules: nx.DiGraph) -> str:
    """Which other packages a package imports, or the only part of one that it does."""
    parts: dict[str, set[str]] = {}
    for a, b in modules.edges:
        other = b.partition(".")[0]
        if a.partition(".")[0] == name and other != name:
            parts.setdefault(other, set()).add(child(b, other) or other)
    named = [next(iter(some)) if len(some) == 1 else other for other, some in sorted(parts.items())]
    return "imports " + ", ".join(named) if named else "imports none of the others"


def frame_drawn(frame: Frame, left: float, top: float) -> list[str]:
    layout = frame.layout
    shift = left + (frame.width_px - layout.width_px) / 2.0
    row = {place: i for i, floor in enumerate(layout.floors) for place in floor}
    width, height = frame.width_px, frame.height_px
    lines = [
        f'<rect class="frame" x="{left:.0f}" y="{top:.0f}" width="{width:.0f}" '
        f'height="{height:.0f}" rx="8"/>',
        f'<text class="title" x="{left + MARGIN_PX:.0f}" y="{top + 24.0:.0f}">{frame.name}</text>',
        f'<text class="note" x="{left + MARGIN_PX:.0f}" y="{top + 42.0:.0f}">{frame.needs}</text>',
    ]
    y = {place: top + TITLE_PX + FLOOR_PX * i for place, i in row.items()}
    for arrow in layout.arrows:
        points = [(shift + layout.x_px[place], y[place]) for place in arrow]
        lines.append(curve(points))
    for part, label in frame.labels.items():
        wide = LETTER_PX * len(label) + 16.0
        x = shift + layout.x_px[part]
        kind = "box module" if label.endswith(".py") else "box"
        lines += [
            f'<rect class="{kind}" x="{x - wide / 2.0:.1f}" y="{y[part]:.1f}" width="{wide:.1f}" '
            f'height="{BOX_PX:.0f}" rx="5"/>',
            f'<text x="{x:.1f}" y="{y[part] + 18.5:.1f}" text-anchor="middle">{label}</text>',
        ]
    return lines


def curve(points: list[tuple[float, float]]) -> str:
    """From the foot of one box through the bends, each straight down, to the head of another."""
    path = f"M{points[0][0]:.1f} {points[0][1] + BOX_PX:.1f}"
    for (x, above), (below_x, y) in pairwise(points):
        middle = (above + BOX_PX + y) / 2.0
        path += f"C{x:.1f} {middle:.1f} {below_x:.1f} {middle:.1f} {below_x:.1f} {y:.1f}"
        if (below_x, y) != points[-1]:
            path += f"V{y + BOX_PX:.1f}"
    return f'<path class="arrow" d="{path}" marker-end="url(#head)"/>'
