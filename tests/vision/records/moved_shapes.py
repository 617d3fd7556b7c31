"""Shapes around (0, 0), moves of them, and the pictures that show them: the truth."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from planner.scene import (
    Arc,
    CircleRecord,
    Edge,
    PolygonRecord,
    Segment,
)
from tests.support.drawn.render import coverage, cut_disc, outline_points, polygon, rounded

SEED = 41

REACH = 46.0
CELL = 104
LEAST_SIDE, LEAST_RADIUS, LEAST_STADIUM = 20.0, 10.0, 12.0

Outline = PolygonRecord | CircleRecord
Vec = tuple[float, float]


@dataclass(frozen=True)
class Thing:
    """An obstacle's outline, clockwise on the screen, and its holes, counter-clockwise."""

    outline: Outline
    holes: tuple[Outline, ...] = ()


@dataclass(frozen=True)
class Move:
    """x, y -> scale * (x, y) + shift, with x and y exchanged at last where ``transposed``."""

    scale: float = 1.0
    shift: Vec = (0.0, 0.0)
    transposed: bool = False

    def point(self, at: Vec) -> Vec:
        x, y = self.scale * at[0] + self.shift[0], self.scale * at[1] + self.shift[1]
        return (y, x) if self.transposed else (x, y)

    def edge(self, edge: Edge) -> Edge:
        """A mirrored edge is run through backwards, so that its arc turns as before."""
        start, end = self.point(edge.start), self.point(edge.end)
        if self.transposed:
            start, end = end, start
        if isinstance(edge, Segment):
            return Segment(start, end)
        return Arc(start, end, self.point(edge.center), edge.radius * self.scale, edge.ccw)

    def outline(self, outline: Outline) -> Outline:
        if isinstance(outline, CircleRecord):
            return CircleRecord(self.point(outline.center), outline.radius * self.scale)
        edges = [self.edge(e) for e in outline.edges]
        return PolygonRecord(tuple(reversed(edges) if self.transposed else edges))

    def things(self, things: Sequence[Thing]) -> list[Thing]:
        return [
            Thing(self.outline(t.outline), tuple(self.outline(h) for h in t.holes)) for t in things
        ]


def reversed_outline(outline: Outline) -> Outline:
    """The same outline as the border of a hole."""
    if isinstance(outline, CircleRecord):
        return outline
    edges: list[Edge] = []
    for e in reversed(outline.edges):
        if isinstance(e, Segment):
            edges.append(Segment(e.end, e.start))
        else:
            edges.append(Arc(e.end, e.start, e.center, e.radius, not e.ccw))
    return PolygonRecord(tuple(edges))


def picture_of(
    things: Sequence[Thing],
    size: tuple[int, int],
    *,
    blur: float = 0.7,
    noise: float = 0.0,
    seed: int = 0,
    light: float = 215.0,
) -> np.ndarray:
    """Dark things (40) on light ground, anti-aliased, (h, w) uint8."""
    share = np.zeros((size[1], size[0]))
    for thing in things:
        outlines = [outline_points(o) for o in (thing.outline, *thing.holes)]
        np.maximum(share, coverage(outlines, size), out=share)
    grey = light + (40.0 - light) * share
    if blur > 0.0:
        grey = cv2.GaussianBlur(grey, (0, 0), blur, borderType=cv2.BORDER_REPLICATE)
    grey = grey + noise * np.random.default_rng(seed).standard_normal(grey.shape)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


# --- shapes around (0, 0)


def angles_of(vertices: np.ndarray) -> np.ndarray:
    """The angle between the two sides at every vertex, (n,) in 0 .. 2 pi; inside, clockwise."""
    back = np.roll(vertices, 1, axis=0) - vertices
    on = np.roll(vertices, -1, axis=0) - vertices
    angle = np.arctan2(back[:, 1], back[:, 0]) - np.arctan2(on[:, 1], on[:, 0])
    return np.asarray(angle % math.tau)


def turned(vertices: np.ndarray, angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return vertices @ np.array([[c, s], [-s, c]])


def convex(rng: np.random.Generator) -> Thing:
    """3 to 8 vertices on a circle, unevenly."""
    while True:
        n = int(rng.integers(3, 9))
        t = (np.arange(n) + rng.uniform(-0.2, 0.2, n)) * math.tau / n + rng.uniform(0.0, math.tau)
        least = min(0.55 * LEAST_SIDE / math.sin(math.pi / n), REACH - 1.0)
        v = rng.uniform(least, REACH) * np.stack([np.cos(t), np.sin(t)], axis=1)
        sides = np.hypot(*(v - np.roll(v, 1, axis=0)).T)
        angles = np.degrees(angles_of(v))
        if sides.min() >= LEAST_SIDE and angles.min() >= 50.0 and angles.max() <= 145.0:
            return Thing(polygon(v))


def ell(rng: np.random.Generator) -> Thing:
    """An L, at any angle."""
    p, q, r, s = rng.uniform(LEAST_SIDE, 30.0, 4)
    v = np.array([(0, 0), (p + r, 0), (p + r, q), (p, q), (p, q + s), (0, q + s)])
    return Thing(polygon(turned(v - v.mean(axis=0), rng.uniform(0.0, math.tau))))


def disc(rng: np.random.Generator) -> Thing:
    return Thing(CircleRecord((0.0, 0.0), rng.uniform(LEAST_RADIUS, REACH)))


def half_disc(rng: np.random.Generator) -> Thing:
    radius, angle = rng.uniform(2.0 * LEAST_RADIUS, REACH), rng.uniform(0.0, math.tau)
    return Thing(cut_disc(np.zeros(2), radius, angle, rng.uniform(0.9, 1.7)))


def ring(rng: np.random.Generator) -> Thing:
    """A disc or a square, with a round or a square hole."""
    square = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    inside, middle = rng.uniform(LEAST_RADIUS, 16.0), rng.uniform(-3.0, 3.0, 2)
    hole: Outline = CircleRecord((float(middle[0]), float(middle[1])), inside)
    if rng.random() < 0.5:
        hole = polygon(turned(square * inside, rng.uniform(0.0, math.tau)) + middle)
    outline: Outline = CircleRecord((0.0, 0.0), rng.uniform(34.0, REACH))
    if rng.random() < 0.5:
        outline = polygon(turned(square * rng.uniform(28.0, 32.0), rng.uniform(0.0, math.tau)))
    return Thing(outline, (reversed_outline(hole),))


def stadium(rng: np.random.Generator) -> Thing:
    radius = rng.uniform(LEAST_STADIUM, 22.0)
    half = rng.uniform(LEAST_SIDE / 2.0, REACH - radius)
    ends = turned(np.array([(-half, 0.0), (half, 0.0)]), rng.uniform(0.0, math.tau))
    return Thing(rounded(ends, radius))


CORNERED = (convex, convex, ell, disc, half_disc, ring)
"""Shapes whose edges meet at corners, if they meet."""
ALL = (*CORNERED, stadium)


def arena(seed: int, shapes: Sequence[Callable[..., Thing]] = CORNERED) -> list[Thing]:
    """One to four things, each around its cell's middle; two cells a row, the first at (0, 0)."""
    rng = np.random.default_rng([SEED, seed])
    things = []
    for i in range(int(rng.integers(1, 5))):
        x, y = rng.uniform(-0.5, 0.5, 2) + (np.array([i % 2, i // 2]) + 0.5) * CELL
        thing = shapes[int(rng.integers(len(shapes)))](rng)
        things += Move(shift=(float(x), float(y))).things([thing])
    return things


def size_for(things: Sequence[Thing], scale: float = 1.0, more: int = 0) -> tuple[int, int]:
    columns, rows = min(len(things), 2), (len(things) + 1) // 2
    return math.ceil(scale * CELL * columns) + more, math.ceil(scale * CELL * rows) + more
