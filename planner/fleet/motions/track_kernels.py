"""Two robots' tracks: their least distance, and the pieces that share a place.

Rules and units
- A track is (k, 3) of t, x, y with k >= 1, t >= 0 and never falling; the robot stays at the last
  place for ever.
- Nothing is sampled: between two rows of either track both robots move straight and evenly, with
  the least distance where the derivative of its square is zero.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.fleet.motions.motion_kernels import forbidden_delays
from planner.scene.compile_options import LEAF, OWNING


@njit(**LEAF)
def _place_at(track, row, t):
    """Place at a time within the piece that begins with a row."""
    if row + 1 >= track.shape[0] or track[row + 1, 0] <= track[row, 0]:
        return track[row, 1], track[row, 2]
    share = (t - track[row, 0]) / (track[row + 1, 0] - track[row, 0])
    share = min(max(share, 0.0), 1.0)
    return (
        track[row, 1] + share * (track[row + 1, 1] - track[row, 1]),
        track[row, 2] + share * (track[row + 1, 2] - track[row, 2]),
    )


@njit(**LEAF)
def least_distance(one, other):
    """Least distance of two robots' centres at any time, and when: (distance, time)."""
    best, when = math.inf, 0.0
    i, j = 0, 0
    t = 0.0
    while True:
        while i + 1 < one.shape[0] and one[i + 1, 0] <= t:
            i += 1
        while j + 1 < other.shape[0] and other[j + 1, 0] <= t:
            j += 1
        ax, ay = _place_at(one, i, t)
        bx, by = _place_at(other, j, t)
        x, y = ax - bx, ay - by
        then = math.inf
        if i + 1 < one.shape[0]:
            then = one[i + 1, 0]
        if j + 1 < other.shape[0]:
            then = min(then, other[j + 1, 0])
        share = 0.0
        if then < math.inf:
            ax, ay = _place_at(one, i, then)
            bx, by = _place_at(other, j, then)
            dx, dy = ax - bx - x, ay - by - y
            moved = dx * dx + dy * dy
            if moved > 0.0:
                share = min(max(-(x * dx + y * dy) / moved, 0.0), 1.0)
            x, y = x + share * dx, y + share * dy
        distance = math.hypot(x, y)
        if distance < best:
            best = distance
            when = t + share * (then - t) if share > 0.0 else t
        if then == math.inf:
            return best, when
        t = then


@njit(**LEAF)
def _motion(track, k):
    """A piece of a track for ``forbidden_delays``: (vx, vy, lasts)."""
    lasts = track[k + 1, 0] - track[k, 0]
    if lasts <= 0.0:
        return 0.0, 0.0, 0.0
    return (
        (track[k + 1, 1] - track[k, 1]) / lasts, (track[k + 1, 2] - track[k, 2]) / lasts, lasts,
    )  # fmt: skip


@njit(**LEAF)
def _are_apart(one, k, other, m, gap):
    """True if the boxes of two pieces are further apart than the gap."""
    for c in range(1, 3):
        low, high = min(one[k, c], one[k + 1, c]), max(one[k, c], one[k + 1, c])
        if min(other[m, c], other[m + 1, c]) - high >= gap:
            return True
        if low - max(other[m, c], other[m + 1, c]) >= gap:
            return True
    return False


@njit(**LEAF)
def find_order(one, other, gap, wait_for, waits_for):
    """Find the order at shared places of two tracks, two rows or more each, that never touch.

    For each piece of ``other`` from row m, ``wait_for[m]`` becomes the row of ``one`` to be passed
    before, -1 if none; ``waits_for`` is the reverse. The delays at which two pieces would touch are
    one interval; the side of the plan's own delay decides the order. Consecutive pieces near the
    same piece are on the same side, so no robot waits in the way.
    """
    wait_for[:] = -1
    waits_for[:] = -1
    for k in range(one.shape[0] - 1):
        for m in range(other.shape[0] - 1):
            if _are_apart(one, k, other, m, gap):
                continue
            low, high = forbidden_delays(
                one[k, 1] - other[m, 1], one[k, 2] - other[m, 2], _motion(one, k),
                _motion(other, m), gap,
            )  # fmt: skip
            if low > high:
                continue
            delay = one[k, 0] - other[m, 0]
            if delay - low <= high - delay:
                wait_for[m] = max(wait_for[m], k + 1)
            else:
                waits_for[k] = max(waits_for[k], m + 1)


@njit(**OWNING)
def nearest_pair(flat, first, radii):
    """Pair of tracks with the least distance beyond its radii: (margin, i, j, time).

    Track i is rows ``first[i]`` to ``first[i + 1]`` of ``flat``.
    """
    margin, one, other, when = math.inf, -1, -1, 0.0
    for i in range(radii.shape[0]):
        for j in range(i + 1, radii.shape[0]):
            distance, t = least_distance(
                flat[first[i] : first[i + 1]], flat[first[j] : first[j + 1]]
            )
            if distance - radii[i] - radii[j] < margin:
                margin, one, other, when = distance - radii[i] - radii[j], i, j, t
    return margin, one, other, when


@njit(**OWNING)
def order_of_pair(one, other, gap):
    """Allocate and run ``find_order``: (wait_for (m - 1,), waits_for (k - 1,))."""
    wait_for = np.empty(max(other.shape[0] - 1, 0), np.int64)
    waits_for = np.empty(max(one.shape[0] - 1, 0), np.int64)
    find_order(one, other, gap, wait_for, waits_for)
    return wait_for, waits_for
