"""What the paper's recipe gets wrong, measured beside what the default mode does instead.

Everything is rendered from known records with seeds: dark shapes, contrast 175 grey levels, a
blur of 0.7 px, noise as given (sigma, in grey levels). Lengths in pixels.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

import vision
from benchmarks.paper.inputs import SEED
from navigation.draw.outlines import chain_points
from planner.scene import CircleRecord, PolygonRecord, Scene
from tests.support.drawn.render import draw, outline_points, polygon, rounded
from vision.binarise.binarise import binarise
from vision.borders.contours import follow_borders
from vision.paper.circles import SLACK_PX
from vision.paper.corners import SUPPORT

Points = NDArray[np.float64]
Mode = Literal["paper", "exact"]
MODES: tuple[Mode, Mode] = ("paper", "exact")
TILE = 120
NEAR_PX = 5.0
"""A found corner this near to a true one is that corner."""


@dataclass(frozen=True, slots=True)
class Corners:
    """Of ``true`` corners: how many were ``missed``, how many found are ``false``, and the
    rms distance of the right ones."""

    true: int
    missed: int
    false: int
    rms_px: float


@dataclass(frozen=True, slots=True)
class Taken:
    """How many of ``shown`` shapes were taken for circles, and the worst radius error."""

    shown: int
    circles: int
    radius_error_px: float


def line_floor() -> float:
    """The largest lambda_S that a perfect digital line has with k = 7, over all slopes.

    Lines y = round(a x + b), in steps of 0.001 in a and 0.05 in b.
    """
    x = np.arange(2 * SUPPORT + 1, dtype=np.float64)
    worst = 0.0
    for a in np.arange(0.0, 1.0001, 0.001):
        y = np.floor(a * x[None, :] + np.arange(0.0, 1.0, 0.05)[:, None] + 0.5)
        c11, c22 = x.var(), y.var(axis=1)
        c12 = (x * y).mean(axis=1) - x.mean() * y.mean(axis=1)
        small = 0.5 * (c11 + c22 - np.sqrt((c11 - c22) ** 2 + 4.0 * c12**2))
        worst = max(worst, float(small.max()))
    return worst


def corner_value(angle_deg: float) -> float:
    """lambda_S at a perfect corner of that angle: two arms of k unit steps."""
    half = math.radians(angle_deg) / 2.0
    steps = np.arange(-SUPPORT, SUPPORT + 1.0)
    x, y = np.abs(steps) * math.cos(half), steps * math.sin(half)
    c = np.cov(np.stack([x, y]), bias=True)
    return float(np.linalg.eigvalsh(c)[0])


def corners(noise: float, mode: Mode, shapes: int = 48) -> Corners:
    """Corners of turned polygons with sides of 20 px and more and angles up to 150 degrees."""
    records, rng = [], np.random.default_rng([SEED, 1])
    for i in range(shapes):
        records.append(_turned_polygon(i, rng))
    image, truths = _sheet(records, noise, [SEED, 2, round(noise)])
    scene = vision.extract(image, mode=mode)
    found = np.array(_vertices(scene)).reshape(-1, 2)
    true = np.concatenate(truths)
    gaps = np.linalg.norm(true[:, None] - found[None], axis=2)
    nearest = gaps.min(axis=1, initial=np.inf)
    hit = nearest <= NEAR_PX
    return Corners(
        len(true),
        int(np.count_nonzero(~hit)),
        len(found) - int(np.count_nonzero(hit)),
        float(np.sqrt(np.mean(nearest[hit] ** 2))),
    )


def circles(radius: float, noise: float, mode: Mode, count: int = 36) -> Taken:
    """Discs of one radius at random places: how many are found to be circles."""
    return _taken(lambda rng: CircleRecord(_place(rng), radius), radius, noise, mode, count)


def octagons(radius: float, noise: float, mode: Mode, count: int = 36) -> Taken:
    """Regular octagons of one circumradius, turned at random: how many pass for circles."""
    return _taken(lambda rng: _regular(8, radius, rng), radius, noise, mode, count)


def literal_discs(radius: float, count: int = 36) -> Taken:
    """Discs without noise that pass equation 14 as it is written: bounds in y for every pixel,
    with the paper mode's slack."""
    rng = np.random.default_rng([SEED, 8])
    passed = 0
    for _ in range(count):
        image = draw([CircleRecord(_place(rng), radius)], (TILE, TILE))
        contours, _ = follow_borders(binarise(image, method="otsu").mask).contours()
        dx, dy = np.abs(contours - contours.mean(axis=0)).T
        r = float(np.hypot(dx, dy).mean())
        on_circle = np.sqrt(np.maximum(r * r - dx * dx, 0.0))
        passed += bool((np.abs(on_circle - dy) <= 0.5 + SLACK_PX).all())
    return Taken(count, passed, math.nan)


def eigenvalue_ratio(record: PolygonRecord | CircleRecord) -> float:
    """lambda_S / lambda_L of the whole contour, which the paper tried as a sign of circles."""
    points = np.rint(outline_points(record, 0.01))
    image = np.zeros((TILE, TILE), np.uint8)
    cv2.fillPoly(image, [points.astype(np.int32).reshape(-1, 1, 2)], 1)
    contour = cv2.findContours(image, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0][0]
    small, large = np.linalg.eigvalsh(np.cov(contour.reshape(-1, 2).T.astype(np.float64)))
    return float(small / large)


def ratio_shapes() -> dict[str, PolygonRecord | CircleRecord]:
    """A circle, and shapes that are none."""
    rng = np.random.default_rng([SEED, 3])
    return {
        "circle": CircleRecord((60.0, 60.0), 40.0),
        "square": _regular(4, 45.0, rng),
        "triangle": _regular(3, 50.0, rng),
        "hexagon": _regular(6, 42.0, rng),
    }


def protrusion(radius: float, mode: Mode, noise: float = 0.0) -> float:
    """How far stadiums' true outlines stick out of the records that should hold them."""
    rng = np.random.default_rng([SEED, 4])
    records: list[PolygonRecord | CircleRecord] = []
    for _ in range(12):
        a = rng.uniform(0.0, math.tau)
        along = 8.0 * np.array([math.cos(a), math.sin(a)])
        middle = np.array(_place(rng))
        records.append(rounded(np.array([middle - along, middle + along]), radius))
    image, truths = _sheet(records, noise, [SEED, 5])
    scene = vision.extract(image, mode=mode)
    rings = [_ring(r) for o in scene.objects for r in o.records]
    return max(_outside(points, rings) for points in truths)


def _outside(points: Points, rings: Sequence[Points]) -> float:
    """How far the points lie outside the ring that is theirs; 0 where all are inside."""
    middle = points.mean(axis=0)
    own = min(rings, key=lambda ring: float(np.linalg.norm(ring.mean(axis=0) - middle)))
    contour = own.astype(np.float32).reshape(-1, 1, 2)
    signed = (cv2.pointPolygonTest(contour, (float(x), float(y)), True) for x, y in points)
    return -min(0.0, *signed)


def _ring(record: object) -> Points:
    assert isinstance(record, PolygonRecord | CircleRecord)
    return chain_points(record, y_down=True)


def _taken(
    make: Callable[[np.random.Generator], PolygonRecord | CircleRecord],
    radius: float,
    noise: float,
    mode: Mode,
    count: int,
) -> Taken:
    rng = np.random.default_rng([SEED, 6, round(10 * radius)])
    image, _ = _sheet([make(rng) for _ in range(count)], noise, [SEED, 7, round(noise)])
    found = [
        r for o in vision.extract(image, mode=mode).objects for r in o.records
        if isinstance(r, CircleRecord)
    ]  # fmt: skip
    error = max((abs(r.radius - radius) for r in found), default=math.nan)
    return Taken(count, len(found), error)


def _sheet(
    records: Sequence[PolygonRecord | CircleRecord], noise: float, seed: Sequence[int]
) -> tuple[NDArray[np.uint8], list[Points]]:
    """The records side by side in one picture, and their true outlines there.

    Records lie around the middle of a tile; a polygon's outline is its corners.
    """
    columns = math.ceil(math.sqrt(len(records)))
    rows = math.ceil(len(records) / columns)
    image = np.full((rows * TILE, columns * TILE), 215, np.uint8)
    truths, rng = [], np.random.default_rng(list(seed))
    for i, record in enumerate(records):
        x, y = (i % columns) * TILE, (i // columns) * TILE
        image[y : y + TILE, x : x + TILE] = draw([record], (TILE, TILE), noise=noise, rng=rng)
        truths.append(outline_points(record, 0.01) + np.array([x, y]))
    return image, truths


def _vertices(scene: Scene) -> Iterable[tuple[float, float]]:
    return [
        edge.start
        for o in scene.objects
        for r in o.records
        if isinstance(r, PolygonRecord)
        for edge in r.edges
    ]


def _place(rng: np.random.Generator) -> tuple[float, float]:
    x, y = 0.5 * TILE + rng.uniform(-1.0, 1.0, 2)
    return float(x), float(y)


def _regular(sides: int, radius: float, rng: np.random.Generator) -> PolygonRecord:
    x, y = _place(rng)
    turn = rng.uniform(0.0, math.tau)
    angles = [turn + math.tau * i / sides for i in range(sides)]
    return polygon([(x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles])


def _turned_polygon(number: int, rng: np.random.Generator) -> PolygonRecord:
    """Triangles to heptagons (129 degrees) and an L, by turns."""
    if number % 6 == 5:
        x, y = _place(rng)
        a = rng.uniform(0.0, math.tau)
        c, s = math.cos(a), math.sin(a)
        shape = [(-30, -30), (30, -30), (30, -5), (-5, -5), (-5, 30), (-30, 30)]
        return polygon([(x + c * u - s * v, y + s * u + c * v) for u, v in shape])
    return _regular(3 + number % 6, float(rng.uniform(30.0, 45.0)), rng)
