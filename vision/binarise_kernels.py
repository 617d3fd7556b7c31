"""What a picture's grey values look like: their histogram and their noise, from a sample.

Grey values are 0 .. 255, integer or floating point. They look at no more than about
``SAMPLE`` pixels, spread evenly over the picture.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

SAMPLE = 65536
"""Pixels looked at, about."""
BINS = 4096
"""Second differences are counted by quarters of a grey level."""
FIRST, LAST = np.int64(0), np.int64(256)
REFINEMENTS = 3
"""Times that the level moves half-way between the middles of what it splits."""


@njit(cache=True, nogil=True)
def sampled_histogram(grey):
    """How many of the sampled pixels have each grey value: (256,) int64."""
    height, width = grey.shape
    # four counters for a value: runs of the same grey need not wait for each other
    counters = np.zeros((4, 256), np.int64)
    step = max(1, height * width // SAMPLE)
    rows = 1
    while rows * rows < step:
        rows += 1
    columns = max(1, step // rows)
    for y in range(0, height, rows):
        x = (y // rows) % columns
        while x + 3 * columns < width:
            counters[0, int(grey[y, x] + 0.5)] += 1
            counters[1, int(grey[y, x + columns] + 0.5)] += 1
            counters[2, int(grey[y, x + 2 * columns] + 0.5)] += 1
            counters[3, int(grey[y, x + 3 * columns] + 0.5)] += 1
            x += 4 * columns
        while x < width:
            counters[0, int(grey[y, x] + 0.5)] += 1
            x += columns
    histogram = np.empty(256, np.int64)
    for v in range(256):
        histogram[v] = counters[0, v] + counters[1, v] + counters[2, v] + counters[3, v]
    return histogram


@njit(cache=True, nogil=True)
def noise_sigma(grey):
    """The noise's standard deviation, from the median absolute second difference along rows.

    The median makes it blind to edges; a ramp has no second difference at all.
    """
    height, width = grey.shape
    if width < 3:
        return 0.0
    pairs = np.zeros((2, BINS), np.int64)
    rows = max(1, height // 64)
    columns = max(1, width // 256)
    total = 0
    for y in range(rows // 2, height, rows):
        which = 0
        for x in range(1, width - 1, columns):
            d = abs(np.float64(grey[y, x - 1]) - 2.0 * grey[y, x] + grey[y, x + 1])
            pairs[which, min(int(d * 4.0 + 0.5), BINS - 1)] += 1
            which = 1 - which
            total += 1
    seen = 0
    for i in range(BINS):
        here = pairs[0, i] + pairs[1, i]
        if seen + here >= 0.5 * total:
            inside = (0.5 * total - seen) / here
            low = 0.0 if i == 0 else i - 0.5
            return (
                (low + inside * (i + 0.5 - low)) / 4.0 / (0.6744898 * 2.4494897) if i > 0 else 0.0
            )
        seen += here
    return 0.0


@njit(cache=True, nogil=True)
def split_histogram(histogram, noise, least):
    """The two classes of a histogram (256,) by minimum error, ``least`` grey levels apart.

    Kittler and Illingworth, 1986. No class is narrower than ``noise`` and a grey level.
    Returns ``(found, dark, light, light_spread, dark_share)``: the classes' medians, the light
    one's quartile distance as a normal distribution's sigma, and the dark one's share.
    """
    total = 0.0
    whole = 0.0
    squares = 0.0
    for v in range(256):
        n = np.float64(histogram[v])
        total += n
        whole += n * v
        squares += n * v * v
    floor = noise * noise + 1.0
    split = -1
    cheapest = np.inf
    n0 = 0.0
    s0 = 0.0
    q0 = 0.0
    for v in range(255):
        n = np.float64(histogram[v])
        n0 += n
        s0 += n * v
        q0 += n * v * v
        n1 = total - n0
        if n0 <= 0.0 or n1 <= 0.0:
            continue
        m0 = s0 / n0
        m1 = (whole - s0) / n1
        if m1 - m0 < least:
            continue
        v0 = max(q0 / n0 - m0 * m0, floor)
        v1 = max((squares - q0) / n1 - m1 * m1, floor)
        p0 = n0 / total
        p1 = n1 / total
        cost = p0 * math.log(v0) + p1 * math.log(v1) - 2.0 * (p0 * math.log(p0) + p1 * math.log(p1))
        if cost < cheapest:
            cheapest = cost
            split = v
    if split < 0:
        return False, 0.0, 0.0, 0.0, 0.0
    dark = _quantile(histogram, FIRST, split + 1, 0.5)
    light = _quantile(histogram, split + 1, LAST, 0.5)
    for _ in range(REFINEMENTS):
        # half-way between the middles, whatever tail the split has cut off
        above = int(0.5 * (dark + light)) + 1
        dark = _quantile(histogram, FIRST, above, 0.5)
        light = _quantile(histogram, above, LAST, 0.5)
    if light - dark < least:
        return False, 0.0, 0.0, 0.0, 0.0
    level = 0.5 * (dark + light)
    above = int(level) + 1
    spread = _quantile(histogram, above, LAST, 0.75) - _quantile(histogram, above, LAST, 0.25)
    below = 0.0
    for v in range(256):
        if v < level:
            below += histogram[v]
    return True, dark, light, spread / 1.349, below / total


@njit(cache=True, nogil=True)
def _quantile(histogram, first, last, share):
    """The grey value in first .. last - 1 below which ``share`` of their pixels lie."""
    total = 0.0
    for v in range(first, last):
        total += histogram[v]
    running = 0.0
    for v in range(first, last):
        running += histogram[v]
        if running >= share * total:
            return float(v)
    return float(last)
