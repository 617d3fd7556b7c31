"""Routes, tours and refusals: how short, how soon, how sure.

    python benchmarks/routes.py [--scenes 200] [--output benchmarks/results/routes.md]

- Length: `prefer="length"` against the visibility graph of the borders moved outwards (the tests'
  slow oracle), over random scenes in which obstacles touch and cross, and against what a user
  would write today: scikit-image's least-cost path over the pixels the disc can stand on.
- Time: one plan at every preference, by the number of obstacles, the roadmap being built.
- Work: what the search for the shortest path tried of its budget, and what the whole budget takes.
- Mazes: a path, its smoothing and its timing by its length, which is in cells.
- Tours: the exact order of 15 stations; the heuristic against it, and above 15 against the bound
  of Held and Karp (1970) by minimum 1-trees.
- Refusals: the widest robot against bisection over the oracle, and the time that it takes.

Times are of the processor, the least of several; ratios are within one run.
"""

from __future__ import annotations

import argparse
import math
import platform
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

import planner
from planner.borders.generators import JOINT
from planner.formats.grid_maps import grid_scene
from planner.motion.smooth import smooth_path
from planner.motion.trajectory import default_limits, time_path
from planner.scene import Bounds, CircleRecord, FloatArray, Record, Scene
from planner.search import tangent_kernels, tangent_search, tour
from planner.search.tangent_search import shortest_way
from tests.support.oracles.visibility_oracle import shortest_length
from tests.support.scenes.mazes import maze
from tests.support.scenes.planner_scenes import (
    polygon,
    random_scene,
    scene_of,
    slow_distance,
    slow_inside,
)

RADIUS = 9.0
FRAMES = [(640, 480, 20), (1920, 1080, 60), (3840, 2160, 200), (3840, 2160, 1000)]
Table = list[list[str]]
Vec = tuple[float, float]


def least_ms(work: Callable[[], Any], rounds: int = 5) -> float:
    times = []
    for _ in range(rounds):
        begin_s = time.process_time()
        work()
        times.append(1e3 * (time.process_time() - begin_s))
    return min(times)


def crowd(width: int, height: int, count: int, rng: np.random.Generator) -> Scene:
    """Polygons and circles anywhere: many touch or cross."""
    size = 0.35 * math.sqrt(width * height / count)
    made: list[Record] = []
    for _ in range(count):
        x, y = float(rng.uniform(0, width)), float(rng.uniform(0, height))
        reach = float(rng.uniform(0.3, 1.0)) * size
        if rng.random() < 0.3:
            made.append(CircleRecord((x, y), reach))
            continue
        k = int(rng.integers(3, 9))
        a = np.sort(rng.uniform(0, math.tau, k))
        r = reach * rng.uniform(0.3, 1.0, k)
        corners = zip((x + r * np.cos(a)).tolist(), (y + r * np.sin(a)).tolist(), strict=True)
        made.append(polygon(list(corners)))
    return scene_of(*made, bounds=Bounds(-0.5, -0.5, width - 0.5, height - 0.5))


def stations(roadmap: planner.Roadmap, scene: Scene, need: float, seed: int) -> list[Vec]:
    """Places where the disc can stand, far apart first."""
    rng = np.random.default_rng(seed)
    b = scene.bounds
    places = rng.uniform([b.x_min, b.y_min], [b.x_max, b.y_max], (600, 2))
    places = places[roadmap.clearance(places) >= need]
    return [(float(x), float(y)) for x, y in places]


def length_of(way: FloatArray) -> float:
    return float(np.hypot(*np.diff(way, axis=0).T).sum())


def over_pixels(scene: Scene, radius: float, start: Vec, goal: Vec) -> Callable[[], float] | None:
    """The length of scikit-image's least-cost path, from a picture of where the disc can stand."""
    try:
        from skimage.graph import MCP_Geometric
    except ImportError:
        return None
    b = scene.bounds
    xs, ys = np.meshgrid(np.arange(0, math.floor(b.x_max)), np.arange(0, math.floor(b.y_max)))
    cells = np.c_[xs.ravel(), ys.ravel()].astype(float)
    free = (slow_distance(scene, cells) >= radius) & ~slow_inside(scene, cells)
    cost = np.where(free, 1.0, -1.0).reshape(xs.shape)
    here, there = ((min(round(y), len(cost) - 1), round(x)) for x, y in (start, goal))

    def search() -> float:
        grid = MCP_Geometric(cost)
        costs, _ = grid.find_costs([here], [there])
        return float(costs[there])

    return search


def lengths(scenes: int) -> Table:
    """Ours, and the pixels', over the oracle's."""
    ours, theirs, times, missed = [], [], [], 0
    for seed in range(scenes):
        rng = np.random.default_rng(seed + 50_000)
        scene, radius = random_scene(rng), float(rng.uniform(1.5, 8.0))
        roadmap = planner.build_roadmap(scene, radius)
        start, goal = (stations(roadmap, scene, radius, seed) + [(0.0, 0.0)] * 2)[:2]
        best = shortest_length(scene, radius, start, goal)
        path = roadmap.plan(start, goal, prefer="length")
        if isinstance(path, planner.NoPath):
            missed += math.isfinite(best) and "nearer" not in path.reason
            continue
        ours.append(path.length / best)
        search = over_pixels(scene, radius, start, goal)
        if search is not None and math.isfinite(pixels := search()) and best > 20.0:
            theirs.append(pixels / best)
            plan_ms = least_ms(lambda r=roadmap, s=start, g=goal: r.plan(s, g, prefer="length"))
            times.append(least_ms(search) / max(plan_ms, 1e-3))
    rows = [["way", "scenes", "median", "99 %", "most", "beyond 2 %", "time over ours"]]
    for name, found, ratio in (
        ("Clearway, `length`", ours, "1"),
        ("pixels, scikit-image", theirs, f"{np.median(times):.0f}" if times else "-"),
    ):
        if found:
            a = np.array(found)
            rows.append(
                [name, f"{len(a)}", f"{np.median(a):.5f}", f"{np.quantile(a, 0.99):.5f}",
                 f"{a.max():.5f}", f"{(a > 1.02).sum()}", ratio]
            )  # fmt: skip
    rows.append(["missed or invented ways", f"{missed}", *[""] * 5])
    return rows


def plan_times() -> Table:
    rows = [["picture", "objects", "length ms", "balanced ms", "clearance ms", "share of budget"]]
    for width, height, count in FRAMES:
        scene = crowd(width, height, count, np.random.default_rng(count))
        roadmap = planner.build_roadmap(scene, RADIUS)
        places = stations(roadmap, scene, RADIUS, 1)
        pairs = [(a, b) for a, b in zip(places[::2], places[1::2], strict=False)][:60]
        pairs = [p for p in pairs if isinstance(roadmap.plan(*p), planner.Path)][:12]
        cells = [f"{width}x{height}", f"{count}"]
        for prefer in ("length", "balanced", "clearance"):
            ms = [least_ms(lambda p=p, w=prefer, r=roadmap: r.plan(*p, prefer=w), 3) for p in pairs]
            cells.append(f"{np.median(ms):.2f} ({max(ms):.2f})")
        shares = [work_of(roadmap, *p) / tangent_search.BUDGET for p in pairs]
        rows.append([*cells, f"{max(shares):.3f}"])
    return rows


def work_of(roadmap: planner.Roadmap, start: Vec, goal: Vec) -> int:
    """Tangents tried where nothing is known but the scene: the most a search can ask for."""
    borders = roadmap.borders
    k = borders.primitive_count
    ends = np.array([start, goal])
    discs = tangent_kernels.discs_around(
        borders.kind[:k], borders.data[:k], RADIUS, JOINT * borders.extent, *ends, math.inf
    )
    found = tangent_kernels.shortest(
        borders.tree, discs, RADIUS * (1 - 1e-9), math.inf, tangent_search.BUDGET
    )
    return int(found[3])


def whole_budget() -> Table:
    """A goal behind a wall among so many obstacles that the search does not end by itself."""
    rng = np.random.default_rng(7)
    crowded = crowd(4000, 4000, 3000, rng)
    wall = polygon([(1990.0, -10.0), (2010.0, -10.0), (2010.0, 4010.0), (1990.0, 4010.0)])
    scene = scene_of(*(o.records[0] for o in crowded.objects), wall, bounds=crowded.bounds)
    roadmap = planner.build_roadmap(scene, RADIUS)
    places = stations(roadmap, scene, RADIUS, 2)
    start = next(p for p in places if p[0] < 1000.0)
    goal = next(p for p in places if p[0] > 3000.0)
    ms = least_ms(lambda: shortest_way(roadmap.borders, start, goal, RADIUS), 2)
    certain = shortest_way(roadmap.borders, start, goal, RADIUS).certain
    return [
        ["pieces", "budget", "ms", "gave up"],
        [f"{roadmap.borders.primitive_count}", f"{tangent_search.BUDGET:.0e}", f"{ms:.0f}",
         "no" if certain else "yes"],
    ]  # fmt: skip


def mazes(sides: tuple[int, ...] = (101, 201, 301)) -> Table:
    """Seconds of each step, and with which power of the length smoothing and timing grow."""
    rows = [["maze", "length", "plan s", "smooth s", "time s", "all s", "power"]]
    before: tuple[float, float] | None = None
    for side in sides:
        roadmap = planner.build_roadmap(grid_scene(maze(side, np.random.default_rng(1))), 0.3)
        ends = (1.0, 1.0), (side - 2.0, side - 2.0)
        path = roadmap.plan(*ends)
        assert isinstance(path, planner.Path)
        look = roadmap.path_clearance, roadmap.clearance
        smooth = smooth_path(path, *look, keep=0.3)
        steps: list[Callable[[], Any]] = [
            lambda r=roadmap, e=ends: r.plan(*e),
            lambda p=path, k=look: smooth_path(p, *k, keep=0.3),
            lambda p=smooth, k=look: time_path(p, default_limits(0.3), clearance=k[1]),
        ]
        took = [least_ms(step, 3) / 1e3 for step in steps]
        last = took[1] + took[2]
        power = "-"
        if before is not None:
            power = f"{math.log(last / before[1]) / math.log(path.length / before[0]):.2f}"
        before = path.length, last
        cells = [f"{t:.3f}" for t in (*took, sum(took))]
        rows.append([f"{side}x{side}", f"{path.length:.0f}", *cells, power])
    return rows


def one_tree_bound(distance: FloatArray, rounds: int = 400) -> float:
    """Held and Karp's lower bound of a closed tour: minimum 1-trees under node prices."""
    n = len(distance)
    price, best, step = np.zeros(n), -math.inf, 0.1 * float(distance.mean())
    for _ in range(rounds):
        d = distance + price[:, None] + price[None]
        inside = np.zeros(n, bool)
        inside[[0, 1]] = True
        near, parent = d[1].copy(), np.full(n, 1)
        degree, total = np.zeros(n), -2.0 * price.sum()
        for _ in range(n - 2):
            k = int(np.argmin(np.where(inside, np.inf, near)))
            inside[k] = True
            total += near[k]
            degree[[k, parent[k]]] += 1
            closer = ~inside & (d[k] < near)
            near[closer], parent[closer] = d[k][closer], k
        ends = np.argsort(d[0] + np.where(np.arange(n) == 0, np.inf, 0.0))[:2]
        total += d[0, ends].sum()
        degree[0] = 2
        degree[ends] += 1
        best = max(best, total)
        price += step * (degree - 2)
        step *= 0.99
    return best


def tours() -> Table:
    rows = [["stations", "orders", "over the exact: median", "most", "order ms", "whole plan ms"]]
    scene = crowd(1920, 1080, 60, np.random.default_rng(60))
    roadmap = planner.build_roadmap(scene, RADIUS)
    places = stations(roadmap, scene, RADIUS, 5)
    hub = places[0]
    places = [p for p in places if isinstance(roadmap.plan(hub, p), planner.Path)]
    for count in (8, 12, 15, 20, 30, 50):
        ratios, order_ms = [], []
        for seed in range(10):
            xy = np.random.default_rng(seed).random((count + 1, 2))
            matrix = np.hypot(*(xy[:, None] - xy[None]).transpose(2, 0, 1))
            order_ms.append(least_ms(lambda m=matrix: round_trip(m), 3))
            exact = count <= tour.EXACT_STATIONS
            known = round_trip(matrix).cost if exact else one_tree_bound(matrix)
            ratios.append(searched(matrix) / known)
        via = places[1 : count + 1]
        goal = places[count + 1]
        whole = least_ms(lambda v=via, g=goal: roadmap.plan(hub, g, via=v, order="best"), 3)
        against = "" if count <= tour.EXACT_STATIONS else " (bound)"
        rows.append(
            [f"{count}", "exact" if not against else "heuristic",
             f"{np.median(ratios):.4f}{against}", f"{max(ratios):.4f}{against}",
             f"{max(order_ms):.1f}", f"{whole:.0f}"]
        )  # fmt: skip
    return rows


def round_trip(matrix: FloatArray) -> tour.Tour:
    """The order of the stations from the first one back to it."""
    there_and_back = [*range(len(matrix)), 0]
    return tour.best_tour(matrix[np.ix_(there_and_back, there_and_back)])


def searched(matrix: FloatArray) -> float:
    """The heuristic's cost, also for as few stations as are exact otherwise."""
    kept, tour.EXACT_STATIONS = tour.EXACT_STATIONS, 0
    try:
        return round_trip(matrix).cost
    finally:
        tour.EXACT_STATIONS = kept


def refusals(scenes: int) -> Table:
    off, over, walled, wrong = [], [], 0, 0
    for seed in range(scenes):
        rng = np.random.default_rng(seed + 80_000)
        scene, radius = random_scene(rng), float(rng.uniform(4.0, 14.0))
        roadmap = planner.build_roadmap(scene, radius)
        places = stations(roadmap, scene, radius, seed)
        pairs = list(zip(places[:16:2], places[1:16:2], strict=False))
        answers = [roadmap.plan(*pair) for pair in pairs]
        refused = [i for i, a in enumerate(answers) if isinstance(a, planner.NoPath)]
        if not refused:
            continue
        places, answer = list(pairs[refused[0]]), answers[refused[0]]
        if answer.widest_radius is None:
            walled += 1
            fits = math.isfinite(shortest_length(scene, radius / 7.9, places[0], places[1]))
            wrong += fits
            continue
        low, high = 0.5 * answer.widest_radius, radius
        for _ in range(12):
            middle = 0.5 * (low + high)
            if math.isfinite(shortest_length(scene, middle, places[0], places[1])):
                low = middle
            else:
                high = middle
        off.append(abs(answer.widest_radius / (0.5 * (low + high)) - 1.0))

        def again(scene: Scene = scene, radius: float = radius, p: list[Vec] = places) -> None:
            planner.build_roadmap(scene, radius).plan(p[0], p[1])

        build = least_ms(lambda s=scene, r=radius: planner.build_roadmap(s, r), 3)
        over.append((least_ms(again, 3) - build) / build)
    return [
        ["refusals", "widest: most off", "walled in", "of those wrong", "time over the build's"],
        [f"{len(off) + walled}", f"{max(off, default=0.0):.2e}", f"{walled}", f"{wrong}",
         f"{np.median(over):.2f}, at most {max(over):.2f}"],
    ]  # fmt: skip


def as_markdown(table: Table) -> str:
    head, *rows = ["| " + " | ".join(row) + " |" for row in table]
    return "\n".join([head, "|" + "---|" * len(table[0]), *rows])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=200)
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results/routes.md"))
    chosen = parser.parse_args()
    parts = [
        ("Length over the shortest", lengths(chosen.scenes)),
        ("One plan, median (most)", plan_times()),
        ("The whole budget of the search for the shortest", whole_budget()),
        ("Mazes", mazes()),
        ("Tours", tours()),
        ("Refusals", refusals(chosen.scenes)),
    ]
    text = "# Routes, tours and refusals\n\n"
    text += f"`python benchmarks/routes.py --scenes {chosen.scenes}`, Python "
    text += f"{platform.python_version()}, {platform.machine()}. Times in ms of the processor.\n"
    for title, table in parts:
        text += f"\n## {title}\n\n{as_markdown(table)}\n"
    print(text)
    chosen.output.parent.mkdir(parents=True, exist_ok=True)
    chosen.output.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
