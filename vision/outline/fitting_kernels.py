"""Lines, arcs and circles through the sub-pixel points of every border.

Rules and units
- Points (k, 2) float64 in pixels (or rectified pixels), y down, border after border, each a
  closed sequence.
- ``dead_zone`` is the deviation that costs nothing (the staircase of a picture without grey),
  ``sigma`` the spread of the points about the true edge.
- One border at a time: is it a circle; where does it break (``vision.outline.partition_kernels``);
  what are its edges and where do they meet (``vision.outline.corners.joint_kernels``); do they
  cover it (``vision.outline.check.area_lost_kernels``), or without grey, do they separate its
  pixels (``vision.outline.drawn.separating_chord_kernels``).
- Whatever was fitted, an outline that leaves its border, or leaves a part of it out, is given up
  for chords from border point to border point (``vision.outline.check.stray_kernels``).
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF
from vision.outline.canonical_frame_kernels import (
    bring_cracks_along,
    bring_into_place,
    put_edges_back,
)
from vision.outline.check.area_lost_kernels import (
    area_beside_circle,
    area_lost,
    check_edges,
    chords,
    pass_between_pixels,
)
from vision.outline.check.residual_kernels import measure_residual
from vision.outline.check.stray_kernels import outline_strays
from vision.outline.corners.dropped_side_kernels import sharpen
from vision.outline.corners.fillet_kernels import ROUNDS, round_corners, touch_lines
from vision.outline.corners.joint_kernels import edge_end, fit_and_join
from vision.outline.corners.merged_line_kernels import straighten
from vision.outline.corners.missed_arc_kernels import any_bent_line
from vision.outline.corners.wall_end_kernels import cut_tips, square_tips
from vision.outline.drawn.separating_chord_kernels import all_chords, mend
from vision.outline.drawn.separation_kernels import find_cracks, middles
from vision.outline.fit.outline_kernels import STRAY_PX, finish_edge
from vision.outline.fit.separating_fit_kernels import (
    HALF,
    lost_to_circle,
    pixels_lost_to_circle,
    separate_circle,
)
from vision.outline.fit.shape_kernels import (
    HUGE,
    circle_cost,
    circle_rms,
    fit_circle,
    goes_round,
    refine_circle,
)
from vision.outline.fitted_borders import CIRCLE, LINE, POLYGON, TINY
from vision.outline.partition_kernels import partition

FEWEST = 10
"""Points of the smallest border that is fitted."""
TANGENT_PX = 0.05
CRISP_TANGENT_PX = 0.3
"""By how much two smoothly joined edges may miss or cross each other, noise aside."""
CUT_PX = 0.7
"""Blur's worth of a missing corner pixel: the sides still meet where they would with it."""
MOST_PX = 1.0
"""How far an edge may leave a border without noise: less than the pixel that is promised."""
CALM_LOSS_PX = 0.02
"""Deviation that does not count as area lost."""
STRICTER, STRICTER_BY = 2, 0.1
"""Times that a border without grey is broken, and by how much more the second time a pixel
counts."""
CALMER_BY, FINER_BY = 0.25, 0.4
ROUNDER_BY = 0.85
"""By how much cheaper an arc is then: it is no dearer than two chords that pass for it."""
QUIET_PX = 0.1
"""The same with grey: by how much less deviation is free, and by how much nearer to each other the
places are where it may break; and the noise up to which that tells."""
NO_BLUR = 0.0
"""Without grey no corner is rounded."""
SURE = 0.5
"""Pixels by which mending is stricter than the search."""
THIRDS = np.int64(3)
"""Arcs that a circle is cut into where it does not separate its pixels: each turns by less than
half a circle."""
LOSS_SHARE, LEAST_LOSS = 0.0035, 1.0
"""Area that an object's edges may lose, as a share of its own, and in pixels."""

HELD_AREA = 400
"""Pixels from which an object drawn again covers its own, whether or not it is round."""
CIRCLE_LOSS = 1.3
"""How much more than its edges might a circle may lose that spares them all."""
CHORD_PX, CRISP_CHORD_PX = 0.2, 0.34
"""How far a chord of a ragged stretch may leave its border points: without grey no farther than
half a pixel along the axis at 45 degrees."""
INWARDS, LOUD_PX = 0.31, 0.15
"""Blur moves the half-way level of a circle inwards by half its variance over the radius; a blur
that is read off profiles along rows and columns, which meet a circle aslant, looks so much wider
that it is less than a third (measured). Less with noise, and nothing from this spread on (too)."""
ROUGH = 64
"""Points that tell most other shapes from a circle."""
REFINEMENTS = np.int64(8)
NONE, ONE = np.int64(0), np.int64(1)
"""Typed, so that kernels are compiled for numbers and not once more for these."""


@njit(cache=True, nogil=True)
def fit_borders(
    points, point_starts, areas, owners, crack_x, crack_y, crack_way, crack_starts, crisp,
    dead_zone, sigma, spread, blur, guard, trim, prices,
):  # fmt: skip
    """Lines, arcs and circles of every border.

    ``areas`` (b,): the pixels that each border encloses, holes negative; ``owners`` (b,): the
    outline that it belongs to; the borders' cracks as in
    ``vision.borders.contours.Borders`` where edges have to separate every crack's pixels, or else
    none; ``crisp``: a picture without grey; ``spread``: what noise does to a point; ``guard``,
    ``trim``: how far a fit, and the search, keep from corners; ``prices`` (3,) of a line, an arc
    and a circle. Returns
    ``(border_kind, edge_starts, kind, data)``: per border POLYGON, CIRCLE or TINY and its first
    edge; per edge LINE, ARC_CW or ARC_CCW and data (k, 6): the edge's first point x, y, then
    cx, cy, r of an arc, and the whole border's rms deviation. A circle is one edge of kind LINE
    with its centre and radius in the data. TINY borders have no edges.
    """
    borders = point_starts.shape[0] - 1
    longest = 0
    for b in range(borders):
        longest = max(longest, point_starts[b + 1] - point_starts[b])
    budgets = np.empty(borders, np.float64)
    pixels = np.zeros(borders, np.int64)
    _allow_losses(point_starts, areas, owners, pixels, budgets)
    exact = crack_x.shape[0] > 0
    room = max(points.shape[0], crack_x.shape[0]) + borders
    for b in range(borders if exact else 0):
        longest = max(longest, crack_starts[b + 1] - crack_starts[b])
    border_kind = np.empty(borders, np.int8)
    edge_starts = np.empty(borders + 1, np.int64)
    kind = np.empty(room, np.int8)
    data = np.empty((room, 6), np.float64)
    at = np.empty(longest + 1, np.int64)
    state = np.empty(longest + 1, np.int64)
    inside = np.empty(longest + 1, np.bool_)
    qx = np.empty(2 * longest + 2 if exact else 1, np.float64)
    qy = np.empty(2 * longest + 2 if exact else 1, np.float64)
    hx = np.empty(2 * longest + 2 if exact else 1, np.float64)
    hy = np.empty(2 * longest + 2 if exact else 1, np.float64)
    crack_of = np.empty(longest + 1, np.int64)
    px = np.empty(2 * longest + 2, np.float64)
    py = np.empty(2 * longest + 2, np.float64)
    is_seed = np.empty(longest + 1, np.bool_)
    seeds = np.empty(longest + 1, np.int64)
    breaks = np.empty(longest + 1, np.int64)
    is_arc = np.empty(longest + 1, np.bool_)
    ragged = np.empty(longest + 1, np.bool_)
    stale = np.empty(longest + 1, np.bool_)
    is_tip = np.empty(longest + 1, np.bool_)
    losses = np.empty(longest + 1, np.float64)
    shape = np.empty((longest + 1, 5), np.float64)
    joints = np.empty((longest + 1, 2), np.float64)
    ranges = np.empty((longest + 1, 2), np.int64)
    fresh = np.empty((longest + 1, 2), np.bool_)
    kinds = np.empty(longest + 1, np.int8)
    rows = np.empty((longest + 1, 6), np.float64)
    active = np.empty((2, longest + 2), np.float64)
    push = np.empty((2 * longest + 2, 6), np.float64)
    circle = np.empty(3, np.float64)
    spare = np.empty(3, np.float64)
    finer = prices.copy()
    if not crisp:
        finer[1] *= ROUNDER_BY
    worst = dead_zone + 0.12 if crisp else 0.35 + dead_zone + 4.5 * sigma
    round_worst = min(worst, STRAY_PX)
    allowed = MOST_PX + 4.5 * spread
    free = CALM_LOSS_PX + 2.0 * spread
    skip = math.ceil(trim)
    chord = CRISP_CHORD_PX if crisp else CHORD_PX + 2.0 * spread
    rounded = CUT_PX if exact else blur
    tangent = CRISP_TANGENT_PX if crisp else TANGENT_PX + spread
    seed_tolerance = 0.9 if crisp else 0.35 + dead_zone + 2.5 * sigma
    expected = _expected_cost(dead_zone, sigma, spread)
    count = 0
    for b in range(borders):
        first = point_starts[b]
        n = point_starts[b + 1] - first
        edge_starts[b] = count
        if n < FEWEST:
            border_kind[b] = TINY
            continue
        transposed, turns, ox, oy = bring_into_place(
            points[first : first + n], exact, active[0], px, py
        )
        budget = budgets[b]
        cracks = 0
        if exact:
            these = slice(crack_starts[b], crack_starts[b + 1])
            cracks = middles(crack_x[these], crack_y[these], crack_way[these], qx, qy, hx, hy)
            ox, oy = bring_cracks_along(
                px, py, n, qx, qy, hx, hy, cracks, transposed, turns, ox, oy
            )
        round_cost, nearly = _circle_of_all(
            px, py, n, crisp, dead_zone, sigma, round_worst, budget, prices[2], circle, active,
            pixels[b] >= HELD_AREA, qx, qy, hx, hy, cracks,
        )  # fmt: skip
        edges = 0
        strict = sigma
        if exact and nearly:
            # no search would find what it loses: it is mended
            edges = _thirds(px, py, n, circle, breaks, is_arc, joints, shape)
        calm = dead_zone
        seeded = seed_tolerance
        sound = False
        looks = STRICTER if crisp or spread <= QUIET_PX else 1
        for again in range(looks):
            if (edges > 0 and again == 0) or round_cost <= 3.0 * prices[0] + expected * n:
                break
            paid = finer if again > 0 else prices
            edges, cost = partition(
                px, py, n, skip, crisp, calm, strict, worst, seeded, round_cost,
                circle[2] if round_cost < HUGE else 0.0, paid, is_seed, seeds, breaks, is_arc,
                active,
            )  # fmt: skip
            if round_cost <= cost:
                edges = 0
                break
            fit_and_join(
                px, py, n, breaks, is_arc, edges, crisp, guard, rounded, tangent, joints, shape,
                ranges, fresh, active,
            )  # fmt: skip
            if not crisp:
                edges, cut = cut_tips(px, py, n, breaks, is_arc, edges, shape, blur, guard, is_tip)
                if cut:
                    fit_and_join(
                        px, py, n, breaks, is_arc, edges, crisp, guard, rounded, tangent, joints,
                        shape, ranges, fresh, active,
                    )  # fmt: skip
                    square_tips(px, py, n, breaks, is_arc, edges, shape, joints, is_tip)
                edges = _round_corners(
                    px, py, n, breaks, is_arc, edges, guard, rounded, tangent, calm, strict, worst,
                    expected, prices, paid, joints, shape, ranges, fresh, active, stale,
                )  # fmt: skip
            if exact and not is_arc[:edges].any():
                # what straight sides lose they lose at their corners, which are mended
                break
            if crisp and budget >= pass_between_pixels(
                px, py, n, breaks, is_arc, edges, shape, joints, free, allowed, guard,
                ragged, losses, stale, kinds, rows, spare, push,
            ):  # fmt: skip
                break
            if crisp:
                strict *= STRICTER_BY
                continue
            lost = area_lost(
                px, py, n, breaks, is_arc, edges, shape, joints, crisp, free, allowed, guard,
                ragged, losses, stale, kinds, rows, spare,
            )  # fmt: skip
            if round_cost < HUGE and area_beside_circle(px, py, NONE, n, circle, free) < lost:
                # its one edge covers the border better than all of these
                edges = 0
                break
            sound = lost <= budget
            bent = again + 1 < looks and any_bent_line(
                px, py, n, is_arc, edges, shape, ranges, spread, spare
            )
            if sound and not bent:
                break
            calm *= CALMER_BY
            seeded *= FINER_BY
        if edges == 0:
            border_kind[b] = CIRCLE
            kind[count] = LINE
            data[count, 5] = circle_rms(px, py, NONE, n, circle)
            if not crisp:
                quiet = max(1.0 - spread / LOUD_PX, 0.0)
                circle[2] += quiet * INWARDS * blur * blur / max(circle[2], blur)
            data[count, 0] = ox + circle[0] - circle[2]
            data[count, 1] = oy + circle[1]
            data[count, 2] = ox + circle[0]
            data[count, 3] = oy + circle[1]
            data[count, 4] = circle[2]
            put_edges_back(kind[count:], data[count:], ONE, transposed, turns)
            count += 1
            continue
        border_kind[b] = POLYGON
        many = 0
        if exact:
            many = _finish(
                px, py, n, breaks, is_arc, edges, shape, joints, spare, kind[count:],
                data[count:],
            )  # fmt: skip
            find_cracks(px, py, n, qx, qy, cracks, crack_of)
            for e in range(edges):
                at[e] = crack_of[breaks[e]]
            many = mend(
                qx, qy, hx, hy, cracks, at, kind[count:], data[count:], many, budget - SURE, state,
                inside, seeds,
            )  # fmt: skip
            if outline_strays(qx, qy, cracks, at, kind[count:], data[count:], many):
                many = all_chords(qx, qy, hx, hy, cracks, at, kind[count:], data[count:], seeds)
            measure_residual(qx, qy, cracks, at, kind[count:], data[count:], many, NO_BLUR, NO_BLUR)
        else:
            if not sound:
                check_edges(
                    px, py, n, breaks, is_arc, edges, shape, joints, crisp, free, allowed, guard,
                    budget, ragged, losses, stale, kinds, rows, spare,
                )  # fmt: skip
            many = _write_with_chords(
                px, py, n, breaks, edges, joints, kinds, rows, ragged, chord, is_seed, seeds,
                kind[count:], data[count:], at,
            )  # fmt: skip
            if outline_strays(px, py, n, at, kind[count:], data[count:], many):
                many = _write_chords(
                    px, py, n, chord, is_seed, seeds, kind[count:], data[count:], at
                )
            measure_residual(px, py, n, at, kind[count:], data[count:], many, blur, guard)
        _place(data[count:], many, ox, oy, kind[count:])
        put_edges_back(kind[count:], data[count:], many, transposed, turns)
        if many < 3 and not kind[count : count + many].any():
            # two lines enclose nothing: so small a border is its pixels' outline
            border_kind[b] = TINY
            many = 0
        count += many
    edge_starts[borders] = count
    return border_kind, edge_starts, kind[:count].copy(), data[:count].copy()


@njit(cache=True, nogil=True)
def _allow_losses(point_starts, areas, owners, pixels, budgets):
    """Fill every border's ``budgets``, and ``pixels``, those of its object without its holes.

    An object may lose a share of its pixels, which its borders divide among them by their points.
    """
    borders = areas.shape[0]
    lengths = np.zeros(borders, np.int64)
    for b in range(borders):
        pixels[owners[b]] += areas[b]
        lengths[owners[b]] += point_starts[b + 1] - point_starts[b]
    for b in range(borders):
        pixels[b] = pixels[owners[b]]
        allowed = max(LOSS_SHARE * pixels[b], LEAST_LOSS)
        length = point_starts[b + 1] - point_starts[b]
        budgets[b] = allowed * length / max(lengths[owners[b]], 1)


@njit(**LEAF)
def _circle_of_all(
    px, py, n, crisp, dead_zone, sigma, worst, budget, price, circle, active, held,
    qx, qy, hx, hy, cracks,
):  # fmt: skip
    """The circle through a whole border: its cost with its price, and whether it nearly fits.

    HUGE where it is none. ``nearly``: it runs beside every point, but loses too many pixels.
    """
    # a sample tells most other shapes from a circle
    if not fit_circle(px, py, NONE, n, max(1, n // ROUGH), circle):
        return HUGE, False
    far = circle_cost(px, py, NONE, n, circle, crisp, dead_zone, sigma, 2.0 * worst, HUGE)
    if far >= HUGE or not fit_circle(px, py, NONE, n, ONE, circle):
        return HUGE, False
    refine_circle(px, py, NONE, n, REFINEMENTS, circle)
    if not goes_round(px, py, n, circle[0], circle[1]):
        return HUGE, False
    if crisp:
        separate_circle(px, py, NONE, n, circle, active)
        if circle_cost(px, py, NONE, n, circle, crisp, HALF, 1.0, worst, HUGE) < HUGE:
            lost = lost_to_circle(px, py, n, circle)
            if cracks > 0:
                lost = pixels_lost_to_circle(qx, qy, hx, hy, cracks, circle)
            if lost <= budget:
                return price, False
            if held and lost > max(CIRCLE_LOSS * budget, 1.0):
                return HUGE, True
    cost = circle_cost(px, py, NONE, n, circle, crisp, dead_zone, sigma, worst, HUGE)
    return price + cost, False


@njit(cache=True, nogil=True)
def _round_corners(
    px, py, n, breaks, is_arc, edges, guard, blur, tangent, dead_zone, sigma, worst, expected,
    prices, paid, joints, shape, ranges, fresh, active, is_fillet,
):  # fmt: skip
    """Put fillets where sharp corners do not fit, and fit again; returns the number of edges.

    What is one line then, at the prices that were ``paid`` in the search, is made one first.
    """
    is_fillet[:edges] = False
    corner = np.empty(7, np.float64)
    searched = 0
    while True:
        edges, changed = straighten(
            px, py, n, breaks, is_arc, edges, shape, ranges, dead_zone, sigma, worst, paid,
            is_fillet, corner,
        )  # fmt: skip
        if not changed:
            edges, changed = sharpen(
                px, py, n, breaks, is_arc, edges, shape, joints, blur, dead_zone, sigma, worst,
                expected, prices[0], is_fillet, corner,
            )  # fmt: skip
        if not changed and searched < ROUNDS:
            searched += 1
            edges, changed = round_corners(
                px, py, n, breaks, is_arc, edges, shape, joints, blur, dead_zone, sigma, worst,
                expected, prices, is_fillet,
            )  # fmt: skip
        if not changed:
            break
        fit_and_join(
            px, py, n, breaks, is_arc, edges, False, guard, blur, tangent, joints, shape, ranges,
            fresh, active,
        )  # fmt: skip
        touch_lines(
            px, py, n, breaks, is_arc, edges, shape, joints, is_fillet, blur, dead_zone, sigma,
            worst, corner,
        )  # fmt: skip
    return edges


@njit(**LEAF)
def _thirds(px, py, n, circle, breaks, is_arc, joints, shape):
    """Write a circle as three arcs; returns their number."""
    for t in range(THIRDS):
        k = t * n // THIRDS
        x = px[k] - circle[0]
        y = py[k] - circle[1]
        share = circle[2] / max(math.sqrt(x * x + y * y), 1e-9)
        breaks[t] = k
        is_arc[t] = True
        joints[t, 0] = circle[0] + x * share
        joints[t, 1] = circle[1] + y * share
        for c in range(3):
            shape[t, c] = circle[c]
        shape[t, 4] = 0.0
    return THIRDS


@njit(**LEAF)
def _finish(px, py, n, breaks, is_arc, edges, shape, joints, circle, kind, data):
    """Write the edges between their joints; returns their number."""
    for e in range(edges):
        kind[e] = finish_edge(
            px, py, breaks[e], edge_end(breaks, edges, n, e), is_arc[e], shape, e, joints,
            e + 1 if e + 1 < edges else 0, data, circle,
        )  # fmt: skip
    return edges


@njit(cache=True, nogil=True)
def _write_with_chords(
    px, py, n, breaks, edges, joints, kinds, rows, ragged, chord, is_seed, found, kind, data, at,
):  # fmt: skip
    """Write finished edges, and chords instead of the ragged ones; returns their number.

    ``at``: the point that each one begins at.
    """
    count = 0
    for e in range(edges):
        if not ragged[e]:
            kind[count] = kinds[e]
            at[count] = breaks[e]
            for c in range(6):
                data[count, c] = rows[e, c]
            count += 1
            continue
        m = chords(px, py, breaks[e], edge_end(breaks, edges, n, e), chord, is_seed, found)
        for t in range(m):
            x = joints[e, 0] if t == 0 else px[found[t]]
            y = joints[e, 1] if t == 0 else py[found[t]]
            at[count] = found[t] - n if found[t] >= n else found[t]
            _write_chord(kind, data, count, x, y)
            count += 1
    return count


@njit(cache=True, nogil=True)
def _write_chords(px, py, n, chord, is_seed, found, kind, data, at):
    """Write chords all around a border, from point to point; returns their number."""
    count = chords(px, py, NONE, n, chord, is_seed, found)
    for t in range(count):
        at[t] = found[t]
        _write_chord(kind, data, t, px[found[t]], py[found[t]])
    return count


@njit(**LEAF)
def _write_chord(kind, data, i, x, y):
    kind[i] = LINE
    data[i, 0] = x
    data[i, 1] = y
    data[i, 2] = 0.0
    data[i, 3] = 0.0
    data[i, 4] = 0.0


@njit(**LEAF)
def _place(data, count, ox, oy, kind):
    """Move finished edges from the border's own origin to the picture's."""
    for i in range(count):
        data[i, 0] += ox
        data[i, 1] += oy
        if kind[i] != LINE:
            data[i, 2] += ox
            data[i, 3] += oy


@njit(**LEAF)
def _expected_cost(dead_zone, sigma, spread):
    """What noise alone costs a point: the mean of a normal deviation's excess, squared."""
    if spread <= 0.0:
        return 0.0
    a = dead_zone / spread
    tail = 0.5 * math.erfc(a / math.sqrt(2.0))
    density = math.exp(-0.5 * a * a) / math.sqrt(2.0 * math.pi)
    return 2.0 * ((1.0 + a * a) * tail - a * density) * (spread / sigma) ** 2
