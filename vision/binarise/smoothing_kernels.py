"""A picture with less noise, only as far as it is looked at.

Rules and units
- Grey values are whole, 0 .. 255. A smoothing is three weights, of the centre, of what is next
  to it and of what is next but one, in both directions; their sum, squared, is ``norm``: at
  most 256, so that sums stay within 16 bits.
- Beyond the picture's edge it is mirrored, the pixels of the edge themselves not repeated.
- Everything is worked out row by row in two rows of room, whole rows at a time.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF, OWNING
from vision.binarise.binarise_kernels import count_greys, sample_steps, summed

MARGIN = 2
"""Pixels that the smoothing reaches beyond one: defined, of five weights."""


@njit(**OWNING)
def calmed_histogram(grey, weights, norm):
    """How many of the sampled pixels have each smoothed grey value, rounded: (256,) int64."""
    height, width = grey.shape
    counters = np.zeros((4, 256), np.uint32)
    sums = np.empty(width + 2 * MARGIN, np.uint16)
    line = np.empty(width, np.uint8)
    rows, columns = sample_steps(height, width)
    for y in range(0, height, rows):
        sum_rows(grey, y, weights, sums)
        _divide(sums, weights, norm, line)
        count_greys(line[(y // rows) % columns :], columns, counters)
    return summed(counters)


@njit(**LEAF)
def sum_limit(bound, norm):
    """The sum from which on a smoothed grey value is rounded to more than ``bound``."""
    return np.uint16(min(max((bound + 1) * norm - norm // 2, 0), 65535))


@njit(**LEAF)
def _mirrored(i, count):
    """Where in 0 .. count - 1 a row or column up to two beyond the edge is looked for."""
    if count == 1:
        return 0
    i = abs(i)
    last = count - 1
    return abs(last - abs(last - i))


@njit(**LEAF)
def sum_rows(grey, y, weights, sums):
    """The weighted sums over five rows around row ``y``, with the margin at both ends."""
    height, width = grey.shape
    _weigh(
        grey[_mirrored(y - 2, height)],
        grey[_mirrored(y - 1, height)],
        grey[y],
        grey[_mirrored(y + 1, height)],
        grey[_mirrored(y + 2, height)],
        weights,
        sums[MARGIN : width + MARGIN],
    )
    for beyond in range(1, MARGIN + 1):
        sums[MARGIN - beyond] = sums[MARGIN + _mirrored(-beyond, width)]
        last = width - 1 + beyond
        sums[MARGIN + last] = sums[MARGIN + _mirrored(last, width)]


@njit(**LEAF)
def _weigh(a, b, c, d, e, weights, sums):
    centre, near, far = weights
    for x in range(sums.shape[0]):
        sums[x] = np.uint16(
            far * (np.uint16(a[x]) + np.uint16(e[x]))
            + near * (np.uint16(b[x]) + np.uint16(d[x]))
            + centre * np.uint16(c[x])
        )


@njit(**LEAF)
def _divide(sums, weights, norm, line):
    """The smoothed grey values of a row, rounded."""
    width = line.shape[0]
    centre, near, far = weights
    # multiplied by 2^16 / norm instead, which is exact for all sums that there are
    factor = np.uint16((65536 + norm - 1) // norm)
    half = np.uint16(norm // 2)
    a, b, c = sums[:width], sums[1 : width + 1], sums[2 : width + 2]
    d, e = sums[3 : width + 3], sums[4 : width + 4]
    for x in range(width):
        total = np.uint16(far * (a[x] + e[x]) + near * (b[x] + d[x]) + centre * c[x] + half)
        line[x] = np.uint8((np.uint32(total) * np.uint32(factor)) >> np.uint32(16))


@njit(**LEAF)
def compare(sums, weights, limit, out):
    """Whether the smoothed grey values of a row lie below the limit, times ``norm``."""
    width = out.shape[0]
    centre, near, far = weights
    a, b, c = sums[:width], sums[1 : width + 1], sums[2 : width + 2]
    d, e = sums[3 : width + 3], sums[4 : width + 4]
    for x in range(width):
        total = np.uint16(far * (a[x] + e[x]) + near * (b[x] + d[x]) + centre * c[x])
        out[x] = total < limit
