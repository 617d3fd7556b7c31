"""Shapes with known edges, in grey pictures of several blurs and noises: what a fit is judged by.

Rules and units
- Pixels, centres at integers, y down; outlines run clockwise on the screen.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.vision.corners import shape
from planner.scene import Arc, PolygonRecord, Segment
from tests.support.drawn.render import cut_disc, draw, polygon, rounded

SIZE = 200, 200
SEED = 23
Points = NDArray[np.float64]
SIGNS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


class Family(NamedTuple):
    """A kind of shape: ``make`` draws one by chance, ``looks`` are blurs (px) and noises.

    ``has_edges``: whether its outline is made of lines and arcs, so that their number is known.
    """

    make: Callable[[np.random.Generator], PolygonRecord]
    looks: tuple[tuple[float, float], ...]
    has_edges: bool = True


def _placed(outline: Points, rng: np.random.Generator) -> Points:
    """An outline about its own origin, turned and moved to the picture's middle."""
    angle = rng.uniform(0.0, math.tau)
    c, s = math.cos(angle), math.sin(angle)
    middle = 99.5 + rng.uniform(-1.0, 1.0, 2)
    return np.asarray(np.asarray(outline, float) @ np.array([[c, s], [-s, c]]) + middle)


def _corners(rng: np.random.Generator) -> PolygonRecord:
    return polygon(shape(rng) + 39.5)


def _blunt(rng: np.random.Generator) -> PolygonRecord:
    """Twelve corners of 150 degrees between sides of 16 to 30 px."""
    t = np.arange(12) * math.tau / 12.0
    r = rng.uniform(8.0, 15.0) / math.sin(math.pi / 12.0)
    return polygon(_placed(r * np.stack([np.cos(t), np.sin(t)], axis=1), rng))


def _bevelled(rng: np.random.Generator) -> PolygonRecord:
    """A rectangle whose corners are cut off by sides of 5 to 18 px."""
    corners = SIGNS * rng.uniform(30.0, 60.0, 2)
    cut = float(rng.uniform(3.5, 13.0))
    outline = []
    for i in range(4):
        for other in (corners[i - 1], corners[(i + 1) % 4]):
            outline.append(corners[i] + cut * (other - corners[i]) / math.dist(other, corners[i]))
    return polygon(_placed(np.array(outline), rng))


def _rounded(rng: np.random.Generator) -> PolygonRecord:
    inner = _placed(SIGNS * rng.uniform(12.0, 45.0, 2), rng)
    return rounded(inner, float(rng.uniform(6.0, 20.0)))


def _stadium(rng: np.random.Generator) -> PolygonRecord:
    ends = _placed(np.array([(-1.0, 0.0), (1.0, 0.0)]) * rng.uniform(12.0, 35.0), rng)
    r = float(rng.uniform(8.0, 30.0))
    along = (ends[1] - ends[0]) / math.dist(*ends)
    across = r * np.array([-along[1], along[0]])
    a, b, c, d = (
        (float(p[0]), float(p[1]))
        for p in (ends[0] - across, ends[1] - across, ends[1] + across, ends[0] + across)
    )
    left, right = ((float(p[0]), float(p[1])) for p in ends)
    return PolygonRecord(
        (
            Segment(a, b),
            Arc(b, c, right, r, ccw=False),
            Segment(c, d),
            Arc(d, a, left, r, ccw=False),
        )
    )


def _cut(rng: np.random.Generator) -> PolygonRecord:
    middle = 99.5 + rng.uniform(-1.0, 1.0, 2)
    half = float(rng.choice([0.6, 1.5]))
    return cut_disc(middle, float(rng.uniform(20.0, 50.0)), rng.uniform(0.0, math.tau), half)


def _crescent(rng: np.random.Generator) -> PolygonRecord:
    """What a disc leaves of another one of the same radius beside it."""
    radius = float(rng.uniform(40.0, 80.0))
    apart = float(rng.uniform(0.3, 0.8)) * radius
    angle = float(rng.uniform(0.0, math.tau))
    x, y = (float(v) for v in rng.uniform(95.0, 105.0, 2))
    half = math.acos(0.5 * apart / radius)
    a, b = (
        (x + radius * math.cos(angle + s * half), y + radius * math.sin(angle + s * half))
        for s in (1.0, -1.0)
    )
    other = (x + apart * math.cos(angle), y + apart * math.sin(angle))
    return PolygonRecord((Arc(a, b, (x, y), radius, ccw=False), Arc(b, a, other, radius, ccw=True)))


def _gear(rng: np.random.Generator) -> PolygonRecord:
    """Flat arcs between sharp corners."""
    teeth = int(rng.integers(6, 11))
    begin = rng.uniform(0.0, math.tau)
    x, y = (float(v) for v in 99.5 + rng.uniform(-0.5, 0.5, 2))
    edges: list[Segment | Arc] = []
    at = [
        (x + r * math.cos(t), y + r * math.sin(t))
        for i in range(2 * teeth)
        for t0 in (begin + i * math.pi / teeth,)
        for r in ((80.0, 60.0)[i % 2],)
        for t in (t0, t0 + math.pi / teeth)
    ]
    for i in range(2 * teeth):
        a, b = at[2 * i], at[2 * i + 1]
        edges.append(Arc(a, b, (x, y), (80.0, 60.0)[i % 2], ccw=False))
        edges.append(Segment(b, at[(2 * i + 2) % len(at)]))
    return PolygonRecord(tuple(edges))


def _bar(rng: np.random.Generator) -> PolygonRecord:
    half = np.array([rng.uniform(40.0, 80.0), rng.uniform(1.75, 3.5)])
    return polygon(_placed(SIGNS * half, rng))


def _comb(rng: np.random.Generator) -> PolygonRecord:
    width = rng.uniform(4.5, 7.0)
    outline = [(-64.0, 20.0)]
    for tooth in range(6):
        x = -64.0 + tooth * 21.0
        outline += [(x, -30.0), (x + width, -30.0), (x + width, 10.0), (x + 21.0, 10.0)]
    return polygon(_placed(np.array([*outline, (62.0, 20.0)]), rng))


def _pointed(rng: np.random.Generator) -> PolygonRecord:
    half = rng.uniform(14.0, 35.0)
    return polygon(_placed(np.array([(-70.0, 0.0), (60.0, -half), (60.0, half)]), rng))


def _star(rng: np.random.Generator) -> PolygonRecord:
    n = 2 * int(rng.integers(4, 8))
    t = np.arange(n) * math.tau / n
    r = rng.uniform(40.0, 85.0) * np.where(np.arange(n) % 2, rng.uniform(0.4, 0.75), 1.0)
    return polygon(_placed(np.stack([r * np.cos(t), r * np.sin(t)], axis=1), rng))


def _ellipse(rng: np.random.Generator) -> PolygonRecord:
    t = np.linspace(0.0, math.tau, 400, endpoint=False)
    a, b = rng.uniform(40.0, 80.0), rng.uniform(14.0, 40.0)
    return polygon(_placed(np.stack([a * np.cos(t), b * np.sin(t)], axis=1), rng))


def _blob(rng: np.random.Generator) -> PolygonRecord:
    t = np.linspace(0.0, math.tau, 400, endpoint=False)
    r = rng.uniform(30.0, 70.0) * (1.0 + 0.18 * np.sin(3.0 * t) + 0.08 * np.cos(5.0 * t + 1.0))
    return polygon(_placed(np.stack([r * np.cos(t), r * np.sin(t)], axis=1), rng))


FAMILIES: dict[str, Family] = {
    "corners": Family(_corners, ((0.7, 0.0), (0.7, 20.0), (1.5, 0.0), (1.5, 20.0), (2.0, 10.0))),
    "blunt": Family(_blunt, ((0.7, 0.0), (0.7, 20.0))),
    "bevelled": Family(_bevelled, ((0.7, 5.0), (1.5, 0.0), (0.7, 10.0))),
    "rounded": Family(_rounded, ((0.7, 0.0), (1.5, 0.0), (0.7, 5.0), (0.7, 20.0))),
    "stadium": Family(_stadium, ((0.7, 0.0), (0.7, 3.0), (0.7, 10.0))),
    "cut disc": Family(_cut, ((0.7, 0.0), (0.7, 20.0))),
    "crescent": Family(_crescent, ((0.7, 0.0), (0.7, 10.0))),
    "gear": Family(_gear, ((0.5, 0.0), (0.7, 5.0))),
    "bar": Family(_bar, ((0.7, 0.0), (0.7, 5.0), (1.5, 5.0))),
    "comb": Family(_comb, ((0.7, 0.0), (0.7, 5.0))),
    "pointed": Family(_pointed, ((0.7, 0.0), (1.5, 5.0))),
    "star": Family(_star, ((0.7, 0.0), (0.7, 10.0))),
    "ellipse": Family(_ellipse, ((0.7, 0.0), (0.7, 5.0), (0.7, 20.0)), has_edges=False),
    "blob": Family(_blob, ((0.7, 0.0), (0.7, 10.0)), has_edges=False),
}


def drawn(
    name: str, look: tuple[float, float], number: int
) -> tuple[PolygonRecord, NDArray[np.uint8]]:
    """Shape ``number`` of a family and its picture."""
    blur, noise = look
    rng = np.random.default_rng([SEED, number, len(name), int(10 * blur), int(noise)])
    truth = FAMILIES[name].make(rng)
    return truth, draw([truth], SIZE, blur=blur, noise=noise, rng=rng)
