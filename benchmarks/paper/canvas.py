"""Panels of a figure: scenes side by side on one page, in the project's visual language.

Screen pixels: x right, y down. Lines that leave a panel are cut at its frame.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from navigation.draw.outlines import chain_points, ring_points
from navigation.draw.shapes import (
    FAINT_INK,
    FLOOR,
    FRAME,
    INK,
    OBSTACLE,
    OBSTACLE_EDGE,
    RAMP_STEPS,
    Area,
    Colour,
    DiscShape,
    Drawing,
    Label,
    Layer,
    Screen,
    Shape,
    Strokes,
    fit_screen,
    ramp_colour,
)
from navigation.draw.svg import to_svg
from planner.delaunay.voronoi_diagram import DiagramArrays
from planner.scene import Bounds, PointRecord, PolygonRecord, Scene

Points = NDArray[np.float64]

FULL, REDUCED, DEFAULT = (184, 92, 0), (44, 108, 184), (10, 122, 62)
"""The full pixel approach, the reduced one, and the default mode: in every chart the same."""
INVALID: Colour = (196, 150, 150)
SITE: Colour = (202, 40, 36)
MARGIN, TITLE, GAP = 20.0, 26.0, 18.0


@dataclass(slots=True)
class Page:
    """A figure in the making: shapes and embedded pictures."""

    width: float
    height: float
    title: str
    shapes: list[Shape] = field(default_factory=list)
    pictures: list[str] = field(default_factory=list)

    def svg(self) -> str:
        """The figure as SVG text."""
        w, h = round(self.width), round(self.height)
        view = (0.0, 0.0, float(w), float(h))
        text = to_svg(Drawing(w, h, view, (Layer("figure", tuple(self.shapes)),), self.title))
        return text.replace('<g id="figure"', "\n".join((*self.pictures, '<g id="figure"')), 1)

    def add_picture(
        self, image: NDArray[np.uint8], frame: tuple[float, float, float, float]
    ) -> None:
        """A grey picture in 16 levels behind the shapes; ``frame``: left, top, width, height."""
        levels = (image >> 4) * np.uint8(17)
        _, data = cv2.imencode(".png", levels, [cv2.IMWRITE_PNG_COMPRESSION, 9])
        text = base64.b64encode(data.tobytes()).decode("ascii")
        x, y, w, h = frame
        self.pictures.append(
            f'<image x="{x:g}" y="{y:g}" width="{w:g}" height="{h:g}"'
            f' href="data:image/png;base64,{text}"/>'
        )


@dataclass(frozen=True, slots=True)
class Panel:
    """One frame on a page, with a caption above it."""

    page: Page
    screen: Screen

    def draw(self, *shapes: Shape) -> None:
        """Add shapes that are in screen pixels already."""
        self.page.shapes.extend(shapes)

    def floor(self) -> None:
        """The light floor."""
        self.draw(Area((self.screen.frame,), FLOOR))

    def frame(self) -> None:
        """The frame, on top of what reaches it."""
        self.draw(Strokes((np.vstack([self.screen.frame, self.screen.frame[:1]]),), FRAME, 1.2))

    def scene(self, scene: Scene, opacity: float = 1.0) -> None:
        """The scene's objects, dark; ``opacity`` lets lines inside them show."""
        for obj in scene.objects:
            filled = replace(obj, holes=())
            rings = [self.screen.points(r) for r in ring_points(filled, scene.y_down)]
            if rings:
                self.draw(Area(tuple(rings), OBSTACLE, opacity, OBSTACLE_EDGE))

    def outlines(self, scene: Scene, colour: Colour, width: float = 1.2) -> None:
        """The records' edges as lines."""
        lines = []
        for obj in scene.objects:
            for record in obj.records:
                if isinstance(record, PointRecord):
                    continue
                ring = chain_points(record, scene.y_down)
                closed = isinstance(record, PolygonRecord)
                lines.append(self.screen.points(np.vstack([ring, ring[:1]]) if closed else ring))
        self.draw(Strokes(tuple(lines), colour, width))

    def lines(self, segments: Points, colour: Colour, width: float, **style: object) -> None:
        """Segments (n, 4) of the scene, cut at the frame."""
        inside = clip(segments, self.screen.bounds)
        if len(inside):
            xy = self.screen.points(inside.reshape(-1, 2)).reshape(-1, 2, 2)
            self.draw(Strokes(tuple(xy), colour, width, **style))  # type: ignore[arg-type]

    def by_clearance(self, segments: Points, clearance: Points, width: float = 1.8) -> None:
        """Segments (n, 4) coloured by the clearance (n,) of each: warm is tight."""
        if not len(segments):
            return
        span = max(float(clearance.max() - clearance.min()), 1e-9)
        step = np.rint((clearance - clearance.min()) / span * (RAMP_STEPS - 1)).astype(int)
        for s in sorted(set(step.tolist()), reverse=True):
            self.lines(segments[step == s], ramp_colour(s), width)

    def dots(
        self, points: Points, radius: float, fill: Colour, stroke: Colour | None = None
    ) -> None:
        """A disc on every point (n, 2)."""
        for x, y in self.screen.points(points).tolist():
            self.draw(DiscShape(x, y, radius, fill=fill, stroke=stroke))

    def label(self, at: Points, text: str, dx: float = 6.0, dy: float = -5.0) -> None:
        """A word beside a place of the scene."""
        ((x, y),) = self.screen.points(at.reshape(1, 2)).tolist()
        self.draw(Label(x + dx, y + dy, text, 12.0, INK, halo=True))


def panels(
    window: Bounds, captions: Iterable[str], columns: int, width: float, title: str
) -> tuple[Page, list[Panel]]:
    """A page of equal panels that all show ``window``, ``width`` pixels wide each."""
    names = list(captions)
    height = width * window.height / window.width
    rows = -(-len(names) // columns)
    page = Page(
        2 * MARGIN + columns * width + (columns - 1) * GAP,
        MARGIN + rows * (height + TITLE + GAP),
        title,
    )
    made = []
    for i, name in enumerate(names):
        left = MARGIN + (i % columns) * (width + GAP)
        top = MARGIN + (i // columns) * (height + TITLE + GAP) + TITLE - 8.0
        screen = fit_screen(window, True, width, height, left, top)
        page.shapes.append(Label(left, top - 8.0, name, 13.0, INK, bold=True))
        made.append(Panel(page, screen))
    return page, made


def note(page: Page, text: str) -> None:
    """A line of small print at the page's foot."""
    page.height += 14.0
    page.shapes.append(Label(MARGIN, page.height - 12.0, text, 11.5, FAINT_INK))


def diagram_segments(diagram: DiagramArrays, sites: Points, reach: float) -> tuple[Points, Points]:
    """Every edge as a segment (n, 4), and its row in ``diagram.edges`` (n,).

    Edges that go to infinity are as long as ``reach``; those without a length are left out.
    """
    rows, segments = [], []
    for row, (left, right, start, end) in enumerate(diagram.edges.tolist()):
        if diagram.zero_length[row]:
            continue
        along = sites[right] - sites[left]
        across = np.array([-along[1], along[0]]) / max(float(np.hypot(*along)), 1e-12)
        middle = 0.5 * (sites[left] + sites[right])
        a = diagram.vertices[start] if start >= 0 else None
        b = diagram.vertices[end] if end >= 0 else None
        # the left site lies to the left of the way from a to b, with y up
        if a is None:
            a = (middle if b is None else b) - reach * across
        if b is None:
            b = (middle if start < 0 else a) + reach * across
        rows.append(row)
        segments.append([*a, *b])
    return np.array(segments).reshape(-1, 4), np.array(rows, dtype=np.int64)


def clip(segments: Points, box: Bounds) -> Points:
    """The parts of segments (n, 4) inside a box (Liang and Barsky); those outside vanish."""
    start, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    enter, leave = np.zeros(len(segments)), np.ones(len(segments))
    for axis, low, high in ((0, box.x_min, box.x_max), (1, box.y_min, box.y_max)):
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.stack([low - start[:, axis], high - start[:, axis]]) / along[:, axis]
        flat = along[:, axis] == 0.0
        within = (start[:, axis] >= low) & (start[:, axis] <= high)
        t[0, flat], t[1, flat] = -np.inf, np.where(within[flat], np.inf, -np.inf)
        enter, leave = np.maximum(enter, t.min(axis=0)), np.minimum(leave, t.max(axis=0))
    kept = enter < leave
    s, d = start[kept], along[kept]
    return np.hstack([s + enter[kept, None] * d, s + leave[kept, None] * d])
