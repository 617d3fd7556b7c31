"""Steps across the border between black and white.

Rules and units
- A step is how much lighter a pixel is than one ``STEP_REACH_PX`` rows or columns away, measured by
  ``worth`` (256,), which grows with the grey value. Pairs of pixels come from a sample of rows.
- A pair supports a border between its pixels by its step less ``cost``. A soft step opposes it: one
  hardly more than its share of the step from ``OUTER`` before it to ``OUTER`` behind it.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF, OWNING, SUMS
from vision.binarise.binarise_kernels import PIXELS_AT_A_TIME, SAMPLE, STEP_REACH_PX

OUTER = 6
"""Pixels beyond both ends: chosen, evenly changing light then has a quarter of the outer step, a
sharp edge all of it."""
SOFT = 0.4
"""Share of the outer step that is light's: chosen, beyond the quarter of evenly changing light."""
LEAST_SHARP = 0.2
"""Least sharp share of a border's step: derived, half-way between a lens's edge (0.35 at a blur of
2 px, 0.54 at 0.7) and light's (0.06 at 3.5 px, -0.26 at 7) along a straight border
(``tests/vision/binarise/test_judge.py``)."""
SAMPLED_PAIRS = 2 * SAMPLE
"""Pairs read where a whole picture is judged, about: derived, every pixel of a sample begins
two."""


@njit(**LEAF)
def _row_step(height, width, pairs):
    """Step in rows between pairs."""
    return max(1, 2 * height * width // pairs)


@njit(**LEAF)
def steps_across_level(grey, level, weak, strong, pairs):
    """Count the pairs across a level, and their weak and strong steps.

    Return ``(all, weak, strong)``; the latter two by grey levels.
    """
    height, width = grey.shape
    length = min(width - STEP_REACH_PX, PIXELS_AT_A_TIME)
    segments = max(1, (width - STEP_REACH_PX) // PIXELS_AT_A_TIME)
    step = max(1, 2 * height * segments * length // pairs)
    every, weaks, strongs = 0.0, 0.0, 0.0
    for i in range(0, (height - STEP_REACH_PX) * segments, step):
        y = i // segments
        x = PIXELS_AT_A_TIME * ((i + y) % segments)
        here = grey[y, x : x + length]
        for down in (False, True):
            there = (
                grey[y + STEP_REACH_PX, x : x + length] if down else grey[y, x + STEP_REACH_PX :]
            )
            a, b, c = _steps(here, there, level, weak, strong)
            every += a
            weaks += b
            strongs += c
    return every, weaks, strongs


@njit(**SUMS)
def _steps(here, there, level, weak, strong):
    nothing, one = np.float32(0.0), np.float32(1.0)
    every, weaks, strongs = nothing, nothing, nothing
    for x in range(here.shape[0]):
        a = np.float32(here[x])
        b = np.float32(there[x])
        step = abs(a - b)
        across = one if (a < level) != (b < level) else nothing
        every += across
        weaks += across if step < weak else nothing
        strongs += across if step > strong else nothing
    return every, weaks, strongs


@njit(**LEAF)
def steps_off_level(grey, level, clear, enough):
    """Count pixels that begin a clear step on a level's light side, with nothing across it nearby.

    Every second row is read, until there are ``enough``. ``clear`` is ``(share, least, end,
    sign)``: the step is at least ``least``, and at least ``share`` of the light, which is the
    distance from ``end``, where ``sign`` times grey values begin, to the pixel farther from it.
    Pixels ``STEP_REACH_PX`` away on all sides lie on the light side too: the foot of an edge across
    the level does not count.
    """
    height, width = grey.shape
    found = 0.0
    for y in range(STEP_REACH_PX, height - 2 * STEP_REACH_PX, 2):
        rows = grey[y - STEP_REACH_PX : y + 2 * STEP_REACH_PX + 1]
        for x in range(STEP_REACH_PX, width - 2 * STEP_REACH_PX, PIXELS_AT_A_TIME):
            length = min(width - 2 * STEP_REACH_PX - x, PIXELS_AT_A_TIME)
            if _any_step(rows, x, length, level, clear[1]):
                found += _clear_steps(rows, x, length, level, clear)
        if found >= enough:
            break
    return found


@njit(**SUMS)
def _any_step(rows, first, length, level, least):
    """True if a stretch has a step on the light side; most have none."""
    nothing, one = np.float32(0.0), np.float32(1.0)
    here, below = rows[STEP_REACH_PX, first:], rows[2 * STEP_REACH_PX, first:]
    found = nothing
    for x in range(length):
        value = np.float32(here[x])
        right = np.float32(here[x + STEP_REACH_PX])
        down = np.float32(below[x])
        steep = (abs(value - right) >= least) & (right >= level)
        steep |= (abs(value - down) >= least) & (down >= level)
        found += one if steep & (value >= level) else nothing
    return found > nothing


@njit(**SUMS)
def _clear_steps(rows, first, length, level, clear):
    nothing, one = np.float32(0.0), np.float32(1.0)
    share, least, end, sign = clear
    above, here = rows[0, first:], rows[STEP_REACH_PX, first:]
    below, beyond = rows[2 * STEP_REACH_PX, first:], rows[3 * STEP_REACH_PX, first:]
    before = rows[:, first - STEP_REACH_PX :]
    found = nothing
    for x in range(length):
        value = np.float32(here[x])
        right = np.float32(here[x + STEP_REACH_PX])
        down = np.float32(below[x])
        side = value < level
        across = (right < level) != side
        across |= (down < level) != side
        across |= (np.float32(above[x]) < level) != side
        across |= (np.float32(before[STEP_REACH_PX, x]) < level) != side
        across |= (np.float32(below[x + STEP_REACH_PX]) < level) != side
        across |= (np.float32(above[x + STEP_REACH_PX]) < level) != side
        across |= (np.float32(before[2 * STEP_REACH_PX, x]) < level) != side
        across |= (np.float32(here[x + 2 * STEP_REACH_PX]) < level) != side
        across |= (np.float32(beyond[x]) < level) != side
        # and across the corners: an edge may be oblique
        across |= (np.float32(before[0, x]) < level) != side
        across |= (np.float32(above[x + 2 * STEP_REACH_PX]) < level) != side
        across |= (np.float32(before[3 * STEP_REACH_PX, x]) < level) != side
        across |= (np.float32(beyond[x + 2 * STEP_REACH_PX]) < level) != side
        lit = max(sign * value, sign * right) - sign * end
        steep = abs(value - right) >= max(share * lit, least)
        lit = max(sign * value, sign * down) - sign * end
        steep |= abs(value - down) >= max(share * lit, least)
        found += one if steep & (not (across | side)) else nothing
    return found


@njit(**LEAF)
def _pair(grey, y, x, down):
    height, width = grey.shape
    if down:
        before = grey[max(y - OUTER, 0), x]
        behind = grey[min(y + STEP_REACH_PX + OUTER, height - 1), x]
        return before, grey[y, x], grey[y + STEP_REACH_PX, x], behind
    before = grey[y, max(x - OUTER, 0)]
    behind = grey[y, min(x + STEP_REACH_PX + OUTER, width - 1)]
    return before, grey[y, x], grey[y, x + STEP_REACH_PX], behind


@njit(**LEAF)
def _sharp_step(worth, before, a, b, behind):
    """Step from ``a`` to ``b`` and its sharp part, signed alike."""
    step = worth[int(b + 0.5)] - worth[int(a + 0.5)]
    outer = worth[int(behind + 0.5)] - worth[int(before + 0.5)]
    if step >= 0.0:
        return step, step - SOFT * max(outer, 0.0)
    return step, step - SOFT * min(outer, 0.0)


@njit(**LEAF)
def typical_step(grey, worth, pairs):
    """Step of the strongest sharp edges: the mean weighted by their squares."""
    height, width = grey.shape
    squares = 0.0
    cubes = 0.0
    for y in range(0, height, _row_step(height, width, pairs)):
        for down in (False, True):
            if down and y + STEP_REACH_PX >= height:
                continue
            for x in range(width if down else width - STEP_REACH_PX):
                before, a, b, behind = _pair(grey, y, x, down)
                step, sharp = _sharp_step(worth, before, a, b, behind)
                if step * sharp > 0.0:
                    squares += sharp * sharp
                    cubes += abs(sharp) * sharp * sharp
    return cubes / squares if squares > 0.0 else 0.0


@njit(**OWNING)
def support_by_level(grey, shut, worth, cost, pairs):
    """Support for a border at each level, and the number of pairs across it: 2 x (257,).

    Pixels below the level are obstacle. Pairs with a pixel where ``shut`` (h, w) is not 0 are left
    out; ``shut`` may be empty.
    """
    height, width = grey.shape
    whole = shut.size == 0
    changes = np.zeros((2, 258))
    for y in range(0, height, _row_step(height, width, pairs)):
        for down in (False, True):
            if down and y + STEP_REACH_PX >= height:
                continue
            for x in range(width if down else width - STEP_REACH_PX):
                if not whole and (
                    shut[y, x]
                    or (shut[y + STEP_REACH_PX, x] if down else shut[y, x + STEP_REACH_PX])
                ):
                    continue
                before, a, b, behind = _pair(grey, y, x, down)
                low = int(min(a, b) + 0.5)
                high = int(max(a, b) + 0.5)
                if low < high:
                    step, sharp = _sharp_step(worth, before, a, b, behind)
                    support = min(step - cost, sharp) if step >= 0.0 else min(-step - cost, -sharp)
                    changes[0, low + 1] += support
                    changes[1, low + 1] += 1.0
                    changes[0, high + 1] -= support
                    changes[1, high + 1] -= 1.0
    return np.cumsum(changes[0])[:257], np.cumsum(changes[1])[:257]


@njit(**OWNING)
def steps_of_regions(grey, labels, count, end, sign):
    """Steps across the border of each region: ``(steps, light, sharp, pairs)``.

    ``labels`` (h, w) int32 are 1 .. count - 1 in the regions and 0 elsewhere. All are sums over the
    pairs with one pixel in a region. On each of its four sides (count, 4): how much lighter the
    other pixel is; the light (see ``steps_off_level``); and the number of pairs. In all (count,):
    the sharp part of the steps.
    """
    height, width = grey.shape
    steps = np.zeros((count, 4))
    light = np.zeros((count, 4))
    sharp = np.zeros(count)
    pairs = np.zeros((count, 4), np.int64)
    for y in range(height):
        for x in range(width):
            here = labels[y, x]
            for down in (False, True):
                there_y, there_x = (y + STEP_REACH_PX, x) if down else (y, x + STEP_REACH_PX)
                if there_y >= height or there_x >= width:
                    continue
                there = labels[there_y, there_x]
                if (here > 0) == (there > 0):
                    continue
                before, one, other, behind = _pair(grey, y, x, down)
                a, b = np.float64(one), np.float64(other)
                outer = np.float64(behind) - np.float64(before)
                inward = 1.0 if here > 0 else -1.0
                region = max(here, there)
                side = 2 * down + (here > 0)
                steps[region, side] += inward * (b - a)
                light[region, side] += max(sign * a, sign * b) - sign * end
                sharp[region] += inward * (b - a) - SOFT * max(inward * outer, 0.0)
                pairs[region, side] += 1
    return steps, light, sharp, pairs


@njit(**OWNING)
def mark_sharp_steps(grey, least, strong, end, sign):
    """Mark 1 where a faint, sharp step begins, 2 at the dark end of a strong one (h, w).

    A step is at least ``least`` grey levels, and strong with a share ``strong`` of the light.
    """
    height, width = grey.shape
    marks = np.zeros((height, width), np.uint8)
    for y in range(height):
        for down in (False, True):
            if down and y + STEP_REACH_PX >= height:
                continue
            for x in range(width if down else width - STEP_REACH_PX):
                there = grey[y + STEP_REACH_PX, x] if down else grey[y, x + STEP_REACH_PX]
                a, b = np.float64(grey[y, x]), np.float64(there)
                if abs(b - a) < least:
                    continue
                before, _, _, behind = _pair(grey, y, x, down)
                along = 1.0 if b > a else -1.0
                step = along * (b - a)
                outer = along * (np.float64(behind) - np.float64(before))
                if step - SOFT * max(outer, 0.0) >= LEAST_SHARP * step:
                    lit = max(sign * a, sign * b) - sign * end
                    if step < strong * lit:
                        marks[y, x] = max(marks[y, x], 1)
                    elif a < b:
                        marks[y, x] = 2
                    else:
                        marks[
                            y + (STEP_REACH_PX if down else 0), x + (0 if down else STEP_REACH_PX)
                        ] = 2
    return marks
