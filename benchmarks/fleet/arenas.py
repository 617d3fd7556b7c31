"""Several robots among obstacles: random arenas, crossings, new goals, and what company costs.

    python -m benchmarks.fleet.arenas [--arenas 300] [--output benchmarks/results/fleet_arenas.md]

Random arenas are 3 m by 2 m with up to eight round obstacles and 2 to 12 robots of their own radii,
5 to 12 cm, from and to random places. In a crossing of two corridors of one robot's width eight
robots, two queued in each arm, exchange places. A new goal is asked for while eight others drive,
each a random number of waypoints on its path. The loss is the sum of arrivals of six robots in
``configs/arenas/laboratory.txt`` over the sum when each drives alone. Each plan is judged once more
by closed-form closest approaches, and driven in random interleavings of its releases until all are
at their goals. Times are of the processor, in ms.
"""

from __future__ import annotations

import argparse
import math
import random
import statistics
import time
from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

import planner
from planner.fleet.execution import releases
from planner.fleet.motions.track_kernels import least_distance
from planner.scene import Bounds, CircleRecord, PolygonRecord, Scene, SceneObject, Segment

LABORATORY = Path(__file__).parents[2] / "configs/arenas/laboratory.txt"
RADIUS_M = 0.105
"""Of a robot in the laboratory, with its margin (``configs/tour.yaml``)."""
Place = tuple[float, float]


def timed(work: Callable[[], Any]) -> tuple[Any, float]:
    """What the work returned, and its milliseconds of the processor."""
    begin = time.process_time()
    return work(), 1e3 * (time.process_time() - begin)


def least_gap(tracks: Sequence[Any], radii: Sequence[float]) -> float:
    """What is left between the two robots that come nearest."""
    return min(
        (
            least_distance(tracks[i], tracks[j])[0] - radii[i] - radii[j]
            for i in range(len(tracks))
            for j in range(i)
        ),
        default=math.inf,
    )


def driven(plan: planner.FleetPlan, rng: np.random.Generator) -> list[Any] | None:
    """The tracks as driven by releases, each piece as long as chance will; None in a deadlock."""
    passed, begun = [0] * len(plan.tracks), [False] * len(plan.tracks)
    rows = [[(0.0, *track[0, 1:])] for track in plan.tracks]
    now_s = 0.0
    while True:
        allowed = releases(plan, passed)
        can = [i for i, r in enumerate(allowed) if begun[i] or r.row > passed[i]]
        if not can:
            break
        i = int(rng.choice(can))
        now_s += float(rng.uniform(0.1, 5.0))
        rows[i].append((now_s, *plan.tracks[i][passed[i] + begun[i], 1:]))
        passed[i] += begun[i]
        begun[i] = not begun[i]
    at_end = passed == [len(track) - 1 for track in plan.tracks]
    return [np.array(r) for r in rows] if at_end else None


def free_places(
    roadmap: planner.Roadmap, radii: Sequence[float], bounds: Bounds, rng: np.random.Generator
) -> list[Place] | None:
    """A free place for each robot, none of which touch; None where the arena is too full."""
    found: list[Place] = []
    for _ in range(4000):
        x = float(rng.uniform(bounds.x_min, bounds.x_max))
        y = float(rng.uniform(bounds.y_min, bounds.y_max))
        size = radii[len(found)]
        apart = all(
            math.dist((x, y), p) > size + r + 0.01 for p, r in zip(found, radii, strict=False)
        )
        if apart and roadmap.clearance([(x, y)])[0] > 1.05 * size:
            found.append((x, y))
            if len(found) == len(radii):
                return found
    return None


def random_arena(seed: int) -> tuple[planner.Roadmap, list[Place], list[Place], list[float]] | None:
    """A roadmap, starts, goals, radii."""
    rng = np.random.default_rng(seed)
    bounds = Bounds(0.0, 0.0, 3.0, 2.0)
    centres = rng.uniform((0.4, 0.4), (2.6, 1.6), (int(rng.integers(0, 9)), 2)).tolist()
    objects = tuple(
        SceneObject(i, (CircleRecord((x, y), float(rng.uniform(0.05, 0.25))),))
        for i, (x, y) in enumerate(centres)
    )
    radii = rng.uniform(0.05, 0.12, int(rng.integers(2, 13))).tolist()
    roadmap = planner.build_roadmap(Scene("m", bounds, objects), radius=min(radii))
    starts = free_places(roadmap, radii, bounds, rng)
    goals = free_places(roadmap, radii, bounds, rng)
    return None if starts is None or goals is None else (roadmap, starts, goals, radii)


def arenas_row(count: int) -> str:
    """Random arenas: plans, refusals with a proof, neither; times; gaps; deadlocks."""
    planned = proved = open_ = deadlocks = 0
    times, gaps = [], []
    for seed in range(count):
        task = random_arena(seed)
        if task is None:
            continue
        plan, ms = timed(partial(planner.plan_fleet, *task))
        times.append(ms)
        if isinstance(plan, planner.NoFleetPlan):
            proved += plan.proved
            open_ += not plan.proved
            print(f"arena {seed}, {len(task[1])} robots: {plan.reason}", flush=True)
            continue
        planned += 1
        tracks = driven(plan, np.random.default_rng(seed))
        deadlocks += tracks is None
        gaps.append(least_gap(plan.tracks, task[3]))
        gaps.append(least_gap(tracks or plan.tracks, task[3]))
    return (
        f"| random arenas, 2 to 12 robots | {planned} + {proved} of {planned + proved + open_} |"
        f" {statistics.median(times):.0f} / {max(times):.0f} |"
        f" least gap {min(gaps):.1e} m, {deadlocks} deadlocks |"
    )


def crossing(half_m: float, width_m: float) -> Scene:
    """Two corridors that cross in the middle."""
    h = 0.5 * width_m
    corners = [(a, b) for a in (-1, 1) for b in (-1, 1)]
    objects = []
    for i, (a, b) in enumerate(corners):
        x0, x1 = sorted((a * h, a * half_m))
        y0, y1 = sorted((b * h, b * half_m))
        ring = [(x0, y0), (x0, y1), (x1, y1), (x1, y0), (x0, y0)]
        sides = tuple(Segment(p, q) for p, q in pairwise(ring))
        objects.append(SceneObject(i, (PolygonRecord(sides),)))
    return Scene("m", Bounds(-half_m, -half_m, half_m, half_m), tuple(objects))


def crossing_row() -> str:
    """Eight robots in one crossing, in arms of three lengths, exchanged in five orders."""
    times, gaps, loss = [], [], []
    planned = deadlocks = 0
    for half_m in (0.9, 1.2, 1.6):
        roadmap = planner.build_roadmap(crossing(half_m, 0.24), radius=0.1)
        out = (half_m - 0.12, half_m - 0.34)
        arms = ((1, 0), (0, 1), (-1, 0), (0, -1))
        starts = [(a * d, b * d) for a, b in arms for d in out]
        orders = [
            [(-a * d, -b * d) for a, b in arms for d in out],
            [(-a * d, -b * d) for a, b in arms for d in out[::-1]],
            *(random.Random(seed).sample(starts, 8) for seed in range(3)),
        ]
        for goals in orders:
            plan, ms = timed(partial(planner.plan_fleet, roadmap, starts, goals))
            times.append(ms)
            if isinstance(plan, planner.NoFleetPlan):
                print(f"crossing of {half_m}: {plan.reason}", flush=True)
                continue
            planned += 1
            tracks = driven(plan, np.random.default_rng(0))
            deadlocks += tracks is None
            gaps.append(least_gap(tracks or plan.tracks, [0.1] * 8))
            alone = sum(math.dist(a, b) / 0.2 for a, b in zip(starts, goals, strict=True))
            loss.append(plan.flowtime_s / max(alone, 1.0))
    return (
        f"| eight in one narrow crossing | {planned} of {len(times)} |"
        f" {statistics.median(times):.0f} / {max(times):.0f} |"
        f" least gap {min(gaps, default=math.nan):.1e} m, {deadlocks} deadlocks |"
    )


def goals_row(count: int) -> str:
    """A new goal for one of nine while the eight others drive."""
    times, alone, asked, answered = [], 0, 0, 0
    for seed in range(count):
        rng = np.random.default_rng(1000 + seed)
        scene = planner.load_scene(LABORATORY)
        wide = scene.with_bounds(Bounds(0.0, 0.0, 2.4, 1.8))
        radii = [0.06] * 9
        roadmap = planner.build_roadmap(wide, radius=radii[0])
        places = [free_places(roadmap, radii, wide.bounds, rng) for _ in range(2)]
        if places[0] is None or places[1] is None:
            continue
        goals = [*places[1][:8], places[0][8]]
        plan = planner.plan_fleet(roadmap, places[0], goals, radii)
        if isinstance(plan, planner.NoFleetPlan):
            continue
        schedule = planner.FleetSchedule.of(roadmap, plan, radii)
        passed = [0] * 9
        for _ in range(int(rng.integers(8, 40))):
            can = [i for i, r in enumerate(releases(plan, passed)) if r.row > passed[i]]
            if can:
                passed[int(rng.choice(can))] += 1
        sent = [
            min(max(r.row, row), row + 3)
            for row, r in zip(passed, releases(plan, passed), strict=True)
        ]
        asked += 1
        new, ms = timed(partial(schedule.with_goals, {8: places[1][8]}, passed, sent))
        times.append(ms)
        if isinstance(new, planner.FleetSchedule):
            answered += 1
            alone += new.changed == (8,)
    return (
        f"| a new goal while eight drive, laboratory | {answered} of {asked} |"
        f" {statistics.median(times):.0f} / {max(times):.0f} |"
        f" {alone} with no other path changed |"
    )


def loss_row(count: int) -> str:
    """Six robots in the laboratory: the sum of arrivals over the sum of each alone."""
    times, losses = [], []
    for seed in range(count):
        rng = np.random.default_rng(2000 + seed)
        scene = planner.load_scene(LABORATORY)
        wide = scene.with_bounds(Bounds(0.0, 0.0, 2.4, 1.8))
        radii = [RADIUS_M] * 6
        roadmap = planner.build_roadmap(wide, radius=RADIUS_M)
        starts = free_places(roadmap, radii, wide.bounds, rng)
        if starts is None:
            continue
        # each drives to where another stands
        goals = [*starts[1:], starts[0]]
        plan, ms = timed(partial(planner.plan_fleet, roadmap, starts, goals))
        if isinstance(plan, planner.NoFleetPlan):
            print(f"laboratory {seed}: {plan.reason}", flush=True)
            continue
        times.append(ms)
        singles = [
            planner.plan_fleet(roadmap, [a], [b]) for a, b in zip(starts, goals, strict=True)
        ]
        losses.append(plan.flowtime_s / sum(single.flowtime_s for single in singles))
    return (
        f"| six exchange places in the laboratory | {len(losses)} of {count} |"
        f" {statistics.median(times):.0f} / {max(times):.0f} |"
        f" {statistics.fmean(losses):.2f} x alone on average, {max(losses):.2f} at worst |"
    )


def main() -> None:
    """Print the table, and write it where asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--arenas", type=int, default=300)
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    lines = [
        "| what | planned + proved impossible | processor ms, median / worst | judged |",
        "|---|---|---|---|",
    ]
    for row in (crossing_row(), goals_row(30), loss_row(30), arenas_row(options.arenas)):
        print(row, flush=True)
        lines.append(row)
    if options.output is not None:
        options.output.write_text(
            "# Several robots among obstacles\n\n"
            "`python -m benchmarks.fleet.arenas --output benchmarks/results/fleet_arenas.md`\n\n"
            + "\n".join(lines)
            + "\n"
        )


if __name__ == "__main__":
    main()
