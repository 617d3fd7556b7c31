"""The roadmap judged: is it complete, is it exact, and what does a change of the scene cost?

    python benchmarks/roadmap.py [--scenes 2000] [--output benchmarks/results/roadmap.md]

Completeness: random and hand-made scenes whose objects may touch, cross, nest and leave the
bounds. Between two places a path must be found where a grid of distances (scipy, one pixel) joins
them at the radius + 1 px, and none where it does not at the radius - 1 px; every path's distance
to the borders is measured on points of its own. Exactness: how far vertices and places on edges
are from being equally far from both of their pieces, and their clearance from the distance that
numpy alone computes, in parts of the scene's size. Size: one plate with ever more holes in it, and
every cell of a grid an obstacle as a coin falls. Change: 60 objects, one of them moved, taken
out or put in, against building anew, in turn; processor time, medians of the paired ratios.
"""

from __future__ import annotations

import argparse
import itertools
import platform
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

import planner
from planner.formats.grid_maps import grid_scene
from planner.path import Path as PlannedPath
from planner.scene import Bounds, FloatArray, Scene, SceneObject, primitive_kernels
from tests.support.scenes.mazes import noise, plate
from tests.support.scenes.planner_scenes import (
    hand_made,
    polygon,
    random_scene,
    scene_of,
    slow_distance,
    slow_inside,
)

SPACINGS = (0.5, 1.0, 1.5, 1.9)
"""In robot radii; the method allows less than 2."""
PAIRS = 6


@dataclass(slots=True)
class Tally:
    """What the completeness campaign counted."""

    scenes: int = 0
    pairs: int = 0
    paths: int = 0
    missed: int = 0
    invented: int = 0
    least: float = np.inf


def campaign(count: int) -> Tally:
    """Plan in ``count`` scenes, hand-made ones first, and compare with the grid's answer."""
    tally = Tally()
    named = list(hand_made().values())
    for seed in range(count):
        rng = np.random.default_rng(seed)
        scene = named[seed] if seed < len(named) else random_scene(rng)
        judge(scene, float(rng.uniform(1.5, 10.0)), rng, tally)
        tally.scenes += 1
        if seed % 100 == 99:
            print(f"{tally}", file=sys.stderr)
    return tally


def judge(scene: Scene, radius: float, rng: np.random.Generator, tally: Tally) -> None:
    from scipy import ndimage

    b = scene.bounds
    xs, ys = np.meshgrid(np.arange(np.ceil(b.x_min), b.x_max), np.arange(np.ceil(b.y_min), b.y_max))
    places = np.c_[xs.ravel(), ys.ravel()]
    distance = slow_distance(scene, places)
    distance[slow_inside(scene, places)] *= -1.0
    grid = distance.reshape(xs.shape)
    four = ndimage.generate_binary_structure(2, 1)
    sure = ndimage.label(grid >= radius + 1.0, structure=four)[0].ravel()
    maybe = ndimage.label(grid >= radius - 1.0, structure=np.ones((3, 3)))[0].ravel()
    standing = np.flatnonzero(distance >= radius + 1e-6)
    if len(standing) < 2:
        return
    roadmap = planner.build_roadmap(scene, radius)
    for i, j in rng.choice(standing, (PAIRS, 2)):
        answer = roadmap.plan(places[i], places[j])
        tally.pairs += 1
        if isinstance(answer, PlannedPath):
            tally.paths += 1
            tally.invented += int(maybe[i] != maybe[j])
            tally.least = min(
                tally.least, slow_distance(scene, _dense(answer.points)).min() / radius
            )
        else:
            tally.missed += int(sure[i] == sure[j] and sure[i] != 0)


def _dense(points: FloatArray) -> FloatArray:
    t = np.linspace(0.0, 1.0, 7)[:, None]
    return np.concatenate([a + t * (b - a) for a, b in itertools.pairwise(points)])


def exactness(spacing: float, seeds: range) -> tuple[float, float, float, float]:
    """Worst bisector and clearance error, and the shares of wide links and vertices proved."""
    worst_side, worst_clearance = 0.0, 0.0
    proved = wide = vertices_proved = vertices = 0
    for seed in seeds:
        rng = np.random.default_rng(seed)
        scene = random_scene(rng)
        radius = float(rng.uniform(2.0, 8.0))
        roadmap = planner.build_roadmap(scene, radius, spacing=spacing * radius)
        chains, borders = roadmap.chains, roadmap.borders
        size = borders.extent
        links = np.flatnonzero(chains.proved)
        for i in links:
            for p, side in itertools.product((i, i + 1), chains.pieces[i].tolist()):
                d = primitive_kernels.distance(borders.kind, borders.data, side, *chains.points[p])
                worst_side = max(worst_side, abs(d - chains.rho[p]) / size)
        apart = np.abs(slow_distance(scene, chains.points) - chains.rho)
        worst_clearance = max(worst_clearance, float(apart.max(initial=0.0)) / size)
        usable = (chains.gap >= radius) & (chains.pieces[:, 0] >= 0)
        proved += int((usable & chains.proved).sum())
        wide += int(usable.sum())
        some, every = roadmap.agvd.vertices_proved(radius)
        vertices_proved, vertices = vertices_proved + some, vertices + every
    return worst_side, worst_clearance, proved / wide, vertices_proved / vertices


def sixty_objects(rng: np.random.Generator) -> list[SceneObject]:
    """Convex polygons on a grid over 1920 x 1080, 60 of them and one to spare."""
    objects = []
    for n in range(61):
        x, y = 100.0 + 172.0 * (n % 11), 90.0 + 180.0 * (n // 11)
        size, k = float(rng.uniform(25.0, 60.0)), int(rng.integers(3, 9))
        a = (np.arange(k) + rng.uniform(-0.3, 0.3, k)) * 2.0 * np.pi / k
        x, y = x + rng.uniform(-15.0, 15.0), y + rng.uniform(-15.0, 15.0)
        corners = zip((x + size * np.cos(a)).tolist(), (y + size * np.sin(a)).tolist(), strict=True)
        objects.append(SceneObject(n, (polygon(list(corners)),)))
    return objects


def change(rounds: int) -> dict[str, tuple[float, float, float]]:
    """Milliseconds of building anew, of updating, and their ratio, for every kind of change."""
    bounds = Bounds(-0.5, -0.5, 1919.5, 1079.5)
    kinds: dict[str, Callable[[list[SceneObject]], list[SceneObject]]] = {
        "moved": lambda o: [*o[:30], o[60], *o[31:60]],
        "taken out": lambda o: [*o[:30], *o[31:60]],
        "put in": lambda o: o,
    }
    out = {}
    for name, changed in kinds.items():
        anew, updated = [], []
        for seed in range(rounds + 1):
            objects = sixty_objects(np.random.default_rng(seed))
            before = scene_of(*objects[:60], bounds=bounds)
            roadmap = planner.build_roadmap(before, 6.0)
            scene = replace(before, objects=tuple(changed(objects)))
            begun = time.thread_time()
            planner.build_roadmap(scene, 6.0)
            middle = time.thread_time()
            roadmap.updated(scene)
            ended = time.thread_time()
            if seed:  # the first one compiles
                anew.append(1e3 * (middle - begun))
                updated.append(1e3 * (ended - middle))
        ratio = statistics.median(a / u for a, u in zip(anew, updated, strict=True))
        out[name] = statistics.median(anew), statistics.median(updated), ratio
    return out


def sizes() -> list[str]:
    """Seconds of building the roadmap, and with which power of the primitives they grow."""
    rows = ["| obstacles | primitives | roadmap, s | power |", "|---|---|---|---|"]
    before: tuple[int, float] | None = None
    grids = [(f"plate, {n} x {n} holes", plate(n)) for n in (40, 70, 100, 140)]
    grids += [(f"coins, {n} x {n}", noise(n, np.random.default_rng(n))) for n in (250, 500)]
    for name, grid in grids:
        scene = grid_scene(grid)
        count = len(scene.primitives().kind)
        begun = time.thread_time()
        planner.build_roadmap(scene, 0.4)
        took = time.thread_time() - begun
        power = "-"
        if before is not None and before[0] < count:
            power = f"{np.log(took / before[1]) / np.log(count / before[0]):.2f}"
        rows.append(f"| {name} | {count} | {took:.3f} | {power} |")
        before = count, took
    return rows


def report(scenes: int, rounds: int) -> str:
    lines = [
        "# The roadmap judged",
        "",
        "`python benchmarks/roadmap.py`; what is measured and how, its docstring says. "
        f"Python {platform.python_version()}, {platform.machine()}.",
        "",
        "## One of 60 objects changes (1920 x 1080, radius 6)",
        "",
        "| change | anew, ms | updated, ms | times faster |",
        "|---|---|---|---|",
    ]
    for name, (anew, updated, ratio) in change(rounds).items():
        lines.append(f"| {name} | {anew:.2f} | {updated:.2f} | {ratio:.1f} |")
    lines += ["", "## Size", "", *sizes()]
    lines += ["", "## Exactness, in parts of the scene's size", ""]
    lines.append(
        "| spacing, radii | bisectors, worst | clearances, worst | wide links proved "
        "| wide vertices proved |"
    )
    lines.append("|---|---|---|---|---|")
    for spacing in SPACINGS:
        side, clearance, links, vertices = exactness(spacing, range(60))
        lines.append(
            f"| {spacing} | {side:.1e} | {clearance:.1e} | {100 * links:.1f} % "
            f"| {100 * vertices:.1f} % |"
        )
    if scenes:
        t = campaign(scenes)
        lines += ["", "## Completeness", ""]
        lines.append("| scenes | pairs | paths | missed | invented | least clearance / radius |")
        lines.append("|---|---|---|---|---|---|")
        lines.append(
            f"| {t.scenes} | {t.pairs} | {t.paths} | {t.missed} | {t.invented} | {t.least:.6f} |"
        )
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scenes", type=int, default=2000, help="of the completeness campaign")
    parser.add_argument("--rounds", type=int, default=40, help="of every kind of change")
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    text = report(options.scenes, options.rounds)
    print(text)
    if options.output:
        options.output.write_text(text)


if __name__ == "__main__":
    main()
