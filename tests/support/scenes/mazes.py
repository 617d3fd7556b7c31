"""Grids that are large in one way: mazes with one long way, and a plate with many holes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Grid = NDArray[np.bool_]


def maze(side: int, rng: np.random.Generator) -> Grid:
    """A maze (side, side) without loops, side odd, True is wall: rooms at odd places."""
    wall = np.ones((side, side), np.bool_)
    wall[1, 1] = False
    stack = [(1, 1)]
    while stack:
        y, x = stack[-1]
        steps = [(2, 0), (-2, 0), (0, 2), (0, -2)]
        ahead = [
            (y + dy, x + dx)
            for dy, dx in steps
            if 0 < y + dy < side and 0 < x + dx < side and wall[y + dy, x + dx]
        ]
        if not ahead:
            stack.pop()
            continue
        v, u = ahead[int(rng.integers(len(ahead)))]
        wall[v, u] = wall[(y + v) // 2, (x + u) // 2] = False
        stack.append((v, u))
    return wall


def noise(side: int, rng: np.random.Generator) -> Grid:
    """Every cell an obstacle or not, as a coin falls."""
    return rng.random((side, side)) < 0.5


def plate(holes: int) -> Grid:
    """One obstacle with ``holes`` times ``holes`` square holes, two cells wide and two apart."""
    grid = np.ones((4 * holes + 2, 4 * holes + 2), np.bool_)
    for dy in (2, 3):
        for dx in (2, 3):
            grid[dy::4, dx::4] = False
    grid[:, 0] = False
    return grid
