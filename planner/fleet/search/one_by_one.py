"""Plans where hardly any robot can move: one at a time, between places out of the way.

The robots are rearranged as pebbles (``pebbles``) on stations of the shared graph (``stations``);
the usual searches bring them there, and from stations to their goals. Each move begins when all
earlier ones near it have ended, so robots apart drive at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from planner.fleet.motions.interval_search_kernels import HORIZON, moves_along
from planner.fleet.search.joint_search import JointSearch
from planner.fleet.search.matching import match_for_sum
from planner.fleet.search.pebbles import Move, rearrange
from planner.fleet.search.solver import Solver
from planner.fleet.search.stations import StationGraph, choose_stations
from planner.fleet.search.team import Route, TeamRobot, edges_of, make_robot
from planner.scene import FloatArray

CHANCES = 4
"""Random choices of stations, after those of reason."""
TRIES = 100
"""Searches of one robot to bring all to stations, or from there to their goals."""
MOST_CONSTRAINTS = 1000
"""Constraints of the joint search if these fail."""

Expired = Callable[[], bool]


def plan_one_by_one(
    solver: Solver, junctions: Sequence[int], expired: Expired
) -> dict[int, Route] | None:
    """Route for each robot, or None; ``junctions`` are nodes where paths meet."""
    robots, rng = solver.robots, solver.rng
    places = robots[0].graph.places
    gap = 2.0 * max(robot.radius for robot in robots)
    edges = _shared_edges(robots)
    routes = [solver.alone(i).way for i in range(len(robots))]
    on_way = np.unique(np.concatenate(routes))
    busy = _by_traffic(junctions, routes, places, gap)
    for seeds in _seeds(robots, busy, on_way, rng):
        if expired():
            return None
        stations = choose_stations(places, edges, seeds, on_way.tolist(), gap)
        found = _by_stations(robots, stations, rng, expired)
        if found is not None:
            return found
    return None


def _shared_edges(robots: Sequence[TeamRobot]) -> NDArray[np.int64]:
    count = len(robots[0].graph.places)
    graphs = {id(robot.graph.to): robot.graph for robot in robots}
    codes = []
    for graph in graphs.values():
        row = np.repeat(np.arange(count), np.diff(graph.starts))
        codes.append(np.intersect1d(row * count + graph.to, graph.to * count + row))
    shared = reduce(np.intersect1d, codes)
    pairs: NDArray[np.int64] = np.column_stack([shared // count, shared % count])
    return np.ascontiguousarray(pairs[pairs[:, 0] != pairs[:, 1]])


def _seeds(
    robots: Sequence[TeamRobot],
    junctions: list[int],
    on_way: NDArray[np.int64],
    rng: np.random.Generator,
) -> Iterator[list[int]]:
    starts, goals = [r.start for r in robots], [r.goal for r in robots]
    yield [*goals, *starts]
    for count in sorted({1, 2, len(junctions)} & set(range(1, len(junctions) + 1))):
        yield [*junctions[:count], *goals, *starts]
    for _ in range(CHANCES):
        some = rng.permutation(junctions).tolist() or rng.choice(on_way, 1).tolist()
        yield [*some, *goals, *starts]


def _by_traffic(
    junctions: Sequence[int], routes: Sequence[NDArray[np.int64]], places: FloatArray, gap: float
) -> list[int]:
    passed = {}
    for node in junctions:
        away = [np.hypot(*(places[route] - places[node]).T).min() for route in routes]
        passed[node] = sum(a < 0.5 * gap for a in away)
    return sorted((n for n in junctions if passed[n]), key=lambda n: (-passed[n], n))


def _by_stations(
    robots: Sequence[TeamRobot], stations: StationGraph, rng: np.random.Generator, expired: Expired
) -> dict[int, Route] | None:
    part = _largest_part(stations)
    number = {station: k for k, station in enumerate(part)}
    nodes = [stations.nodes[station] for station in part]
    near = [[number[t] for t in stations.near[station]] for station in part]
    if len(part) < len(robots):
        return None
    begin = _nearest_stations(robots, [r.start for r in robots], nodes)
    end = _nearest_stations(robots, [r.goal for r in robots], nodes)
    if begin is None or end is None:
        return None
    moves = rearrange(near, begin, end, rng, expired)
    if moves is None:
        return None
    phases = [
        _drive(robots, [r.start for r in robots], [nodes[k] for k in begin], rng, expired),
        _timed(robots, [nodes[k] for k in begin], moves, _Ways(stations, part, robots)),
        _drive(robots, [nodes[k] for k in end], [r.goal for r in robots], rng, expired),
    ]
    done = [phase for phase in phases if phase is not None]
    return _joined(robots, done) if len(done) == len(phases) else None


def _largest_part(stations: StationGraph) -> list[int]:
    left = set(range(len(stations.nodes)))
    best: list[int] = []
    while left:
        part, queue = set(), [min(left)]
        while queue:
            n = queue.pop()
            if n not in part:
                part.add(n)
                queue.extend(stations.near[n])
        left -= part
        if len(part) > len(best):
            best = sorted(part)
    return best


def _nearest_stations(
    robots: Sequence[TeamRobot], at: Sequence[int], nodes: Sequence[int]
) -> list[int] | None:
    places = robots[0].graph.places
    away = places[list(at)][:, None] - places[list(nodes)][None]
    chosen = match_for_sum(np.hypot(away[:, :, 0], away[:, :, 1])).tolist()
    return chosen if min(chosen) >= 0 else None


def _drive(
    robots: Sequence[TeamRobot],
    starts: Sequence[int],
    goals: Sequence[int],
    rng: np.random.Generator,
    expired: Expired,
) -> dict[int, Route] | None:
    team = [
        make_robot(robot.graph, edges_of(robot.graph), robot.radius, a, b)
        for robot, a, b in zip(robots, starts, goals, strict=True)
    ]
    if any(robot.alone_s >= HORIZON for robot in team):
        return None
    solver = Solver(team, rng)
    if solver.plan_all(expired, TRIES):
        return solver.routes
    joint = JointSearch(team, rng)
    return joint.routes() if joint.run(MOST_CONSTRAINTS, expired) else None


class _Ways:
    def __init__(
        self, stations: StationGraph, part: Sequence[int], robots: Sequence[TeamRobot]
    ) -> None:
        self.stations, self.part = stations, part
        self.places = robots[0].graph.places
        self.gap = 2.0 * max(robot.radius for robot in robots)
        self._near: dict[tuple[int, ...], bool] = {}

    def way(self, u: int, v: int) -> list[int]:
        return self.stations.ways[self.part[u], self.part[v]]

    def are_near(self, one: tuple[int, int], other: tuple[int, int]) -> bool:
        """True if robots on these two paths could touch."""
        key = (*sorted(one), *sorted(other))
        if key not in self._near:
            a, b = (self.places[self.way(*pair)] for pair in (one, other))
            self._near[key] = _polylines_apart(a, b) < self.gap
        return self._near[key]


def _polylines_apart(one: FloatArray, other: FloatArray) -> float:
    """Distance of two polylines, underestimated by at most their longest piece."""
    a, b = 0.5 * (one[1:] + one[:-1]), 0.5 * (other[1:] + other[:-1])
    half = 0.5 * max(np.hypot(*np.diff(line, axis=0).T).max() for line in (one, other))
    away = a[:, None] - b[None]
    return float(np.hypot(away[:, :, 0], away[:, :, 1]).min() - 2.0 * half)


def _timed(
    robots: Sequence[TeamRobot], nodes: Sequence[int], moves: Sequence[Move], ways: _Ways
) -> dict[int, Route]:
    rows: dict[int, tuple[list[int], list[float], list[float]]] = {
        i: ([node], [0.0], []) for i, node in enumerate(nodes)
    }
    ended: list[tuple[int, tuple[int, int], float]] = []
    for i, u, v in moves:
        way, arrivals, departures = rows[i]
        at = arrivals[-1]
        for j, pair, end in ended:
            if j != i and end > at and ways.are_near(pair, (u, v)):
                at = end
        for node in ways.way(u, v)[1:]:
            departures.append(at)
            at += _lasts(robots[i], way[-1], node)
            way.append(node)
            arrivals.append(at)
        ended.append((i, (u, v), at))
    return {i: _route(robots[i], *row) for i, row in rows.items()}


def _lasts(robot: TeamRobot, u: int, v: int) -> float:
    graph = robot.graph
    row = slice(graph.starts[u], graph.starts[u + 1])
    return float(graph.lasts[row][graph.to[row] == v].min())


def _route(
    robot: TeamRobot, way: Sequence[int], arrivals: Sequence[float], departures: Sequence[float]
) -> Route:
    nodes, at_s = np.array(way, np.int64), np.array(arrivals)
    left_s = np.array(departures, np.float64)
    moves = moves_along(robot.graph.places, nodes, at_s, left_s, robot.radius)
    return Route(nodes, at_s, left_s, moves)


def _joined(robots: Sequence[TeamRobot], phases: Sequence[dict[int, Route]]) -> dict[int, Route]:
    joined = {}
    begins = np.cumsum([0.0, *(max(r.arrival_s for r in phase.values()) for phase in phases)])
    for i, robot in enumerate(robots):
        way, arrivals, departures = [robot.start], [0.0], []
        for phase, begin in zip(phases, begins.tolist(), strict=False):
            route = phase[i]
            way += route.way[1:].tolist()
            arrivals += (route.arrivals[1:] + begin).tolist()
            departures += (route.departures + begin).tolist()
        joined[i] = _route(robot, way, arrivals, departures)
    return joined
