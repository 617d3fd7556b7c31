"""Paths over lanes and one-way zones: a lazy search over the lanes' lines and free connections.

- Nodes are the leg's ends, places of the lanes' lines, those nearest to the ends among them, and
  gates just outside a one-way zone, through which it is entered and left. Nodes of a line are at
  least a gate's distance apart, however finely the line is drawn.
- A lane's pieces join its own nodes, in its direction for a one-way zone; the roadmap's paths join
  all others, around one-way zones.
- A free connection costs at least its straight length on the cheapest lane. Only those on the
  cheapest sequence of nodes are planned, until none is left there (lazy shortest paths; Dellin and
  Srinivasa, ICAPS 2016), or ``MOST_PLANS`` are: then the cheapest complete sequence counts.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from planner.borders.polyline import arc_lengths, moves
from planner.scene import FloatArray, Vec
from planner.zones.areas import BandArea
from planner.zones.rules import Rules
from planner.zones.zone_ground import ZoneGround

MOST_PLANS = 60
"""Connections planned for one leg: chosen, 0.1 s among a hundred obstacles."""
GATES_BESIDE = 1.02
"""Distance of gates, in what the body needs to be outside: chosen."""

OUTSIDE = -3
"""Lanes of gates, each its own, count down from here: defined, -1 and -2 are the leg's ends."""

Connect = Callable[[FloatArray, FloatArray], FloatArray | None]
"""Plans a free connection between two places: a polyline (n, 2) that breaks no rule, or None."""


@dataclass(slots=True)
class LaneNetwork:
    """Places, pieces of lanes as polylines between two, and nodes to connect freely."""

    places: list[FloatArray] = field(default_factory=list)
    pieces: dict[tuple[int, int], FloatArray] = field(default_factory=dict)
    free: list[int] = field(default_factory=list)
    lane: list[int] = field(default_factory=list)
    """Two nodes of one lane are not connected freely."""

    def add(self, place: FloatArray, lane: int, *, free: bool) -> int:
        """Add a node; return its number."""
        self.places.append(place)
        self.lane.append(lane)
        if free:
            self.free.append(len(self.places) - 1)
        return len(self.places) - 1

    def join(
        self, i: int, j: int, keeps: Callable[[FloatArray], bool], line: FloatArray | None = None
    ) -> None:
        """Join two nodes by a polyline (n, 2), else straight, if it is free."""
        if line is None:
            line = np.array([self.places[i], self.places[j]])
        if keeps(line):
            self.pieces[i, j] = line


def cheapest(
    start: Vec,
    goal: Vec,
    rules: Rules,
    keeps: Callable[[FloatArray], bool],
    connect: Connect,
    need: float,
) -> FloatArray | None:
    """Return the cheapest polyline (n, 2) from start to goal by lanes or freely; None if none.

    ``keeps`` is True for lines clear of obstacles and keep-out zones and not against a one-way
    zone; ``need`` is the distance that gates keep from their zone.
    """
    net = LaneNetwork()
    begin = net.add(np.array(start), -1, free=True)
    end = net.add(np.array(goal), -2, free=True)
    for number, one in enumerate(rules.of("one_way", "lane")):
        _lay_lane(net, number, one, keeps, need)
    return _search(net, begin, end, rules, connect)


def _lay_lane(
    net: LaneNetwork,
    number: int,
    one: ZoneGround,
    keeps: Callable[[FloatArray], bool],
    need: float,
) -> None:
    area = one.zone.area
    assert isinstance(area, BandArea)
    one_way = one.zone.kind == "one_way"
    aside = GATES_BESIDE * (0.5 * area.width + need)
    line, at = _with_feet(np.array(area.line), net.places[:2], aside)
    nodes = {k: net.add(line[k], number, free=not one_way) for k in at}
    for a, b in pairwise(at):
        net.join(nodes[a], nodes[b], keeps, line[a : b + 1])
        if not one_way:
            net.join(nodes[b], nodes[a], keeps, line[a : b + 1][::-1])
    if not one_way:
        return
    for k, node in nodes.items():
        ahead = one.directions(line[k][None])[0]
        left = np.array([-ahead[1], ahead[0]])
        gates = [line[k] + aside * left, line[k] - aside * left]
        if k == 0:
            gates.append(line[k] - aside * ahead)
        for gate in gates:
            _add_gate(net, gate, node, keeps, enters=True)
        if k == 0:
            gates.pop()
        if k == at[-1]:
            gates.append(line[k] + aside * ahead)
        for gate in gates:
            _add_gate(net, gate, node, keeps, enters=False)
        for end in range(2):  # a leg may begin or end inside
            inside = one.distances(net.places[end][None])[0] < 0.0
            if inside and math.dist(net.places[end], line[k]) < aside:
                net.join(*((end, node) if end == 0 else (node, end)), keeps)


def _add_gate(
    net: LaneNetwork,
    gate: FloatArray,
    node: int,
    keeps: Callable[[FloatArray], bool],
    *,
    enters: bool,
) -> None:
    line = np.array([gate, net.places[node]] if enters else [net.places[node], gate])
    if keeps(line):
        at = net.add(gate, OUTSIDE - len(net.places), free=True)
        net.pieces[(at, node) if enters else (node, at)] = line


def _with_feet(
    line: FloatArray, places: list[FloatArray], apart: float
) -> tuple[FloatArray, list[int]]:
    """The line (n, 2) with its places nearest to two others, and the rows of its nodes.

    Nodes are its ends, those two, and further places that are ``apart`` from the node before.
    """
    along = arc_lengths(line)
    feet_at: list[float] = []
    for place in places:
        step = np.diff(line, axis=0)
        length = np.diff(along)
        share = np.clip(((place - line[:-1]) * step).sum(axis=1) / length**2, 0.0, 1.0)
        feet = line[:-1] + share[:, None] * step
        k = int(np.argmin(np.hypot(*(feet - place).T)))
        feet_at.append(float(along[k] + share[k] * length[k]))
    where = np.unique([*along, *feet_at])
    nodes = [0]
    for row, here in enumerate(where.tolist()):
        if row and (here in feet_at or row == len(where) - 1 or here - where[nodes[-1]] >= apart):
            nodes.append(row)
    with_feet = np.column_stack([np.interp(where, along, line[:, axis]) for axis in range(2)])
    return with_feet, nodes


def _search(
    net: LaneNetwork, begin: int, end: int, rules: Rules, connect: Connect
) -> FloatArray | None:
    count = len(net.places)
    places, lane = np.array(net.places), np.array(net.lane)
    cost = np.full((count, count), np.inf)
    lines: dict[tuple[int, int], FloatArray] = dict(net.pieces)
    free = np.zeros(count, np.bool_)
    free[net.free] = True
    apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    open_ = free[:, None] & free[None] & (lane[:, None] != lane[None])
    open_[:, begin] = open_[end, :] = False
    cost[open_] = rules.least_factor() * apart[open_]
    for (i, j), line in net.pieces.items():
        cost[i, j], open_[i, j] = rules.cost(line), False
    for _ in range(MOST_PLANS):
        sequence = _shortest(cost, begin, end)
        if sequence is None:
            return None
        unplanned = [(i, j) for i, j in pairwise(sequence) if open_[i, j]]
        if not unplanned:
            return _joined([lines[pair] for pair in pairwise(sequence)])
        for i, j in unplanned:
            found, open_[i, j] = connect(places[i], places[j]), False
            cost[i, j] = math.inf if found is None else rules.cost(found)
            if found is not None:
                lines[i, j] = found
    cost[open_] = np.inf
    sequence = _shortest(cost, begin, end)
    return None if sequence is None else _joined([lines[pair] for pair in pairwise(sequence)])


def _shortest(cost: FloatArray, begin: int, end: int) -> list[int] | None:
    """Dijkstra's algorithm on a dense matrix (n, n) of costs."""
    count = len(cost)
    best, before = np.full(count, np.inf), np.full(count, -1)
    best[begin] = 0.0
    left = np.ones(count, np.bool_)
    while True:
        at = int(np.argmin(np.where(left, best, np.inf)))
        if not left[at] or not np.isfinite(best[at]):
            return None
        if at == end:
            break
        left[at] = False
        through = best[at] + cost[at]
        better = through < best
        best[better], before[better] = through[better], at
    sequence = [end]
    while sequence[-1] != begin:
        sequence.append(int(before[sequence[-1]]))
    return sequence[::-1]


def _joined(lines: list[FloatArray]) -> FloatArray:
    points = np.concatenate([lines[0][:1], *(line[1:] for line in lines)])
    return np.ascontiguousarray(points[moves(points)])
