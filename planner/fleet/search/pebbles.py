"""Robots as pebbles on a graph, moved one at a time from one arrangement to another.

- ``near[n]`` are node n's neighbours; a move takes one pebble to an empty one.
- Both the start and the end arrangement change until they are equal: one node after the other,
  whose removal leaves the rest connected, gets the same pebble in both and is taken out. The moves
  of the second are reversed.
- While one pebble is brought to a node, all others are alike and can be arranged at will within
  each part that its node leaves of the graph. A state is thus its node and the number of others in
  each part: there are few, and the search always ends (Papadimitriou et al., "Motion planning on a
  graph", FOCS 1994; Auletta et al., "A linear-time algorithm for the feasibility of pebble motion
  on trees", Algorithmica 23, 1999).
"""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush

import numpy as np

Move = tuple[int, int, int]
"""(pebble, from node, to node)."""
Near = Sequence[Sequence[int]]
SPLITS_MOST = 400
"""Divisions of the others among a graph's parts that are tried for one step."""
CANDIDATES = 6
"""Nodes, and pebbles for each, that are tried before an order is given up."""
ORDERS = 8
"""Orders in which nodes are taken out: of 1079 small tasks that have a plan they find 1069."""


def rearrange(
    near: Near,
    start: Sequence[int],
    goal: Sequence[int],
    rng: np.random.Generator,
    expired: Callable[[], bool],
) -> list[Move] | None:
    """Moves of pebbles i from ``start[i]`` to ``goal[i]``, or None, which proves nothing.

    The nodes must be connected. Nodes far from the middle are taken out first, then in random
    orders.
    """
    depth = np.array(_depths(near))
    goals = np.isin(np.arange(len(near)), goal)
    # first nodes that hold a pebble at the end: it then has nothing to move there
    orders = [depth + len(near) * goals, depth]
    orders += [depth + rng.uniform(0.0, 2.0, len(near)) for _ in range(ORDERS - 2)]
    for order in orders:
        moves = _in_order(near, start, goal, order.tolist(), expired)
        if moves is not None or expired():
            return moves
    return None


def _in_order(
    near: Near,
    start: Sequence[int],
    goal: Sequence[int],
    order: Sequence[float],
    expired: Callable[[], bool],
) -> list[Move] | None:
    front, back = Arrangement(near, start), Arrangement(near, goal)
    left = set(range(len(near)))
    pebbles = set(range(len(start)))
    while any(front.at[i] != back.at[i] for i in pebbles):
        if expired() or not _settle_one(front, back, left, pebbles, order):
            return None
    return without_detours([*front.moves, *((i, v, u) for i, u, v in reversed(back.moves))])


class Arrangement:
    """Positions of the pebbles, and the moves that led there."""

    def __init__(self, near: Near, at: Sequence[int]) -> None:
        self.near = near
        self.at = list(at)
        self.on = {node: i for i, node in enumerate(at)}
        self.moves: list[Move] = []

    def move(self, u: int, v: int) -> None:
        """Move the pebble on node u to its empty neighbour v."""
        pebble = self.on.pop(u)
        self.on[v] = pebble
        self.at[pebble] = v
        self.moves.append((pebble, u, v))

    def copy(self) -> Arrangement:
        """Copy without moves."""
        return Arrangement(self.near, self.at)

    def shift(self, path: Sequence[int]) -> None:
        """Move every pebble along a path one towards its empty end, the last first."""
        empty = path[-1]
        for node in reversed(path[:-1]):
            if node in self.on:
                for u, v in _steps(path, node, empty):
                    self.move(u, v)
                empty = path[path.index(empty) - 1]

    def follow(self, moves: Sequence[Move]) -> None:
        """Make moves of an equal arrangement."""
        for _, u, v in moves:
            self.move(u, v)


def _steps(path: Sequence[int], node: int, to: int) -> Iterator[tuple[int, int]]:
    return itertools.pairwise(path[path.index(node) : path.index(to) + 1])


def _depths(near: Near) -> list[int]:
    reach = [max(_distances(near, n, set(range(len(near)))).values()) for n in range(len(near))]
    middle = max(range(len(near)), key=lambda n: (-reach[n], len(near[n])))
    far = _distances(near, middle, set(range(len(near))))
    return [far.get(n, 0) for n in range(len(near))]


def _distances(near: Near, begin: int, within: set[int]) -> dict[int, int]:
    found = {begin: 0}
    queue = deque([begin])
    while queue:
        n = queue.popleft()
        for m in near[n]:
            if m in within and m not in found:
                found[m] = found[n] + 1
                queue.append(m)
    return found


def _path(near: Near, begin: int, is_end: Callable[[int], bool], within: set[int]) -> list[int]:
    """Shortest path to the nearest end; empty if there is none."""
    parent = {begin: -1}
    queue = deque([begin])
    while queue:
        n = queue.popleft()
        if is_end(n):
            path = [n]
            while parent[path[-1]] >= 0:
                path.append(parent[path[-1]])
            return path[::-1]
        for m in near[n]:
            if m in within and m not in parent:
                parent[m] = n
                queue.append(m)
    return []


def _settle_one(
    front: Arrangement, back: Arrangement, left: set[int], pebbles: set[int], order: Sequence[float]
) -> bool:
    """Settle one pebble on one node in both arrangements; True on success."""
    free = sorted(_removable(front.near, left), key=lambda n: -order[n])
    for node in free[:CANDIDATES]:
        for i in _by_nearness(front, back, node, left, pebbles)[:CANDIDATES]:
            there = bring(front, i, node, left)
            here = bring(back, i, node, left) if there is not None else None
            if there is not None and here is not None:
                front.follow(there)
                back.follow(here)
                left.discard(node)
                pebbles.discard(i)
                return True
    return False


def _by_nearness(
    front: Arrangement, back: Arrangement, node: int, left: set[int], pebbles: set[int]
) -> list[int]:
    far = _distances(front.near, node, left)
    return sorted(pebbles, key=lambda i: (2 * far[back.at[i]] + far[front.at[i]], i))


def _removable(near: Near, left: set[int]) -> list[int]:
    return [n for n in left if len(_parts(near, n, left)) <= 1]


def _parts(near: Near, node: int, left: set[int]) -> list[set[int]]:
    rest = left - {node}
    parts = []
    for n in near[node]:
        if n in rest:
            part = set(_distances(near, n, rest))
            rest -= part
            parts.append(part)
    return parts


@dataclass(slots=True)
class _State:
    arrangement: Arrangement
    parent: _State | None
    cost: int


def bring(begin: Arrangement, pebble: int, node: int, left: set[int]) -> list[Move] | None:
    """Moves that bring one pebble to a node, the others anywhere; None if there are none."""
    near = begin.near
    far = _distances(near, node, left)
    first = _State(begin.copy(), None, 0)
    parts: dict[int, list[set[int]]] = {}
    heap = [(2 * far[begin.at[pebble]], 0, first)]
    count = itertools.count(1)
    done = set()
    while heap:
        _, _, state = heappop(heap)
        here = state.arrangement
        at = here.at[pebble]
        if at == node:
            return _moves_to(state)
        if at not in parts:
            parts[at] = _parts(near, at, left)
        key = (at, tuple(sum(n in here.on for n in part) for part in parts[at]))
        if key in done:
            continue
        done.add(key)
        for part in parts[at]:
            if all(n in here.on for n in part):
                continue
            for to in near[at]:
                if to in part:
                    for then in _steps_into(here, at, to, part):
                        cost = state.cost + len(then.moves)
                        rank = cost + 2 * far[to]
                        heappush(heap, (rank, next(count), _State(then, state, cost)))
    return None


def _moves_to(last: _State) -> list[Move]:
    states = []
    state: _State | None = last
    while state is not None:
        states.append(state.arrangement.moves)
        state = state.parent
    return [move for moves in reversed(states) for move in moves]


def _steps_into(here: Arrangement, at: int, to: int, part: set[int]) -> Iterator[Arrangement]:
    """Arrangements after the pebble's step from ``at`` to ``to``.

    One for each division of the part's others among the pieces that ``to`` leaves of it.
    """
    near = here.near
    pieces = _parts(near, to, part)
    robots = sum(n in here.on for n in part)
    counts = [sum(n in here.on for n in piece) for piece in pieces]
    capacities = [len(piece) for piece in pieces]
    shares = itertools.islice(_shares(robots, capacities), SPLITS_MOST)
    for share in sorted(
        shares, key=lambda s: sum(abs(a - b) for a, b in zip(s, counts, strict=True))
    ):
        then = here.copy()
        _share_out(then, to, pieces, share)
        then.move(at, to)
        yield then


def _shares(robots: int, capacities: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Divisions of robots among pieces with these capacities."""
    if not capacities:
        if robots == 0:
            yield ()
        return
    rest = sum(capacities[1:])
    for k in range(max(0, robots - rest), min(robots, capacities[0]) + 1):
        for others in _shares(robots - k, capacities[1:]):
            yield (k, *others)


def _share_out(
    here: Arrangement, through: int, pieces: Sequence[set[int]], share: Sequence[int]
) -> None:
    near = here.near
    while True:
        missing = [
            k - sum(n in here.on for n in piece) for k, piece in zip(share, pieces, strict=True)
        ]
        if through in here.on:
            within = pieces[max(range(len(pieces)), key=missing.__getitem__)] | {through}
            here.shift(_path(near, through, lambda n: n not in here.on, within))
        elif min(missing, default=0) < 0:
            within = pieces[min(range(len(pieces)), key=missing.__getitem__)] | {through}
            path = _path(near, through, lambda n: n in here.on, within)
            here.shift(path[::-1])
        else:
            return


def without_detours(moves: Sequence[Move]) -> list[Move]:
    """Drop the moves of pebbles that return to a node unused by others meanwhile."""
    kept = list(moves)
    changed = True
    while changed:
        changed = False
        last: dict[tuple[int, int], int] = {}
        for k, (i, u, v) in enumerate(kept):
            last.setdefault((i, u), k)
            begin = last.get((i, v))
            for other in [key for key in last if key[1] == v and key[0] != i]:
                del last[other]
            if begin is not None:
                kept = [
                    move for m, move in enumerate(kept) if not (begin <= m <= k and move[0] == i)
                ]
                changed = True
                break
    return kept
