"""Contact times of two discs on straight lines, in closed form.

Rules and units
- A motion starts at (x, y) at its start time with velocity (vx, vy) and lasts ``lasts``; a disc at
  rest has velocity zero. Lengths are in the graph's units, times in its units at unit speed.
- ``gap`` is the least distance of the centres, the sum of both radii.
- The delays between two motions at which they come nearer than the gap are one open interval:
  nearness is convex in both times, and so is its projection on one axis.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF

NEVER = math.inf
INSTANT = 1e-9
"""Nearness that lasts no longer is rounding: touching for an instant."""


@njit(**LEAF)
def near_times(x, y, vx, vy, lasts, gap):
    """Times within [0, lasts] when a moving point is nearer to the origin than ``gap``: (from, to).

    (NEVER, -NEVER) if it never is. Points at rest are near always or never.
    """
    a = vx * vx + vy * vy
    b = x * vx + y * vy
    c = x * x + y * y - gap * gap
    if a == 0.0:
        return (0.0, lasts) if c < 0.0 else (NEVER, -NEVER)
    inner = b * b - a * c
    if inner <= 0.0:
        return NEVER, -NEVER
    root = math.sqrt(inner)
    # first the root without cancellation, the other by their product
    q = -(b + math.copysign(root, b))
    one, other = q / a, c / q if q != 0.0 else 0.0
    begin, end = max(min(one, other), 0.0), min(max(one, other), lasts)
    return (begin, end) if begin < end else (NEVER, -NEVER)


@njit(**LEAF)
def forbidden_delays(x, y, first, second, gap):
    """Delays of the first motion after the second at which they come too near: (from, to).

    The vector (x, y) leads from the second motion's start to the first's; both motions are (vx, vy,
    lasts). (NEVER, -NEVER) if no delay is forbidden.

    In the plane (s, t) of the times since each start, nearness is |p + s v - t w| < gap, a convex
    set; within the box [0, lasts1] x [0, lasts2] the delay t - s is extreme where the box's sides
    cut it, or where its own outline is touched inside.
    """
    vx, vy, lasts1 = first
    wx, wy, lasts2 = second
    low, high = NEVER, -NEVER
    # the first at a fixed time s, at its start and end: the second moves past a disc at rest
    for s in (0.0, lasts1):
        begin, end = near_times(x + s * vx, y + s * vy, -wx, -wy, lasts2, gap)
        if begin <= end:
            low, high = min(low, begin - s), max(high, end - s)
    for t in (0.0, lasts2):
        begin, end = near_times(x - t * wx, y - t * wy, vx, vy, lasts1, gap)
        if begin <= end:
            low, high = min(low, t - end), max(high, t - begin)
    return _touched_inside(x, y, first, second, gap, low, high)


@njit(**LEAF)
def _touched_inside(x, y, first, second, gap, low, high):
    """The interval widened by extremes of t - s inside the box.

    There the gradient of the squared distance is along (-1, 1). With d = p + s v - t w, 2 d.v = -k
    and -2 d.w = k, so d.(v - w) = 0, and |d| = gap.
    """
    vx, vy, lasts1 = first
    wx, wy, lasts2 = second
    ux, uy = vx - wx, vy - wy
    speed = math.hypot(ux, uy)
    cross = vx * wy - vy * wx
    if speed == 0.0 or cross == 0.0:
        return low, high
    for side in (-gap, gap):
        # d = side * (perpendicular of u): p + s v - t w = d, two equations for s and t
        rx, ry = -side * uy / speed - x, side * ux / speed - y
        s = (rx * wy - ry * wx) / cross
        t = (rx * vy - ry * vx) / cross
        if 0.0 <= s <= lasts1 and 0.0 <= t <= lasts2:
            low, high = min(low, t - s), max(high, t - s)
    return low, high


@njit(**LEAF)
def do_steps_touch(first, second, gap):
    """True if two discs that begin together, each (x, y, vx, vy, lasts), come nearer than the gap.

    Each rests at its end after arrival; touching for an instant is allowed.
    """
    ax, ay, avx, avy, a_lasts = first
    bx, by, bvx, bvy, b_lasts = second
    both = min(a_lasts, b_lasts)
    begin, end = near_times(ax - bx, ay - by, avx - bvx, avy - bvy, both, gap)
    if end - begin > INSTANT:
        return True
    x, y = ax - bx + both * (avx - bvx), ay - by + both * (avy - bvy)
    vx, vy = (avx, avy) if a_lasts > b_lasts else (-bvx, -bvy)
    begin, end = near_times(x, y, vx, vy, max(a_lasts, b_lasts) - both, gap)
    if end - begin > INSTANT:
        return True
    ex = ax + a_lasts * avx - bx - b_lasts * bvx
    ey = ay + a_lasts * avy - by - b_lasts * bvy
    return ex * ex + ey * ey < gap * gap * (1.0 - INSTANT)
