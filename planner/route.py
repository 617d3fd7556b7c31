"""From a request to a path: attach the stations, search the chains, prove the answer.

Rules and units
- Stations attach inside a chain, by retraction: straight away from the nearest border until a
  second one is as near, and then onto the chain.
- Every answer is proved at the end: the exact distance of the whole polyline to every border
  is at least the radius and the margin, or it is no answer.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice, pairwise

import numpy as np

from planner import bisector_kernels, distance_kernels, search_kernels
from planner.agvd import Chains
from planner.bisectors import EQUAL
from planner.corridor import pull_taut
from planner.generators import Borders
from planner.path import NoPath, Path
from planner.scene import FloatArray, IntArray, Vec
from planner.tour import best_tour

PREFERENCES = {"length": 0.0, "balanced": 0.5, "clearance": 1.0}
"""The names of ``prefer`` and the numbers they stand for."""
DETOUR = 4.0
"""How much longer a step at a clearance of one radius may be, at the preference just below 1."""
ROOM = 2.0
"""Radii of clearance kept on top of the first, where there is room, per unit of preference."""
ROUTES = 4
"""Routes over different chains that are compared."""
TRIES = 8
"""Searches made for every alternative wanted: many of them find a way that is known already."""
PENALTY = 1.4
"""How much dearer a chain becomes with every route that took it."""
NEAR = 0.25
"""A retracted place this near to a chain, in radii, has met it."""
ENTRIES = 8
"""Chains tried as a station's way onto the roadmap."""
FLATNESS = 0.02
"""How far a path may leave the bisector it follows, in radii, where there is room."""
ROUNDING = 1e-9
"""Clearances are equal within this share of the scene's extent."""


@dataclass(frozen=True, slots=True)
class Request:
    """What is asked for: ``stations`` are start, every via, goal, with a heading or None."""

    stations: tuple[Vec, ...]
    headings_rad: tuple[float | None, ...]
    preference: float
    best_order: bool
    alternatives: int
    margin: float

    def in_order(self, order: Sequence[int]) -> Request:
        """The same request with its vias in another order."""
        picked = (0, *(i + 1 for i in order), len(self.stations) - 1)
        return replace(
            self,
            stations=tuple(self.stations[i] for i in picked),
            headings_rad=tuple(self.headings_rad[i] for i in picked),
        )

    @classmethod
    def of(
        cls,
        start: Sequence[float],
        goal: Sequence[float],
        prefer: str | float,
        via: Sequence[Sequence[float]],
        order: str,
        alternatives: int,
        margin: float,
    ) -> Request:
        """Parse the arguments of ``Roadmap.plan``; ``ValueError`` says what is wrong."""
        named = [("start", start), *((f"via[{i}]", v) for i, v in enumerate(via)), ("goal", goal)]
        parsed = [_station(name, value) for name, value in named]
        if order not in ("fixed", "best"):
            raise ValueError(f"order = {order!r}: must be 'fixed' or 'best'")
        if not (math.isfinite(margin) and margin >= 0.0):
            raise ValueError(f"margin = {margin}: must be >= 0 and finite")
        if int(alternatives) != alternatives or alternatives < 0:
            raise ValueError(f"alternatives = {alternatives}: must be a whole number >= 0")
        return cls(
            tuple(p[0] for p in parsed),
            tuple(p[1] for p in parsed),
            _preference(prefer),
            order == "best",
            int(alternatives),
            float(margin),
        )


def _station(name: str, value: Sequence[float]) -> tuple[Vec, float | None]:
    numbers = [float(v) for v in value]
    if len(numbers) not in (2, 3) or not all(math.isfinite(v) for v in numbers):
        raise ValueError(f"{name} = {tuple(value)}: must be x, y or x, y, heading, all finite")
    return (numbers[0], numbers[1]), numbers[2] if len(numbers) == 3 else None


def _preference(prefer: str | float) -> float:
    if isinstance(prefer, str):
        if prefer not in PREFERENCES:
            raise ValueError(f"prefer = {prefer!r}: must be one of {', '.join(PREFERENCES)}")
        return PREFERENCES[prefer]
    value = float(prefer)
    if not 0.0 <= value <= 1.0:
        raise ValueError(f"prefer = {prefer}: must be from 0 (length) to 1 (clearance)")
    return value


@dataclass(frozen=True, slots=True)
class Line:
    """A polyline (n, 2) and the pieces (n, 2) that each link runs between, -1 where straight."""

    points: FloatArray
    pairs: IntArray

    def reversed(self) -> Line:
        """The same line the other way round: left and right change places."""
        pairs = np.full_like(self.pairs, -1)
        pairs[:-1] = self.pairs[:-1][::-1, ::-1]
        return Line(self.points[::-1], pairs)

    @classmethod
    def straight(cls, points: FloatArray) -> Line:
        """A line between no two pieces."""
        return cls(points, np.full((len(points), 2), -1, np.int32))


@dataclass(frozen=True, slots=True)
class Entry:
    """A station's way onto chain ``chain`` at point ``link`` + ``part`` of its link.

    ``access`` (n, 2) runs from the station to the place on the chain; ``gap`` is its exact
    clearance. ``to_end`` are cost and clearance from there to the chain's two ends.
    """

    chain: int
    link: int
    part: float
    access: FloatArray
    cost: float
    gap: float
    to_end: tuple[tuple[float, float], tuple[float, float]]


def plan_request(
    borders: Borders, chains: Chains, radius: float, request: Request
) -> Path | NoPath:
    """Answer a request on measured chains, for a disc of ``radius``."""
    need = radius + request.margin
    vias = (f"station {i}" for i in range(1, len(request.stations) - 1))
    names = ["the start", *vias, "the goal"]
    for name, place in zip(names, request.stations, strict=True):
        if reason := why_not(borders, name, place, need):
            return NoPath(reason)
    order = tuple(range(len(request.stations) - 2))
    if request.best_order and len(order) > 1:
        order = _best_order(borders, chains, request, need)
    request = request.in_order(order)
    tries = TRIES * request.alternatives + (ROUTES if request.preference < 1.0 else 1)
    legs: list[list[FloatArray]] = []
    for a, b in pairwise(request.stations):
        found = plan_leg(borders, chains, a, b, need, request.preference, tries)
        if not found:
            return NoPath(f"no way from {_at(a)} to {_at(b)} is {2 * need:g} wide throughout")
        legs.append(found)
    best = _as_path(borders, [leg[0] for leg in legs], radius, request, order)
    if not request.alternatives:
        return best
    others = (_as_path(borders, choice, radius, request, order) for choice in _others(legs))
    return replace(best, alternatives=tuple(islice(others, request.alternatives)))


def _others(legs: list[list[FloatArray]]) -> Iterator[list[FloatArray]]:
    """Ways that differ from the best in one leg, the next best of each leg first."""
    for rank in range(1, max(len(leg) for leg in legs)):
        for i, leg in enumerate(legs):
            if rank < len(leg):
                yield [leg[rank] if j == i else other[0] for j, other in enumerate(legs)]


def _best_order(borders: Borders, chains: Chains, request: Request, need: float) -> tuple[int, ...]:
    """The order of the vias that makes the way over the chains shortest."""
    floor = need - ROUNDING * borders.extent
    cost, total = search_kernels.chain_costs(
        chains.rho, chains.gap, chains.step, chains.first, chains.length, need,
        DETOUR * request.preference
    )  # fmt: skip
    ways = [attach(borders, chains, place, floor, cost) for place in request.stations]
    m = len(ways)
    matrix = np.full((m, m), np.inf)
    for i in range(m):
        matrix[i, i] = 0.0
        for j in range(i + 1, m):
            if request.stations[i] == request.stations[j]:
                matrix[i, j] = matrix[j, i] = 0.0
            elif ways[i] and ways[j]:
                far = _cost_between(chains, total, cost, ways[i], ways[j], floor)
                matrix[i, j] = matrix[j, i] = far
    tour = best_tour(matrix)
    if not math.isfinite(tour.cost):
        return tuple(range(m - 2))
    return tuple(i - 1 for i in tour.order)


def widest_way(
    borders: Borders, chains: Chains, stations: Sequence[Vec]
) -> tuple[float, Vec] | None:
    """The largest radius that can make the journey, and where it is narrowest, or None."""
    narrowest: tuple[float, Vec] | None = None
    cost, total = search_kernels.chain_costs(
        chains.rho, chains.gap, chains.step, chains.first, chains.length, 1.0, 0.0
    )
    least = ROUNDING * borders.extent
    for a, b in pairwise(stations):
        if a == b:
            continue
        entries = attach(borders, chains, a, least, cost)
        exits = attach(borders, chains, b, least, cost)
        if not entries or not exits:
            return None
        gap = _widest_gap(chains, entries, exits)
        if gap <= least:
            return None
        route = _cheapest(chains, total, cost, entries, exits, gap * (1.0 - 1e-12))
        if route is None:
            return None
        way = _certain(borders, route[0], gap)
        if way is None:
            return None
        wide, x, y, _, _ = distance_kernels.polyline_clearance(*borders.tree, way)
        if narrowest is None or wide < narrowest[0]:
            narrowest = (wide, (x, y))
    return narrowest


def why_not(borders: Borders, name: str, place: Vec, need: float) -> str | None:
    """Why a disc of radius ``need`` cannot stand there, or None where it can."""
    x, y = place
    box = borders.box
    if not (box[0] <= x <= box[2] and box[1] <= y <= box[3]):
        return f"{name} {_at(place)} lies outside the bounds"
    distance, which = distance_kernels.nearest(*borders.tree, x, y, np.inf)
    inside = np.flatnonzero(borders.owners_around(x, y, distance))
    if len(inside):
        return f"{name} {_at(place)} lies inside obstacle {inside[0]}"
    if distance < need - ROUNDING * borders.extent:
        owner = borders.owner[which]
        what = "the bounds" if owner < 0 else f"obstacle {owner}"
        return (
            f"{name} {_at(place)} is {distance:.6g} from {what}, "
            f"nearer than the radius and margin of {need:g}"
        )
    return None


def _at(place: Vec) -> str:
    return f"({place[0]:g}, {place[1]:g})"


def plan_leg(
    borders: Borders,
    chains: Chains,
    start: Vec,
    goal: Vec,
    need: float,
    preference: float,
    wanted: int = ROUTES,
) -> list[FloatArray]:
    """Polylines from start to goal with clearance >= ``need``, the preferred one first.

    Up to ``wanted`` routes over different chains, each as its corridor's shortest way that keeps
    ``1 + ROOM * preference`` radii off the borders where there is room; with the preference 1
    the route itself, the widest there is. Empty where there is no way.
    """
    if start == goal:
        return [np.array([start, goal])]
    if wanted <= ROUTES and _is_clear(borders, start, goal, need, preference):
        return [np.array([start, goal])]
    floor = need - ROUNDING * borders.extent
    cost, total = search_kernels.chain_costs(
        chains.rho, chains.gap, chains.step, chains.first, chains.length, need, DETOUR * preference
    )
    for anywhere in (False, True):
        entries = attach(borders, chains, start, floor, cost, anywhere)
        exits = attach(borders, chains, goal, floor, cost, anywhere)
        if not entries or not exits:
            continue
        least = floor
        if preference >= 1.0:
            least = max(floor, _widest_gap(chains, entries, exits) * (1.0 - 1e-12))
        found: list[tuple[float, FloatArray]] = []
        seen: set[frozenset[int]] = set()
        dearer = total.copy()
        for _ in range(wanted):
            route = _cheapest(chains, dearer, cost, entries, exits, least)
            if route is None:
                break
            line, used = route
            dearer[list(used)] *= PENALTY
            least = floor
            if used in seen:
                continue
            seen.add(used)
            way = _finish(borders, line, need, preference, alone=wanted <= ROUTES)
            if way is not None:
                found.append((_judge(borders, way, need, preference), way))
        if found and preference < 1.0:
            found.sort(key=lambda pair: pair[0])
        if found:
            return [way for _, way in found]
    return []


def _is_clear(borders: Borders, start: Vec, goal: Vec, need: float, preference: float) -> bool:
    """Whether the straight line is as far off the borders as the preference asks.

    The widest way (preference 1) is never cut short.
    """
    if preference >= 1.0:
        return False
    ends = np.array([start, goal])
    rho, _ = borders.distances(ends)
    return _keeps(borders, ends, float(rho.min()), need, preference)


def _keeps(
    borders: Borders, line: FloatArray, standing: float, need: float, preference: float
) -> bool:
    """Whether a line keeps ``1 + ROOM * preference`` radii, or what its ends have (standing)."""
    gap, *_ = distance_kernels.polyline_clearance(*borders.tree, line)
    wish = min(need * (1.0 + ROOM * preference), standing)
    return bool(gap >= max(need, wish) - ROUNDING * borders.extent)


def _finish(
    borders: Borders, line: Line, need: float, preference: float, *, alone: bool
) -> FloatArray | None:
    """The route as a proved polyline: taut, or as it is where that cannot be proved.

    ``alone``: no alternatives are wanted, so it may be cut short across to another side of an
    obstacle.
    """
    if preference >= 1.0:
        return _certain(borders, line, need)
    keep = need * (1.0 + ROOM * preference)
    way = pull_taut(borders, line.points, line.pairs, keep, need)
    if way is None:
        way = _certain(borders, line, need)
    if way is None or not alone:
        return way
    way = _cut_short(borders, way, need, preference)
    return np.ascontiguousarray(_cut_short(borders, way[::-1], need, preference)[::-1])


def _cut_short(borders: Borders, way: FloatArray, need: float, preference: float) -> FloatArray:
    """The way with straight lines put in where they keep their distance; never longer.

    From each point the line to the last one is tried, then to one half as far, and so on:
    O(n log n) lines for n points.
    """
    way = np.ascontiguousarray(way)
    rho, _ = borders.distances(way)
    kept = [0]
    while kept[-1] < len(way) - 1:
        here = kept[-1]
        step = len(way) - 1 - here
        while step > 1:
            ends = np.ascontiguousarray(way[[here, here + step]])
            standing = float(min(rho[here], rho[here + step]))
            if _keeps(borders, ends, standing, need, preference):
                break
            step //= 2
        kept.append(here + step)
    return np.ascontiguousarray(way[kept])


def _judge(borders: Borders, way: FloatArray, need: float, preference: float) -> float:
    """What a way costs: its length, and more where it is narrow."""
    steps = np.hypot(*np.diff(way, axis=0).T)
    if preference == 0.0:
        return float(steps.sum())
    middles = 0.5 * (way[1:] + way[:-1])
    rho, _ = borders.distances(middles)
    return float((steps * (1.0 + DETOUR * preference * need / np.maximum(rho, need))).sum())


def _certain(borders: Borders, line: Line, need: float) -> FloatArray | None:
    """The line's polyline, close enough to the bisectors to keep ``need``, or None."""
    points: FloatArray
    points, _ = bisector_kernels.follow(
        *borders.tree,
        np.ascontiguousarray(line.points),
        np.ascontiguousarray(line.pairs),
        need,
        FLATNESS * need,
        EQUAL * borders.extent,
    )
    gap = distance_kernels.polyline_clearance(*borders.tree, points)[0]
    return points if gap >= need - 2.0 * ROUNDING * borders.extent else None


def attach(
    borders: Borders,
    chains: Chains,
    place: Vec,
    floor: float,
    cost: FloatArray,
    anywhere: bool = False,
) -> list[Entry]:
    """Ways from a place onto the chains, each with clearance >= ``floor``; the nearest first.

    Where retraction meets a chain that chain is the way; with ``anywhere``, or where it meets
    none, any of the nearest chains that a straight line reaches.
    """
    x, y, _, _, _ = search_kernels.retract(*borders.tree, *place, 2.0 * borders.extent)
    ridge = (x, y)
    usable = np.ones(len(chains), dtype=np.bool_)
    found = search_kernels.nearest_links(chains.points, chains.first, usable, x, y, ENTRIES)
    entries: list[Entry] = []
    for chain, link, part, away in zip(*(a.tolist() for a in found), strict=True):
        if chain < 0:
            break
        met = found[3][0] <= NEAR * floor and not anywhere
        if met and entries and away > found[3][0] + ROUNDING * borders.extent:
            break
        a, b = chains.points[link], chains.points[min(link + 1, chains.first[chain + 1] - 1)]
        foot = a + part * (b - a)
        if chains.proved[link]:
            left, right = chains.pieces[link]
            foot[0], foot[1], _ = bisector_kernels.slide_between(
                borders.kind, borders.data, left, right, foot[0], foot[1], EQUAL * borders.extent
            )
        access = np.array([place, ridge, foot])
        gap = distance_kernels.polyline_clearance(*borders.tree, access)[0]
        if gap < floor:
            continue
        ends = _to_ends(chains, cost, chain, link, part)
        length = math.dist(place, ridge) + away
        entries.append(Entry(chain, link, part, access, length, gap, ends))
    return entries


def _to_ends(
    chains: Chains, cost: FloatArray, chain: int, link: int, part: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Cost and clearance from a place inside a chain to its first and to its last point."""
    lo, hi = int(chains.first[chain]), int(chains.first[chain + 1]) - 1
    if lo == hi:
        return ((0.0, float(chains.rho[lo])),) * 2
    back = float(cost[lo:link].sum() + part * cost[link])
    ahead = float(cost[link + 1 : hi].sum() + (1.0 - part) * cost[link])
    return (
        (back, float(chains.gap[lo : link + 1].min())),
        (ahead, float(chains.gap[link:hi].min())),
    )


def _gates(
    chains: Chains, entries: list[Entry]
) -> tuple[IntArray, FloatArray, FloatArray, list[tuple[Entry, int]]]:
    node, cost, gap, who = [], [], [], []
    for entry in entries:
        for end in range(2):
            node.append(chains.ends[entry.chain, end])
            cost.append(entry.cost + entry.to_end[end][0])
            gap.append(min(entry.gap, entry.to_end[end][1]))
            who.append((entry, end))
    return np.array(node, np.int32), np.array(cost), np.array(gap), who


def _widest_gap(chains: Chains, entries: list[Entry], exits: list[Entry]) -> float:
    """The largest clearance a way from any entry to any exit can keep."""
    around, leaving = search_kernels.adjacency(chains.ends, len(chains.node_xy))
    s_node, _, s_gap, _ = _gates(chains, entries)
    g_node, _, g_gap, _ = _gates(chains, exits)
    best = search_kernels.widest(
        around, leaving, chains.ends, chains.clearance, s_node, s_gap, g_node, g_gap
    )
    for a in entries:
        for b in exits:
            if a.chain == b.chain:
                best = max(best, min(a.gap, b.gap, _between_gap(chains, a, b)))
    return float(best)


def _between_gap(chains: Chains, a: Entry, b: Entry) -> float:
    lo, hi = min(a.link, b.link), max(a.link, b.link)
    if chains.first[a.chain + 1] - chains.first[a.chain] == 1:
        return float(chains.rho[lo])
    return float(chains.gap[lo : hi + 1].min())


def _cheapest(
    chains: Chains,
    total: FloatArray,
    cost: FloatArray,
    entries: list[Entry],
    exits: list[Entry],
    floor: float,
) -> tuple[Line, frozenset[int]] | None:
    """The route and its chains: the cheapest way from any entry to any exit, or None."""
    around, leaving = search_kernels.adjacency(chains.ends, len(chains.node_xy))
    s_node, s_cost, s_gap, s_who = _gates(chains, entries)
    g_node, g_cost, g_gap, g_who = _gates(chains, exits)
    s_cost = np.where(s_gap >= floor, s_cost, np.inf)
    g_cost = np.where(g_gap >= floor, g_cost, np.inf)
    best, entry, out, steps = search_kernels.cheapest(
        around, leaving, chains.ends, total, chains.clearance, floor,
        s_node, s_cost, g_node, g_cost
    )  # fmt: skip
    direct: tuple[Entry, Entry] | None = None
    for a in entries:
        for b in exits:
            if a.chain != b.chain or min(a.gap, b.gap, _between_gap(chains, a, b)) < floor:
                continue
            here = a.cost + b.cost + abs(_position(cost, a) - _position(cost, b))
            if here < best:
                best, direct = here, (a, b)
    if not math.isfinite(best):
        return None
    if direct is not None:
        a, b = direct
        inner = _inner(chains, a, b)
        return _join([_arrive(a), inner, _arrive(b).reversed()]), frozenset({a.chain})
    (a, a_end), (b, b_end) = s_who[entry], g_who[out]
    pieces = [_arrive(a), _to_end_line(chains, a, a_end)]
    for step in steps.tolist():
        c, end = divmod(step, 2)
        line = _part(chains, chains.first[c], chains.first[c + 1])
        pieces.append(line if end == 0 else line.reversed())
    pieces += [_to_end_line(chains, b, b_end).reversed(), _arrive(b).reversed()]
    return _join(pieces), frozenset([a.chain, b.chain, *(steps // 2).tolist()])


def _cost_between(
    chains: Chains,
    total: FloatArray,
    cost: FloatArray,
    entries: list[Entry],
    exits: list[Entry],
    floor: float,
) -> float:
    """What the cheapest way costs, infinity where there is none."""
    route = _cheapest(chains, total, cost, entries, exits, floor)
    if route is None:
        return math.inf
    return float(np.hypot(*np.diff(route[0].points, axis=0).T).sum())


def _position(cost: FloatArray, entry: Entry) -> float:
    return float(cost[: entry.link].sum() + entry.part * cost[entry.link])


def _part(chains: Chains, lo: int, hi: int) -> Line:
    """The chain's points from lo up to hi, hi excluded; unproved links are straight."""
    pairs = np.where(chains.proved[lo:hi, None], chains.pieces[lo:hi], np.int32(-1))
    return Line(chains.points[lo:hi], pairs)


def _arrive(entry: Entry) -> Line:
    """The straight way from a station to its place on a chain."""
    return Line.straight(entry.access)


def _inner(chains: Chains, a: Entry, b: Entry) -> Line:
    """The chain between two places on it."""
    if (a.link, a.part) <= (b.link, b.part):
        inner = _part(chains, a.link, b.link + 1)
        points = np.concatenate([a.access[-1:], inner.points[1:], b.access[-1:]])
        return Line(points, np.concatenate([inner.pairs, [[-1, -1]]]).astype(np.int32))
    return _inner(chains, b, a).reversed()


def _to_end_line(chains: Chains, entry: Entry, end: int) -> Line:
    """The chain from a place inside it to one of its ends."""
    lo, hi = int(chains.first[entry.chain]), int(chains.first[entry.chain + 1])
    if hi - lo == 1:
        return Line.straight(entry.access[-1:])
    if end == 0:
        back = _part(chains, lo, entry.link + 1)
        points = np.concatenate([back.points, entry.access[-1:]])
        pairs = np.concatenate([back.pairs, [[-1, -1]]]).astype(np.int32)
        return Line(points, pairs).reversed()
    ahead = _part(chains, entry.link, hi)
    return Line(np.concatenate([entry.access[-1:], ahead.points[1:]]), ahead.pairs)


def _join(lines: list[Line]) -> Line:
    """One line without repeated points; each starts where the one before it ends."""
    lines = [line for line in lines if len(line.points)]
    points = np.concatenate([line.points for line in lines])
    pairs = np.concatenate([line.pairs for line in lines])
    kept = np.ones(len(points), dtype=np.bool_)
    kept[:-1] = np.any(points[1:] != points[:-1], axis=1)
    return Line(points[kept], pairs[kept])


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
    steps = np.diff(polyline, axis=0)
    for array in (polyline, rho):
        array.setflags(write=False)
    return Path(
        points=polyline,
        clearances=rho,
        length=float(np.hypot(steps[:, 0], steps[:, 1]).sum()),
        min_clearance=gap,
        min_clearance_at=(x, y),
        robot_radius=radius,
        stations=tuple(stations),
        headings_rad=request.headings_rad,
        order=order,
    )
