"""Sub-pixel edge points: where the light crosses the half level, crack by crack.

Rules and units
- Pixel coordinates, pixel centres at integers, y down; grey values as floats.
- A crack contributes where the border runs more along it than across it, so that one point a
  row or column is left and the profile across the crack meets the edge at 45 degrees or more.
- The profile across the crack is smoothed along itself (Gaussian, sigma 1 px): next to the
  best that can be done at a noisy edge, and it makes the step so wide that an interpolation
  through the normal distribution's inverse is exact to a few thousandths of a pixel.
- The half level is taken from both plateaus beside the edge, averaged over a stretch of the
  border, so that objects of different darkness and uneven light do not move the edge.
- Where a wall or a gap is so narrow that a plateau may not be reached, nothing beyond its middle
  is read: the light is not smoothed, and the given level counts, unless what is seen of the
  plateau tells another one.
- One border at a time: its profiles are gathered from the picture into rows of ``work``, a
  column a crack, and everything else runs over whole rows, several cracks at once.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from vision.kernel_options import LEAF, SUMS

REACH = 3
"""Cracks to either side that tell the border's direction."""
STRETCH = 64
"""Cracks to either side over which the plateaus are averaged."""
TAP0, TAP1, TAP2 = 0.40261995, 0.24420134, 0.05448868
"""A Gaussian of sigma 1 on five pixels."""
WANDER = 2
"""How many pixels beside the crack the smoothed crossing may lie."""
CRISP = 0.95
"""Share of the contrast in one step from which an edge counts as drawn without grey."""
BEHIND, SAMPLES = 4, 10
"""A profile has so many pixels behind its obstacle pixel, and so many in all."""
UNREACHED = 1 / 8
"""So far from half-way between what is seen of both plateaus, as a share of what lies between
them, the given level is still believed at a narrow wall: a fifth of the contrast is unseen."""
SAME_GREY = 1e-9
"""A rounding of grey values."""
MIDDLE_X, MIDDLE_Y, CLEAR, CHOSEN, SLANTED, DARK, LIGHT = 10, 11, 12, 13, 14, 15, 16
NEAR, FAR, DARK_LEVEL, LIGHT_LEVEL, CROSSING, ASTRAY = 17, 18, 19, 20, 21, 22
WALL, GAP, ROWS = 23, 24, 25
"""Rows of ``work`` behind those of the profile: twice a crack's middle; 1 where both plateaus are
there, where the crack gives a point, where the border runs aslant; the plateaus beside it; the
smoothed profile at the obstacle pixel and at the free one; the plateaus of its stretch; where the
light crosses the half level, in pixels from the obstacle pixel; 1 where that lies farther away;
1 where the obstacle, and where the free space, is three or four pixels wide."""


@njit(cache=True, nogil=True)
def edge_points(grey, mask, level, by_level, xs, ys, directions, starts, points):
    """Sub-pixel points of every border, in order.

    ``grey`` (h, w), obstacles dark; ``mask`` the padded mask; ``level`` the threshold, and
    ``by_level`` whether the mask is what lies below it, no more and no less; ``points`` is
    room for one more point (k, 2) than there are cracks.
    Returns ``(points, point_starts, slope, crispness)``: (k, 2) float64, per border the index
    of its first point, the mean step of the smoothed profile at the edge as a share of the
    contrast, and the share of slanted cracks with a full step.
    """
    borders = starts.shape[0] - 1
    point_starts = np.empty(borders + 1, np.int64)
    longest = 0
    for b in range(borders):
        longest = max(longest, starts[b + 1] - starts[b])
    work = np.empty((ROWS, longest + 2 * REACH), np.float64)
    places = np.empty((2, longest), np.int64)
    sums = np.zeros((4, longest + 1), np.float64)
    totals = np.zeros(4)
    count = 0
    for b in range(borders):
        first = starts[b]
        n = starts[b + 1] - first
        x = xs[first : first + n]
        y = ys[first : first + n]
        direction = directions[first : first + n]
        point_starts[b] = count
        _locate(grey, x, y, direction, n, work, places)
        if not by_level:
            _look_at_mask(mask, grey.shape[1], x, y, direction, n, work[CLEAR])
        _gather(grey, mask, x, y, direction, n, work, places)
        _look_along(direction, n, work)
        _look_beside(level, by_level, n, work)
        _find_plateaus(n, work, sums)
        _find_crossings(level, n, work, totals)
        count = _place(grey, level, x, y, direction, n, work, totals, points, count)
    point_starts[borders] = count
    slope = totals[0] / totals[1] if totals[1] > 0 else 0.4
    crispness = totals[2] / totals[3] if totals[3] > 0 else 0.0
    return points[:count], point_starts, slope, crispness


@njit(**LEAF)
def _out(direction):
    """From a crack's obstacle pixel to its free one, by the walk's direction: x and y."""
    return (direction & 1) * (2 - direction), (1 - (direction & 1)) * (direction - 1)


@njit(**LEAF)
def _locate(grey, xs, ys, directions, n, work, places):
    """Where every crack lies, and what its profile holds at the obstacle pixel.

    ``places`` (2, k): a crack's obstacle pixel in the picture, and the way from it to the free
    one. A border that runs up or down finds a new line of the memory at every crack: a short
    loop has many of them fetched at once, and the profiles are read from lines that are there.
    """
    width = grey.shape[1]
    flat_grey = grey.reshape(-1)
    middle_x = work[MIDDLE_X]
    middle_y = work[MIDDLE_Y]
    here = work[BEHIND]
    clear = work[CLEAR]
    crossing = work[CROSSING]
    at = places[0]
    step = places[1]
    for i in range(n):
        x = np.int64(xs[i])
        y = np.int64(ys[i])
        nx, ny = _out(np.int64(directions[i]))
        middle_x[REACH + i] = 2 * x + nx
        middle_y[REACH + i] = 2 * y + ny
        at[i] = y * width + x
        step[i] = ny * width + nx
        crossing[i] = 0.0
        clear[i] = 1.0
    for i in range(n):
        here[i] = flat_grey[np.uint64(at[i])]
    for i in range(REACH):
        middle_x[i] = middle_x[n + i]
        middle_y[i] = middle_y[n + i]
        middle_x[n + REACH + i] = middle_x[REACH + i]
        middle_y[n + REACH + i] = middle_y[REACH + i]


@njit(**LEAF)
def _look_at_mask(mask, width, xs, ys, directions, n, clear):
    """CLEAR from a mask that was not made from these grey values: three pixels to either side.

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
            nx, ny = _out(np.int64(directions[i]))
            # unsigned: no index counts from the end
            across = np.uint64(ny * stride + nx)
            here = np.uint64((y + 1) * stride + x + 1)
            dark = flat[here - across] & flat[here - across - across]
            ahead = here + across + across
            clear[i] = dark & ~(flat[ahead] | flat[ahead + across]) & 1


@njit(**LEAF)
def _gather(grey, mask, xs, ys, directions, n, work, places):
    """The rest of the profile across every crack.

    Where the profile leaves the picture, CLEAR is found here. Where the free pixel lies outside,
    CROSSING is -1.
    """
    height, width = grey.shape
    flat_grey = grey.reshape(-1)
    clear = work[CLEAR]
    for i in range(n):
        x = np.int64(xs[i])
        y = np.int64(ys[i])
        if 5 <= x < width - 5 and 5 <= y < height - 5:
            # unsigned: no index counts from the end
            at = np.uint64(places[0, i])
            step = np.uint64(places[1, i])
            back = at - step
            work[3, i] = flat_grey[back]
            back -= step
            work[2, i] = flat_grey[back]
            back -= step
            work[1, i] = flat_grey[back]
            back -= step
            work[0, i] = flat_grey[back]
            at += step
            work[5, i] = flat_grey[at]
            at += step
            work[6, i] = flat_grey[at]
            at += step
            work[7, i] = flat_grey[at]
            at += step
            work[8, i] = flat_grey[at]
            at += step
            work[9, i] = flat_grey[at]
            continue
        nx, ny = _out(np.int64(directions[i]))
        for k in range(SAMPLES):
            px = min(max(x + (k - BEHIND) * nx, 0), width - 1)
            py = min(max(y + (k - BEHIND) * ny, 0), height - 1)
            work[k, i] = grey[py, px]
        clear[i] = 1.0 if _is_clear(mask, x, y, nx, ny, width, height) else 0.0
        if not (0 <= x + nx < width and 0 <= y + ny < height):
            work[CROSSING, i] = -1.0


@njit(**LEAF)
def _is_clear(mask, x, y, nx, ny, width, height):
    """Three obstacle pixels on one side and three free ones on the other, near the margin."""
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


@njit(**LEAF)
def _look_along(directions, n, work):
    """Which cracks give a point, and where the border runs aslant."""
    middle_x = work[MIDDLE_X]
    middle_y = work[MIDDLE_Y]
    chosen = work[CHOSEN]
    slanted = work[SLANTED]
    for i in range(n):
        # twice the way between the cracks' middles
        dx = abs(middle_x[i + 2 * REACH] - middle_x[i])
        dy = abs(middle_y[i + 2 * REACH] - middle_y[i])
        upright = directions[i] & 1 == 1
        across = dx if upright else dy
        along = dy if upright else dx
        chosen[i] = 1.0 if across <= along else 0.0
        slanted[i] = 1.0 if across > 1.0 else 0.0


@njit(**LEAF)
def _look_beside(level, by_level, n, work):
    """The plateaus beside every crack, and the profile smoothed at its two pixels.

    A plateau is the mean of two pixels, or the nearer one where the outer one may be at the far
    side, or in a narrow wall or gap the middle.
    """
    a4 = work[0]
    a3 = work[1]
    a2 = work[2]
    a1 = work[3]
    here = work[4]
    b1 = work[5]
    b2 = work[6]
    b3 = work[7]
    b4 = work[8]
    b5 = work[9]
    wall = work[WALL]
    gap = work[GAP]
    clear = work[CLEAR]
    dark = work[DARK]
    light = work[LIGHT]
    near = work[NEAR]
    far = work[FAR]
    if by_level:
        for i in range(n):
            dark_side = (a1[i] < level) & (a2[i] < level)
            light_side = (b2[i] >= level) & (b3[i] >= level)
            clear[i] = clear[i] if dark_side & light_side else 0.0
    for i in range(n):
        three = a3[i] >= level
        four = a4[i] >= level
        five = a4[i] + a4[i] > a2[i] + level
        middle = a1[i] if three else 0.5 * (a1[i] + a2[i])
        beyond = a2[i] if five else 0.5 * (a2[i] + a3[i])
        dark[i] = middle if three | four else beyond
        wall[i] = 1.0 if three | four else 0.0
        three = b4[i] < level
        four = b5[i] < level
        five = b5[i] + b5[i] < b3[i] + level
        middle = b2[i] if three else 0.5 * (b2[i] + b3[i])
        beyond = b3[i] if five else 0.5 * (b3[i] + b4[i])
        light[i] = middle if three | four else beyond
        gap[i] = 1.0 if three | four else 0.0
        near[i] = TAP0 * here[i] + TAP1 * (a1[i] + b1[i]) + TAP2 * (a2[i] + b2[i])
        far[i] = TAP0 * b1[i] + TAP1 * (here[i] + b2[i]) + TAP2 * (a1[i] + b3[i])
    # the few places where a narrow wall looks wide, at its corners, show no plateau either
    if 2.0 * _sum(wall[:n]) > n:
        wall[:n] = 1.0
    if 2.0 * _sum(gap[:n]) > n:
        gap[:n] = 1.0


@njit(**SUMS)
def _sum(row):
    total = 0.0
    for i in range(row.shape[0]):
        total += row[i]
    return total


@njit(**SUMS)
def _find_plateaus(n, work, sums):
    """Dark and light for every crack, from what lies within STRETCH of it.

    Near a corner the plateaus are not reached, so that the second round leaves out what is
    lighter or darker than the first round's mean. A crack whose stretch has none keeps its own.
    """
    reach = min(STRETCH, (n - 1) // 2)
    for again in range(2):
        if again == 0:
            _add_up(n, work, sums)
        else:
            _add_up_the_plain(n, work, sums)
        for row, level, total, count, others in (
            (DARK, DARK_LEVEL, 0, 1, 3),
            (LIGHT, LIGHT_LEVEL, 2, 3, 1),
        ):
            rows = work[row], work[level], sums[total], sums[count], sums[others]
            _set_level(0, reach, reach + 1, n - reach, True, n, *rows)
            _set_level(reach, n - reach, 2 * reach + 1, 0, False, n, *rows)
            _set_level(n - reach, n, 1, n - 2 * reach, True, n, *rows)


@njit(**LEAF)
def _add_up(n, work, sums):
    """Up to every crack: what is dark and how many, what is light and how many.

    Sums of whole and half grey values, and so exact: the same wherever a border begins.
    """
    clear = work[CLEAR]
    dark = work[DARK]
    light = work[LIGHT]
    dark_sum = sums[0]
    darks = sums[1]
    light_sum = sums[2]
    lights = sums[3]
    a = 0.0
    b = 0.0
    c = 0.0
    for i in range(n):
        a += clear[i] * dark[i]
        b += clear[i]
        c += clear[i] * light[i]
        dark_sum[i + 1] = a
        darks[i + 1] = b
        light_sum[i + 1] = c
        lights[i + 1] = b


@njit(**LEAF)
def _add_up_the_plain(n, work, sums):
    """The same without what is lighter or darker than the levels found first."""
    clear = work[CLEAR]
    dark = work[DARK]
    light = work[LIGHT]
    dark_level = work[DARK_LEVEL]
    light_level = work[LIGHT_LEVEL]
    dark_sum = sums[0]
    darks = sums[1]
    light_sum = sums[2]
    lights = sums[3]
    a = 0.0
    b = 0.0
    c = 0.0
    d = 0.0
    for i in range(n):
        counts = clear[i] if dark[i] <= dark_level[i] + SAME_GREY else 0.0
        a += counts * dark[i]
        b += counts
        counts = clear[i] if light[i] >= light_level[i] - SAME_GREY else 0.0
        c += counts * light[i]
        d += counts
        dark_sum[i + 1] = a
        darks[i + 1] = b
        light_sum[i + 1] = c
        lights[i + 1] = d


@njit(**SUMS)
def _set_level(begin, end, ahead, behind, around, n, own, level, total, count, others):
    """The means of the stretches of cracks ``begin`` .. ``end`` - 1, dark or light.

    The stretch of the first one ends before crack ``ahead`` and begins at crack ``behind``;
    ``around``: past the border's end. ``own`` and ``level``: each crack's plateau, and its
    stretch's; ``total`` and ``count``: the sums of the plateaus and their number; ``others``:
    the number of those of the other kind, without which there is no level either.
    One kind at a time: a loop that writes two rows works on one crack at a time.
    """
    cracks = end - begin
    own = own[begin:end]
    level = level[begin:end]
    total_ahead = total[ahead : ahead + cracks]
    count_ahead = count[ahead : ahead + cracks]
    others_ahead = others[ahead : ahead + cracks]
    total_behind = total[behind : behind + cracks]
    count_behind = count[behind : behind + cracks]
    others_behind = others[behind : behind + cracks]
    whole = 1.0 if around else 0.0
    whole_total = whole * total[n]
    whole_count = whole * count[n]
    whole_others = whole * others[n]
    for i in range(cracks):
        counted = count_ahead[i] - count_behind[i] + whole_count
        known = (counted > 0.0) & (others_ahead[i] - others_behind[i] + whole_others > 0.0)
        mean = (total_ahead[i] - total_behind[i] + whole_total) / max(counted, 1.0)
        level[i] = mean if known else own[i]


@njit(**SUMS)
def _find_crossings(level, n, work, totals):
    """Where the smoothed profile crosses the half level between the crack's own two pixels.

    ``totals``: the sum and number of slopes, full steps and slanted cracks.
    """
    here = work[BEHIND]
    beside = work[BEHIND + 1]
    wall = work[WALL]
    gap = work[GAP]
    clear = work[CLEAR]
    chosen = work[CHOSEN]
    slanted = work[SLANTED]
    near = work[NEAR]
    far = work[FAR]
    dark_level = work[DARK_LEVEL]
    light_level = work[LIGHT_LEVEL]
    crossing = work[CROSSING]
    astray = work[ASTRAY]
    slopes = 0.0
    crossed = 0.0
    steps = 0.0
    slants = 0.0
    for i in range(n):
        g0 = here[i]
        g1 = beside[i]
        step = g1 - g0
        contrast = light_level[i] - dark_level[i]
        seen = (clear[i] > 0.0) & (contrast > 0.0)
        counts = chosen[i] * slanted[i] if seen else 0.0
        slants += counts
        steps += counts if step >= CRISP * contrast else 0.0
        share = 1.0 / (contrast if contrast > 0.0 else 1.0)
        half = 0.5 * (light_level[i] + dark_level[i])
        p0 = _probit((near[i] - half) * share)
        p1 = _probit((far[i] - half) * share)
        rise = p1 - p0
        between = seen & (near[i] < half) & (half <= far[i])
        good = between & (rise > 1e-6)
        counts = chosen[i] if good else 0.0
        slopes += counts * (far[i] - near[i]) * share
        crossed += counts
        plain = (g1 > level) & (step > 0.0) & (g0 < level) & (clear[i] == 0.0)
        t = (level - g0) / (step if step > 0.0 else 1.0) if plain else 0.5
        t = -p0 / (rise if rise > 1e-6 else 1.0) if good else t
        crossing[i] = 0.5 if crossing[i] < 0.0 else t
        narrow = wall[i] + gap[i] > 0.0
        astray[i] = 1.0 if seen & (narrow | (not between)) else 0.0
    totals[0] += slopes
    totals[1] += crossed
    totals[2] += steps
    totals[3] += slants


@njit(**SUMS)
def _probit(w):
    """The inverse normal distribution near its middle, but for a factor; w in [-0.5, 0.5]."""
    w = min(max(w, -0.5), 0.5)
    q = w * w
    return w * (1.0 + q * (1.047198 + q * (2.30291 + q * 6.0)))


@njit(**LEAF)
def _place(grey, level, xs, ys, directions, n, work, totals, points, count):
    """The points of the chosen cracks, in order; returns the next point's number."""
    crossing = work[CROSSING]
    chosen = work[CHOSEN]
    astray = work[ASTRAY]
    for i in range(n):
        nx, ny = _out(np.int64(directions[i]))
        t = crossing[i]
        if astray[i] * chosen[i] > 0.0:
            if work[WALL, i] + work[GAP, i] > 0.0:
                t = _crossing_narrow(level, i, work)
            else:
                t = _crossing_beside(grey, xs[i], ys[i], nx, ny, i, work, totals)
        points[count, 0] = xs[i] + t * nx
        points[count, 1] = ys[i] + t * ny
        count += np.int64(chosen[i])
    return count


@njit(**LEAF)
def _crossing_beside(grey, x, y, nx, ny, i, work, totals):
    """Where the smoothed profile crosses the half level beside the crack's own two pixels."""
    half = 0.5 * (work[LIGHT_LEVEL, i] + work[DARK_LEVEL, i])
    share = 1.0 / (work[LIGHT_LEVEL, i] - work[DARK_LEVEL, i])
    k = 0
    s0 = work[NEAR, i]
    s1 = work[FAR, i]
    while s0 >= half and k > -WANDER:
        k -= 1
        s1 = s0
        s0 = _smoothed(grey, x + k * nx, y + k * ny, nx, ny)
    while s1 < half and k < WANDER:
        k += 1
        s0 = s1
        s1 = _smoothed(grey, x + (k + 1) * nx, y + (k + 1) * ny, nx, ny)
    if s0 < half <= s1:
        p0 = _probit((s0 - half) * share)
        p1 = _probit((s1 - half) * share)
        if p1 - p0 > 1e-6:
            totals[0] += (s1 - s0) * share
            totals[1] += 1.0
            return k - p0 / (p1 - p0)
    return 0.5


@njit(**LEAF)
def _crossing_narrow(level, i, work):
    """Where the profile itself crosses the half level, at a wall or a gap three or four wide."""
    dark = work[DARK_LEVEL, i]
    light = work[LIGHT_LEVEL, i]
    half = 0.5 * (light + dark)
    # what a plateau lacks can only lie beyond what is seen of it
    lowest = half - (UNREACHED * (light - dark) if work[WALL, i] > 0.0 else 0.0)
    highest = half + (UNREACHED * (light - dark) if work[GAP, i] > 0.0 else 0.0)
    if lowest <= level <= highest:
        half = level
    k = BEHIND
    while work[k, i] >= half and k > BEHIND - WANDER:
        k -= 1
    while work[k + 1, i] < half and k < BEHIND + WANDER:
        k += 1
    g0 = work[k, i]
    g1 = work[k + 1, i]
    return k - BEHIND + (half - g0) / (g1 - g0) if g0 < half <= g1 else 0.5


@njit(**LEAF)
def _smoothed(grey, x, y, nx, ny):
    """The profile across a crack, smoothed at one pixel; the picture goes on beyond its edge."""
    height, width = grey.shape
    value = 0.0
    for k in range(-2, 3):
        px = min(max(x + k * nx, 0), width - 1)
        py = min(max(y + k * ny, 0), height - 1)
        tap = TAP0 if k == 0 else (TAP1 if abs(k) == 1 else TAP2)
        value += tap * grey[py, px]
    return value
