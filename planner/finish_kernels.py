"""Cutting a way short and judging it, on flat arrays: many straight lines tried in one call.

Rules and units
- A straight line is kept where its exact distance to every border is at least what is asked.
- A way's points stand where they stand: where both ends of a line are nearer to a border than is
  wished for, the line may be as near as they are, but never nearer than is needed.
"""

# The arrays' types are in the docstrings; numba infers them.
# mypy: disable-error-code="no-untyped-def,no-untyped-call"

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.distance_kernels import nearest, segment_clearance


@njit(cache=True, nogil=True)
def cut_short(kind, data, order, large, boxes, way, need, wish, rounding):
    """The way (n, 2) with straight lines put in, from its start on and then from its end.

    From each point the line to the last one is tried, then to one half as far, and so on:
    O(n log n) lines for n points. A line keeps ``wish``, or what its ends have where that is
    less, but no less than ``need``; all of it less ``rounding``.
    """
    xy = way.copy()
    rho = np.empty(len(way))
    for i in range(len(way)):
        rho[i], _ = nearest(kind, data, order, large, boxes, xy[i, 0], xy[i, 1], np.inf)
    n = len(way)
    for _ in range(2):
        here, m = 0, 1
        while here < n - 1:
            step = n - 1 - here
            while step > 1:
                there = here + step
                keep = max(need, min(wish, min(rho[here], rho[there]))) - rounding
                _, _, which = segment_clearance(
                    kind, data, order, large, boxes,
                    xy[here, 0], xy[here, 1], xy[there, 0], xy[there, 1], keep,
                )  # fmt: skip
                if which < 0:
                    break
                step //= 2
            here += step
            xy[m, 0], xy[m, 1], rho[m] = xy[here, 0], xy[here, 1], rho[here]
            m += 1
        n = m
        for i in range(n // 2):  # the other way round: after both turns it is as it was
            j = n - 1 - i
            for c in range(2):
                xy[i, c], xy[j, c] = xy[j, c], xy[i, c]
            rho[i], rho[j] = rho[j], rho[i]
    return xy[:n].copy()


@njit(cache=True, nogil=True)
def judge(kind, data, order, large, boxes, way, need, weight):
    """The way's length, each step 1 + ``weight * need / clearance`` as dear, there >= need."""
    total = 0.0
    for i in range(len(way) - 1):
        ax, ay, bx, by = way[i, 0], way[i, 1], way[i + 1, 0], way[i + 1, 1]
        step = math.hypot(bx - ax, by - ay)
        if weight > 0.0:
            x, y = 0.5 * (ax + bx), 0.5 * (ay + by)
            rho, _ = nearest(kind, data, order, large, boxes, x, y, np.inf)
            step *= 1.0 + weight * need / max(rho, need)
        total += step
    return total
