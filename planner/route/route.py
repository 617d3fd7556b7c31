"""From a request to a path: attach the stations, search the chains, prove the answer.

Rules and units
- Routes over the roadmap's chains are made taut (``taut.py``). The shortest path need not follow a
  chain: a search over tangents finds it (``tangent_search.py``).
- The exact distance of every answer to every border is at least the radius and the margin.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice, pairwise

import numpy as np

from planner.borders import box_tree_kernels
from planner.borders.generators import Borders
from planner.borders.polyline import length_of
from planner.diagram.agvd import Chains
from planner.path import NoPath, Path
from planner.route.hysteresis import continued, is_kept, last_legs, preferred
from planner.route.margin import WAY_OUT_REACH, way_out
from planner.route.no_way import Blocked, NamedStation, why_not
from planner.route.plan_request import Request
from planner.route.taut import as_wide, best_cut, finish, is_clear, judge
from planner.route.whole_path import as_path
from planner.scene import FloatArray, UnknownCells, Vec
from planner.search.chain_graph_kernels import Gates
from planner.search.chain_search import (
    CLEARANCE_ROUNDING,
    WORK,
    Network,
    attach,
    cheapest_routes,
    widest_gap,
)
from planner.search.homotopy import Word, anchors, word
from planner.search.tangent_search import shortest_way
from planner.search.tour import best_tour

ROUTES = 4
"""Routes over different chains that are compared."""
DEAREST = 1.25
"""A route more times as dear as the cheapest is not compared. Of 560 plans among up to 1,000
obstacles none was better for 1.5, eleven were worse for 1.1."""
SPARE_ROUTES = 2
"""Routes made taut for every alternative wanted, so that the best of them are found."""
MOST_ROUTES = 512
"""Most routes compared, unless the alternatives wanted take more."""
TAUT_POINTS = 200_000
"""Most points of routes that are made taut for them: about 0.2 s."""
AS_WIDE = 1e-9
"""Routes whose clearances differ by this part of them are equally wide."""
OTHERS = 3
"""Paths looked at besides the best for one on the sides of the last one."""
SECOND_OPINION = 4_000_000
"""Tangents tried before it is believed that there is no path: about 0.2 s."""
GAVE_UP = "the search for the shortest path reached its limit: there may be a shorter one"
FEWER = "the search for other paths reached its limit: there may be more, or better ones"
UNSURE = "the search for a path by tangents reached its limit: there may be one"


@dataclass(frozen=True, slots=True)
class Ways:
    """Polylines between two stations, the preferred one first, with remarks."""

    lines: tuple[FloatArray, ...]
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Leg:
    """Task from one station to the next for a disc of radius ``need``.

    ``clearances``: both stations' distances from the borders.
    """

    borders: Borders
    network: Network
    start: Vec
    goal: Vec
    need: float
    preference: float
    clearances: tuple[float, float]

    @classmethod
    def of(
        cls, borders: Borders, network: Network, ends: tuple[Vec, Vec], need: float, prefer: float
    ) -> Leg:
        """Measure both ends; ``need`` is lowered if a station is nearer by rounding."""
        one, other = borders.distances(np.array(ends))[0].tolist()
        return cls(borders, network, *ends, min(need, one, other), prefer, (one, other))


def plan_request(
    borders: Borders,
    chains: Chains,
    radius: float,
    request: Request,
    units: str = "",
    *,
    chains_only: bool = False,
    near: Path | NoPath | None = None,
    unknown: UnknownCells | None = None,
) -> Path | NoPath | Blocked:
    """Answer a request on measured chains, for a disc of ``radius``.

    ``chains_only`` trusts the chains if they have no path, as the paper does. ``near`` is the last
    answer (``hysteresis.py``). A refusal names uncertain obstacles, those in ``unknown``.
    """
    need = radius + request.margin
    asked = request
    vias = (f"station {i}" for i in range(1, len(request.stations) - 1))
    names = ["the start", *vias, "the goal"]
    request, ways_out, refused = _stand(borders, radius, request, names, units, unknown)
    if refused is not None:
        return refused
    network = Network.of(chains, need, request.preference)
    order = tuple(range(len(request.stations) - 2))
    if request.best_order and len(order) > 1:
        order = _best_order(borders, network, request, need, chains_only=chains_only)
    request, asked = request.in_order(order), asked.in_order(order)
    legs: list[Ways] = []
    lasts = last_legs(near, len(request.stations) - 1)
    visited = [names[0], *(names[1 + i] for i in order), names[-1]]
    for k, ((a, b), last) in enumerate(zip(pairwise(request.stations), lasts, strict=True)):
        leg = Leg.of(borders, network, (a, b), need, request.preference)
        found = plan_leg(leg, request.alternatives, chains_only=chains_only)
        if not found.lines:
            ends = visited[k], visited[k + 1]
            return Blocked(a, b, need, request.stations, names=ends, remarks=found.remarks)
        if last is not None and a != b:
            found = _staying(leg, last, found, request.alternatives)
        legs.append(found)
    legs = [replace(leg, lines=_from_stations(asked, k, leg.lines)) for k, leg in enumerate(legs)]
    best = as_path(borders, [leg.lines[0] for leg in legs], radius, request, order)
    said = [*ways_out, *(r for leg in legs for r in leg.remarks)]
    best = replace(best, remarks=tuple(dict.fromkeys(said)))
    if not request.alternatives:
        return best
    others = (as_path(borders, choice, radius, request, order) for choice in _others(legs))
    return replace(best, alternatives=tuple(islice(others, request.alternatives)))


def _stand(
    borders: Borders,
    radius: float,
    request: Request,
    names: list[str],
    units: str,
    unknown: UnknownCells | None,
) -> tuple[Request, list[str], NoPath | Blocked | None]:
    """Request from places that keep the margin, remarks on that, and a refusal or None.

    Only stations of a ``relaxed`` request may lie within the margin (:mod:`planner.route.margin`).
    """
    need = radius + request.margin
    what = "the radius and margin" if request.margin > 0.0 else "the radius"
    least = [(0.0, ""), (radius, "the radius")] if request.relaxed else [(0.0, ""), (need, what)]
    ends = request.stations[0], request.stations[-1]
    places = [
        NamedStation.of(borders, *named) for named in zip(names, request.stations, strict=True)
    ]
    for keep, of_what in least:
        for place in places:
            if reason := why_not(borders, place, keep, units, of_what, unknown):
                if keep == 0.0:
                    return request, [], NoPath(reason)
                return request, [], Blocked(*ends, keep, request.stations, reason)
    stations, said = list(request.stations), []
    for i, place in enumerate(places):
        if not request.relaxed or place.distance >= need - CLEARANCE_ROUNDING * borders.extent:
            continue
        out = way_out(borders, place.name, place.at, radius, request.margin, units)
        if out is None:
            reason = why_not(borders, place, need, units, what)
            reason = (
                f"{reason}, and no straight way of {WAY_OUT_REACH:g} times that leads out of it"
            )
            return request, [], Blocked(*ends, need, request.stations, reason)
        stations[i] = out.place
        said.append(out.remark)
    return replace(request, stations=tuple(stations)), said, None


def _from_stations(
    asked: Request, leg: int, lines: tuple[FloatArray, ...]
) -> tuple[FloatArray, ...]:
    """Extend the leg's lines to those stations that lie within the margin."""
    begin, end = asked.stations[leg : leg + 2]
    out = []
    for line in lines:
        before = [] if tuple(line[0].tolist()) == begin else [[begin]]
        behind = [] if tuple(line[-1].tolist()) == end else [[end]]
        out.append(np.concatenate([*before, line, *behind]) if before or behind else line)
    return tuple(out)


def _others(legs: list[Ways]) -> Iterator[list[FloatArray]]:
    """Paths that differ from the best in one leg, the next best of each leg first."""
    for rank in range(1, max(len(leg.lines) for leg in legs)):
        for i, leg in enumerate(legs):
            if rank < len(leg.lines):
                yield [
                    leg.lines[rank] if j == i else other.lines[0] for j, other in enumerate(legs)
                ]


def _best_order(
    borders: Borders, network: Network, request: Request, need: float, *, chains_only: bool
) -> tuple[int, ...]:
    """Order of the vias that makes the path shortest; the requested one if no order reaches all."""
    stations = request.stations
    matrix = np.zeros((len(stations), len(stations)))
    for i in range(len(stations)):
        for j in range(i + 1, len(stations)):
            ends = stations[i], stations[j]
            leg = Leg.of(borders, network, ends, need, request.preference)
            lines = plan_leg(leg, chains_only=chains_only).lines
            matrix[i, j] = matrix[j, i] = length_of(lines[0]) if lines else math.inf
    tour = best_tour(matrix)
    if not math.isfinite(tour.cost):
        return tuple(range(len(stations) - 2))
    return tuple(i - 1 for i in tour.order)


def plan_leg(leg: Leg, alternatives: int = 0, *, chains_only: bool = False) -> Ways:
    """Return the paths of :func:`_plan_leg`, the same in both directions.

    Planning begins at the end with more room, which turns and moves with the scene.
    """
    apart = leg.clearances[0] - leg.clearances[1]
    even = abs(apart) <= CLEARANCE_ROUNDING * leg.borders.extent
    if apart > 0.0 if not even else leg.start <= leg.goal:
        return _certified(leg, _plan_leg(leg, alternatives, chains_only=chains_only))
    back = replace(leg, start=leg.goal, goal=leg.start, clearances=leg.clearances[::-1])
    found = _plan_leg(back, alternatives, chains_only=chains_only)
    lines = tuple(np.ascontiguousarray(line[::-1]) for line in found.lines)
    return _certified(leg, replace(found, lines=lines))


def _certified(leg: Leg, found: Ways) -> Ways:
    """Keep the paths with exact clearance ``need``."""
    least = leg.need - CLEARANCE_ROUNDING * leg.borders.extent
    proved = tuple(
        line
        for line in found.lines
        if box_tree_kernels.polyline_clearance(leg.borders.tree, line)[0] >= least
    )
    return replace(found, lines=proved)


def _plan_leg(leg: Leg, alternatives: int, *, chains_only: bool) -> Ways:
    """Polylines from start to goal with clearance >= ``need``, the preferred one first.

    Each further one passes some obstacle on another side than all before. At preference 0 the first
    is the shortest of all; up to 1, a corridor's shortest that keeps
    ``1 + WISH_RADII * preference`` radii off the borders where there is room; at 1 the widest
    route, the cheapest of those equally wide within ``AS_WIDE``.
    """
    borders, start, goal, need = leg.borders, leg.start, leg.goal, leg.need
    if start == goal:
        return Ways((np.array([start, goal]),))
    clear = is_clear(borders, np.array([start, goal]), min(leg.clearances), need, leg.preference)
    if clear and not alternatives:
        return Ways((np.array([start, goal]),))
    routed = _routes(leg, alternatives)
    found = list(routed.lines)
    if clear:
        found.insert(0, np.array([start, goal]))
    if not found and chains_only:
        return Ways(())
    if not found:
        # the chains may lack paths this wide: a bounded second opinion
        exact = shortest_way(borders, start, goal, need, budget=SECOND_OPINION)
        if exact.way is None:
            return Ways((), () if exact.certain else (UNSURE,))
        return Ways((exact.way,))
    if leg.preference > 0.0 or clear:
        return Ways(_distinct(borders, found, alternatives), routed.remarks)
    exact = shortest_way(borders, start, goal, need, length_of(found[0]))
    if exact.way is not None:
        found.insert(0, exact.way)
    unsure = () if exact.certain else (GAVE_UP,)
    return Ways(_distinct(borders, found, alternatives), (*routed.remarks, *unsure))


def _routes(leg: Leg, alternatives: int) -> Ways:
    """Paths over different chains, the preferred one first; some may be shifts of others.

    The first may be cut short to another side of an obstacle.
    """
    borders, network, need, preference = leg.borders, leg.network, leg.need, leg.preference
    floor = need - CLEARANCE_ROUNDING * borders.extent
    for anywhere in (False, True):
        entries = attach(borders, network, leg.start, floor, anywhere)
        exits = attach(borders, network, leg.goal, floor, anywhere)
        if not (len(entries.where) and len(exits.where)):
            continue
        best = None
        if preference >= 1.0:
            least = max(floor, widest_gap(network, entries, exits) * (1.0 - AS_WIDE))
            lines, _ = cheapest_routes(borders, network, entries, exits, least, 1)
            best = as_wide(borders, lines, need, least)
        else:
            lines, _ = cheapest_routes(
                borders, network, entries, exits, floor, ROUTES, dearest=DEAREST
            )
            ways, first = finish(borders, lines, need, preference)
            if len(first) > 1:
                best = best_cut(borders, ways, first, need, preference)
        if best is None:
            continue
        if not alternatives:
            return Ways((best,))
        others = _others_than(leg, best, entries, exits, alternatives)
        found = [best, *others.lines]
        if preference < 1.0:  # among more routes there may be a cheaper one
            found.sort(key=lambda way: judge(borders, way, need, preference))
        return replace(others, lines=tuple(found))
    return Ways(())


def _others_than(
    leg: Leg, best: FloatArray, entries: Gates, exits: Gates, alternatives: int
) -> Ways:
    """The cheapest routes made taut, the best first: enough for the distinct ones required.

    Routes that begin or end on different chains may be shifts of one another, so the search
    continues until there are enough, no more, or ``MOST_ROUTES``, or until ``WORK`` or
    ``TAUT_POINTS``, which a remark reports.
    """
    borders, need, preference = leg.borders, leg.need, leg.preference
    floor = need - CLEARANCE_ROUNDING * borders.extent
    wanted = ROUTES + SPARE_ROUTES * alternatives
    found: list[FloatArray] = []
    done, left, points_left = 0, WORK, TAUT_POINTS
    while True:
        lines, work = cheapest_routes(borders, leg.network, entries, exits, floor, wanted, left)
        left -= work
        fresh = lines.after(done, points_left)
        points_left -= len(fresh.points)
        ways, first = finish(borders, fresh, need, preference)
        found += [ways[a:b] for a, b in pairwise(first.tolist())]
        bounded = left < 0 or done + len(fresh) < len(lines)
        enough = len(_distinct(borders, [best, *found], alternatives)) > alternatives
        if enough or bounded or len(lines) < wanted or wanted >= MOST_ROUTES:
            found.sort(key=lambda way: judge(borders, way, need, preference))
            return Ways(tuple(found), (FEWER,) if bounded and not enough else ())
        done = len(lines)
        wanted *= 2


def _staying(leg: Leg, last: FloatArray, found: Ways, alternatives: int) -> Ways:
    """The paths found, after the continued last path if that is as good."""
    borders, need = leg.borders, leg.need
    way = continued(borders, last, leg.start, leg.goal, need)
    lines = found.lines
    if len(lines) == 1 and not is_kept(borders, way, need):
        lines = plan_leg(leg, OTHERS).lines
    best = preferred(borders, way, lines, need, leg.preference)
    return replace(found, lines=_distinct(borders, [best, *lines], alternatives))


def _distinct(
    borders: Borders, ways: Sequence[FloatArray], alternatives: int
) -> tuple[FloatArray, ...]:
    """The first path, and up to ``alternatives`` others that are no shift of one before."""
    if not alternatives:
        return tuple(ways[:1])
    places = anchors(borders)
    kept: dict[Word, FloatArray] = {}
    for way in ways:
        kept.setdefault(word(places, way), way)
    return tuple(islice(kept.values(), alternatives + 1))
