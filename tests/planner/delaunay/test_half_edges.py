"""Half-edges: their arrays, and a check that finds every kind of damage."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import planner
from planner.delaunay.half_edges import DiagramError, HalfEdges

SITES = np.vstack(
    (
        np.random.default_rng(7).random((40, 2)) * 10.0,
        [(float(x), float(y)) for x in range(12, 16) for y in range(4)],
    )
)


@pytest.fixture
def diagram() -> HalfEdges:
    return planner.voronoi(SITES)


def changed(array: NDArray[np.generic], index: object, value: object) -> NDArray[np.generic]:
    copy = array.copy()
    copy[index] = value  # type: ignore[index]
    return copy


def test_arrays_are_read_only(diagram: HalfEdges) -> None:
    for name in HalfEdges.__slots__:
        with pytest.raises(ValueError, match="read-only"):
            getattr(diagram, name)[...] = 0


def test_twin_runs_back_between_the_same_vertices(diagram: HalfEdges) -> None:
    e = np.arange(len(diagram.origin))
    assert np.array_equal(diagram.origin[diagram.next], diagram.origin[e ^ 1])
    edges = diagram.edges()
    assert np.array_equal(edges[:, :2].ravel(), diagram.cell)
    assert np.array_equal(edges[:, 2:].ravel(), diagram.origin)


def test_the_cell_lies_to_the_left_of_its_half_edges(diagram: HalfEdges) -> None:
    start, end = diagram.edges()[:, 2], diagram.edges()[:, 3]
    bounded = (start >= 0) & (end >= 0) & ~diagram.zero_length
    along = diagram.vertices[end[bounded]] - diagram.vertices[start[bounded]]
    left, right = diagram.edges()[bounded, :2].T
    across = diagram.sites[left] - diagram.sites[right]
    assert (along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0] > 0.0).all()


def test_unbounded_cells_are_those_of_the_hull() -> None:
    square = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0), (1.0, 2.0), (2.5, 2.0)]
    d = planner.voronoi(square)
    assert sorted(d.cell[d.origin < 0].tolist()) == [0, 1, 2, 3]


def test_neighbours_are_sorted_pairs_without_zero_edges(diagram: HalfEdges) -> None:
    pairs = diagram.neighbours()
    assert pairs.dtype == np.int32
    assert (pairs[:, 0] < pairs[:, 1]).all()
    assert np.array_equal(np.unique(pairs, axis=0), pairs)
    assert diagram.zero_length.sum() == 9
    assert len(pairs) == len(diagram.edges()) - 9


@pytest.mark.parametrize("n", [0, 1, 2, 3, 4])
def test_few_sites_pass_the_check(n: int) -> None:
    planner.voronoi(SITES[:n]).check()


DAMAGE: dict[str, tuple[Callable[[HalfEdges], HalfEdges], str]] = {
    "a twin in its own cell": (
        lambda d: replace(d, cell=changed(d.cell, 1, d.cell[0])),
        "twins",
    ),
    "an index out of range": (
        lambda d: replace(d, next=changed(d.next, 3, len(d.next))),
        r"next: must be in",
    ),
    "a next that leads elsewhere": (
        lambda d: replace(d, next=changed(d.next, [0, 9], d.next[[9, 0]])),
        "prev must undo next",
    ),
    "two cells exchanged at one half-edge": (
        lambda d: replace(d, cell=changed(d.cell, [4, 5], d.cell[[5, 4]])),
        "stay in the cell",
    ),
    "an origin exchanged": (
        lambda d: replace(d, origin=changed(d.origin, [0, 40], d.origin[[40, 0]])),
        "start where the edge ends",
    ),
    "a vertex with a wrong site": (
        lambda d: replace(
            d,
            vertex_sites=changed(d.vertex_sites, (2, 0), (d.vertex_sites[2, 0] + 1) % len(d.sites)),
        ),
        "one of its origin's sites",
    ),
    "a vertex of the wrong turn": (
        lambda d: replace(d, vertex_sites=changed(d.vertex_sites, 5, d.vertex_sites[5, ::-1])),
        r"vertex_sites\[5\]: must turn",
    ),
    "a vertex moved": (
        lambda d: replace(d, vertices=changed(d.vertices, 8, d.vertices[8] + 1e-4)),
        r"vertices\[8\]: not equidistant",
    ),
    "a vertex that is NaN": (
        lambda d: replace(d, vertices=changed(d.vertices, 8, np.nan)),
        r"vertices\[8\]: not equidistant",
    ),
    "a wrong flag": (
        lambda d: replace(d, zero_length=~d.zero_length),
        "zero_length is not",
    ),
    "a site moved": (
        lambda d: replace(d, sites=changed(d.sites, 30, d.sites[31] + 1e-3)),
        "not equidistant",
    ),
    "a representative that lies elsewhere": (
        lambda d: replace(d, representative=changed(d.representative, 9, 8)),
        "representative",
    ),
    "a site without a cell": (
        lambda d: replace(
            d,
            sites=np.vstack((d.sites, [(5.0, 5.0)])),
            representative=np.append(d.representative, np.int32(len(d.sites))),
        ),
        "each cell must be one cycle",
    ),
}


@pytest.mark.parametrize("name", DAMAGE)
def test_check_finds(name: str, diagram: HalfEdges) -> None:
    damage, message = DAMAGE[name]
    diagram.check()
    with pytest.raises(DiagramError, match=message):
        damage(diagram).check()


def test_check_finds_a_circle_that_is_not_empty() -> None:
    # a valid diagram of four sites, one of which then moves into another vertex's circle
    sites = np.array([(0.0, 0.0), (4.0, 0.0), (2.0, 3.0), (2.0, -5.0)])
    d = planner.voronoi(sites)
    moved = planner.voronoi(changed(sites, 3, (2.0, -1.0)))
    wrong = replace(
        d,
        sites=moved.sites,
        vertices=np.array([_centre(moved.sites[list(t)]) for t in d.vertex_sites]),
    )
    with pytest.raises(DiagramError, match="a circle is not empty"):
        wrong.check()


def _centre(corner: NDArray[np.float64]) -> NDArray[np.float64]:
    rows = 2.0 * (corner[1:] - corner[0])
    right = (corner[1:] ** 2).sum(axis=1) - (corner[0] ** 2).sum()
    centre: NDArray[np.float64] = np.linalg.solve(rows, right)
    return centre
