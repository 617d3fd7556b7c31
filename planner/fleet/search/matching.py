"""Matchings of rows to columns at least cost: least sum, or least largest cost.

Costs (n, m) are infinite for an impossible pair; of the largest matchings the best is found,
exactly except for the last bits of its sum. Each row is matched along a shortest augmenting path
over reduced costs, O(n^2 (n + m)) in all (Jonker and Volgenant, Computing 38, 1987). Such a path
always exists, as a row may take a column of its own that costs more than any matching.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from planner.scene import FloatArray


def match_for_sum(costs: FloatArray) -> NDArray[np.int64]:
    """Column of each row, -1 for none: the least sum of the largest matchings."""
    rows, columns = costs.shape
    possible = np.isfinite(costs)
    worst = float(costs[possible].max(initial=0.0)) - float(costs[possible].min(initial=0.0)) + 1.0
    none = worst * (rows + 1.0)
    wide = np.full((rows, columns + rows), np.inf)
    wide[:, :columns] = np.where(possible, costs - costs[possible].min(initial=0.0), np.inf)
    wide[np.arange(rows), columns + np.arange(rows)] = none
    chosen = np.full(rows, -1)
    owner = np.full(columns + rows, -1)
    price = np.zeros(columns + rows)
    for row in range(rows):
        _augment(row, wide, price, owner, chosen)
    return np.where(chosen < columns, chosen, -1)


def _augment(
    row: int,
    costs: FloatArray,
    price: FloatArray,
    owner: NDArray[np.int64],
    chosen: NDArray[np.int64],
) -> None:
    """Match one more row along the shortest augmenting path; prices keep reduced costs >= 0."""
    columns = len(price)
    far = costs[row] - price
    parent = np.full(columns, row)
    done = np.zeros(columns, np.bool_)
    while True:
        column = int(np.argmin(np.where(done, np.inf, far)))
        done[column] = True
        if owner[column] < 0:
            break
        other = int(owner[column])
        # the other row may change to any column at this cost: its own has reduced cost zero
        through = far[column] + costs[other] - price - (costs[other, column] - price[column])
        nearer = ~done & (through < far)
        far[nearer] = through[nearer]
        parent[nearer] = other
    price[done] += far[done] - far[column]
    while True:
        other = int(parent[column])
        owner[column] = other
        column, chosen[other] = int(chosen[other]), column
        if other == row:
            return


def match_for_last(costs: FloatArray) -> NDArray[np.int64]:
    """Column of each row, -1 for none; of the largest matchings, the least largest cost.

    Among those with this largest cost, the least sum.
    """
    most = int((match_for_sum(costs) >= 0).sum())
    levels = np.unique(costs[np.isfinite(costs)])
    low, high = 0, len(levels) - 1
    while low < high:
        middle = (low + high) // 2
        allowed = np.where(costs <= levels[middle], 0.0, np.inf)
        if int((match_for_sum(allowed) >= 0).sum()) == most:
            high = middle
        else:
            low = middle + 1
    limit = levels[low] if len(levels) else 0.0
    return match_for_sum(np.where(costs <= limit, costs, np.inf))
