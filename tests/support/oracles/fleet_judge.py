"""An independent judge of fleet plans: closest approaches in continuous time, and brute force.

Nothing here knows the planner's kernels. A track is rows t, x, y, standing after its end.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

Edge = tuple[int, int]


def place_at(track: np.ndarray, t: float) -> np.ndarray:
    return np.array(
        [np.interp(t, track[:, 0], track[:, 1]), np.interp(t, track[:, 0], track[:, 2])]
    )


def closest_approach(one: np.ndarray, other: np.ndarray) -> float:
    """The least distance of two centres at any time: a parabola between each two of all times."""
    times = np.unique(np.concatenate([[0.0], one[:, 0], other[:, 0]]))
    best = float(np.hypot(*(place_at(one, times[-1]) - place_at(other, times[-1]))))
    for a, b in itertools.pairwise(times.tolist()):
        begin = place_at(one, a) - place_at(other, a)
        step = place_at(one, b) - place_at(other, b) - begin
        moved = float(step @ step)
        share = min(max(-float(begin @ step) / moved, 0.0), 1.0) if moved > 0.0 else 0.0
        best = min(best, float(np.hypot(*(begin + share * step))))
    return best


def least_gap(tracks: Sequence[np.ndarray], radii: Sequence[float]) -> float:
    """What is left between the two discs that come nearest; negative where they overlap."""
    return min(
        (
            closest_approach(tracks[i], tracks[j]) - radii[i] - radii[j]
            for i, j in itertools.combinations(range(len(tracks)), 2)
        ),
        default=math.inf,
    )


def judge_on_graph(
    nodes: np.ndarray, edges: Sequence[Edge], starts: Sequence[int], goals: Sequence[int],
    tracks: Sequence[np.ndarray], radius: float,
) -> None:  # fmt: skip
    """Each track is of unit speed along edges from its start to its goal, and none touch."""
    nodes = np.asarray(nodes, dtype=float)
    ways = {(*nodes[a].tolist(), *nodes[b].tolist()) for a, b in np.asarray(edges).tolist()}
    assert len(tracks) == len(starts)
    for track, start, goal in zip(tracks, starts, goals, strict=True):
        assert track[0].tolist() == [0.0, *nodes[start].tolist()]
        assert track[-1, 1:].tolist() == nodes[goal].tolist()
        for (t, x, y), (u, v, w) in itertools.pairwise(track.tolist()):
            length = math.hypot(v - x, w - y)
            if (x, y) == (v, w):
                assert u >= t
            else:
                assert (x, y, v, w) in ways
                assert u - t == np.float64(u - t)
                assert math.isclose(u - t, length, rel_tol=1e-9, abs_tol=1e-9 * (1.0 + u))
    assert least_gap(tracks, [radius] * len(tracks)) >= -1e-7


def has_joint_plan(
    nodes: np.ndarray, edges: Sequence[Edge], radius: float, starts: Sequence[int],
    goals: Sequence[int],
) -> bool:  # fmt: skip
    """Breadth first over all configurations: every step that moves any robots along one edge."""
    nodes = np.asarray(nodes, dtype=float)
    after = {n: {n} for n in range(len(nodes))}
    for a, b in edges:
        after[a].add(b)

    def track(u: int, v: int) -> np.ndarray:
        lasts = float(np.hypot(*(nodes[v] - nodes[u])))
        return np.array([[0.0, *nodes[u]], [lasts, *nodes[v]]])

    known: dict[tuple[int, int, int, int], bool] = {}

    def clear(u: int, v: int, w: int, x: int) -> bool:
        if (u, v, w, x) not in known:
            known[u, v, w, x] = closest_approach(track(u, v), track(w, x)) >= 2.0 * radius - 1e-9
        return known[u, v, w, x]

    seen, queue = {tuple(starts)}, [tuple(starts)]
    while queue:
        at = queue.pop(0)
        if at == tuple(goals):
            return True
        for then in itertools.product(*(sorted(after[n]) for n in at)):
            if then not in seen and all(
                clear(at[i], then[i], at[j], then[j])
                for i, j in itertools.combinations(range(len(at)), 2)
            ):
                seen.add(then)
                queue.append(then)
    return False


def delayed(
    tracks: Sequence[np.ndarray], dependencies: Sequence[tuple[int, int, int, int]],
    rng: np.random.Generator, most_s: float,
) -> list[np.ndarray]:  # fmt: skip
    """The tracks as driven with random delays at every point, keeping the dependencies only."""
    needs: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for first, passed, waiting, row in dependencies:
        needs.setdefault((waiting, row), []).append((first, passed))
    driven = [[(0.0, *track[0, 1:])] for track in tracks]
    reached = [[0.0] for _ in tracks]
    while any(len(reached[i]) < len(track) for i, track in enumerate(tracks)):
        before = [len(r) for r in reached]
        for i, track in enumerate(tracks):
            row = len(reached[i]) - 1
            if row + 1 >= len(track):
                continue
            asked = needs.get((i, row), [])
            if any(passed >= len(reached[j]) for j, passed in asked):
                continue
            leaves = max([reached[i][-1], *(reached[j][passed] for j, passed in asked)])
            leaves += rng.uniform(0.0, most_s) * (rng.random() < 0.3)
            length = np.hypot(*(track[row + 1, 1:] - track[row, 1:]))
            lasts = 0.0 if length == 0.0 else track[row + 1, 0] - track[row, 0]
            driven[i] += [(leaves, *track[row, 1:]), (leaves + lasts, *track[row + 1, 1:])]
            reached[i].append(leaves + lasts)
        assert [len(r) for r in reached] != before, "a deadlock: all wait for each other"
    return [np.array(rows) for rows in driven]
