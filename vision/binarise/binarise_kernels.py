"""Histogram and noise of a picture's grey values, from a sample.

Grey values are 0 .. 255, integer or floating point. About ``SAMPLE`` evenly spread pixels are read;
for the noise, ``SAMPLED`` rows and columns.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF, OWNING

SAMPLE = 32768
"""Pixels in a sample, about: chosen, a share of one in a hundred is known to a twentieth of
itself."""
SAMPLED = math.isqrt(SAMPLE // 4)
"""Rows, and columns, in which noise is measured, about: derived, two differences at each crossing
are half as many as the pixels; their median is known to one part in a hundred."""
SIGMAS = 6.0
"""Standard deviations by which a signal exceeds noise: derived, noise does so twice in 10^9."""
STEP_REACH_PX = 4
"""Pixels from one end of a step to the other: chosen, an edge of a lens in focus."""
PIXELS_AT_A_TIME = 128
"""Pixels of a row compared together: indifferent, for time."""
BINS = 2048
"""Distinct second differences: derived, there can be 2,040 quarters."""
PARTS = np.int64(4)
"""Parts of a grey level in which fractional second differences are counted: chosen."""
# typed, so that no sum changes its type: defined.
ONE = np.uint32(1)
# defined.
TWO = np.int64(2)
# defined.
FOUR = np.uint64(4)
FIRST_LEVEL, LAST_LEVEL = np.int64(0), np.int64(256)
"""Typed, so that kernels are compiled for one kind of number: defined."""


@njit(**OWNING)
def sampled_histogram(grey):
    """Histogram of the sampled pixels, (256,) int64."""
    height, width = grey.shape
    # four counters a value, so that equal greys do not wait for each other
    counters = np.zeros((4, 256), np.uint32)
    rows, columns = sample_steps(height, width)
    for y in range(0, height, rows):
        count_greys(grey[y, (y // rows) % columns :], columns, counters)
    return summed(counters)


@njit(**LEAF)
def sample_steps(height, width):
    """Steps in rows and columns between sampled pixels."""
    step = max(1, height * width // SAMPLE)
    rows = 1
    while rows * rows < step:
        rows += 1
    return rows, max(1, step // rows)


@njit(**LEAF)
def count_greys(line, columns, counters):
    """Add every ``columns``-th pixel to the counters (4, 256)."""
    # 0 for integers
    half = line.dtype.type(0.5)
    first, second, third, fourth = counters
    step = np.uint64(columns)
    end = np.uint64(line.shape[0])
    together = np.uint64(max(0, line.shape[0] - 3 * columns))
    x = np.uint64(0)
    while x < together:
        first[np.uint64(line[x] + half)] += ONE
        second[np.uint64(line[x + step] + half)] += ONE
        third[np.uint64(line[x + step + step] + half)] += ONE
        fourth[np.uint64(line[x + step + step + step] + half)] += ONE
        x += FOUR * step
    while x < end:
        first[np.uint64(line[x] + half)] += ONE
        x += step


@njit(**OWNING)
def summed(counters):
    """Histogram (256,) int64 of the counters."""
    histogram = np.empty(256, np.int64)
    for v in range(256):
        histogram[v] = np.int64(counters[0, v]) + counters[1, v] + counters[2, v] + counters[3, v]
    return histogram


@njit(**OWNING)
def noise_sigma(grey):
    """Standard deviation of the noise, from the median absolute second difference.

    The median ignores edges. The sample is symmetric: the picture mirrored, turned or transposed
    has the same noise.
    """
    height, width = grey.shape
    counters = np.zeros((2, BINS), np.uint32)
    rows = max(1, height // SAMPLED)
    columns = max(1, width // SAMPLED)
    total = 0
    for first in range(rows // 2, (height + 1) // 2, rows):
        last = height - 1 - first
        total += _count_row(grey, first, columns, counters)
        if last != first:
            total += _count_row(grey, last, columns, counters)
    # integers have integer differences; others count in quarters
    parts = np.int64(1) if grey.dtype.type(0.5) == 0 else PARTS
    seen = 0
    for i in range(BINS):
        here = np.int64(counters[0, i]) + counters[1, i]
        if seen + here >= 0.5 * total:
            inside = (0.5 * total - seen) / here if here > 0 else 0.0
            low = 0.0 if i == 0 else i - 0.5
            median = (low + inside * (i + 0.5 - low)) / parts
            return median / (0.6744898 * 2.4494897) if i > 0 else 0.0
        seen += here
    return 0.0


@njit(**LEAF)
def _count_row(grey, y, columns, counters):
    height, width = grey.shape
    here = grey[y]
    total = 0
    first = columns // 2
    begin = first if first > 0 else columns
    if width >= 3:
        total += count_bends(here, here[1:], here[2:], begin - 1, columns, width - 2, counters)
    if 1 <= y < height - 1:
        total += count_bends(grey[y - 1], here, grey[y + 1], first, columns, width, counters)
    return total


@njit(**LEAF)
def count_bends(before, here, behind, first, step, length, counters):
    """Count second differences from ``first`` to the middle, and mirrored, into (2, BINS).

    Those of integers count as they are, others in quarters. Return their number.
    """
    half = here.dtype.type(0.5)
    parts = np.int64(1) if half == 0 else PARTS
    one_way, other_way = counters
    last = np.uint64(BINS - 1)
    count = 0
    for x in range(first, (length + 1) // 2, step):
        bend = abs(before[x] - TWO * here[x] + behind[x])
        one_way[min(np.uint64(parts * bend + half), last)] += ONE
        count += 1
        mirrored = length - 1 - x
        if mirrored != x:
            bend = abs(before[mirrored] - TWO * here[mirrored] + behind[mirrored])
            other_way[min(np.uint64(parts * bend + half), last)] += ONE
            count += 1
    return count


@njit(**LEAF)
def steepest_level(grey, least):
    """Mean grey value at the steepest steps, or -1 if no step reaches ``least`` grey levels.

    A step weighs by its third power.
    """
    height, width = grey.shape
    rows, _ = sample_steps(height, width)
    weights = 0.0
    levels = 0.0
    for y in range(0, height - 1, rows):
        here, below = grey[y], grey[y + 1]
        for x in range(width - 1):
            a = np.float64(here[x])
            for b in (np.float64(here[x + 1]), np.float64(below[x])):
                step = abs(b - a)
                if step >= least:
                    weights += step**3
                    levels += step**3 * 0.5 * (a + b)
    return levels / weights if weights > 0.0 else -1.0


@njit(**OWNING)
def flat_histogram(grey, most):
    """Histogram of the sampled pixels that are not edges, (256,) int64.

    Across each, grey changes by at most ``most`` in either direction: plateaus and ridges.
    """
    height, width = grey.shape
    histogram = np.zeros(256, np.int64)
    rows, columns = sample_steps(height, width)
    for y in range(1, height - 1, rows):
        above, here, below = grey[y - 1], grey[y], grey[y + 1]
        for x in range(1 + (y // rows) % columns, width - 1, columns):
            across = abs(np.float64(here[x + 1]) - np.float64(here[x - 1]))
            down = abs(np.float64(below[x]) - np.float64(above[x]))
            if across <= most and down <= most:
                histogram[int(here[x] + 0.5)] += 1
    return histogram


@njit(**LEAF)
def plateau_share(histogram, level, dark, middle, reach):
    """Share of a class's pixels within ``reach`` of its ``middle``; 1 for an empty class.

    The class lies below ``level`` if ``dark``, else above.
    """
    every = 0.0
    near = 0.0
    for v in range(256):
        if (v < level) != dark:
            continue
        every += histogram[v]
        if abs(v - middle) <= reach:
            near += histogram[v]
    return near / every if every > 0.0 else 1.0


@njit(**LEAF)
def halve_histogram(histogram):
    """Halves of a histogram (256,) with the least variance within them (Otsu, 1979).

    Return ``(dark, light, dark_share, between, variance)``: means, the dark half's share, the
    variance between the halves, and the whole.
    """
    total, whole, squares = 0.0, 0.0, 0.0
    for v in range(256):
        n = np.float64(histogram[v])
        total += n
        whole += n * v
        squares += n * v * v
    mean = whole / total
    below, dark_sum = 0.0, 0.0
    dark, light, share, between = mean, mean, 0.0, 0.0
    for v in range(255):
        n = np.float64(histogram[v])
        below += n
        dark_sum += n * v
        above = total - below
        if below <= 0.0 or above <= 0.0:
            continue
        m0 = dark_sum / below
        m1 = (whole - dark_sum) / above
        found = below * above * (m1 - m0) ** 2 / total**2
        if found > between:
            dark, light, share, between = m0, m1, below / total, found
    return dark, light, share, between, squares / total - mean * mean


@njit(**OWNING)
def split_histogram(histogram, noise, least):
    """Two classes of a histogram (256,) by minimum error, at least ``least`` grey levels apart.

    Kittler and Illingworth, 1986. No class is narrower than ``noise`` and a grey level. Return
    ``(found, dark, light, light_spread, dark_share)``: the classes' medians, the light one's
    quartile distance as a normal distribution's sigma, and the dark one's share.
    """
    sums = np.zeros((257, 3))
    for v in range(256):
        n = np.float64(histogram[v])
        sums[v + 1, 0] = sums[v, 0] + n
        sums[v + 1, 1] = sums[v, 1] + n * v
        sums[v + 1, 2] = sums[v, 2] + n * v * v
    total, whole, squares = sums[256, 0], sums[256, 1], sums[256, 2]
    floor = noise * noise + 1.0
    split = -1
    cheapest = np.inf
    for v in range(255):
        n0, s0, q0 = sums[v + 1, 0], sums[v + 1, 1], sums[v + 1, 2]
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
    dark = _quantile(histogram, FIRST_LEVEL, split + 1, 0.5)
    light = _quantile(histogram, split + 1, LAST_LEVEL, 0.5)
    before = -1
    above = int(0.5 * (dark + light)) + 1
    for _ in range(256):
        if above == before:
            break
        # half-way between the medians, whatever tail the split cut off
        before = above
        dark = _quantile(histogram, FIRST_LEVEL, above, 0.5)
        light = _quantile(histogram, above, LAST_LEVEL, 0.5)
        above = int(0.5 * (dark + light)) + 1
    if light - dark < least:
        return False, 0.0, 0.0, 0.0, 0.0
    level = 0.5 * (dark + light)
    above = int(level) + 1
    spread = _quantile(histogram, above, LAST_LEVEL, 0.75) - _quantile(
        histogram, above, LAST_LEVEL, 0.25
    )
    below = 0.0
    for v in range(256):
        if v < level:
            below += histogram[v]
    return True, dark, light, spread / 1.349, below / total


@njit(**OWNING)
def _quantile(histogram, first, last, share):
    total = 0.0
    for v in range(first, last):
        total += histogram[v]
    running = 0.0
    for v in range(first, last):
        running += histogram[v]
        if running >= share * total:
            return float(v)
    return float(last)
