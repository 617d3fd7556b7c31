"""The light across every crack of a border, and both plateaus beside it.

Rules and units
- As in ``vision.borders.edge_kernels``.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from planner.scene import FloatArray
from planner.scene.compile_options import LEAF, SUMS

DIRECTION_REACH = 3
"""Cracks to either side that give the border's direction."""
TAP0, TAP1, TAP2 = 0.40261995, 0.24420134, 0.05448868
"""A Gaussian of sigma 1 on five pixels."""
PIXELS_BEHIND, PROFILE_PIXELS = 4, 10
"""Pixels of a profile behind its obstacle pixel, and in all."""
ROWS = PROFILE_PIXELS + 15
"""Rows behind a ``Profiles``."""


class Profiles(NamedTuple):
    """Profiles of a border's cracks and their results: a column a crack."""

    profile: FloatArray
    """(PROFILE_PIXELS, k): grey values, from obstacle to free."""
    middle_x: FloatArray
    """Twice a crack's middle, with DIRECTION_REACH cracks more at both ends."""
    middle_y: FloatArray
    clear: FloatArray
    """1 where both plateaus are there, else 0."""
    chosen: FloatArray
    """1 where the crack gives a point."""
    slanted: FloatArray
    """1 where the border runs aslant."""
    dark: FloatArray
    """The plateaus beside the crack."""
    light: FloatArray
    near: FloatArray
    """The smoothed profile at the obstacle pixel and at the free one."""
    far: FloatArray
    dark_level: FloatArray
    """The plateaus of its stretch."""
    light_level: FloatArray
    crossing: FloatArray
    """Crossing of the half level, in pixels from the obstacle pixel."""
    astray: FloatArray
    """1 where that lies beyond the crack's own two pixels."""
    wall: FloatArray
    """1 where the obstacle is three or four pixels wide."""
    gap: FloatArray
    """1 where the free space is."""


@njit(**LEAF)
def out(direction):
    """Step from a crack's obstacle pixel to its free one: x and y."""
    return (direction & 1) * (2 - direction), (1 - (direction & 1)) * (direction - 1)


@njit(**LEAF, forceinline=True)
def locate(grey, xs, ys, directions, n, work, places):
    """Place of every crack, and its profile's value at the obstacle pixel.

    ``places`` (2, k): a crack's obstacle pixel in the picture, and the offset to the free one.
    """
    width = grey.shape[1]
    flat_grey = grey.reshape(-1)
    here = work.profile[PIXELS_BEHIND]
    at = places[0]
    step = places[1]
    for i in range(n):
        x = np.int64(xs[i])
        y = np.int64(ys[i])
        nx, ny = out(np.int64(directions[i]))
        work.middle_x[DIRECTION_REACH + i] = 2 * x + nx
        work.middle_y[DIRECTION_REACH + i] = 2 * y + ny
        at[i] = y * width + x
        step[i] = ny * width + nx
        work.crossing[i] = 0.0
        work.clear[i] = 1.0
    for i in range(n):
        here[i] = flat_grey[np.uint64(at[i])]
    for i in range(DIRECTION_REACH):
        work.middle_x[i] = work.middle_x[n + i]
        work.middle_y[i] = work.middle_y[n + i]
        work.middle_x[n + DIRECTION_REACH + i] = work.middle_x[DIRECTION_REACH + i]
        work.middle_y[n + DIRECTION_REACH + i] = work.middle_y[DIRECTION_REACH + i]


@njit(**LEAF)
def look_at_mask(mask, width, xs, ys, directions, n, clear):
    """Set ``clear`` from a mask not made from these grey values: three pixels to either side.

    Not for cracks near the picture's edge.
    """
    height = mask.shape[0] - 2
    stride = mask.shape[1]
    flat = mask.reshape(-1)
    for i in range(n):
        clear[i] = flat[np.uint64((ys[i] + 1) * stride + xs[i] + 1)] & 1
    for i in range(n):
        x = np.int64(xs[i])
        y = np.int64(ys[i])
        if 5 <= x < width - 5 and 5 <= y < height - 5:
            nx, ny = out(np.int64(directions[i]))
            # unsigned: no index counts from the end
            across = np.uint64(ny * stride + nx)
            here = np.uint64((y + 1) * stride + x + 1)
            dark = flat[here - across] & flat[here - across - across]
            ahead = here + across + across
            clear[i] = dark & ~(flat[ahead] | flat[ahead + across]) & 1


@njit(**LEAF, forceinline=True)
def gather(grey, mask, xs, ys, directions, n, work, places):
    """Gather the rest of the profile across every crack.

    ``clear`` is found here if the profile leaves the picture. ``crossing`` is -1 if the free pixel
    is outside.
    """
    height, width = grey.shape
    flat_grey = grey.reshape(-1)
    for i in range(n):
        x = np.int64(xs[i])
        y = np.int64(ys[i])
        if 5 <= x < width - 5 and 5 <= y < height - 5:
            # unsigned: no index counts from the end
            at = np.uint64(places[0, i])
            step = np.uint64(places[1, i])
            there = at
            for k in range(PIXELS_BEHIND - 1, -1, -1):
                there -= step
                work.profile[k, i] = flat_grey[there]
            there = at
            for k in range(PIXELS_BEHIND + 1, PROFILE_PIXELS):
                there += step
                work.profile[k, i] = flat_grey[there]
            continue
        nx, ny = out(np.int64(directions[i]))
        for k in range(PROFILE_PIXELS):
            px = min(max(x + (k - PIXELS_BEHIND) * nx, 0), width - 1)
            py = min(max(y + (k - PIXELS_BEHIND) * ny, 0), height - 1)
            work.profile[k, i] = grey[py, px]
        work.clear[i] = 1.0 if _is_clear(mask, x, y, nx, ny, width, height) else 0.0
        if not (0 <= x + nx < width and 0 <= y + ny < height):
            work.crossing[i] = -1.0


@njit(**LEAF)
def _is_clear(mask, x, y, nx, ny, width, height):
    for k in range(1, 3):
        px = x - k * nx
        py = y - k * ny
        if px < 0 or py < 0 or px >= width or py >= height or mask[py + 1, px + 1] & 1 == 0:
            return False
    for k in range(1, 4):
        px = x + k * nx
        py = y + k * ny
        if px < 0 or py < 0 or px >= width or py >= height:
            return k > 1
        if mask[py + 1, px + 1] & 1:
            return False
    return True


@njit(**LEAF, forceinline=True)
def look_along(directions, n, work):
    """Mark cracks that give a point, and slanted parts of the border."""
    for i in range(n):
        dx = abs(work.middle_x[i + 2 * DIRECTION_REACH] - work.middle_x[i])
        dy = abs(work.middle_y[i + 2 * DIRECTION_REACH] - work.middle_y[i])
        upright = directions[i] & 1 == 1
        across = dx if upright else dy
        along = dy if upright else dx
        work.chosen[i] = 1.0 if across <= along else 0.0
        work.slanted[i] = 1.0 if across > 1.0 else 0.0


@njit(**LEAF, forceinline=True)
def look_beside(level, by_level, n, work):
    """Find the plateaus beside every crack, and the profile smoothed at its two pixels.

    A plateau is the mean of two pixels; the nearer one if the outer may be at the far side; the
    middle in a narrow wall or gap.
    """
    pixels = work.profile
    a4, a3, a2, a1, here = pixels[0], pixels[1], pixels[2], pixels[3], pixels[4]
    b1, b2, b3, b4, b5 = pixels[5], pixels[6], pixels[7], pixels[8], pixels[9]
    if by_level:
        for i in range(n):
            dark_side = (a1[i] < level) & (a2[i] < level)
            light_side = (b2[i] >= level) & (b3[i] >= level)
            work.clear[i] = work.clear[i] if dark_side & light_side else 0.0
    for i in range(n):
        three = a3[i] >= level
        four = a4[i] >= level
        five = a4[i] + a4[i] > a2[i] + level
        middle = a1[i] if three else 0.5 * (a1[i] + a2[i])
        beyond = a2[i] if five else 0.5 * (a2[i] + a3[i])
        work.dark[i] = middle if three | four else beyond
        work.wall[i] = 1.0 if three | four else 0.0
        three = b4[i] < level
        four = b5[i] < level
        five = b5[i] + b5[i] < b3[i] + level
        middle = b2[i] if three else 0.5 * (b2[i] + b3[i])
        beyond = b3[i] if five else 0.5 * (b3[i] + b4[i])
        work.light[i] = middle if three | four else beyond
        work.gap[i] = 1.0 if three | four else 0.0
        work.near[i] = TAP0 * here[i] + TAP1 * (a1[i] + b1[i]) + TAP2 * (a2[i] + b2[i])
        work.far[i] = TAP0 * b1[i] + TAP1 * (here[i] + b2[i]) + TAP2 * (a1[i] + b3[i])
    # where a narrow wall looks wide, at its corners, there is no plateau either
    if 2.0 * _sum(work.wall[:n]) > n:
        work.wall[:n] = 1.0
    if 2.0 * _sum(work.gap[:n]) > n:
        work.gap[:n] = 1.0


@njit(**SUMS)
def _sum(row):
    total = 0.0
    for i in range(row.shape[0]):
        total += row[i]
    return total
