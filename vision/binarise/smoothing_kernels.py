"""A picture smoothed as far as it is read, and the dots lost in that.

Rules and units
- Grey values are integers, 0 .. 255, smoothed by the binomial of 5 x 5 pixels; its weights add up
  to 256, and the sums fit in 16 bits.
- Beyond its edge the picture is mirrored without repeating the edge pixels. -
- A pixel below the level before smoothing belongs to a dot if it is darker than its surroundings by
  ``SIGMAS`` standard deviations of the noise, alone or smoothed by the binomial of 5 x 5 pixels:
  matched filters for one pixel and for about four. Less than one in a thousand pictures of 640 x
  480 has a false dot.
- Pixels next to something large, and pieces of a line, are left to the smoothed picture.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF, OWNING
from planner.scene.primitive_kernels import grown
from vision.binarise.binarise_kernels import (
    PIXELS_AT_A_TIME,
    SIGMAS,
    STEP_REACH_PX,
    count_greys,
    sample_steps,
    summed,
)
from vision.shared.typed_numbers import ZERO

# defined: binomial weights in either direction, typed so that sums stay narrow
CENTRE, NEXT, NEXT_BUT_ONE = np.uint16(6), np.uint16(4), np.uint16(1)
# defined: the weights add up to 2 to this power
WHOLE_BITS = np.uint16(8)
# defined: half of it, for rounding
ROUND_UP = np.uint16(128)
SMOOTHING_REACH_PX = 2
"""Pixels that the smoothing reaches beyond one: defined."""
BINOMIAL_LEFT = 0.2734
"""Share of white noise that the binomial leaves: derived, 70 / 256."""
RING = STEP_REACH_PX
"""Distance of the pixels around a dot: derived, outside its blurred rim."""
LINE_DEPTH = 0.4
"""Depth on both sides of a line, as a share of its own: chosen."""
DOT_REACH_PX = RING + 1
"""Reach in pixels, in rows and columns: derived, a dot and its rim."""
MOST_MARKED = int(0.25 * math.pi * RING**2)
"""Most marked pixels there around a dot: derived, a disc inside the ring."""


@njit(**OWNING)
def smoothed_histogram(grey):
    """Histogram of the sampled pixels' smoothed grey values, rounded: (256,) int64."""
    height, width = grey.shape
    counters = np.zeros((4, 256), np.uint32)
    sums = np.empty(width + 2 * SMOOTHING_REACH_PX, np.uint16)
    line = np.empty(width, np.uint8)
    rows, columns = sample_steps(height, width)
    for y in range(0, height, rows):
        sum_rows(grey, y, sums)
        _divide(sums, line)
        count_greys(line[(y // rows) % columns :], columns, counters)
    return summed(counters)


@njit(**LEAF)
def sum_limit(bound):
    """Least sum whose smoothed grey value is rounded to more than ``bound``."""
    return np.uint16(min(max(((bound + 1) << WHOLE_BITS) - ROUND_UP, 0), 65535))


@njit(**LEAF)
def _mirrored(i, count):
    """Mirror an index up to two beyond the edge."""
    if count == 1:
        return 0
    i = abs(i)
    last = count - 1
    return abs(last - abs(last - i))


@njit(**LEAF)
def sum_rows(grey, y, sums):
    """Sum five weighted rows around row ``y``, with the margin at both ends."""
    height, width = grey.shape
    _weigh(
        grey[_mirrored(y - 2, height)],
        grey[_mirrored(y - 1, height)],
        grey[y],
        grey[_mirrored(y + 1, height)],
        grey[_mirrored(y + 2, height)],
        sums[SMOOTHING_REACH_PX : width + SMOOTHING_REACH_PX],
    )
    for beyond in range(1, SMOOTHING_REACH_PX + 1):
        sums[SMOOTHING_REACH_PX - beyond] = sums[SMOOTHING_REACH_PX + _mirrored(-beyond, width)]
        last = width - 1 + beyond
        sums[SMOOTHING_REACH_PX + last] = sums[SMOOTHING_REACH_PX + _mirrored(last, width)]


@njit(**LEAF)
def _weigh(a, b, c, d, e, sums):
    """Sum five rows, or five places of one, by the binomial's weights."""
    for x in range(sums.shape[0]):
        sums[x] = np.uint16(
            NEXT_BUT_ONE * (np.uint16(a[x]) + np.uint16(e[x]))
            + NEXT * (np.uint16(b[x]) + np.uint16(d[x]))
            + CENTRE * np.uint16(c[x])
        )


@njit(**LEAF)
def _divide(sums, line):
    width = line.shape[0]
    a, b, c = sums[:width], sums[1 : width + 1], sums[2 : width + 2]
    d, e = sums[3 : width + 3], sums[4 : width + 4]
    for x in range(width):
        total = np.uint16(
            NEXT_BUT_ONE * (a[x] + e[x]) + NEXT * (b[x] + d[x]) + CENTRE * c[x] + ROUND_UP
        )
        line[x] = np.uint8(total >> WHOLE_BITS)


@njit(**LEAF)
def compare(sums, limit, out):
    """Mark a row's smoothed grey values below the limit of ``sum_limit``."""
    width = out.shape[0]
    a, b, c = sums[:width], sums[1 : width + 1], sums[2 : width + 2]
    d, e = sums[3 : width + 3], sums[4 : width + 4]
    for x in range(width):
        total = np.uint16(NEXT_BUT_ONE * (a[x] + e[x]) + NEXT * (b[x] + d[x]) + CENTRE * c[x])
        out[x] = total < limit


@njit(**OWNING)
def mark_below_but_dots(grey, bound, mask):
    """Mark where the smoothed picture is ``bound`` or darker; list pixels dark only unsmoothed.

    ``mask`` (h + 2, w') is padded. Return the places of ``dots_left_out``, in one pass.
    """
    height, width = grey.shape
    sums = np.empty(width + 2 * SMOOTHING_REACH_PX, np.uint16)
    limit = sum_limit(bound)
    level = np.uint8(min(max(bound + 1, 0), 255))
    left_out = np.zeros(
        (width + PIXELS_AT_A_TIME - 1) // PIXELS_AT_A_TIME * PIXELS_AT_A_TIME, np.uint8
    )
    places = np.empty(4 * left_out.shape[0], np.int64)
    count = ZERO
    for y in range(height):
        sum_rows(grey, y, sums)
        marks = mask[y + 1, 1 : width + 1]
        compare(sums, limit, marks)
        _find_left_out(grey[y], level, marks, left_out)
        count = _list(left_out, y * width, places, count)
        if count + left_out.shape[0] > places.shape[0]:
            places = grown(places, 2 * places.shape[0])
    return places[:count]


@njit(**OWNING)
def dots_left_out(grey, level, mask):
    """Places below the level, given in the picture's own type, that are not marked.

    A place is row * width + column.
    """
    height, width = grey.shape
    left_out = np.zeros(
        (width + PIXELS_AT_A_TIME - 1) // PIXELS_AT_A_TIME * PIXELS_AT_A_TIME, np.uint8
    )
    places = np.empty(4 * left_out.shape[0], np.int64)
    count = ZERO
    for y in range(height):
        _find_left_out(grey[y], level, mask[y + 1, 1 : width + 1], left_out)
        count = _list(left_out, y * width, places, count)
        if count + left_out.shape[0] > places.shape[0]:
            places = grown(places, 2 * places.shape[0])
    return places[:count]


@njit(**LEAF)
def _list(left_out, first, places, count):
    words = left_out.view(np.uint64)
    for block in range(0, words.shape[0], PIXELS_AT_A_TIME // 8):
        if not _any(words[block : block + PIXELS_AT_A_TIME // 8]):
            continue
        for word in range(block, block + PIXELS_AT_A_TIME // 8):
            if words[word] == 0:
                continue
            for x in range(8 * word, 8 * word + 8):
                places[count] = first + x
                count += np.int64(left_out[x])
    return count


@njit(**OWNING)
def mark_dots(grey, noise, places, mask):
    """Mark dots among the places with 1 in a padded mask; return their number."""
    width = grey.shape[1]
    dots = 0
    for place in places:
        if _is_dot(grey, mask, place // width, place % width, noise):
            places[dots] = place
            dots += 1
    # only now: a dot's pixels must not count as something large
    for i in range(dots):
        mask[places[i] // width + 1, places[i] % width + 1] = 1
    return dots


@njit(**LEAF)
def _find_left_out(line, level, marks, out):
    one = np.uint8(1)
    for x in range(line.shape[0]):
        out[x] = np.uint8(line[x] < level) & (marks[x] ^ one)


@njit(**LEAF)
def _any(words):
    every = np.uint64(0)
    for i in range(words.shape[0]):
        every |= words[i]
    return every != 0


@njit(**LEAF)
def _is_dot(grey, mask, y, x, noise):
    height, width = grey.shape
    if _is_next_to_large(mask, y, x, height, width):
        return False
    total = 0.0
    around = 0
    for down in range(-RING, RING + 1):
        across = 1 if abs(down) == RING else 2 * RING
        for right in range(-RING, RING + 1, across):
            there_y, there_x = y + down, x + right
            inside = 0 <= there_y < height and 0 <= there_x < width
            if inside and mask[there_y + 1, there_x + 1] == 0:
                total += grey[there_y, there_x]
                around += 1
    if around == 0:
        return False
    ground = total / around
    depth = ground - _smoothed(grey, y, x)
    alone = SIGMAS * noise * math.sqrt(1.0 + 1.0 / around)
    least = SIGMAS * noise * math.sqrt(BINOMIAL_LEFT**2 + 1.0 / around)
    if ground - grey[y, x] < alone and depth < least:
        return False
    return not _is_on_a_line(grey, y, x, ground, depth)


@njit(**LEAF)
def _is_on_a_line(grey, y, x, ground, depth):
    """True if the picture is about as dark on both sides, as along a joint of the floor."""
    height, width = grey.shape
    # sixteen places around a dot
    for i, j in ((0, 4), (2, 4), (3, 3), (4, 2), (4, 0), (4, -2), (3, -3), (2, -4)):
        if min(y, height - 1 - y) < i or min(x, width - 1 - x) < abs(j):
            continue
        here = ground - _smoothed(grey, y + i, x + j)
        there = ground - _smoothed(grey, y - i, x - j)
        if min(here, there) >= LINE_DEPTH * depth:
            return True
    return False


@njit(**LEAF)
def _is_next_to_large(mask, y, x, height, width):
    # most candidates lie on an edge: look across it first
    middle = DOT_REACH_PX // 2
    if y >= DOT_REACH_PX and mask[y + 1 - middle, x + 1] & mask[y + 1 - DOT_REACH_PX, x + 1]:
        return True
    if (
        y + DOT_REACH_PX < height
        and mask[y + 1 + middle, x + 1] & mask[y + 1 + DOT_REACH_PX, x + 1]
    ):
        return True
    if x >= DOT_REACH_PX and mask[y + 1, x + 1 - middle] & mask[y + 1, x + 1 - DOT_REACH_PX]:
        return True
    if x + DOT_REACH_PX < width and mask[y + 1, x + 1 + middle] & mask[y + 1, x + 1 + DOT_REACH_PX]:
        return True
    marked = 0
    for i in range(max(0, y - DOT_REACH_PX), min(height, y + DOT_REACH_PX + 1)):
        for j in range(max(0, x - DOT_REACH_PX), min(width, x + DOT_REACH_PX + 1)):
            marked += mask[i + 1, j + 1]
    return marked > MOST_MARKED


@njit(**LEAF)
def _smoothed(grey, y, x):
    height, width = grey.shape
    total = 0.0
    for i in range(-2, 3):
        row = min(max(y + i, 0), height - 1)
        weight = _weight(i)
        for j in range(-2, 3):
            column = min(max(x + j, 0), width - 1)
            total += weight * _weight(j) * grey[row, column]
    return total


@njit(**LEAF)
def _weight(away):
    away = abs(away)
    if away == 0:
        return 0.375
    return 0.25 if away == 1 else 0.0625
