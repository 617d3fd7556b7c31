"""Several robots among obstacles: from and to any free place, of any radius and speed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from planner.borders.polyline import moves
from planner.fleet.fleet_plan import FleetPlan, NoFleetPlan
from planner.fleet.ground.shared_graph import GroundPlaces, lay_places
from planner.fleet.ground.zone_edges import cost_factors, usable_edges
from planner.fleet.motions.interval_search_kernels import MotionGraph
from planner.fleet.on_graph import check_effort
from planner.fleet.search.fleet_search import SHORTENING_ROUNDS, OutOfTime, search, touching
from planner.fleet.search.team import TeamRobot, edges_of, make_graph, make_robot
from planner.motion.trajectory import default_limits
from planner.path import Limits, NoPath, Path
from planner.roadmap.roadmap import Roadmap, build_roadmap
from planner.scene import FloatArray
from planner.shared.arguments import as_list, as_numbers, as_positive, brief, of_kind
from planner.shared.search_clock import Clock, search_clock_s
from planner.zones.rules import Rules
from planner.zones.zone import Zone
from planner.zones.zoned_roadmap import ZonedRoadmap

TRACK_ROUNDING = 1e-9
"""A track keeps the radius within this share of the coordinates' extent."""


def plan_fleet(
    roadmap: Roadmap,
    starts: Sequence[Sequence[float]],
    goals: Sequence[Sequence[float]],
    radii: float | Sequence[float] | None = None,
    limits: Limits | Sequence[Limits] | None = None,
    *,
    time_limit_s: float = 30.0,
    improve: int = SHORTENING_ROUNDS,
    seed: int = 0,
    clock: Clock = search_clock_s,
    zones: Sequence[Sequence[Zone]] | None = None,
) -> FleetPlan | NoFleetPlan:
    """Plan tracks for several discs among the roadmap's obstacles, no two of which ever touch.

    ``starts`` and ``goals`` are free places (x, y) or (x, y, heading_rad), one of each per robot;
    headings are not planned for. ``radii`` is one for all or one each, the roadmap's if None; other
    radii get their own roadmaps. ``limits`` is one for all or one each: a robot drives at
    ``limits.speed`` or is at rest, and changes of speed and turns take no time here; None means
    :func:`planner.motion.trajectory.default_limits` of its radius, one diameter a second.
    ``time_limit_s``, ``improve``, ``seed`` and ``clock`` are as in
    :func:`planner.fleet.on_graph.plan_on_graph`. ``zones`` are those that hold for each robot;
    times count slow zones and lanes by their cost, and robots may wait in no-waiting zones until
    :func:`planner.fleet.no_waiting.wait_before` moves their waits. A robot whose goal is its start
    stays there where a zone forbids goals. Every track keeps its robot's radius from all borders.
    ``ValueError`` on input that makes no sense.
    """
    of_kind("roadmap", roadmap, Roadmap)
    effort = replace(check_effort(time_limit_s, improve, seed, clock), live=True)
    begin, end = check_places("starts", starts), check_places("goals", goals)
    if len(begin) != len(end):
        raise ValueError(f"{len(begin)} starts and {len(end)} goals: must be as many")
    sizes = check_radii(radii, roadmap.radius, len(begin))
    speeds = check_speeds(limits, sizes)
    ruled = check_zones(zones, len(begin))
    if not len(begin):
        return FleetPlan((), (), 0.0, 0.0)
    for what, chosen in (("starts", begin), ("goals", end)):
        refused = touching(what, chosen, sizes)
        if refused is not None:
            return refused
    grounds = Grounds(roadmap)
    paths = []
    for i, size in enumerate(sizes):
        try:
            path = grounds.path(begin[i], end[i], size, speeds[i], ruled[i], effort.check)
        except OutOfTime:
            return effort.out_of_time(range(i, len(sizes)))
        if isinstance(path, NoPath):
            return NoFleetPlan(f"robot {i}: no path even alone: {path.reason}", (i,))
        # the path's own ends may be rounded: use the exact places
        paths.append(np.concatenate([begin[i : i + 1], path.points[1:-1], end[i : i + 1]]))

    try:
        shared = lay_places(
            grounds.walls(min(sizes)), paths, sizes, effort.check, grounds.closed(min(sizes), ruled)
        )
    except OutOfTime:
        return effort.out_of_time(range(len(sizes)))
    robots: list[TeamRobot] = []
    try:
        robots.extend(team_on(shared, sizes, speeds, grounds, ruled, paths, effort.check))
    except OutOfTime:
        return effort.out_of_time(range(len(robots), len(sizes)))
    plan = search(robots, shared.junctions, effort)
    if isinstance(plan, FleetPlan):
        check_walls(roadmap, plan, sizes)
        check_rules(
            [grounds.zoned(*one).rules for one in zip(sizes, speeds, ruled, strict=True)], plan
        )
    return plan


class Grounds:
    """Roadmaps of one scene for several radii and zones, each made once."""

    def __init__(self, roadmap: Roadmap) -> None:
        self._roadmap = roadmap
        self._walls: dict[float, Roadmap] = {}
        self._zoned: dict[tuple[float, float, tuple[Zone, ...]], ZonedRoadmap] = {}

    def walls(self, radius: float) -> Roadmap:
        """Return the roadmap without zones."""
        if radius not in self._walls:
            self._walls[radius] = roadmap_for(self._roadmap, radius)
        return self._walls[radius]

    def zoned(self, radius: float, speed: float, zones: tuple[Zone, ...]) -> ZonedRoadmap:
        """Return the roadmap with zones."""
        key = radius, speed, zones
        if key not in self._zoned:
            self._zoned[key] = ZonedRoadmap(self.walls(radius), zones, speed)
        return self._zoned[key]

    def path(
        self,
        begin: FloatArray,
        end: FloatArray,
        radius: float,
        speed: float,
        zones: tuple[Zone, ...],
        check: Callable[[], None] = lambda: None,
    ) -> Path | NoPath:
        """Plan one robot's path; where it is already it stays: zones forbid new stops only.

        ``check`` is called before each piece of work, and may raise `OutOfTime`.
        """
        check()
        if (begin == end).all():
            return self.walls(radius).plan(tuple(begin), tuple(end))
        ground = replace(self.zoned(radius, speed, zones), check=check)
        return ground.plan(tuple(begin), tuple(end))

    def closed(self, radius: float, zones: Sequence[tuple[Zone, ...]]) -> list[Roadmap]:
        """Return the different roadmaps on which each robot's keep-out zones are obstacles."""
        shut = {tuple(one for one in own if one.kind == "keep_out") for own in zones}
        return [self.zoned(radius, 1.0, own).closed for own in sorted(shut, key=str)]


def team_on(
    shared: GroundPlaces,
    sizes: Sequence[float],
    speeds: Sequence[float],
    grounds: Grounds,
    zones: Sequence[tuple[Zone, ...]],
    paths: Sequence[FloatArray],
    check: Callable[[], None] = lambda: None,
) -> Iterator[TeamRobot]:
    """The robots one by one, equal ones on one graph; ``check`` is as in :meth:`Grounds.path`.

    A robot that begins in a keep-out zone has its own, with its path out. One that is to stay where
    a zone forbids goals has a graph without edges: it could not come back.
    """
    graphs: dict[tuple[Any, ...], tuple[MotionGraph, NDArray[np.int64]]] = {}
    largest = float(np.abs(shared.places).max())
    for i, (size, speed) in enumerate(zip(sizes, speeds, strict=True)):
        check()
        rules = grounds.zoned(size, speed, zones[i]).rules
        begin = (float(paths[i][0, 0]), float(paths[i][0, 1]))
        held = any(rules.is_held_by(one, begin) for one in rules.of("keep_out"))
        stays = bool((paths[i][0] == paths[i][-1]).all())
        rooted = stays and rules.station_breach("its place", begin) is not None
        key = size, speed, zones[i], i if held or rooted else -1
        if key not in graphs:
            wide = shared.edges[shared.clearance >= size - TRACK_ROUNDING * largest]
            factors = None
            if rooted:
                wide = wide[:0]
            elif zones[i]:
                wide = wide[usable_edges(shared.places, wide, rules, paths[i], check)]
                factors = cost_factors(shared.places, wide, rules)
            graph = make_graph(shared.places, wide, speed, factors)
            graphs[key] = graph, edges_of(graph)
        yield make_robot(*graphs[key], size, shared.starts[i], shared.goals[i])


def check_walls(roadmap: Roadmap, plan: FleetPlan, sizes: Sequence[float]) -> None:
    """Raise ``AssertionError`` if a track comes too near to a border: our bug."""
    for i, track in enumerate(plan.tracks):
        places = np.ascontiguousarray(track[:, 1:])
        rounding = 2.0 * TRACK_ROUNDING * float(np.abs(places).max())
        found = roadmap.path_clearance(places)
        inside = roadmap.clearance(places).min()
        if min(found.distance, float(inside)) < sizes[i] - rounding:
            raise AssertionError(
                f"robot {i} would come to {found.distance:g} of a border at {found.at},"
                f" must be {sizes[i]:g}: a bug in the planner"
            )


def check_rules(rules: Sequence[Rules], plan: FleetPlan) -> None:
    """Raise ``AssertionError`` if a track breaks a zone's rule: our bug."""
    for i, (own, track) in enumerate(zip(rules, plan.tracks, strict=True)):
        places = np.ascontiguousarray(track[moves(track[:, 1:]), 1:])
        if not own.grounds or len(places) < 2:
            continue
        breach = own.breach(places)
        if breach is not None:
            raise AssertionError(f"the path of robot {i} {breach}: a bug in the planner")


def roadmap_for(roadmap: Roadmap, radius: float) -> Roadmap:
    """Roadmap of the same scene for a radius, with all dead ends, where robots give way."""
    if radius == roadmap.radius and roadmap.least_branch == 0.0:
        return roadmap
    return build_roadmap(roadmap.scene, radius, mode=roadmap.mode)


def check_places(name: str, rows: Sequence[Sequence[float]]) -> FloatArray:
    """Places without their headings, (n, 2); ``ValueError`` on senseless ones."""
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
    """Radius of each robot; ``ValueError`` on senseless ones."""
    values: ArrayLike = default if radii is None else radii
    array = as_numbers("radii", values, "a number, or one each")
    if array.ndim == 0:
        array = np.full(count, float(array))
    if array.shape != (count,):
        raise ValueError(f"{array.size} radii for {count} robots: must be one, or one each")
    return [as_positive(f"radii[{i}]", radius) for i, radius in enumerate(array.tolist())]


def check_zones(zones: Sequence[Sequence[Zone]] | None, count: int) -> list[tuple[Zone, ...]]:
    """Zones of each robot; ``ValueError`` unless there are as many lists as robots."""
    if zones is None:
        return [()] * count
    each = [as_list("zones", own, "zones") for own in as_list("zones", zones, "lists of zones")]
    if len(each) != count:
        raise ValueError(f"{len(each)} lists of zones for {count} robots: must be one each")
    return [tuple(of_kind("zones", one, Zone) for one in own) for own in each]


def check_speeds(limits: Limits | Sequence[Limits] | None, sizes: list[float]) -> list[float]:
    """Speed of each robot; ``ValueError`` on senseless ones."""
    if limits is None:
        return [default_limits(size).speed for size in sizes]
    if isinstance(limits, Limits):
        each = [limits] * len(sizes)
    else:
        each = [of_kind("limits", one, Limits) for one in as_list("limits", limits, "Limits")]
    if len(each) != len(sizes):
        raise ValueError(f"{len(each)} limits for {len(sizes)} robots: must be one, or one each")
    return [as_positive(f"limits[{i}].speed", one.speed) for i, one in enumerate(each)]
