"""The paper's figures and tables have the shape that docs/paper says; see benchmarks/paper."""

from __future__ import annotations

import importlib
import math
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

import planner
import vision
from benchmarks.paper import (
    arena,
    canvas,
    claims,
    diagrams,
    guarantees,
    inputs,
    insertion,
    measured,
    page,
    timing,
    weaknesses,
)
from planner.delaunay.voronoi_diagram import voronoi_arrays
from planner.scene import Bounds
from tests.support.scenes.planner_scenes import hand_made

TOP = Path(__file__).parents[2]
FOLDER = TOP / "docs" / "paper"
NAMED = re.findall(r"f?\"([^\"\n]+::[^\"\n]+)\"", (TOP / "benchmarks/paper/claims.py").read_text())


@pytest.fixture(scope="module")
def picture() -> inputs.Picture:
    return inputs.arena_picture()


@pytest.mark.parametrize("shift", [(0.0, 0.0), (-30.0, 20.0), (15.0, -40.0)])
def test_the_papers_walk_gives_the_region_that_the_kernel_gives(
    shift: tuple[float, float],
) -> None:
    sites, new = inputs.fourteen_sites(), inputs.fifteenth_site() + np.array(shift)
    walk = insertion.walk_around(planner.voronoi(sites), new)
    neighbours, corners = insertion.new_region(new, sites)
    assert set(walk.around) == neighbours
    assert len(walk.around) == len(neighbours)
    gaps = np.linalg.norm(walk.corners[:, None] - corners[None], axis=2)
    assert gaps.min(axis=1).max() < 1e-9


def test_fourteen_generators_are_spread_in_the_square() -> None:
    sites = inputs.fourteen_sites()
    assert sites.shape == (14, 2)
    gaps = np.linalg.norm(sites[:, None] - sites[None], axis=2) + 1e9 * np.eye(14)
    assert gaps.min() > 20.0
    assert all(inputs.SQUARE.contains((x, y)) for x, y in sites.tolist())


def test_edges_to_infinity_leave_the_square_on_the_side_away_from_the_sites() -> None:
    sites = np.array([(0.0, 0.0), (4.0, 0.0), (1.0, 3.0)])
    diagram = voronoi_arrays(sites)
    segments, rows = canvas.diagram_segments(diagram, sites, 50.0)
    for (ax, ay, bx, by), row in zip(segments, rows, strict=True):
        left, right, start, _ = diagram.edges[row]
        far = np.array((ax, ay) if start < 0 else (bx, by))
        own = np.linalg.norm(sites[left] - far)
        assert own == pytest.approx(np.linalg.norm(sites[right] - far))
        assert own == pytest.approx(np.linalg.norm(sites - far, axis=1).min())


def test_lines_are_cut_at_the_frame() -> None:
    box = Bounds(0.0, 0.0, 10.0, 10.0)
    lines = np.array([(-5.0, 5.0, 15.0, 5.0), (2.0, 2.0, 3.0, 3.0), (-1.0, -9.0, -1.0, 20.0)])
    kept = canvas.clip(lines, box)
    assert kept.tolist() == [[0.0, 5.0, 10.0, 5.0], [2.0, 2.0, 3.0, 3.0]]


def test_valid_edges_lie_between_different_objects_in_free_space() -> None:
    scene = inputs.drawn_objects()
    roadmap = diagrams.approximate(scene)
    agvd = roadmap.agvd
    used = agvd.ordinary.edges[agvd.valid]
    owner = agvd.generators.owner
    assert 50 < len(used) < len(agvd.ordinary.edges)
    assert (owner[used[:, 0]] != owner[used[:, 1]]).all()
    assert (roadmap.clearance(agvd.ordinary.vertices[used[:, 2:].ravel()]) > 0.0).all()


def test_the_arena_is_reduced_as_in_the_paper(picture: inputs.Picture) -> None:
    paper, default = arena.reduce(picture)
    assert abs(picture.border_pixels - inputs.PAPER_BORDER_PIXELS) <= 5
    assert arena.kinds(vision.extract(picture.image)) == (4, 2, 1)
    assert len(vision.extract(picture.image, mode="paper").objects) == 7
    assert abs(paper.generators - inputs.PAPER_GENERATORS) <= 3
    assert 40 <= paper.vertices <= 80
    assert 0.08 < paper.share < 0.09
    assert default.vertices < paper.vertices
    assert default.share < paper.share


@pytest.mark.parametrize("wanted", [row[0] for row in timing.PAPER_TABLE])
def test_pictures_of_table_1_have_the_border_pixels_asked_for(wanted: int) -> None:
    assert abs(inputs.crowd_picture(wanted).border_pixels - wanted) <= 3


def test_table_1_counts_what_the_paper_counts() -> None:
    row = timing.measure(763, 22.3, runs=3)
    assert 0.04 < row.generators / row.border_pixels < 0.11
    assert row.reduced_diagram_ms < row.full_diagram_ms
    assert row.full_chain_ms >= row.seeing_ms
    assert row.reduced_chain_ms >= row.corners_ms + row.reduced_diagram_ms
    assert row.eigenvalues_ms > 0.0


def test_the_papers_table_is_not_linear_and_its_38_percent_is_a_ratio_of_slopes() -> None:
    full, reduced = timing.paper_fits()
    assert full.exponent > 1.7
    assert reduced.exponent > 1.5
    assert full.intercept < -5000.0
    assert reduced.slope / full.slope == pytest.approx(timing.SAID_GAIN, abs=0.01)


def test_a_fit_finds_the_line_and_the_power() -> None:
    line = timing.fit([1.0, 2.0, 4.0], [5.0, 7.0, 11.0])
    assert (line.slope, line.intercept) == pytest.approx((2.0, 3.0))
    assert timing.fit([1.0, 2.0, 4.0], [3.0, 12.0, 48.0]).exponent == pytest.approx(2.0)


def test_the_threshold_lies_on_the_floor_of_digital_lines() -> None:
    assert 0.100 < weaknesses.line_floor() < 0.106
    assert weaknesses.corner_value(90.0) > 20.0 * weaknesses.line_floor()
    assert weaknesses.corner_value(180.0) == pytest.approx(0.0, abs=1e-12)
    for noise in (0.0, 20.0):
        paper, ours = (weaknesses.corners(noise, mode, 24) for mode in weaknesses.MODES)
        assert paper.missed == ours.missed == 0
        assert paper.false > 5 * max(ours.false, 1)
        assert paper.rms_px > 5.0 * ours.rms_px


def test_sauers_equation_needs_both_axes_and_noise_breaks_it() -> None:
    assert weaknesses.literal_discs(12.0).circles == 0
    calm, noisy = (weaknesses.circles(30.0, noise, "paper") for noise in (0.0, 20.0))
    assert calm.circles == calm.shown
    assert noisy.circles < 0.8 * noisy.shown
    ours = weaknesses.circles(30.0, 20.0, "exact")
    assert ours.circles == ours.shown
    assert ours.radius_error_px < 0.15 < calm.radius_error_px


def test_the_eigenvalue_ratio_does_not_tell_circles() -> None:
    ratios = {k: weaknesses.eigenvalue_ratio(v) for k, v in weaknesses.ratio_shapes().items()}
    assert abs(ratios["square"] - ratios["circle"]) < 0.02
    assert min(ratios["square"], ratios["triangle"]) > 0.95


@pytest.mark.parametrize("radius", [12.0, 20.0])
def test_arcs_of_the_papers_mode_cut_into_the_obstacle(radius: float) -> None:
    assert weaknesses.protrusion(radius, "paper") > 1.5
    assert weaknesses.protrusion(radius, "exact") < 0.25


def test_sampled_clearance_is_unsafe_and_exact_clearance_is_not() -> None:
    near = guarantees.clearances(1.9, range(6))
    assert near.sampled < 0.6
    assert near.exact >= 1.0 - 1e-9
    assert guarantees.clearances(0.5, range(6)).sampled > near.sampled


def test_the_bisector_error_falls_with_the_square_of_delta_and_is_none_by_default() -> None:
    coarse, fine = (guarantees.bisector_error(d, "paper", range(4)) for d in (4.0, 1.0))
    assert 1.5 < math.log(coarse.high / fine.high, 4.0) < 2.5
    exact = guarantees.bisector_error(4.0, "exact", range(4))
    assert exact.high < 1e-8
    assert exact.off < 0.01


def test_the_default_mode_plans_what_whole_objects_as_owners_lose() -> None:
    named = hand_made()
    scenes = [named[name] for name in ("U", "room of one wall", "comb", "bay", "wall to wall")]
    paper, exact = (guarantees.completeness(mode, scenes, 6) for mode in weaknesses.MODES)
    assert paper.joined == exact.joined > 10
    assert exact.planned == exact.joined > paper.planned
    assert paper.invented == exact.invented == 0
    assert exact.least_clearance >= 1.0 - 1e-6


@pytest.mark.parametrize("place", NAMED)
def test_every_claim_names_code_and_tests_that_exist(place: str) -> None:
    constants = {name: getattr(claims, name) for name in re.findall(r"\{(\w+)\}", place)}
    path, name = place.format(**constants).split("::")
    if name.startswith("test_"):
        assert re.search(rf"^def {name}\(", (TOP / path).read_text(), flags=re.MULTILINE)
    else:
        module = importlib.import_module(path.removesuffix(".py").replace("/", "."))
        assert hasattr(module, name)


def test_there_are_claims_to_check() -> None:
    assert len(NAMED) >= 36


def test_the_faults_are_summed_up(tmp_path: Path) -> None:
    file = tmp_path / "faults.md"
    file.write_text(
        "# Faults\n\n| fault | robot | runs | passed | what happened |\n|---|---|---|---|---|\n"
        "| none | Python | 20 | 20 | 20 x executed |\n"
        "| none | C | 5 | 4 | 3 x executed; 2 x stopped, then executed |\n"
    )
    text = "\n".join(page.faults_summary(file))
    assert "1 kinds of fault, 25 runs, 24 passed" in text
    assert "| executed | 23 |" in text
    assert "| stopped, then executed | 2 |" in text
    assert not list(page.faults_summary(tmp_path / "absent.md"))


def test_the_committed_page_is_whole_and_small() -> None:
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    links = [link for link in re.findall(r"\]\(([^)#]+)\)", text) if "://" not in link]
    assert len(links) > 30
    for link in links:
        assert (FOLDER / link).resolve().exists(), link
    for number in range(1, 8):
        svg = (FOLDER / f"figure-{number}.svg").read_text(encoding="utf-8")
        assert ElementTree.fromstring(svg).tag.endswith("svg")
        assert f"figure-{number}.svg" in text
    assert sum(file.stat().st_size for file in FOLDER.iterdir()) < 400 * 1024


def test_figures_come_out_the_same_each_time(picture: inputs.Picture) -> None:
    for draw in (insertion.figure_1, insertion.figure_2, diagrams.figure_3, diagrams.figure_4):
        assert draw() == draw()
    again = inputs.arena_picture()
    assert np.array_equal(again.image, picture.image)
    assert arena.figure_5(picture, 22.3) == arena.figure_5(again, 22.3)


def test_the_walk_agrees_on_the_page() -> None:
    assert measured.walk_agrees()
