"""From a request to a path: attach the stations, search the chains, prove the answer.

Rules and units
- Routes over the roadmap's chains are made taut (``finish.py``). The shortest way that keeps
  the radius need not follow a chain: it is searched for over tangents (``shortest.py``).
- Every answer is proved at the end: the exact distance of the whole polyline to every border
  is at least the radius and the margin, or it is no answer.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice, pairwise

import numpy as np

from planner import distance_kernels
from planner.agvd import Chains
from planner.chain_search import (
    ROUNDING,
    Gates,
    Network,
    attach,
    cheapest_routes,
    routes,
    widest_gap,
)
from planner.finish import as_wide, best_cut, finish, is_clear, judge
from planner.generators import Borders
from planner.homotopy import Word, anchors, word
from planner.hysteresis import continued, is_kept, last_legs, preferred
from planner.no_way import Blocked, why_not
from planner.path import NoPath, Path
from planner.request import Request
from planner.scene import FloatArray, Vec
from planner.shortest import shortest_way
from planner.tour import best_tour

ROUTES = 4
"""Routes over different chains that are compared."""
SPARE_ROUTES = 2
"""Routes made taut for every alternative wanted, so that the best of them are told."""
MOST_ROUTES = 512
"""No more routes are compared than so many, or what the alternatives wanted take."""
AS_WIDE = 1e-9
"""Routes whose clearances differ by so small a part of them are equally wide."""
OTHERS = 3
"""Ways looked at besides the best for one on the sides of the last one."""
SECOND_OPINION = 4_000_000
"""Tangents tried before it is believed that there is no way: about 0.2 s."""
GAVE_UP = "the search for the shortest path reached its limit: there may be a shorter one"


@dataclass(frozen=True, slots=True)
class Ways:
    """Polylines between two stations, the preferred one first, and what must be said of them."""

    lines: tuple[FloatArray, ...]
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Leg:
    """From one station to the next, for a disc of radius ``need``."""

    borders: Borders
    network: Network
    start: Vec
    goal: Vec
    need: float
    preference: float


def plan_request(
    borders: Borders,
    chains: Chains,
    radius: float,
    request: Request,
    units: str = "",
    *,
    chains_only: bool = False,
    near: Path | NoPath | None = None,
) -> Path | NoPath | Blocked:
    """Answer a request on measured chains, for a disc of ``radius``.

    ``chains_only`` believes the chains where they have no way, as the paper does. ``near`` is the
    last answer, which is stayed with as ``hysteresis.py`` says.
    """
    need = radius + request.margin
    vias = (f"station {i}" for i in range(1, len(request.stations) - 1))
    names = ["the start", *vias, "the goal"]
    for least in (0.0, need):
        for name, place in zip(names, request.stations, strict=True):
            if reason := why_not(borders, name, place, least, units):
                if least == 0.0:
                    return NoPath(reason)
                ends = request.stations[0], request.stations[-1]
                return Blocked(*ends, need, request.stations, reason)
    network = Network.of(chains, need, request.preference)
    order = tuple(range(len(request.stations) - 2))
    if request.best_order and len(order) > 1:
        order = _best_order(borders, network, request, need, chains_only=chains_only)
    request = request.in_order(order)
    legs: list[Ways] = []
    lasts = last_legs(near, len(request.stations) - 1)
    visited = [names[0], *(names[1 + i] for i in order), names[-1]]
    for k, ((a, b), last) in enumerate(zip(pairwise(request.stations), lasts, strict=True)):
        leg = Leg(borders, network, a, b, _kept(borders, a, b, need), request.preference)
        found = plan_leg(leg, request.alternatives, chains_only=chains_only)
        if not found.lines:
            return Blocked(a, b, need, request.stations, names=(visited[k], visited[k + 1]))
        if last is not None and a != b:
            found = _staying(leg, last, found, request.alternatives)
        legs.append(found)
    best = _as_path(borders, [leg.lines[0] for leg in legs], radius, request, order)
    best = replace(best, remarks=tuple(dict.fromkeys(r for leg in legs for r in leg.remarks)))
    if not request.alternatives:
        return best
    others = (_as_path(borders, choice, radius, request, order) for choice in _others(legs))
    return replace(best, alternatives=tuple(islice(others, request.alternatives)))


def _kept(borders: Borders, start: Vec, goal: Vec, need: float) -> float:
    """What the way keeps: what is needed, or less where a station stands nearer by rounding."""
    return min(need, float(borders.distances(np.array([start, goal]))[0].min()))


def _others(legs: list[Ways]) -> Iterator[list[FloatArray]]:
    """Ways that differ from the best in one leg, the next best of each leg first."""
    for rank in range(1, max(len(leg.lines) for leg in legs)):
        for i, leg in enumerate(legs):
            if rank < len(leg.lines):
                yield [
                    leg.lines[rank] if j == i else other.lines[0] for j, other in enumerate(legs)
                ]


def _best_order(
    borders: Borders, network: Network, request: Request, need: float, *, chains_only: bool
) -> tuple[int, ...]:
    """The order of the vias that makes the way shortest: of legs planned as they will be.

    Where no order leads to all of them, the order they were asked for in.
    """
    stations = request.stations
    matrix = np.zeros((len(stations), len(stations)))
    for i in range(len(stations)):
        for j in range(i + 1, len(stations)):
            a, b = stations[i], stations[j]
            leg = Leg(borders, network, a, b, _kept(borders, a, b, need), request.preference)
            lines = plan_leg(leg, chains_only=chains_only).lines
            matrix[i, j] = matrix[j, i] = _length(lines[0]) if lines else math.inf
    tour = best_tour(matrix)
    if not math.isfinite(tour.cost):
        return tuple(range(len(stations) - 2))
    return tuple(i - 1 for i in tour.order)


def plan_leg(leg: Leg, alternatives: int = 0, *, chains_only: bool = False) -> Ways:
    """As :func:`_plan_leg`, and the same there and back.

    A leg is planned from the end with more room on: that turns and moves with the scene.
    """
    room = leg.borders.distances(np.array([leg.start, leg.goal]))[0].tolist()
    apart = room[0] - room[1]
    even = abs(apart) <= ROUNDING * leg.borders.extent
    if apart > 0.0 if not even else leg.start <= leg.goal:
        return _plan_leg(leg, alternatives, chains_only=chains_only)
    back = replace(leg, start=leg.goal, goal=leg.start)
    found = _plan_leg(back, alternatives, chains_only=chains_only)
    lines = tuple(np.ascontiguousarray(line[::-1]) for line in found.lines)
    return replace(found, lines=lines)


def _plan_leg(leg: Leg, alternatives: int, *, chains_only: bool) -> Ways:
    """Polylines from start to goal with clearance >= ``need``, the preferred one first.

    Every further one passes some obstacle on another side than those before it. With the
    preference 0 the first is the shortest there is; up to 1, a corridor's shortest that keeps
    ``1 + ROOM * preference`` radii off the borders where there is room; with 1 the widest
    route itself, of those as wide within ``AS_WIDE`` the cheapest. None where there is no way.
    """
    borders, start, goal, need = leg.borders, leg.start, leg.goal, leg.need
    if start == goal:
        return Ways((np.array([start, goal]),))
    clear = is_clear(borders, start, goal, need, leg.preference)
    if clear and not alternatives:
        return Ways((np.array([start, goal]),))
    found = _routes(leg, alternatives)
    if clear:
        found.insert(0, np.array([start, goal]))
    if not found and chains_only:
        return Ways(())
    if not found:
        # the chains tell ways of this width: a second opinion of another method, and its bound
        exact = shortest_way(borders, start, goal, need, budget=SECOND_OPINION)
        return Ways(() if exact.way is None else (exact.way,))
    if leg.preference > 0.0 or clear:
        return Ways(_distinct(borders, found, alternatives))
    exact = shortest_way(borders, start, goal, need, _length(found[0]))
    if exact.way is not None:
        found.insert(0, exact.way)
    return Ways(_distinct(borders, found, alternatives), () if exact.certain else (GAVE_UP,))


def _routes(leg: Leg, alternatives: int) -> list[FloatArray]:
    """Ways over different chains, the preferred one first; some may be the same but for a shift.

    The first may be cut short across to another side of an obstacle. For alternatives the
    cheapest routes of all are made taut, and come the best first.
    """
    borders, network, need, preference = leg.borders, leg.network, leg.need, leg.preference
    floor = need - ROUNDING * borders.extent
    for anywhere in (False, True):
        entries = attach(borders, network, leg.start, floor, anywhere)
        exits = attach(borders, network, leg.goal, floor, anywhere)
        if not (len(entries) and len(exits)):
            continue
        best = None
        if preference >= 1.0:
            least = max(floor, widest_gap(network, entries, exits) * (1.0 - AS_WIDE))
            best = as_wide(borders, routes(network, entries, exits, least, floor, 1), need, least)
        else:
            lines = routes(network, entries, exits, floor, floor, ROUTES)
            ways, first = finish(borders, lines, need, preference)
            if len(first) > 1:
                best = best_cut(borders, ways, first, need, preference)
        if best is None:
            continue
        if not alternatives:
            return [best]
        return [best, *_others_than(leg, best, entries, exits, alternatives)]
    return []


def _others_than(
    leg: Leg, best: FloatArray, entries: Gates, exits: Gates, alternatives: int
) -> list[FloatArray]:
    """The cheapest routes made taut, the best first: enough for so many that are distinct.

    Routes that begin or end on different chains may be shifts of one another, though they are
    not the same: more are sought until there are enough, or no more, or ``MOST_ROUTES``.
    """
    borders, need, preference = leg.borders, leg.need, leg.preference
    wanted = ROUTES + SPARE_ROUTES * alternatives
    while True:
        floor = need - ROUNDING * borders.extent
        lines = cheapest_routes(borders, leg.network, entries, exits, floor, wanted)
        ways, first = finish(borders, lines, need, preference)
        found = [ways[a:b] for a, b in pairwise(first.tolist())]
        enough = len(_distinct(borders, [best, *found], alternatives)) > alternatives
        if enough or len(lines) < wanted or wanted >= MOST_ROUTES:
            return sorted(found, key=lambda way: judge(borders, way, need, preference))
        wanted *= 2


def _staying(leg: Leg, last: FloatArray, found: Ways, alternatives: int) -> Ways:
    """The ways found, behind the last way continued where that is as good."""
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
    """The first way, and up to ``alternatives`` that no way before them can be shifted into."""
    if not alternatives:
        return tuple(ways[:1])
    places = anchors(borders)
    kept: dict[Word, FloatArray] = {}
    for way in ways:
        kept.setdefault(word(places, way), way)
    return tuple(islice(kept.values(), alternatives + 1))


def _length(way: FloatArray) -> float:
    return float(np.hypot(*np.diff(way, axis=0).T).sum())


def _as_path(
    borders: Borders,
    legs: list[FloatArray],
    radius: float,
    request: Request,
    order: tuple[int, ...],
) -> Path:
    """The legs as one proved path."""
    points = [legs[0][:1]]
    stations = [0]
    for leg in legs:
        points.append(leg[1:])
        stations.append(stations[-1] + len(leg) - 1)
    polyline = np.concatenate(points)
    gap, x, y, _, _ = distance_kernels.polyline_clearance(*borders.tree, polyline)
    rho, _ = borders.distances(polyline)
    for array in (polyline, rho):
        array.setflags(write=False)
    return Path(
        points=polyline,
        clearances=rho,
        length=_length(polyline),
        min_clearance=gap,
        min_clearance_at=(x, y),
        robot_radius=radius,
        stations=tuple(stations),
        headings_rad=request.headings_rad,
        order=order,
    )
