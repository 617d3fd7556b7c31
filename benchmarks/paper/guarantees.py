"""What a robot can rely on: clearance, bisectors and completeness, the paper's way and by default.

The scenes are those of the planner's own tests, hand-made ones that go wrong easily and random
ones from seeds; the judges are slow distances that share no code with the planner.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree

import planner
from benchmarks.paper import canvas, charts
from benchmarks.paper.weaknesses import MODES, Mode
from planner.path import Path
from planner.roadmap.roadmap import Roadmap
from planner.scene import Scene, primitive_kernels
from tests.support.scenes.planner_scenes import hand_made, random_scene, slow_distance, slow_inside

Points = NDArray[np.float64]
RADIUS = 4.0
GRID_PX = 1.0


@dataclass(frozen=True, slots=True)
class Clearances:
    """Over all places that a robot of radius 1 is told it fits: the least exact clearance, in
    radii, when clearance is the distance to the generators (``sampled``), when it is that to
    the borders (``exact``), and what the formula sqrt(1 - (delta / 2)^2) allows."""

    spacing: float
    sampled: float
    exact: float
    allowed: float


@dataclass(frozen=True, slots=True)
class BisectorError:
    """How unequal the distances to the two sides are along the diagrams, in px; ``off`` is
    the share of places where they differ by more than 1e-6 px."""

    spacing: float
    mode: Mode
    median: float
    high: float
    worst: float
    off: float
    places: int


@dataclass(frozen=True, slots=True)
class Completeness:
    """Pairs of places: ``joined`` ones that surely have a path and how many of them were
    planned, ``apart`` ones that surely have none and how many got a path all the same."""

    mode: Mode
    scenes: int
    joined: int
    planned: int
    apart: int
    invented: int
    least_clearance: float


def clearances(per_radius: float, seeds: Sequence[int] = range(20)) -> Clearances:
    """At ``spacing = per_radius * radius`` over random scenes."""
    spacing = per_radius * RADIUS
    sampled, exact = math.inf, math.inf
    for seed in seeds:
        scene = random_scene(np.random.default_rng(seed))
        rough = planner.build_roadmap(scene, RADIUS, spacing=spacing, mode="paper")
        points = _dense_chains(rough)
        told, _ = cKDTree(rough.agvd.generators.sites).query(points)
        fits = told >= RADIUS
        if fits.any():
            sampled = min(sampled, float(slow_distance(scene, points[fits]).min()))
        fine = planner.build_roadmap(scene, RADIUS, spacing=spacing)
        edges = [np.asarray(d["polyline"]) for _, _, d in fine.graph.edges(data=True)]
        if edges:
            exact = min(exact, float(slow_distance(scene, np.concatenate(edges)).min()))
    allowed = math.sqrt(max(0.0, 1.0 - 0.25 * per_radius**2))
    return Clearances(per_radius, sampled / RADIUS, exact / RADIUS, allowed)


def bisector_error(spacing: float, mode: Mode, seeds: Sequence[int] = range(12)) -> BisectorError:
    """At every point of every chain a robot of radius ``RADIUS`` can use."""
    errors = []
    for seed in seeds:
        scene = random_scene(np.random.default_rng(seed))
        radius = max(RADIUS, 0.5 * spacing + 1e-6)
        roadmap = planner.build_roadmap(scene, radius, spacing=spacing, mode=mode)
        errors.append(_side_differences(roadmap))
    every = np.concatenate(errors)
    return BisectorError(
        spacing,
        mode,
        float(np.median(every)),
        float(np.quantile(every, 0.95)),
        float(every.max()),
        float(np.mean(every > 1e-6)),
        len(every),
    )


def _side_differences(roadmap: Roadmap) -> Points:
    """|distance to the left piece - distance to the right piece| at the chains' links."""
    chains, borders = roadmap.chains, roadmap.borders
    out = []
    for c in range(len(chains)):
        for i in range(int(chains.first[c]), int(chains.first[c + 1]) - 1):
            left, right = chains.pieces[i].tolist()
            if left < 0 or right < 0 or chains.gap[i] < roadmap.radius:
                continue
            for x, y in (chains.points[i], chains.points[i + 1]):
                one, other = (
                    primitive_kernels.distance(borders.kind, borders.data, piece, x, y)
                    for piece in (left, right)
                )
                out.append(abs(one - other))
    return np.array(out)


def scenes_to_judge(random: int = 25) -> list[Scene]:
    """The hand-made scenes and so many random ones."""
    rngs = (np.random.default_rng(seed) for seed in range(random))
    return [*hand_made().values(), *(random_scene(rng) for rng in rngs)]


def completeness(mode: Mode, scenes: Sequence[Scene], pairs: int = 8) -> Completeness:
    """Paths against connected cells of a grid with enough distance: surely with a pixel more,
    surely not with a pixel less."""
    rng = np.random.default_rng(1)
    counts = np.zeros(4, np.int64)
    least = math.inf
    for scene in scenes:
        places, sure, maybe, standing = _regions(scene)
        if len(standing) < 2:
            continue
        roadmap = planner.build_roadmap(scene, RADIUS, mode=mode)
        for i, j in rng.choice(standing, (pairs, 2)):
            one, two = sure[i] == sure[j] and sure[i] > 0, maybe[i] != maybe[j]
            if not (one or two):
                continue
            answer = roadmap.plan(places[i], places[j])
            found = isinstance(answer, Path)
            counts += (one, one and found, two, two and found)
            if isinstance(answer, Path):
                least = min(least, float(slow_distance(scene, _dense(answer.points)).min()))
    joined, planned, apart, invented = (int(n) for n in counts)
    return Completeness(mode, len(scenes), joined, planned, apart, invented, least / RADIUS)


def _regions(
    scene: Scene,
) -> tuple[Points, NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Places on a grid, their regions at radius + 1 and at radius - 1, and where one can stand."""
    b = scene.bounds
    xs, ys = np.meshgrid(
        np.arange(math.ceil(b.x_min), b.x_max, GRID_PX),
        np.arange(math.ceil(b.y_min), b.y_max, GRID_PX),
    )
    places = np.stack([xs.ravel(), ys.ravel()], axis=1)
    distance = slow_distance(scene, places)
    distance[slow_inside(scene, places)] *= -1.0
    field = distance.reshape(xs.shape)
    four = ndimage.generate_binary_structure(2, 1)
    sure = ndimage.label(field >= RADIUS + 1.0, structure=four)[0].ravel()
    maybe = ndimage.label(field >= RADIUS - 1.0, structure=np.ones((3, 3)))[0].ravel()
    return places, sure, maybe, np.flatnonzero(distance >= RADIUS + 1e-6)


def _dense_chains(roadmap: Roadmap) -> Points:
    chains = roadmap.chains
    lines = [chains.points[chains.first[c] : chains.first[c + 1]] for c in range(len(chains))]
    return np.concatenate([_dense(line) for line in lines])


def _dense(line: Points, parts: int = 9) -> Points:
    t = np.linspace(0.0, 1.0, parts)[:, None]
    pieces = [a + t * (b - a) for a, b in itertools.pairwise(line)]
    return np.concatenate([*pieces, line[-1:]])


def figure_7(errors: Sequence[BisectorError]) -> str:
    """Bisector error against delta, the paper's way and by default."""
    page = canvas.Page(400.0, 400.0, "Figure 7")
    chart = charts.Chart(page, 80.0, 44.0, "How far off the bisector", "delta, px", "px")
    floor = 1e-13
    chart.logarithmic(
        [
            ([(e.spacing, max(e.high, floor)) for e in errors if e.mode == mode], colour)
            for mode, colour in zip(MODES, (canvas.REDUCED, canvas.DEFAULT), strict=True)
        ]
    )
    charts.key(
        page, 376.0, (80.0, canvas.REDUCED, "sampled"), (200.0, canvas.DEFAULT, "default, exact")
    )
    return page.svg()
