"""Stages from robots on a graph to a checked plan, or a reason for none.

Counts of work limit the searches, so equal input gives equal answers; the clock ends them only at
the time limit, which the answer then reports. The limit counts from the request. The current piece
of work, one search, one connection of a robot's path or one robot's times, and the plan's check,
about 20 us a pair of robots, may exceed it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from planner.fleet.dependencies import find_dependencies, is_live
from planner.fleet.execution import deadlocked
from planner.fleet.fleet_plan import FleetPlan, NoFleetPlan
from planner.fleet.motions.track_kernels import nearest_pair
from planner.fleet.search.joint_search import JointSearch
from planner.fleet.search.one_by_one import plan_one_by_one
from planner.fleet.search.pair_proof import PAIRS_FEW, PAIRS_MOST, can_never_pass
from planner.fleet.search.solver import Solver
from planner.fleet.search.team import Route, TeamRobot, cut_off
from planner.scene import FloatArray
from planner.shared.search_clock import Clock

SHORTENING_ROUNDS = 30
"""``python -m benchmarks.fleet`` says what they gain and cost."""
FIRST_TRIES = 400
"""Searches before anything else is tried: ten a robot for 40."""
JOINT_ROUNDS = 500
"""Constraints of the joint search between two such rows of searches; about as long."""
SUSPECTS = 6
"""Robots that failed most often, whose pairs are asked for a proof."""
LIVE_TRIES = 24
"""Robots planned again where a plan's waits form a circle, four of them six times."""
TRAIL = 0.5
"""Delay of one of a circle, as a share of its longest edge and wait."""
PAIR_TRIES = 20
"""Searches for a plan of two robots alone before a proof."""
DISTANCE_ROUNDING = 1e-9
"""Distances are exact within this share of the coordinates' extent."""
NOT_LIVE = (
    "some robots pass shared places at the same time, each before another:"
    " this plan needs its timing, its dependencies alone would wait in a circle"
)


class OutOfTime(Exception):  # noqa: N818 (an answer, not an error)
    """The time limit was reached before the search began."""


@dataclass(frozen=True, slots=True)
class Effort:
    """Limits of a search; ``end_s`` is the time on its ``clock`` to stop.

    With ``live``, a plan whose waits form a circle is changed if possible.
    """

    time_limit_s: float
    end_s: float
    rounds: int
    seed: int
    clock: Clock
    live: bool = False

    def expired(self) -> bool:
        """True if the time limit is reached."""
        return self.clock() >= self.end_s

    def check(self) -> None:
        """Raise `OutOfTime` at the time limit."""
        if self.expired():
            raise OutOfTime

    def out_of_time(self, who: Sequence[int]) -> NoFleetPlan:
        """Refusal at the time limit; ``who`` has no path yet."""
        return NoFleetPlan(
            f"{_listed(who)}: no plan was found within {self.time_limit_s:.3g} s; that there is"
            " none is not proved", tuple(who), proved=False,
        )  # fmt: skip


def search(
    robots: Sequence[TeamRobot], junctions: Sequence[int], effort: Effort
) -> FleetPlan | NoFleetPlan:
    """Plan for robots whose starts and goals do not touch; checked, or a reason for none.

    ``junctions`` are nodes where paths meet.
    """
    if not robots:
        return FleetPlan((), (), 0.0, 0.0)
    lost = cut_off(robots)
    if lost:
        who = _listed(lost)
        return NoFleetPlan(f"{who}: no path to the goal, even alone", tuple(lost))
    solver = Solver(robots, np.random.default_rng(effort.seed))
    refused = _solve(solver, junctions, effort)
    if refused is not None:
        return refused
    solver.improve(effort.rounds, effort.expired)
    if effort.live:
        return _live_plan(solver, junctions, effort.expired)
    return checked_plan(robots, _in_order(solver.routes))


def _live_plan(solver: Solver, junctions: Sequence[int], expired: Callable[[], bool]) -> FleetPlan:
    """Plan in which robots that would wait in a circle come later, or all move one at a time."""
    robots = solver.robots
    plan = checked_plan(robots, _in_order(solver.routes))
    for k in range(LIVE_TRIES):
        circle = deadlocked(plan)
        if not circle or expired():
            return plan
        i = circle[k % len(circle)]
        robot = solver.routes[i]
        trail_s = TRAIL * float(np.diff(robot.arrivals).max(initial=0.0)) * (1 + k // len(circle))
        route = solver.plan_one(i, [j for j in solver.routes if j != i], trail_s=trail_s)
        if route is not None:
            solver.routes[i] = route
            plan = checked_plan(robots, _in_order(solver.routes))
    routes = plan_one_by_one(solver, junctions, expired) if deadlocked(plan) else None
    if routes is None:
        return plan
    serial = checked_plan(robots, _in_order(routes))
    return plan if deadlocked(serial) else serial


def _in_order(routes: dict[int, Route]) -> list[Route]:
    return [routes[i] for i in range(len(routes))]


def _solve(solver: Solver, junctions: Sequence[int], effort: Effort) -> NoFleetPlan | None:
    robots, expired = solver.robots, effort.expired
    if solver.plan_all(expired, FIRST_TRIES):
        return None
    joint = JointSearch(robots, np.random.default_rng(effort.seed))
    first = True
    while not expired():
        if joint.run(JOINT_ROUNDS, expired):
            solver.routes = joint.routes()
            solver.shorten_each()
            return None
        if joint.exhausted:
            who = _often(solver)
            return NoFleetPlan(
                f"{_listed(who)}: no sequence of steps, in which all drive along one edge each or"
                " stand, brings all robots to their goals (proved: all were looked at)", who,
            )  # fmt: skip
        if first:
            pair = _hopeless_pair(solver, PAIRS_FEW, expired)
            routes = None if pair else plan_one_by_one(solver, junctions, expired)
            if routes is not None:
                solver.routes = routes
                solver.shorten_each()
                return None
            pair = pair or _hopeless_pair(solver, PAIRS_MOST, expired)
            if pair is not None:
                return NoFleetPlan(
                    f"{_listed(pair)}: they cannot both reach their goals, one is always in the"
                    " other's only path (proved)", pair,
                )  # fmt: skip
        first = False
        if solver.plan_all(expired, FIRST_TRIES):
            return None
    return effort.out_of_time(_often(solver))


def _often(solver: Solver) -> tuple[int, ...]:
    """At least half as often as the first."""
    most = max(int(solver.pushed.max(initial=0)), 1)
    found = np.flatnonzero(2 * solver.pushed >= most).tolist()
    return tuple(found or range(len(solver.robots)))


def _hopeless_pair(
    solver: Solver, most: int, expired: Callable[[], bool]
) -> tuple[int, int] | None:
    by_failures = np.argsort(-solver.pushed, kind="stable").tolist()
    failed = [i for i in by_failures if solver.pushed[i] > 0][:1]
    suspects = by_failures[:SUSPECTS]
    pairs = [(min(pair), max(pair)) for pair in combinations(suspects, 2)]
    # a robot may fail because of one that is at rest and so never fails itself
    pairs += [(min(i, j), max(i, j)) for i in failed for j in by_failures[SUSPECTS:]]
    for i, j in pairs:
        if expired():
            return None
        one, other = solver.robots[i], solver.robots[j]
        if not _is_in_the_way(solver, i, j):
            continue
        # a plan for two needs no proof, but a few pairs of places are examined faster
        if most > PAIRS_FEW and Solver((one, other), solver.rng).plan_all(expired, PAIR_TRIES):
            continue
        joint = JointSearch((one, other), solver.rng)
        if can_never_pass(one, other, joint, expired, most):
            return i, j
    return None


def _is_in_the_way(solver: Solver, i: int, j: int) -> bool:
    for one, other in ((i, j), (j, i)):
        robot = solver.robots[other]
        for node in (robot.start, robot.goal):
            if not solver.can_pass(one, other, node):
                return True
    return False


def _listed(who: Sequence[int]) -> str:
    if len(who) == 1:
        return f"robot {who[0]}"
    return f"robots {', '.join(map(str, who[:-1]))} and {who[-1]}"


def checked_plan(robots: Sequence[TeamRobot], routes: Sequence[Route]) -> FleetPlan:
    """Plan of the routes, checked by :func:`checked_tracks`."""
    tracks = [track_of(robot, route) for robot, route in zip(robots, routes, strict=True)]
    return checked_tracks(tracks, [robot.radius for robot in robots])


def checked_tracks(tracks: Sequence[FloatArray], sizes: Sequence[float]) -> FleetPlan:
    """Plan of read-only tracks; ``AssertionError`` if two of them touch: our bug."""
    radii = np.array(sizes)
    first = np.concatenate([[0], np.cumsum([len(track) for track in tracks])]).astype(np.int64)
    flat = np.concatenate(tracks)
    margin, i, j, when = nearest_pair(flat, first, radii)
    extent = float(np.abs(flat[:, 1:]).max()) + float(radii.max())
    if margin < -DISTANCE_ROUNDING * extent:
        raise AssertionError(
            f"robots {i} and {j} would overlap by {-margin:g} at {when:g} s: a bug in the planner"
        )
    dependencies = find_dependencies(tracks, radii.tolist())
    arrivals = [float(track[-1, 0]) for track in tracks]
    remarks = () if is_live(tracks, dependencies) else (NOT_LIVE,)
    return FleetPlan(
        tuple(tracks), tuple(dependencies), max(arrivals), math.fsum(arrivals), remarks
    )


def track_of(robot: TeamRobot, route: Route) -> FloatArray:
    """Rows t, x, y: each node's arrival and, after a wait, its departure."""
    places = robot.graph.places[route.way]
    rows = []
    for k, (x, y) in enumerate(places.tolist()):
        rows.append((float(route.arrivals[k]), x, y))
        if k < len(places) - 1 and route.departures[k] > route.arrivals[k]:
            rows.append((float(route.departures[k]), x, y))
    track = np.array(rows)
    track.setflags(write=False)
    return track


def touching(what: str, places: FloatArray, radii: Sequence[float]) -> NoFleetPlan | None:
    """Refusal if two robots' places of one kind are nearer than both radii."""
    sizes, largest = np.asarray(radii), np.abs(places).max(axis=1, initial=0.0).max(initial=0.0)
    for i in range(len(places)):
        needs = sizes[i] + sizes[i + 1 :]
        apart = np.hypot(*(places[i + 1 :] - places[i]).T)
        near = np.flatnonzero(apart < needs - DISTANCE_ROUNDING * (needs + largest))
        if len(near):
            k = int(near[0])
            return NoFleetPlan(
                f"robots {i} and {i + 1 + k}: their {what} are {apart[k]:g} apart,"
                f" must be {needs[k]:g} (both radii)", (i, i + 1 + k),
            )  # fmt: skip
    return None
