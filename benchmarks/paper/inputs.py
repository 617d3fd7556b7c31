"""What goes into the figures and tables: points, scenes and pictures, all from seeds.

Pixels, centres at integers, y down.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from planner.scene import (
    Arc,
    Bounds,
    CircleRecord,
    PolygonRecord,
    Scene,
    SceneObject,
    Segment,
)
from tests.support.drawn.render import coverage, cut_disc, draw, outline_points, polygon, rounded
from vision.binarise.binarise import binarise
from vision.borders.contours import laplacian_border

Points = NDArray[np.float64]
Shape = PolygonRecord | CircleRecord

SEED = 20020118
SQUARE = Bounds(0.0, 0.0, 400.0, 400.0)
"""Where the figures of points and of drawn objects live."""
PAPER_BORDER_PIXELS, PAPER_VERTICES, PAPER_GENERATORS = 1661, 60, 141
"""n, m and p of the paper's section 3.3."""
PICTURE_SIZE = (640, 480)
DARK, LIGHT = 40.0, 215.0


def fourteen_sites() -> Points:
    """14 points in ``SQUARE``, spread like the paper's: each the farthest of four candidates."""
    rng = np.random.default_rng(SEED)
    sites = [np.array([200.0, 190.0])]
    while len(sites) < 14:
        candidates = rng.uniform(35.0, 365.0, (4, 2))
        gaps = np.linalg.norm(candidates[:, None] - np.array(sites)[None], axis=2).min(axis=1)
        sites.append(candidates[int(np.argmax(gaps))])
    return np.array(sites)


def fifteenth_site() -> Points:
    """The point that is put among the fourteen."""
    return np.array([238.0, 222.0])


def drawn_objects() -> Scene:
    """Generalized polygons, a simple one and a circle in a square, for figures 3 and 4."""
    dent = PolygonRecord(
        (
            Segment((225.0, 50.0), (345.0, 60.0)),
            Segment((345.0, 60.0), (350.0, 130.0)),
            Arc((350.0, 130.0), (230.0, 130.0), (290.0, 180.0), math.hypot(60.0, 50.0), ccw=True),
            Segment((230.0, 130.0), (225.0, 50.0)),
        )
    )
    records: list[Shape] = [
        rounded(np.array([(95.0, 85.0), (140.0, 105.0)]), 32.0),
        dent,
        cut_disc(np.array([90.0, 270.0]), 48.0, 0.5, 1.0),
        polygon([(185.0, 185.0), (240.0, 215.0), (190.0, 275.0)]),
        CircleRecord((320.0, 235.0), 34.0),
        rounded(np.array([(215.0, 330.0), (320.0, 320.0), (300.0, 350.0)]), 14.0),
    ]
    return Scene("px", SQUARE, tuple(SceneObject(i, (r,)) for i, r in enumerate(records)))


def arena_records(scale: float) -> list[Shape]:
    """4 simple polygons, 2 generalized polygons and 1 circle, as on the paper's arena."""

    def about(points: list[tuple[float, float]], x: float, y: float) -> Points:
        return np.array([(x + scale * u, y + scale * v) for u, v in points])

    star = [math.tau * i / 5 + 0.3 for i in range(5)]
    return [
        polygon(about([(-55, -25), (35, -45), (50, 25), (-40, 45)], 115, 100).tolist()),
        polygon(about([(52 * math.cos(a), 52 * math.sin(a)) for a in star], 318, 92).tolist()),
        polygon(about([(-40, -40), (60, -10), (-20, 50)], 520, 105).tolist()),
        polygon(
            about(
                [(-50, -45), (30, -65), (30, -25), (-5, -17), (5, 45), (-35, 50)], 115, 365
            ).tolist()
        ),
        rounded(about([(-40, -12), (40, 12)], 335, 240), 32 * scale),
        cut_disc(np.array([525.0, 345.0]), 52 * scale, 0.6, 0.9),
        CircleRecord((318.0, 392.0), 38 * scale),
    ]


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture of known records, and its border pixels n."""

    records: tuple[Shape, ...]
    image: NDArray[np.uint8]
    border_pixels: int


def arena_picture(wanted: int = PAPER_BORDER_PIXELS, noise: float = 2.0) -> Picture:
    """The arena at the scale at which it has ``wanted`` border pixels, or nearly so."""

    def at(scale: float) -> Picture:
        records = arena_records(scale)
        image = draw(
            records,
            PICTURE_SIZE,
            dark=DARK,
            light=LIGHT,
            noise=noise,
            rng=np.random.default_rng(SEED),
        )
        return Picture(tuple(records), image, count_border_pixels(image))

    return _closest(at, wanted, 0.5, 1.15)


def crowd_picture(wanted: int) -> Picture:
    """A picture of as many of the arena's objects as have about ``wanted`` border pixels.

    The objects stand in cells of a grid; where they are few the scale is chosen for the count,
    and where they are many they are copies of ``TILES`` different ones. Their records are not
    kept.
    """
    count = math.ceil(wanted / 215.0)
    columns = math.ceil(math.sqrt(count))
    rows = math.ceil(count / columns)

    def at(scale: float) -> Picture:
        tiles = [_tile(i, scale) for i in range(min(count, TILES))]
        image = np.full((rows * TILE_PX, columns * TILE_PX), round(LIGHT), np.uint8)
        for i in range(count):
            y, x = (i // columns) * TILE_PX, (i % columns) * TILE_PX
            image[y : y + TILE_PX, x : x + TILE_PX] = tiles[i % TILES]
        return Picture((), image, count_border_pixels(image))

    if count > TILES:
        first = at(0.8)
        return at(0.8 * wanted / first.border_pixels)
    return _closest(at, wanted, 0.4, 1.05)


TILES = 28
TILE_PX = 128


def _tile(number: int, scale: float) -> NDArray[np.uint8]:
    """One of the arena's objects, turned and moved a little, in a cell of its own."""
    rng = np.random.default_rng([SEED, number])
    record = arena_records(scale)[number % 7]
    points = outline_points(record)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    angle = rng.uniform(0.0, math.tau)
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    placed = (points - middle) @ turn + 0.5 * TILE_PX + rng.uniform(-1.0, 1.0, 2)
    grey = LIGHT + (DARK - LIGHT) * coverage([placed], (TILE_PX, TILE_PX))
    blurred = cv2.GaussianBlur(grey, (0, 0), 0.7)
    return np.rint(blurred).astype(np.uint8)


def count_border_pixels(image: NDArray[np.uint8]) -> int:
    """n: the pixels where the paper's Laplacian of the binarised picture is positive."""
    return int(np.count_nonzero(laplacian_border(binarise(image, method="otsu").inside)))


def _closest(make: Callable[[float], Picture], wanted: int, low: float, high: float) -> Picture:
    """Of what ``make(scale)`` gives, the one whose border pixels come nearest to ``wanted``.

    Bisection first; then, since counts jump, a few scales around.
    """
    for _ in range(9):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if make(middle).border_pixels < wanted else (low, middle)
    best = make(middle)
    for scale in np.linspace(middle - 0.01, middle + 0.01, 61):
        if best.border_pixels == wanted:
            break
        other = make(float(scale))
        if abs(other.border_pixels - wanted) < abs(best.border_pixels - wanted):
            best = other
    return best
