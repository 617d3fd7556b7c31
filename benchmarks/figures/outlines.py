"""How edge points become edges, step by step on one small picture. Pixels, y down."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.paper import canvas
from benchmarks.paper.canvas import DEFAULT, FULL, REDUCED, SITE, Panel
from navigation.draw.shapes import FAINT_INK, Strokes
from planner.scene import Bounds
from tests.support.drawn.render import coverage, draw, polygon
from vision.binarise.binarise import binarise
from vision.borders.contours import Contours, EdgePoints, follow_borders, locate_edges
from vision.outline.fitted_borders import ARC_CCW, LINE, FittedBorders
from vision.outline.fitting import Tolerance, fit_edges, tolerance_of
from vision.outline.outline_types import BorderPoints
from vision.outline.seed_kernels import seed_breaks

Points = NDArray[np.float64]
SIZE = (60, 44)
DARK, LIGHT = 40.0, 215.0
SEED = 7
WIDE = Bounds(7.5, 4.5, 51.5, 40.5)
CORNER = Bounds(36.5, 4.5, 50.5, 16.5)
TIP = Bounds(38.5, 28.5, 52.5, 40.5)
TIP_AT = (47.3, 35.6)
BESIDE = np.array([(0.0, -0.5), (0.5, 0.0), (0.0, 0.5), (-0.5, 0.0)])
"""From an obstacle pixel's centre to the middle of its crack, by the walk's direction."""


@dataclass(frozen=True, slots=True)
class Fitted:
    """A picture and everything that is made of it on the way to its edges."""

    picture: NDArray[np.uint8]
    borders: Contours
    edges: EdgePoints
    tolerance: Tolerance
    fitted: FittedBorders

    @property
    def points(self) -> Points:
        """The edge points of the one border."""
        return self.edges.points[: self.edges.starts[1]]

    @property
    def cracks(self) -> Points:
        """The middles of the border's cracks."""
        x, y, direction = self.borders.cracks_of(0)
        return np.stack([x, y], axis=1) + BESIDE[direction]

    @property
    def joints(self) -> Points:
        """Where the finished edges meet."""
        return self.fitted.data[: self.fitted.edge_starts[1], :2]

    def outline(self) -> list[Points]:
        """The finished edges as polylines."""
        count = int(self.fitted.edge_starts[1])
        rows, kinds = self.fitted.data[:count], self.fitted.kind[:count]
        return [
            arc_points(rows[e], rows[(e + 1) % count, :2], kinds[e])
            if kinds[e] != LINE
            else np.array([rows[e, :2], rows[(e + 1) % count, :2]])
            for e in range(count)
        ]


def arc_points(row: Points, end: Points, kind: int) -> Points:
    """An arc as a polyline: ``row`` is its first point, centre and radius."""
    center, radius = row[2:4], row[4]
    begin = math.atan2(row[1] - center[1], row[0] - center[0])
    turn = (math.atan2(end[1] - center[1], end[0] - center[0]) - begin) % math.tau
    if kind == ARC_CCW:  # as seen on the screen, where y points down
        turn -= math.tau
    angle = begin + np.linspace(0.0, turn, 48)
    return np.asarray(center + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def shape() -> Points:
    """A house with one round shoulder, as a closed polygon of many points."""
    turn = np.linspace(0.0, 0.5 * math.pi, 40)
    shoulder = np.stack([38.0 + 9.0 * np.sin(turn), 17.0 - 9.0 * np.cos(turn)], axis=1)
    return np.vstack([[(12.0, 8.0)], shoulder, [TIP_AT, (30.0, 29.0), (12.6, 36.4)]])


def fitted(noise: float = 8.0, blur: float = 0.9, *, grey: bool = True) -> Fitted:
    """The shape drawn, binarised, followed, located and fitted."""
    if grey:
        rng = np.random.default_rng(SEED)
        records = [polygon(shape())]
        image = draw(records, SIZE, dark=DARK, light=LIGHT, blur=blur, noise=noise, rng=rng)
    else:
        inside = coverage([shape()], SIZE) >= 0.5
        image = np.where(inside, 0, 255).astype(np.uint8)
    binary = binarise(image)
    borders = follow_borders(binary.mask)
    edges = locate_edges(binary, borders)
    tolerance = tolerance_of(edges, binary.noise, binary.contrast)
    fit = fit_edges(edges.points, edges.starts, borders, tolerance, bilevel=tolerance.crisp)
    return Fitted(image, borders, edges, tolerance, fit)


def seeds_of(one: Fitted) -> Points:
    """Where the border may break: the seeds of the partition."""
    points = one.points - one.points.mean(axis=0)
    far = int(np.argmax((points**2).sum(axis=1)))
    points = np.roll(points, -far, axis=0)
    n = len(points)
    twice = np.vstack([points, points, points[:1]])
    is_seed = np.zeros(n + 1, np.bool_)
    tolerance = 0.35 + one.tolerance.dead_zone_px + 2.5 * one.tolerance.sigma_px
    border = BorderPoints(twice[:, 0].copy(), twice[:, 1].copy(), n)
    seed_breaks(border, tolerance, is_seed, np.empty(n), np.empty((n + 1, 2), np.int64))
    return np.asarray(points[is_seed[:n]] + one.points.mean(axis=0))


def show(panel: Panel, one: Fitted) -> None:
    """The picture's pixels behind a panel."""
    screen, (height, width) = panel.screen, one.picture.shape
    bounds = screen.bounds
    rows = slice(max(0, math.floor(bounds.y_min + 0.5)), min(height, math.ceil(bounds.y_max + 0.5)))
    cols = slice(max(0, math.floor(bounds.x_min + 0.5)), min(width, math.ceil(bounds.x_max + 0.5)))
    part = one.picture[rows, cols]
    corners = np.array([(cols.start - 0.5, rows.start - 0.5), (cols.stop - 0.5, rows.stop - 0.5)])
    (left, top), (right, bottom) = screen.points(corners).tolist()
    big = np.repeat(np.repeat(part, 8, axis=0), 8, axis=1)
    panel.page.add_picture(big, (left, top, right - left, bottom - top))


def draw_outline(panel: Panel, one: Fitted, colour: tuple[int, int, int], width: float) -> None:
    """The finished edges, and a dot at each joint."""
    for line in one.outline():
        links = np.hstack([line[:-1], line[1:]])
        panel.lines(links, colour, width)
    panel.dots(inside(panel, one.joints), 3.2, (255, 255, 255), colour)


def inside(panel: Panel, points: Points) -> Points:
    """Those of the points that lie in the panel."""
    bounds = panel.screen.bounds
    return points[[bounds.contains((float(x), float(y))) for x, y in points]]


def points_figure() -> str:
    """From the cracks between pixels to points in the light."""
    one = fitted()
    captions = ("Cracks: between obstacle and free pixels", "Edge points: where the light is half")
    page, (left, right) = canvas.panels(CORNER, captions, 2, 400.0, "From pixels to edge points")
    for panel in (left, right):
        show(panel, one)
        panel.frame()
    _, _, direction = one.borders.cracks_of(0)
    along = np.array([(0.5, 0.0), (0.0, 0.5), (-0.5, 0.0), (0.0, -0.5)])[direction]
    left.lines(np.hstack([one.cracks - along, one.cracks + along]), SITE, 2.4)
    right.lines(np.hstack([one.cracks - along, one.cracks + along]), FAINT_INK, 1.0)
    right.dots(inside(right, one.points), 3.0, SITE)
    canvas.note(page, f"a corner of radius 9 px, blur 0.9 px, noise 8 of {LIGHT - DARK:g} levels")
    return page.svg()


def partition_figure() -> str:
    """From points to the cheapest partition."""
    one = fitted()
    captions = ("Seeds: where it may break", "The edges: at the price of a line and an arc")
    page, (left, right) = canvas.panels(WIDE, captions, 2, 400.0, "From edge points to edges")
    for panel in (left, right):
        show(panel, one)
        panel.frame()
        panel.dots(one.points, 1.4, SITE)
    left.dots(seeds_of(one), 4.0, (255, 255, 255), FULL)
    draw_outline(right, one, DEFAULT, 2.0)
    return page.svg()


def corners_figure() -> str:
    """What blur does to a corner, and what the fit makes of it."""
    captions = ("Blur 0.7 px", "Blur 1.3 px: points cut the corner, edges do not")
    page, made = canvas.panels(TIP, captions, 2, 400.0, "Corners behind blur")
    for panel, blur in zip(made, (0.7, 1.3), strict=True):
        one = fitted(0.0, blur)
        show(panel, one)
        panel.frame()
        panel.dots(inside(panel, one.points), 3.0, SITE)
        draw_outline(panel, one, DEFAULT, 2.0)
        x, y = one.joints[np.argmin(np.hypot(*(one.joints - TIP_AT).T))]
        angle = np.linspace(0.0, math.tau, 64)
        guard = one.tolerance.guard_px
        ring = np.stack([x + guard * np.cos(angle), y + guard * np.sin(angle)], axis=1)
        panel.draw(Strokes((panel.screen.points(ring),), REDUCED, 1.4, dash=(4.0, 4.0)))
    canvas.note(page, "dashed: the guard; points inside take no part in the fits of the two sides")
    return page.svg()


def drawn_figure() -> str:
    """A picture without grey: every crack is a window that the outline has to pass."""
    one = fitted(grey=False)
    window = Bounds(10.5, 27.5, 24.5, 37.5)
    captions = ("Windows: from obstacle to free pixel", "Edges that pass every window once")
    page, (left, right) = canvas.panels(window, captions, 2, 400.0, "Pictures without grey")
    _, _, direction = one.borders.cracks_of(0)
    way = BESIDE[direction]
    windows = np.hstack([one.cracks - way, one.cracks + way])
    for panel in (left, right):
        show(panel, one)
        panel.lines(windows, SITE, 1.2)
        panel.frame()
    left.dots(inside(left, one.cracks), 2.4, SITE)
    draw_outline(right, one, DEFAULT, 2.0)
    return page.svg()
