"""The Voronoi diagram against exact rational arithmetic, SciPy, and its own invariants."""

from __future__ import annotations

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import Delaunay

import planner
from planner.delaunay.half_edges import HalfEdges
from planner.delaunay.voronoi_diagram import voronoi_arrays
from tests.support.oracles.voronoi_oracle import exact_edges, exact_neighbours

Sites = NDArray[np.float64]
GOLDEN_ANGLE = np.pi * (3.0 - np.sqrt(5.0))
TURN = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)


def checked(sites: object) -> HalfEdges:
    diagram = planner.voronoi(sites)  # type: ignore[arg-type]
    diagram.check()
    return diagram


def assert_exact(sites: object) -> None:
    """Same neighbours, and the same ends of every edge, as the definition says."""
    rows = np.asarray(sites, dtype=np.float64).reshape(-1, 2)
    diagram = checked(rows)
    want = exact_edges(rows)
    assert [(i, j) for i, j, _, _ in want] == [tuple(p) for p in diagram.neighbours()]
    table = {}
    for (a, b, v, u), zero in zip(diagram.edges(), diagram.zero_length, strict=True):
        if not zero:
            table[min(a, b), max(a, b)] = {v, u} if a < b else {u, v}
    size = np.abs(rows).max(initial=0.0)
    for i, j, start, end in want:
        ends = [p for p in (start, end) if p is not None]
        vertices = [diagram.vertices[v] for v in table[i, j] if v >= 0]
        assert len(ends) == len(vertices)
        for x, y in ends:
            reach = 1e-9 * (size + abs(float(x)) + abs(float(y))) + 5e-324
            assert min(np.hypot(float(x) - v[0], float(y) - v[1]) for v in vertices) <= reach


def grid(columns: int, rows: int) -> Sites:
    x, y = np.meshgrid(np.arange(columns, dtype=float), np.arange(rows, dtype=float))
    return np.column_stack((x.ravel(), y.ravel()))


def spiral(n: int) -> Sites:
    k = np.arange(n)
    return np.sqrt(k)[:, None] * np.column_stack(
        (np.cos(k * GOLDEN_ANGLE), np.sin(k * GOLDEN_ANGLE))
    )


RNG = np.random.default_rng(20240501)
CIRCLE_OF_25 = [
    (3, 4), (4, 3), (5, 0), (-3, 4), (-4, 3), (0, 5),
    (0, -5), (-5, 0), (3, -4), (4, -3), (-3, -4), (-4, -3),
]  # fmt: skip
SMALL = {
    "nothing": [],
    "one site": [(2.0, 3.0)],
    "two sites": [(0.0, 0.0), (1.0, 5.0)],
    "one site thrice": [(1.0, 1.0)] * 3,
    "two coincident pairs": [(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (0.0, 0.0)],
    "three in a row": [(0.0, 0.0), (2.0, 2.0), (1.0, 1.0)],
    "a column, shuffled": [(3.0, float(y)) for y in (5, 1, 4, 2, 3, 1)],
    "a triangle": [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)],
    "a square": [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)],
    "a square and its centre": [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0), (1.0, 1.0)],
    "a line and one site off it": [*((float(x), 0.0) for x in range(12)), (5.0, 3.0)],
    "twelve on a circle": CIRCLE_OF_25,
    "twelve on a circle and its centre": [*CIRCLE_OF_25, (0, 0)],
    "two concentric circles": [*CIRCLE_OF_25, *((2 * x, 2 * y) for x, y in CIRCLE_OF_25)],
    "a grid": grid(6, 5),
    "a grid far away": grid(5, 5) + 2.0**40,
    "a hexagonal grid": grid(5, 6) * (1.0, 0.875) + (np.arange(30) // 5 % 2)[:, None] * (0.5, 0.0),
    "a cross": [*((float(x), 0.0) for x in range(-6, 7)), *((0.0, float(y)) for y in range(-6, 7))],
    "a spiral": spiral(30),
    "a nearly regular polygon": np.column_stack((np.cos(TURN), np.sin(TURN)))[:30],
    "sites at the finest step of float64": [(0.0, 0.0), (5e-324, 0.0), (0.0, 5e-324)],
    "two distant clusters": np.vstack((RNG.random((12, 2)), RNG.random((12, 2)) + 1e9)),
    "exponentially shrinking": [(2.0**-k, 3.0**-k) for k in range(30)],
    "random": RNG.random((30, 2)),
}


@pytest.mark.parametrize("name", SMALL)
def test_diagram_is_what_the_definition_says(name: str) -> None:
    assert_exact(SMALL[name])


@pytest.mark.parametrize("scale", [1e-300, 1e-9, 1e9, 1e100])
@pytest.mark.parametrize("name", ["a square and its centre", "random", "a spiral"])
def test_scale_does_not_matter(name: str, scale: float) -> None:
    assert_exact(np.asarray(SMALL[name]) * scale)


small_numbers = st.integers(-4, 4).map(float)
lattice_sites = st.lists(st.tuples(small_numbers, small_numbers), max_size=18)


@given(lattice_sites)
@settings(max_examples=150, deadline=None)
def test_sites_on_a_small_lattice_have_the_exact_diagram(sites: list[tuple[float, float]]) -> None:
    assert_exact(sites)


@st.composite
def nearly_degenerate(draw: st.DrawFn) -> Sites:
    """Sites on a line, a circle or a lattice, each moved by a few units in the last place."""
    t = np.array(draw(st.lists(st.integers(0, 40), min_size=3, max_size=14)), dtype=float)
    angle, offset = 0.1 * draw(st.integers(0, 63)), draw(st.sampled_from([0.0, 1.0, 1e3, 1e6]))
    line = np.column_stack((t * np.cos(angle), t * np.sin(angle)))
    ring = 10.0 * np.column_stack((np.cos(t), np.sin(t)))
    sites = draw(st.sampled_from([line, ring, np.vstack((line, ring))])) + offset
    steps = draw(st.lists(st.integers(-2, 2), min_size=sites.size, max_size=sites.size))
    ulps = np.array(steps, dtype=float).reshape(-1, 2)
    moved: Sites = sites + ulps * np.spacing(np.maximum(np.abs(sites), 1e-3))
    return moved


@given(nearly_degenerate())
@settings(max_examples=100, deadline=None)
def test_sites_within_an_ulp_of_degenerate_have_the_exact_diagram(sites: Sites) -> None:
    assert_exact(sites)


wild = st.floats(-1e150, 1e150, allow_subnormal=True)


@given(st.lists(st.tuples(wild, wild), max_size=12))
@settings(max_examples=100, deadline=None)
def test_any_finite_numbers_have_a_diagram(sites: list[tuple[float, float]]) -> None:
    checked(sites)


@given(st.integers(0, 10_000), st.integers(4, 400))
@settings(max_examples=40, deadline=None)
def test_random_sites_have_the_neighbours_qhull_finds(seed: int, n: int) -> None:
    sites = np.random.default_rng(seed).normal(size=(n, 2)) * (1.0, 3.0)
    corners = Delaunay(sites).simplices
    pairs = np.vstack((corners[:, :2], corners[:, 1:], corners[:, ::2]))
    want = np.unique(np.sort(pairs, axis=1), axis=0)
    assert np.array_equal(checked(sites).neighbours(), want)


LARGE = {
    "a pixel grid": grid(120, 90),
    "a pixel grid with duplicates": np.floor(RNG.random((9000, 2)) * 60),
    "a spiral": spiral(20_000),
    "a wound thread": np.linspace(1, 300, 8000)[:, None]
    * np.column_stack((np.cos(np.linspace(0, 99, 8000)), np.sin(np.linspace(0, 99, 8000)))),
    "a circle": np.column_stack((np.cos(np.arange(8000.0)), np.sin(np.arange(8000.0)))),
    "two lines": np.vstack((grid(4000, 1), np.add(grid(4000, 1), (0.0, 1000.0)))),
    "a parabola": np.column_stack((np.arange(-2000.0, 2000.0), np.arange(-2000.0, 2000.0) ** 2)),
    "nested clusters": (RNG.random((9000, 2)) - 0.5) * 10.0 ** RNG.integers(-12, 3, 9000)[:, None],
    "one far outlier": np.vstack((RNG.random((9000, 2)), [(1e12, 1e12)])),
    "a far offset": RNG.random((5000, 2)) + 1e9,
    "one site many times": np.ones((20_000, 2)),
    "nine sites many times": RNG.integers(0, 3, (9000, 2)) * (1.0, 0.5),
    "a long diagonal": np.arange(9000.0)[:, None] * (0.1, 0.3),
    "random": RNG.random((30_000, 2)),
}  # fmt: skip


@pytest.mark.parametrize("name", LARGE)
def test_large_and_difficult_sets_pass_the_check(name: str) -> None:
    checked(LARGE[name])


def test_grid_cells_touch_only_along_rows_and_columns() -> None:
    pairs = checked(grid(40, 30)).neighbours()
    assert len(pairs) == 39 * 30 + 40 * 29
    assert set((pairs[:, 1] - pairs[:, 0]).tolist()) == {1, 40}


@pytest.mark.parametrize("name", ["random", "twelve on a circle and its centre", "a grid"])
def test_neighbours_do_not_depend_on_order_place_or_turn(name: str) -> None:
    sites = np.asarray(SMALL[name], dtype=float)
    # sums and quarter turns of these numbers are exact
    sites = np.round(sites * 1024.0)
    want = checked(sites).neighbours()
    assert np.array_equal(checked(np.add(sites, (4096.0, -512.0))).neighbours(), want)
    assert np.array_equal(checked(sites[:, ::-1] * (-1.0, 1.0)).neighbours(), want)
    assert np.array_equal(checked(sites * (-1.0, 1.0)).neighbours(), want)
    order = np.random.default_rng(5).permutation(len(sites))
    back = np.sort(order[checked(sites[order]).neighbours()], axis=1)
    assert np.array_equal(back[np.lexsort(back.T[::-1])], want)


def test_coincident_sites_are_represented_by_their_first_row() -> None:
    sites = np.repeat(RNG.random((50, 2)), 3, axis=0)[RNG.permutation(150)]
    first = {}
    want = [first.setdefault(tuple(p), i) for i, p in enumerate(sites)]
    diagram = checked(sites)
    assert diagram.representative.tolist() == want
    assert set(diagram.cell.tolist()) == set(want)
    assert np.array_equal(diagram.neighbours(), exact_neighbours(sites))


def test_vertex_far_away_is_accurate() -> None:
    sites = np.array([(0.0, 0.0), (1.0, 1e-12), (2.0, 0.0)])
    (x, y), = checked(sites).vertices  # fmt: skip
    assert x == pytest.approx(1.0, abs=1e-3)
    assert y == pytest.approx(-5e11, rel=1e-12)


def test_arrays_and_half_edges_tell_the_same() -> None:
    sites = np.vstack((grid(9, 9), RNG.random((200, 2)) * 9.0))
    arrays, diagram = voronoi_arrays(sites), checked(sites)
    assert np.array_equal(arrays.edges, diagram.edges())
    assert np.array_equal(arrays.vertices, diagram.vertices)
    assert np.array_equal(arrays.vertex_sites, diagram.vertex_sites)
    assert np.array_equal(arrays.zero_length, diagram.zero_length)
    assert np.array_equal(arrays.representative, diagram.representative)


def test_sequences_views_and_integers_are_accepted_and_left_alone() -> None:
    sites = RNG.integers(0, 50, (40, 2))
    want = checked(sites).neighbours()
    kept = sites.copy()
    for same in (sites.tolist(), sites.astype(np.float32), np.asfortranarray(sites.astype(float)),
                 np.repeat(sites, 2, axis=0)[::2]):  # fmt: skip
        assert np.array_equal(checked(same).neighbours(), want)
    assert np.array_equal(sites, kept)
    frozen = sites.astype(float)
    frozen.setflags(write=False)
    assert np.array_equal(checked(frozen).neighbours(), want)
    mine = sites.astype(float)
    diagram = checked(mine)
    mine[:] = 0.0
    diagram.check()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e200])
def test_bad_coordinate_names_its_row(bad: float) -> None:
    sites = RNG.random((30, 2))
    sites[17, 1] = bad
    with pytest.raises(ValueError, match=r"sites\[17\]"):
        planner.voronoi(sites)


@pytest.mark.parametrize("shape", [(4,), (3, 3), (2, 2, 2), (5, 1)])
def test_wrong_shape_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"must be \(n, 2\)"):
        planner.voronoi(np.zeros(shape))


def test_threads_do_not_disturb_each_other() -> None:
    inputs = [np.random.default_rng(k).random((3000, 2)) for k in range(8)]
    want = [planner.voronoi(s).neighbours() for s in inputs]
    with ThreadPoolExecutor(8) as pool:
        got = list(pool.map(planner.voronoi, inputs * 4))
    for k, diagram in enumerate(got):
        assert np.array_equal(diagram.neighbours(), want[k % 8])


def _run_without_jit(program: str) -> str:
    root = Path(__file__).parents[3]
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(root)}
    done = subprocess.run(
        [sys.executable, "-c", program],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


DIGEST = """
import hashlib, numpy as np, planner
rng = np.random.default_rng(3)
x = np.linspace(0.0, 40.0, 60)
cases = [rng.random((150, 2)), rng.integers(0, 8, (150, 2)) * 1.0, np.outer(x, (0.3, 0.7)),
         np.vstack((np.outer(x, (0.3, 0.7)), rng.random((20, 2)))), np.ones((9, 2)),
         rng.random((40, 2)) * 1e-200, 10.0 ** rng.uniform(-90, 90, (40, 2))]
whole = hashlib.sha256()
for sites in cases:
    d = planner.voronoi(sites)
    for a in (d.vertices, d.vertex_sites, d.origin, d.next, d.prev, d.cell, d.zero_length):
        whole.update(a.tobytes())
print(whole.hexdigest())
"""


def test_kernel_without_jit_gives_the_same_bits(capsys: pytest.CaptureFixture[str]) -> None:
    exec(compile(DIGEST, "digest", "exec"), {})
    assert _run_without_jit(DIGEST) == capsys.readouterr().out


LYING = """
import numpy as np
import planner.delaunay.half_edges as half_edges
import planner.delaunay.diagram_kernels as diagrams
import planner.delaunay.insertion_kernels as kernels
from planner.delaunay.voronoi_diagram import voronoi

rng = np.random.default_rng(11)
true_conflict, true_orient = kernels.conflict, kernels.orient

def lie(rate, answer):
    return int(rng.integers(-1, 2)) if rng.random() < rate else answer

kernels.CIRCLE_SLACK = 1e30  # every circle is in doubt, so every decision is asked for
for trial in range(60):
    rate = float(rng.choice([0.01, 0.2, 1.0]))
    sites = rng.random((40, 2)) if trial % 2 else rng.integers(0, 6, (40, 2)) * 1.0
    sites = np.unique(sites, axis=0)
    kernels.orient = true_orient
    kernels.conflict = diagrams.conflict = lambda *a: lie(rate, true_conflict(*a))
    diagram = voronoi(sites)
    half_edges._check_links(diagram, simple=False)
    half_edges._check_cycles(diagram)
print("sound")
"""


def test_lying_arithmetic_cannot_break_the_topology() -> None:
    assert _run_without_jit(LYING) == "sound\n"


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_mixtures_of_degenerate_shapes_pass_the_check(seed: int) -> None:
    rng = np.random.default_rng(seed)
    parts: list[Sites] = []
    for _ in range(rng.integers(1, 6)):
        n = int(rng.integers(1, 60))
        place, size = rng.integers(-50, 50, 2) * 1.0, 10.0 ** rng.integers(-3, 3)
        shape = [
            rng.random((n, 2)),
            rng.integers(0, 7, (n, 2)) * 1.0,
            np.outer(np.arange(n), rng.integers(-3, 4, 2)) * 1.0,
            np.column_stack((np.cos(np.arange(n) * 0.5), np.sin(np.arange(n) * 0.5))),
            np.repeat(rng.random((1, 2)), n, axis=0),
        ][rng.integers(5)]
        parts.append(place + size * shape)
    checked(np.vstack(parts))
