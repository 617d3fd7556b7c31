"""Rest of a plan from each robot's progress: tracks from now on, without new delays.

Time zero is now; a track begins at the row that its robot reached last. A robot begins each piece
once it is there and its dependencies are met; planned waits without a dependency are dropped.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from planner.fleet.fleet_plan import FleetPlan
from planner.fleet.motions.interval_search_kernels import HORIZON
from planner.scene import FloatArray


def retimed(plan: FleetPlan, passed: Sequence[int]) -> list[tuple[FloatArray, list[int]]] | None:
    """Each robot's track from now on, and for each of its planned rows the new row.

    None if the remaining robots wait for each other in a circle.
    """
    needs: dict[tuple[int, int], list[tuple[int, int]]] = defaultdict(list)
    for robot, needed, waiting, row in plan.dependencies:
        if passed[robot] < needed:
            needs[waiting, row].append((robot, needed))
    reached = [{row: 0.0} for row in passed]
    left: list[dict[int, float]] = [{} for _ in passed]
    at = list(passed)
    moved = True
    while moved:
        moved = False
        for i, track in enumerate(plan.tracks):
            while at[i] + 1 < len(track):
                asked = needs[i, at[i]]
                if any(needed not in reached[j] for j, needed in asked):
                    break
                begin = max([reached[i][at[i]], *(reached[j][needed] for j, needed in asked)])
                stands = (track[at[i], 1:] == track[at[i] + 1, 1:]).all()
                lasts = 0.0 if stands else float(track[at[i] + 1, 0] - track[at[i], 0])
                left[i][at[i]] = begin
                reached[i][at[i] + 1] = begin + lasts
                at[i] += 1
                moved = True
    if any(at[i] + 1 < len(track) for i, track in enumerate(plan.tracks)):
        return None
    return [
        _rows(track, row, reached[i], left[i])
        for i, (track, row) in enumerate(zip(plan.tracks, passed, strict=True))
    ]


def _rows(
    track: FloatArray, first: int, reached: dict[int, float], left: dict[int, float]
) -> tuple[FloatArray, list[int]]:
    rows: list[tuple[float, float, float]] = []
    number = [0] * len(track)
    for k in range(first, len(track)):
        x, y = track[k, 1:].tolist()
        if not rows or rows[-1] != (reached[k], x, y):
            rows.append((reached[k], x, y))
        number[k] = len(rows) - 1
        if k in left and left[k] > reached[k]:
            rows.append((left[k], x, y))
    return np.array(rows), number


def moves_of(track: FloatArray, radius: float) -> FloatArray:
    """Rows of ``moves`` of a track, as in ``interval_search_kernels``, at rest at its end."""
    lasts = np.append(np.diff(track[:, 0]), HORIZON)
    step = np.vstack([np.diff(track[:, 1:], axis=0), [[0.0, 0.0]]])
    moves = np.column_stack(
        [track[:, 1:], step / np.maximum(lasts, np.finfo(float).tiny)[:, None],
         track[:, 0], lasts, np.full(len(track), radius)]
    )  # fmt: skip
    return np.ascontiguousarray(moves[lasts > 0.0])
