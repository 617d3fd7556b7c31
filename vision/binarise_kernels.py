"""What a picture's grey values look like: their histogram and their noise, from a sample.

Grey values are 0 .. 255, integer or floating point. Both functions look at no more than about
``SAMPLE`` pixels, spread evenly over the picture.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

SAMPLE = 65536
"""Pixels looked at, about."""


@njit(cache=True, nogil=True)
def sampled_histogram(grey):
    """How many of the sampled pixels have each grey value: (256,) int64."""
    height, width = grey.shape
    histogram = np.zeros(256, np.int64)
    step = max(1, height * width // SAMPLE)
    rows = 1
    while rows * rows < step:
        rows += 1
    columns = max(1, step // rows)
    for y in range(0, height, rows):
        for x in range((y // rows) % columns, width, columns):
            histogram[int(grey[y, x] + 0.5)] += 1
    return histogram


@njit(cache=True, nogil=True)
def noise_sigma(grey):
    """The noise's standard deviation, from the median absolute second difference along rows.

    The median makes it blind to edges; a ramp has no second difference at all.
    """
    height, width = grey.shape
    if width < 3:
        return 0.0
    bins = np.zeros(4096, np.int64)
    rows = max(1, height // 64)
    columns = max(1, width // 256)
    total = 0
    for y in range(rows // 2, height, rows):
        for x in range(1, width - 1, columns):
            d = abs(np.float64(grey[y, x - 1]) - 2.0 * grey[y, x] + grey[y, x + 1])
            bins[min(int(d * 4.0 + 0.5), 4095)] += 1
            total += 1
    seen = 0
    for i in range(4096):
        if seen + bins[i] >= 0.5 * total:
            inside = (0.5 * total - seen) / bins[i]
            low = 0.0 if i == 0 else i - 0.5
            return (
                (low + inside * (i + 0.5 - low)) / 4.0 / (0.6744898 * 2.4494897) if i > 0 else 0.0
            )
        seen += bins[i]
    return 0.0
