"""Several robots among obstacles: from and to any free place, of any radius and speed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from planner.fleet.fleet_plan import FleetPlan, NoFleetPlan
from planner.fleet.ground.places import GroundPlaces, OutOfTime, lay_places
from planner.fleet.motions.interval_search_kernels import MotionGraph
from planner.fleet.on_graph import check_effort
from planner.fleet.search.fleet_search import ROUNDS, search, touching
from planner.fleet.search.team import TeamRobot, edges_of, make_graph, make_robot
from planner.motion.trajectory import default_limits
from planner.path import Limits, NoPath
from planner.roadmap.roadmap import Roadmap, build_roadmap
from planner.scene import FloatArray
from planner.shared.arguments import as_float, as_list, as_numbers, brief, of_kind
from planner.shared.search_clock import Clock, search_clock_s

ROUNDING = 1e-9
"""A track keeps the radius within this share of the coordinates' extent."""


def plan_fleet(
    roadmap: Roadmap,
    starts: Sequence[Sequence[float]],
    goals: Sequence[Sequence[float]],
    radii: float | Sequence[float] | None = None,
    limits: Limits | Sequence[Limits] | None = None,
    *,
    time_limit_s: float = 30.0,
    improve: int = ROUNDS,
    seed: int = 0,
    clock: Clock = search_clock_s,
) -> FleetPlan | NoFleetPlan:
    """Plan tracks for several discs among the roadmap's obstacles, no two of which ever touch.

    ``starts`` and ``goals`` are free places (x, y) or (x, y, heading_rad), one of each per robot;
    headings are not planned for. ``radii`` is one for all or one each, the roadmap's if None; other
    radii get their own roadmaps. ``limits`` is one for all or one each: a robot drives at
    ``limits.speed`` or is at rest, and changes of speed and turns take no time here; None means
    :func:`planner.motion.trajectory.default_limits` of its radius, one diameter a second.
    ``time_limit_s``, ``improve``, ``seed`` and ``clock`` are as in
    :func:`planner.fleet.on_graph.plan_on_graph`. Every track keeps its robot's radius from all
    borders. ``ValueError`` on input that makes no sense.
    """
    of_kind("roadmap", roadmap, Roadmap)
    effort = replace(check_effort(time_limit_s, improve, seed, clock), live=True)
    begin, end = check_places("starts", starts), check_places("goals", goals)
    if len(begin) != len(end):
        raise ValueError(f"{len(begin)} starts and {len(end)} goals: must be as many")
    sizes = check_radii(radii, roadmap.radius, len(begin))
    speeds = check_speeds(limits, sizes)
    if not len(begin):
        return FleetPlan((), (), 0.0, 0.0)
    for what, chosen in (("starts", begin), ("goals", end)):
        refused = touching(what, chosen, sizes)
        if refused is not None:
            return refused
    roadmaps: dict[float, Roadmap] = {}
    paths = []
    for i, size in enumerate(sizes):
        if effort.expired():
            return effort.out_of_time(range(i, len(sizes)))
        if size not in roadmaps:
            roadmaps[size] = roadmap_for(roadmap, size)
        path = roadmaps[size].plan(tuple(begin[i]), tuple(end[i]))
        if isinstance(path, NoPath):
            return NoFleetPlan(f"robot {i}: there is no way even alone: {path.reason}", (i,))
        # the path's own ends may be rounded: use the exact places
        paths.append(np.concatenate([begin[i : i + 1], path.points[1:-1], end[i : i + 1]]))

    def check() -> None:
        if effort.expired():
            raise OutOfTime

    try:
        shared = lay_places(roadmaps[min(sizes)], paths, sizes, check)
    except OutOfTime:
        return effort.out_of_time(range(len(sizes)))
    robots: list[TeamRobot] = []
    for robot in team_on(shared, sizes, speeds):
        if effort.expired():
            return effort.out_of_time(range(len(robots), len(sizes)))
        robots.append(robot)
    plan = search(robots, shared.junctions, effort)
    if isinstance(plan, FleetPlan):
        check_walls(roadmap, plan, sizes)
    return plan


def team_on(
    shared: GroundPlaces, sizes: Sequence[float], speeds: Sequence[float]
) -> Iterator[TeamRobot]:
    """The robots one by one, robots of equal radius and speed on one graph."""
    graphs: dict[tuple[float, float], tuple[MotionGraph, NDArray[np.int64]]] = {}
    largest = float(np.abs(shared.places).max())
    for size, speed, a, b in zip(sizes, speeds, shared.starts, shared.goals, strict=True):
        if (size, speed) not in graphs:
            wide = shared.clearance >= size - ROUNDING * largest
            graph = make_graph(shared.places, shared.edges[wide], speed)
            graphs[size, speed] = graph, edges_of(graph)
        yield make_robot(*graphs[size, speed], size, a, b)


def check_walls(roadmap: Roadmap, plan: FleetPlan, sizes: Sequence[float]) -> None:
    """Raise ``AssertionError`` if a track comes too near to a border: our bug."""
    for i, track in enumerate(plan.tracks):
        places = np.ascontiguousarray(track[:, 1:])
        rounding = 2.0 * ROUNDING * float(np.abs(places).max())
        found = roadmap.path_clearance(places)
        inside = roadmap.clearance(places).min()
        if min(found.distance, float(inside)) < sizes[i] - rounding:
            raise AssertionError(
                f"robot {i} would come to {found.distance:g} of a border at {found.at},"
                f" must be {sizes[i]:g}: a bug in the planner"
            )


def roadmap_for(roadmap: Roadmap, radius: float) -> Roadmap:
    """Roadmap of the same scene for a robot of this radius, with all its dead ends.

    Robots give way in dead ends, however short.
    """
    if radius == roadmap.radius and roadmap.least_branch == 0.0:
        return roadmap
    return build_roadmap(roadmap.scene, radius, mode=roadmap.mode)


def check_places(name: str, rows: Sequence[Sequence[float]]) -> FloatArray:
    """Places without their headings, (n, 2); ``ValueError`` if one makes no sense."""
    listed = as_list(name, rows, "places")
    found = np.empty((len(listed), 2))
    for i, row in enumerate(listed):
        numbers = as_numbers(f"{name}[{i}]", row, "(x, y) or (x, y, heading)")
        if numbers.shape not in ((2,), (3,)) or not np.isfinite(numbers).all():
            raise ValueError(
                f"{name}[{i}] = {brief(row)}: must be (x, y) or (x, y, heading), finite"
            )
        found[i] = numbers[:2]
    return found


def check_radii(radii: float | Sequence[float] | None, default: float, count: int) -> list[float]:
    """A radius for each robot; ``ValueError`` if one makes no sense."""
    values: ArrayLike = default if radii is None else radii
    array = as_numbers("radii", values, "a number, or one each")
    if array.ndim == 0:
        array = np.full(count, float(array))
    if array.shape != (count,):
        raise ValueError(f"{array.size} radii for {count} robots: must be one, or one each")
    for i, radius in enumerate(array.tolist()):
        if not math.isfinite(radius) or radius <= 0.0:
            raise ValueError(f"radii[{i}] = {radius:g}: must be > 0 and finite")
    return [float(radius) for radius in array.tolist()]


def check_speeds(limits: Limits | Sequence[Limits] | None, sizes: list[float]) -> list[float]:
    """A speed for each robot; ``ValueError`` if one makes no sense."""
    if limits is None:
        return [default_limits(size).speed for size in sizes]
    if isinstance(limits, Limits):
        each = [limits] * len(sizes)
    else:
        each = [of_kind("limits", one, Limits) for one in as_list("limits", limits, "Limits")]
    if len(each) != len(sizes):
        raise ValueError(f"{len(each)} limits for {len(sizes)} robots: must be one, or one each")
    for i, one in enumerate(each):
        speed = as_float(f"limits[{i}].speed", one.speed)
        if not math.isfinite(speed) or speed <= 0.0:
            raise ValueError(f"limits[{i}].speed = {speed:g}: must be > 0 and finite")
    return [float(one.speed) for one in each]
