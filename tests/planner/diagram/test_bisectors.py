"""Places on bisectors: solved, followed within the stated tolerance, and proved by near sites."""

from __future__ import annotations

import math

import numpy as np
import pytest

import planner
from planner.borders.generators import Borders, gather_borders, place_generators
from planner.diagram import bisector_kernels, mesh, mesh_kernels
from planner.diagram.chains import bend_kernels
from planner.diagram.chains.bend_kernels import LINK_BULGE
from planner.roadmap.roadmap import Roadmap
from planner.scene import ARC, CIRCLE, POINT, SEGMENT, FloatArray, primitive_kernels
from tests.support.scenes.planner_scenes import hand_made, random_scene, slow_distance


def _distance(borders: Borders, piece: int, at: FloatArray) -> float:
    """Distance to one piece, by trigonometry and projections of the test's own."""
    row, kind = borders.data[piece], borders.kind[piece]
    if kind == POINT:
        return math.dist(row[:2], at)
    if kind == SEGMENT:
        a, d = row[:2], row[2:4] - row[:2]
        t = float(np.clip((at - a) @ d / (d @ d), 0.0, 1.0))
        return math.dist(a + t * d, at)
    away = abs(math.dist(row[:2], at) - row[2])
    if kind == CIRCLE:
        return away
    gone = (math.atan2(at[1] - row[1], at[0] - row[0]) - row[3]) % math.tau
    if gone <= row[4]:
        return away
    ends = [row[3], row[3] + row[4]]
    return min(
        math.dist((row[0] + row[2] * math.cos(a), row[1] + row[2] * math.sin(a)), at) for a in ends
    )


def _off_bisector(borders: Borders, pair: FloatArray, a: FloatArray, b: FloatArray) -> float:
    """How far the bisector of two pieces leaves the line from a to b, square to it."""
    left, right = (int(v) for v in pair)
    normal = np.array([a[1] - b[1], b[0] - a[0]]) / math.dist(a, b)
    worst = 0.0
    for t in (0.2, 0.35, 0.5, 0.65, 0.8):
        foot = a + t * (b - a)

        def gap(s: float, foot: FloatArray = foot) -> float:
            at = foot + s * normal
            return _distance(borders, left, at) - _distance(borders, right, at)

        lo, hi = -1.0, 1.0
        while gap(lo) * gap(hi) > 0.0:
            lo, hi = 2.0 * lo, 2.0 * hi
            assert hi < 1e3, "the bisector does not pass this link"
        for _ in range(60):
            middle = 0.5 * (lo + hi)
            if gap(lo) * gap(middle) <= 0.0:
                hi = middle
            else:
                lo = middle
        worst = max(worst, abs(lo))
    return worst


def _sample(roadmap: Roadmap, rng: np.random.Generator, count: int) -> np.ndarray:
    chains = roadmap.chains
    usable = np.flatnonzero(chains.proved & (chains.gap >= roadmap.radius) & (chains.step > 1e-6))
    return rng.choice(usable, min(count, len(usable)), replace=False)


@pytest.mark.parametrize("seed", range(8))
def test_links_stay_within_five_per_cent_of_the_spacing_of_their_bisectors(seed: int) -> None:
    rng = np.random.default_rng(seed)
    roadmap = planner.build_roadmap(random_scene(rng), float(rng.uniform(2.0, 6.0)))
    chains = roadmap.chains
    stated = 0.5 * LINK_BULGE * roadmap.spacing
    assert stated == pytest.approx(0.05 * roadmap.spacing)
    for i in _sample(roadmap, rng, 25):
        off = _off_bisector(roadmap.borders, chains.pieces[i], *chains.points[i : i + 2])
        assert off <= 1.3 * stated


@pytest.mark.parametrize("flatness", [0.5, 0.05, 0.002])
def test_following_a_bisector_keeps_the_flatness_asked_for(flatness: float) -> None:
    rng = np.random.default_rng(3)
    roadmap = planner.build_roadmap(random_scene(rng), 3.0)
    borders, chains = roadmap.borders, roadmap.chains
    for i in _sample(roadmap, rng, 20):
        points, pairs = bisector_kernels.follow(
            borders.tree,
            np.ascontiguousarray(chains.points[i : i + 2]),
            np.array([chains.pieces[i], (-1, -1)], np.int32),
            roadmap.radius,
            flatness,
            borders.equal,
            np.inf,
        )
        for a, b, pair in zip(points[:-1], points[1:], pairs[:-1], strict=True):
            if math.dist(a, b) > 1e-6:
                assert _off_bisector(borders, pair, a, b) <= 1.3 * flatness + 1e-9


@pytest.mark.parametrize("seed", range(10))
def test_nodes_are_equally_far_from_three_borders_or_a_way_ends_there(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    scene = random_scene(rng)
    roadmap = planner.build_roadmap(scene, float(rng.uniform(2.0, 6.0)))
    chains, borders = roadmap.chains, roadmap.borders
    degree = np.bincount(chains.ends.ravel(), minlength=len(chains.node_xy))
    proved = np.ones(len(chains.node_xy), bool)
    for c, (u, v) in enumerate(chains.ends):
        links = chains.proved[chains.first[c] : chains.first[c + 1] - 1]
        if len(links):
            proved[u] &= links[0]
            proved[v] &= links[-1]
    for n in np.flatnonzero((degree == 3) & proved & (chains.node_rho > roadmap.radius)):
        at = chains.node_xy[n]
        far = np.array([_distance(borders, i, at) for i in range(len(borders.kind))])
        assert far.min() == pytest.approx(chains.node_rho[n], abs=1e-9 * borders.extent)
        assert (far <= far.min() + 1e-9 * borders.extent).sum() >= 3


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("share", [0.3, 1.0, 1.9])
def test_the_nearest_border_is_found_among_the_sites_around_a_place(
    seed: int, share: float
) -> None:
    rng = np.random.default_rng(seed)
    scene = random_scene(rng)
    borders = gather_borders(scene)
    generators = place_generators(borders, 4.0 * share)
    made = mesh.make_mesh(generators)
    assert made is not None
    half = 2.0 * share
    mesh.solve(made, borders, 4.0 * share)
    sag = mesh.largest_sag(borders, half)
    flat = mesh._flat(made, sag)
    start = 8 * int(np.flatnonzero(np.isfinite(made.at[:, 0]))[0])
    places = rng.uniform((0.0, 0.0), (159.0, 119.0), (200, 2))
    want = slow_distance(scene, places)
    for (x, y), distance in zip(places, want, strict=True):
        got, which = mesh_kernels.nearest_piece(flat, borders.corners, start, x, y, np.inf, half)
        assert which >= 0
        assert got == pytest.approx(distance, abs=1e-9)
        _, none = mesh_kernels.nearest_piece(
            flat, borders.corners, start, x, y, 0.999 * distance, half
        )
        assert none == -1


@pytest.mark.parametrize("name", list(hand_made()))
def test_no_place_of_a_border_in_the_bounds_is_further_than_half_a_spacing_from_a_generator(
    name: str,
) -> None:
    borders = gather_borders(hand_made()[name])
    spacing = 3.7
    generators = place_generators(borders, spacing)
    k = borders.primitive_count
    for i in range(k):
        mine = generators.label == i
        for side in np.flatnonzero((borders.pieces.before == i) | (borders.pieces.after == i)):
            mine |= generators.label == k + side
        sites = generators.sites[mine]
        x0, y0, x1, y1 = borders.box.tolist()
        for place in _along(borders, i):
            if x0 <= place[0] <= x1 and y0 <= place[1] <= y1:
                assert np.hypot(*(sites - place).T).min() <= 0.5 * spacing + 1e-9


def _along(borders: Borders, i: int) -> FloatArray:
    row, kind = borders.data[i], borders.kind[i]
    t = np.linspace(0.0, 1.0, 101)[:, None]
    if kind == POINT:
        return row[None, :2]
    if kind == SEGMENT:
        return row[:2] + t * (row[2:4] - row[:2])
    start, sweep = (row[3], row[4]) if kind == ARC else (0.0, math.tau)
    a = (start + sweep * t)[:, 0]
    return row[:2] + row[2] * np.c_[np.cos(a), np.sin(a)]


def test_turning_points_far_from_where_they_were_sampled_are_exact() -> None:
    rng = np.random.default_rng(35)
    scene, radius = random_scene(rng), float(rng.uniform(1.5, 10.0))
    # where an arc leaves its tangent slowly, two spacings and more
    roadmap = planner.build_roadmap(scene, radius)
    finer = planner.build_roadmap(scene, radius, spacing=0.3 * radius)
    assert roadmap.agvd.vertices_proved(radius)[0] == roadmap.agvd.vertices_proved(radius)[1]
    clearances = [r.chains.clearance[r.chains.clearance >= radius] for r in (roadmap, finer)]
    assert clearances[0].min() == pytest.approx(clearances[1].min(), abs=1e-6)


def test_all_but_a_few_vertices_are_proved_and_the_rest_are_counted() -> None:
    proved = wide = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        roadmap = planner.build_roadmap(random_scene(rng), 4.0)
        some, all_of_them = roadmap.agvd.vertices_proved(4.0)
        assert some <= all_of_them
        proved, wide = proved + some, wide + all_of_them
    assert wide > 1000
    assert proved >= 0.99 * wide


def test_a_place_that_slid_past_the_end_of_its_run_is_not_between() -> None:
    """Sampled vertices of a run that lie elsewhere slide to either side of it, far away, too."""
    kind = np.array([POINT, ARC], np.int8)
    data = primitive_kernels.with_middles(
        kind,
        np.array(
            [
                (101.46096881591419, 100.6066885330694, 0.0, 0.0, 0.0, 0.0),
                (
                    64.909147142905,
                    235.1990049486365,
                    53.9969840061,
                    -3.0311885581,
                    4.8111449522,
                    0.0,
                ),
            ]
        ),
    )
    places = [(187.9, 146.3), (162.87, 147.67), (144.2, 148.03), (129.36, 147.66), (105.9, 145.3)]
    solved = [bisector_kernels.slide_between(kind, data, 0, 1, *p, 1e-9)[:2] for p in places]
    behind, a, m, b, beyond = solved
    ux, uy, _ = bisector_kernels.heading(kind, data, 0, 1, *a)
    assert ux < 0.0

    def is_between(x: float, y: float) -> bool:
        found = bend_kernels._is_between(kind, data, 0, 1, (*a, ux, uy), (x, y), b, 1.41, 1e-9)
        return bool(found)

    assert is_between(*m)
    assert not is_between(*behind)
    far = bisector_kernels.slide_between(kind, data, 0, 1, 214.0, 144.0, 1e-9)[:2]
    assert not is_between(*far)
    assert not is_between(*beyond)
