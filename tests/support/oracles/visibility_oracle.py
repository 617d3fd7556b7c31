"""The shortest way for a disc, slowly: the visibility graph of the borders moved outwards.

Written from the definition and from the scene's records alone; it shares no code with the
planner. Every corner and every end of a border is a circle of the disc's radius, every round
border one that is larger by it. All common tangents of two circles that keep the radius, and all
stretches of circle between them that do, are the edges; Dijkstra does the rest. Places on
circles are looked at every ``ARC_STEP_RAD``, and clearances may fall short by ``SLACK`` of the
radius, so the answer is never longer than the shortest way.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from planner.scene import Arc, FloatArray, IntArray, Scene, Segment
from tests.support.scenes.planner_scenes import all_edges

ARC_STEP_RAD = 0.05
SLACK = 1e-6


@dataclass
class _Borders:
    """Straight pieces (n, 4) and round ones (n, 5): centre, radius, first angle, sweep > 0."""

    straight: list[tuple[float, ...]] = field(default_factory=list)
    round: list[tuple[float, ...]] = field(default_factory=list)

    def add(self, edge: Segment | Arc, y_down: bool) -> None:
        if isinstance(edge, Segment):
            self.straight.append((*edge.start, *edge.end))
            return
        a0, turn = edge.sweep(y_down)
        self.round.append((*edge.center, edge.radius, min(a0, a0 + turn), abs(turn)))


class VisibilityGraph:
    """The shortest ways of a disc of ``radius`` in a scene."""

    def __init__(self, scene: Scene, radius: float) -> None:
        self._borders = _borders(scene)
        self._circles = _circles(self._borders, radius)
        self._least = radius * (1.0 - SLACK)
        circles = np.array(self._circles).reshape(-1, 3)
        self._tangents = self._clear(circles, *np.triu_indices(len(circles), 1))

    def length(self, start: tuple[float, float], goal: tuple[float, float]) -> float:
        """Length of the shortest way, infinity where there is none."""
        circles = np.array([*self._circles, (*start, 0.0), (*goal, 0.0)])
        first = len(circles) - 2
        i = np.r_[np.tile(np.arange(first), 2), first]
        j = np.r_[np.repeat([first, first + 1], first), first + 1]
        own = self._clear(circles, i, j)
        lengths, angles = (np.concatenate(both) for both in zip(self._tangents, own, strict=True))
        places: list[list[tuple[float, int]]] = [[] for _ in circles]
        number = itertools.count(2)
        rows, cols, cost = [], [], []
        straight = math.inf
        for length, (c, d, a, b) in zip(lengths.tolist(), angles.tolist(), strict=True):
            if c >= first and d >= first:
                straight = length  # the four tangents of two points are one
                continue
            ends = []
            for circle, angle in ((int(c), a), (int(d), b)):
                node = circle - first if circle >= first else next(number)
                ends.append(node)
                places[circle].append((angle % math.tau, node))
            rows.append(ends[0])
            cols.append(ends[1])
            cost.append(length)
        for radius, a, b, u, v in self._free_stretches(places):
            rows.append(u)
            cols.append(v)
            cost.append(radius * (b - a))
        n = next(number)
        graph = coo_matrix((np.maximum(cost, 1e-12), (rows, cols)), shape=(n, n)).tocsr()
        return min(straight, float(dijkstra(graph, directed=False, indices=0)[1]))

    def _clear(
        self, circles: FloatArray, i: IntArray, j: IntArray
    ) -> tuple[FloatArray, FloatArray]:
        """The common tangents that keep the radius: lengths (n,), circles and angles (n, 4)."""
        p, q, angles = _tangents(circles, i, j)
        kept = _clear_ones(self._borders, p, q, self._least)
        return np.hypot(*(q[kept] - p[kept]).T), angles[kept]

    def _free_stretches(
        self, places: list[list[tuple[float, int]]]
    ) -> list[tuple[float, float, float, int, int]]:
        """Stretches of the borders' circles that keep the radius: radius, angles and nodes."""
        stretches = [
            (*circle, *stretch)
            for circle, on_it in zip(self._circles, places, strict=False)
            for stretch in _stretches(sorted(on_it))
        ]
        if not stretches:
            return []
        at, of = [], []
        for k, (x, y, r, a, b, _, _) in enumerate(stretches):
            t = np.linspace(a, b, max(2, math.ceil((b - a) / ARC_STEP_RAD) + 1))
            at.append(np.c_[x + r * np.cos(t), y + r * np.sin(t)])
            of.append(np.full(len(t), k))
        samples, owner = np.concatenate(at), np.concatenate(of)
        blocked = np.ones(len(samples), dtype=bool)
        blocked[_clear_points(self._borders, samples, self._least - 1e-9)] = False
        free = np.bincount(owner, blocked, len(stretches)) == 0
        return [one[2:] for one, is_free in zip(stretches, free, strict=True) if is_free]


def shortest_length(
    scene: Scene, radius: float, start: tuple[float, float], goal: tuple[float, float]
) -> float:
    """Length of the shortest way for a disc of ``radius``, infinity where there is none."""
    return VisibilityGraph(scene, radius).length(start, goal)


def _borders(scene: Scene) -> _Borders:
    found = _Borders()
    corners = scene.bounds.corners()
    for i in range(4):
        found.add(Segment(corners[i], corners[(i + 1) % 4]), scene.y_down)
    for item in all_edges(scene):
        if isinstance(item, tuple):
            found.add(Segment(item, item), scene.y_down)
            continue
        for edge in item:
            found.add(edge, scene.y_down)
    return found


def _circles(borders: _Borders, radius: float) -> list[tuple[float, float, float]]:
    made = set()
    for x0, y0, x1, y1 in borders.straight:
        made |= {(round(x0, 9), round(y0, 9), radius), (round(x1, 9), round(y1, 9), radius)}
    for x, y, r, a, sweep in borders.round:
        made.add((round(x, 9), round(y, 9), r + radius))
        if sweep < math.tau - 1e-9:
            for t in (a, a + sweep):
                at = (round(x + r * math.cos(t), 9), round(y + r * math.sin(t), 9))
                made.add((*at, radius))
    return sorted(made)


def _tangents(
    circles: FloatArray, i: IntArray, j: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """All common tangents of circles i and j: ends (n, 2) and (n, 2), and i, j, angles (n, 4).

    A tangent's normal makes an angle with the line between the centres whose cosine is the
    difference (outer) or the sum (inner) of the radii over the distance. Circles that touch
    from within have the place where they touch.
    """
    gap = circles[j, :2] - circles[i, :2]
    far = np.hypot(*gap.T)
    along = np.arctan2(gap[:, 1], gap[:, 0])
    ends, others, which = [], [], []
    for inner, way in itertools.product((False, True), (-1.0, 1.0)):
        sign = -1.0 if inner else 1.0
        with np.errstate(divide="ignore", invalid="ignore"):
            cosine = (circles[i, 2] - sign * circles[j, 2]) / far
        ok = (far > 0.0) & (np.abs(cosine) <= 1.0 + 1e-9)
        turn = np.arccos(np.clip(cosine[ok], -1.0, 1.0))
        a = along[ok] + way * turn
        b = a if not inner else a + math.pi
        p = circles[i[ok], :2] + circles[i[ok], 2:] * np.c_[np.cos(a), np.sin(a)]
        q = circles[j[ok], :2] + circles[j[ok], 2:] * np.c_[np.cos(b), np.sin(b)]
        ends.append(p)
        others.append(q)
        which.append(np.c_[i[ok], j[ok], a, b])
    return np.concatenate(ends), np.concatenate(others), np.concatenate(which)


def _stretches(places: list[tuple[float, int]]) -> list[tuple[float, float, int, int]]:
    if len(places) < 2:
        return []
    turned = [*places[1:], (places[0][0] + math.tau, places[0][1])]
    return [(a, b, u, v) for (a, u), (b, v) in zip(places, turned, strict=True)]


def _clear_ones(borders: _Borders, p: FloatArray, q: FloatArray, least: float) -> IntArray:
    """The segments p q that are at least so far from every border; blocked ones are let go."""
    left = np.arange(len(p), dtype=np.int32)
    for x0, y0, x1, y1 in borders.straight:
        far = _to_straight(p[left], q[left], np.array([x0, y0]), np.array([x1, y1]))
        left = left[far >= least]
    for x, y, r, a, sweep in borders.round:
        left = left[_to_round(p[left], q[left], np.array([x, y]), r, a, sweep) >= least]
    return left


def _clear_points(borders: _Borders, at: FloatArray, least: float) -> IntArray:
    """The points that are at least so far from every border; blocked ones are let go."""
    left = np.arange(len(at), dtype=np.int32)
    for x0, y0, x1, y1 in borders.straight:
        here = at[left]
        starts, stops = (np.broadcast_to(np.array(e), here.shape) for e in ((x0, y0), (x1, y1)))
        left = left[_point_to(starts, stops, here) >= least]
    for x, y, r, a, sweep in borders.round:
        here = at[left]
        v = here - (x, y)
        on = (np.arctan2(v[:, 1], v[:, 0]) - a) % math.tau <= sweep
        far = np.where(on, np.abs(np.hypot(*v.T) - r), np.inf)
        for t in (a, a + sweep):
            end = np.array([x + r * math.cos(t), y + r * math.sin(t)])
            far = np.minimum(far, np.hypot(*(here - end).T))
        left = left[far >= least]
    return left


def _point_to(p: FloatArray, q: FloatArray, at: FloatArray) -> FloatArray:
    d = q - p
    square = np.maximum((d * d).sum(1), 1e-300)
    t = np.clip(((at - p) * d).sum(1) / square, 0.0, 1.0)
    return np.hypot(*(p + t[:, None] * d - at).T)


def _to_straight(p: FloatArray, q: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    ends = np.minimum(_point_to(p, q, a), _point_to(p, q, b))
    starts = np.broadcast_to(a, p.shape)
    stops = np.broadcast_to(b, p.shape)
    ends = np.minimum(ends, np.minimum(_point_to(starts, stops, p), _point_to(starts, stops, q)))
    side_p, side_q = _cross(b - a, p - a), _cross(b - a, q - a)
    side_a, side_b = _cross(q - p, a - p), _cross(q - p, b - p)
    crosses = (side_p * side_q < 0.0) & (side_a * side_b < 0.0)
    return np.where(crosses, 0.0, ends)


def _to_round(
    p: FloatArray, q: FloatArray, center: FloatArray, r: float, a: float, sweep: float
) -> FloatArray:
    """To an arc: at either's ends, at the place nearest to the centre, or where they cross."""
    d = q - p
    square = np.maximum((d * d).sum(1), 1e-300)
    m = ((center - p) * d).sum(1) / square
    h2 = ((p + m[:, None] * d - center) ** 2).sum(1)
    half = np.sqrt(np.maximum(r * r - h2, 0.0) / square)
    best = np.full(len(p), np.inf)
    for t in (np.zeros(len(p)), np.ones(len(p)), np.clip(m, 0.0, 1.0), m - half, m + half):
        inside = np.clip(t, 0.0, 1.0)
        v = p + inside[:, None] * d - center
        on = (np.arctan2(v[:, 1], v[:, 0]) - a) % math.tau <= sweep
        best = np.where(on, np.minimum(best, np.abs(np.hypot(*v.T) - r)), best)
    for t0 in (a, a + sweep):
        best = np.minimum(best, _point_to(p, q, center + r * np.array([np.cos(t0), np.sin(t0)])))
    return best


def _cross(u: FloatArray, v: FloatArray) -> FloatArray:
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
