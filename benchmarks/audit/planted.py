"""Random maps of cells, and random route graphs on them with faults planted in them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from planner import RouteEdge, RouteGraph, RouteNode, Scene, SpeedLevel
from planner.formats.grid_maps import GridPose, map_scene

FREE, OCCUPIED, UNKNOWN = 0, 1, 2
CELL_M: Final = 0.1
ROWS, COLUMNS = 90, 120
RADIUS_M: Final = 0.25
NODES: Final = 26
PLANTED: Final = 9
LIMITS: Final = (40, 70)
Cells = NDArray[np.int8]
Point = NDArray[np.float64]


@dataclass
class Case:
    """A map (0 free, 1 occupied, 2 unknown, row 0 the top), masks of zones and limits, and a graph.

    ``limits`` are in percent, 0 for none.
    """

    cells: Cells
    zones: NDArray[np.bool_]
    limits: Cells
    nodes: list[RouteNode] = field(default_factory=list)
    edges: list[RouteEdge] = field(default_factory=list)
    planted: list[tuple[str, str]] = field(default_factory=list)

    @property
    def graph(self) -> RouteGraph:
        return RouteGraph(tuple(self.nodes), tuple(self.edges), "nav2")

    @property
    def scene(self) -> Scene:
        unknown = self.cells == UNKNOWN
        return map_scene(self.cells != FREE, GridPose(CELL_M, 0.0, 0.0, 0.0), (), unknown)

    @property
    def keepout(self) -> Scene:
        return map_scene(self.zones, GridPose(CELL_M, 0.0, 0.0, 0.0), rim=False)

    @property
    def speed(self) -> tuple[SpeedLevel, ...]:
        pose = GridPose(CELL_M, 0.0, 0.0, 0.0)
        return tuple(
            SpeedLevel(map_scene(self.limits == limit, pose, rim=False), float(limit))
            for limit in LIMITS
            if (self.limits == limit).any()
        )

    def fresh(self) -> int:
        """A number that neither a node nor an edge has."""
        return 1 + max([0, *(int(one.id or 0) for one in (*self.nodes, *self.edges))])

    def add_node(self, x: float, y: float) -> int:
        number = self.fresh()
        self.nodes.append(RouteNode(number, float(x), float(y)))
        return number

    def add_edge(self, start: int, end: int, **more: Any) -> int:
        number = self.fresh()
        self.edges.append(RouteEdge(number, start, end, **more))
        return number

    def join(self, a: int, b: int) -> tuple[int, int]:
        return self.add_edge(a, b), self.add_edge(b, a)

    def place(self, number: int) -> Point:
        return next(np.array((n.x, n.y)) for n in self.nodes if n.id == number)


def random_map(rng: np.random.Generator) -> Case:
    """A map with zones, and no graph yet."""
    cells = np.zeros((ROWS, COLUMNS), np.int8)
    zones = np.zeros((ROWS, COLUMNS), np.bool_)
    for _ in range(14):
        r, c = rng.integers(0, ROWS), rng.integers(0, COLUMNS)
        h, w = rng.integers(1, 14, 2)
        kind = rng.choice((OCCUPIED, OCCUPIED, UNKNOWN))
        cells[r : r + h, c : c + w] = kind
    for _ in range(2):
        r, c = rng.integers(0, ROWS), rng.integers(0, COLUMNS)
        zones[r : r + rng.integers(2, 10), c : c + rng.integers(2, 10)] = True
    limits = np.zeros((ROWS, COLUMNS), np.int8)
    for limit in LIMITS:
        r, c = rng.integers(0, ROWS), rng.integers(0, COLUMNS)
        limits[r : r + rng.integers(10, 45), c : c + rng.integers(10, 45)] = limit
    return Case(cells, zones, limits)


def fill(case: Case, rng: np.random.Generator, is_sound: Callable[[Point, Point], bool]) -> None:
    """Make a graph without a fault; ``is_sound`` judges a line that is to be an edge."""
    size = np.array((COLUMNS, ROWS)) * CELL_M
    for _ in range(40 * NODES):
        place = rng.uniform(0.0, size)
        gaps = [np.hypot(n.x - place[0], n.y - place[1]) for n in case.nodes]
        if min(gaps, default=9.0) > 0.5 and is_sound(place, place):
            case.add_node(*place.tolist())
        if len(case.nodes) == NODES:
            break
    _connect(case, is_sound)


def _connect(case: Case, is_sound: Callable[[Point, Point], bool]) -> None:
    """Join near nodes by sound edges that cross none, and drop what is not in the largest part."""
    numbers = [int(n.id) for n in case.nodes]
    near = sorted(
        (float(np.hypot(*(case.place(a) - case.place(b)))), a, b)
        for a in numbers
        for b in numbers
        if a < b
    )
    kept: list[tuple[int, int]] = []
    part = {n: n for n in numbers}
    for length, a, b in near[: 5 * len(numbers)]:
        p, q = case.place(a), case.place(b)
        if length > 4.0 or not is_sound(p, q):
            continue
        others = [n for n in numbers if n not in (a, b)]
        if any(_to_segment(case.place(n), p, q) < 0.1 for n in others):
            continue
        if any(_cross(p, q, case.place(c), case.place(d)) for c, d in kept):
            continue
        kept.append((a, b))
        old, new = part[b], part[a]
        part = {n: new if root == old else root for n, root in part.items()}
    roots = list(part.values())
    largest = max(set(roots), key=lambda root: (roots.count(root), -root))
    case.nodes = [n for n in case.nodes if part[int(n.id)] == largest]
    for a, b in kept:
        if part[a] == largest:
            case.join(a, b)


def _to_segment(p: Point, a: Point, b: Point) -> float:
    d = b - a
    t = np.clip((p - a) @ d / max(d @ d, 1e-12), 0.0, 1.0)
    return float(np.hypot(*(p - a - t * d)))


def _cross(a: Point, b: Point, c: Point, d: Point) -> bool:
    def side(p: Point, q: Point, r: Point) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    return side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0


def plant(case: Case, rng: np.random.Generator) -> None:
    """Plant ``PLANTED`` faults of random kinds; ``case.planted`` says which, and where."""
    for _ in range(PLANTED):
        number = rng.integers(len(PLANTS))
        PLANTS[number](case, rng)


def _some_edge(case: Case, rng: np.random.Generator) -> int:
    return int(rng.integers(len(case.edges)))


def _some_node(case: Case, rng: np.random.Generator) -> int:
    return int(case.nodes[rng.integers(len(case.nodes))].id)


def _long_edge(case: Case, rng: np.random.Generator) -> None:
    """Two nodes anywhere on the map: through obstacles, unknown cells, zones, other edges."""
    a, b = rng.choice([int(n.id) for n in case.nodes], 2, replace=False).tolist()
    case.join(a, b)


def _anywhere(case: Case, rng: np.random.Generator) -> None:
    """A node anywhere, also a little off the map, joined to another."""
    size = np.array((COLUMNS, ROWS)) * CELL_M
    case.join(case.add_node(*rng.uniform(-0.5, size + 0.5)), _some_node(case, rng))


def _alone(case: Case, rng: np.random.Generator) -> None:
    number = case.add_node(*rng.uniform(0.0, (COLUMNS * CELL_M, ROWS * CELL_M)))
    case.planted.append(("node_alone", str(number)))


def _beside(case: Case, rng: np.random.Generator) -> tuple[int, int]:
    node = _some_node(case, rng)
    return node, case.add_node(*(case.place(node) + rng.normal(0.0, 0.3, 2)).tolist())


def _dead_end(case: Case, rng: np.random.Generator) -> None:
    node, end = _beside(case, rng)
    case.add_edge(node, end)
    case.planted.append(("node_dead_end", str(end)))


def _no_way_in(case: Case, rng: np.random.Generator) -> None:
    node, begin = _beside(case, rng)
    case.add_edge(begin, node)
    case.planted.append(("node_unreachable", str(begin)))


def _trap(case: Case, rng: np.random.Generator) -> None:
    node, one = _beside(case, rng)
    other = case.add_node(*(case.place(one) + rng.normal(0.0, 0.3, 2)).tolist())
    case.add_edge(node, one)
    case.join(one, other)
    case.planted.append(("node_without_return", str(other)))


def _twin_node(case: Case, rng: np.random.Generator) -> None:
    node = _some_node(case, rng)
    twin = case.add_node(*case.place(node).tolist())
    other = _some_node(case, rng)
    if other != node:
        case.join(twin, other)
        case.planted.append(("node_doubled", str(twin)))


def _twin_edge(case: Case, rng: np.random.Generator) -> None:
    edge = case.edges[_some_edge(case, rng)]
    case.planted.append(("edge_doubled", str(case.add_edge(edge.start, edge.end))))  # type: ignore[arg-type]


def _twin_id(case: Case, rng: np.random.Generator) -> None:
    edge, other = case.edges[_some_edge(case, rng)], _some_edge(case, rng)
    if case.edges[other].id != edge.id:
        case.edges[other] = replace(case.edges[other], id=edge.id)
        case.planted.append(("edge_id_taken", str(edge.id)))


def _no_length(case: Case, rng: np.random.Generator) -> None:
    node = _some_node(case, rng)
    case.planted.append(("edge_without_length", str(case.add_edge(node, node))))


def _no_node(case: Case, rng: np.random.Generator) -> None:
    number = case.add_edge(_some_node(case, rng), case.fresh() + 1000)
    case.planted.append(("edge_without_node", str(number)))


def _wrong_length(case: Case, rng: np.random.Generator) -> None:
    k = _some_edge(case, rng)
    edge = case.edges[k]
    ids = {node.id for node in case.nodes}
    if edge.start not in ids or edge.end not in ids:
        return
    length = float(np.hypot(*(case.place(edge.end) - case.place(edge.start))))  # type: ignore[arg-type]
    part = rng.choice((0.5, 0.9, 1.0, 1.1, 2.0))
    case.edges[k] = replace(edge, length=float(length * part))


def _own_limit(case: Case, rng: np.random.Generator) -> None:
    for _ in range(5):
        k = _some_edge(case, rng)
        case.edges[k] = replace(case.edges[k], speed_percent=float(rng.choice((40, 50, 70, 100))))


def _on_edge(case: Case, rng: np.random.Generator) -> None:
    """A node on an edge, or just beside it, joined to one of the edge's ends."""
    edge = case.edges[_some_edge(case, rng)]
    ids = {node.id for node in case.nodes}
    if edge.start == edge.end or edge.start not in ids or edge.end not in ids:
        return
    a, b = case.place(edge.start), case.place(edge.end)  # type: ignore[arg-type]
    aside = np.array((a[1] - b[1], b[0] - a[0])) / max(float(np.hypot(*(b - a))), 1e-9)
    place = a + rng.uniform(0.2, 0.8) * (b - a) + rng.choice((0.0, 0.0005, 0.004, 0.05)) * aside
    other = _some_node(case, rng)
    number = case.add_node(*place.tolist())
    if other not in (edge.start, edge.end):
        case.join(number, other)


PLANTS: Final = (
    *(_long_edge, _long_edge, _anywhere, _anywhere, _alone, _dead_end, _no_way_in, _trap),
    *(_twin_node, _twin_edge, _twin_id, _no_length, _no_node, _wrong_length, _on_edge),
    *(_own_limit, _own_limit),
)
