"""Lines, arcs and circles through the sub-pixel points of every border.

Rules and units
- Points (k, 2) float64 in pixels (or rectified pixels), y down, border after border, each a
  closed sequence. What is handed on: ``vision.outline.outline_types``.
- One border at a time: is it a circle (``vision.outline.whole_circle_kernels``); where does it
  break (``vision.outline.partition_kernels``); what are its edges and where do they meet
  (``vision.outline.corners.joint_kernels``); do they cover it
  (``vision.outline.check.area_lost_kernels``), or without grey, do they separate its pixels
  (``vision.outline.drawn.separating_chord_kernels``).
- Whatever was fitted, an outline that leaves its border, or leaves a part of it out, is given up
  for chords from border point to border point (``vision.outline.check.stray_kernels``).
"""

# mypy: allow-untyped-defs

from __future__ import annotations

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
    pass_between_pixels,
)
from vision.outline.check.chord_kernels import chords_around, finish_with_chords
from vision.outline.check.residual_kernels import measure_residual
from vision.outline.check.stray_kernels import outline_strays
from vision.outline.corners.dropped_side_kernels import drop_side
from vision.outline.corners.fillet_search_kernels import ROUNDS, insert_fillets, touch_lines
from vision.outline.corners.joint_kernels import fit_and_join
from vision.outline.corners.merged_line_kernels import merge_lines
from vision.outline.corners.missed_arc_kernels import any_bent_line
from vision.outline.corners.wall_end_kernels import cut_ends, square_ends
from vision.outline.drawn.separating_chord_kernels import all_chords, separate_by_chords
from vision.outline.drawn.separation_kernels import fill_cracks, find_cracks
from vision.outline.fit.outline_kernels import finish_edge
from vision.outline.fit.shape_kernels import HUGE
from vision.outline.fitted_borders import CIRCLE, LINE, POLYGON, TINY
from vision.outline.limit_kernels import allow_losses, limits_of
from vision.outline.outline_types import (
    BorderPoints,
    Costs,
    Cracks,
    FinishedEdges,
    Prices,
)
from vision.outline.partition_kernels import partition
from vision.outline.whole_circle_kernels import circle_of_all, cut_circle, write_circle
from vision.outline.work_kernels import make_work

FEWEST = 10
"""Points of the smallest border that is fitted."""
LOOKS = 2
"""Times that a border is broken into edges: the second time by more careful rules, where the first
did not find edges that cover it."""
STRICTER_BY = 0.1
"""Without grey: the share of a deviation that costs as much then."""
CALMER_BY, FINER_BY = 0.25, 0.4
"""With grey: by how much less deviation is free then, and by how much nearer to each other the
places are where the border may break."""
ROUNDER_BY = 0.85
"""With grey: by how much cheaper an arc is then. It is no dearer than two chords that pass for
it."""
QUIET_PX = 0.1
"""With grey: the noise of a point up to which a second look tells."""
CHEAP = 3.0
"""A circle that costs no more than so many lines is not compared with other edges."""
NO_BLUR = 0.0
"""Without grey no corner is rounded."""
SURE = 0.5
"""Pixels by which the last check is stricter than the search."""
HELD_AREA = 400
"""Pixels from which an object drawn again covers its own, whether or not it is round."""
STEP = {**LEAF, "forceinline": True}
"""Options of a step that is called in one place: it is handed all the memory, which a call would
copy number by number."""
NONE, ONE = np.int64(0), np.int64(1)
"""Typed, so that kernels are compiled for numbers and not once more for these."""


@njit(cache=True, nogil=True)
def fit_borders(points, point_starts, areas, owners, crack_pixels, tolerance, prices):
    """Lines, arcs and circles of every border.

    ``areas`` (b,): the pixels that each border encloses, holes negative; ``owners`` (b,): the
    outline that it belongs to; ``crack_pixels``: the borders' cracks where edges have to separate
    every crack's pixels, or else none. Returns
    ``(border_kind, edge_starts, kind, data)``: per border POLYGON, CIRCLE or TINY and its first
    edge; per edge LINE, ARC_CW or ARC_CCW and data (k, 6): the edge's first point x, y, then
    cx, cy, r of an arc, and the whole border's rms deviation. A circle is one edge of kind LINE
    with its centre and radius in the data. TINY borders have no edges.
    """
    borders = point_starts.shape[0] - 1
    exact = crack_pixels.x.shape[0] > 0
    longest = _longest(point_starts)
    if exact:
        longest = max(longest, _longest(crack_pixels.starts))
    budgets = np.empty(borders, np.float64)
    pixels = np.zeros(borders, np.int64)
    allow_losses(point_starts, areas, owners, pixels, budgets)
    limits = limits_of(tolerance, exact)
    work = make_work(longest, exact)
    room = max(points.shape[0], crack_pixels.x.shape[0]) + borders
    border_kind = np.empty(borders, np.int8)
    edge_starts = np.empty(borders + 1, np.int64)
    kind = np.empty(room, np.int8)
    data = np.empty((room, 6), np.float64)
    count = 0
    for b in range(borders):
        edge_starts[b] = count
        here = points[point_starts[b] : point_starts[b + 1]]
        if here.shape[0] < FEWEST:
            border_kind[b] = TINY
            continue
        border = BorderPoints(work.points.x, work.points.y, here.shape[0])
        place = bring_into_place(here, exact, work.near[0], border)
        known = crack_pixels.starts[b + 1] - crack_pixels.starts[b] if exact else 0
        room_of = work.cracks
        cracks = Cracks(room_of.x, room_of.y, room_of.free_x, room_of.free_y, known)
        if exact:
            these = slice(crack_pixels.starts[b], crack_pixels.starts[b + 1])
            fill_cracks(
                crack_pixels.x[these], crack_pixels.y[these], crack_pixels.direction[these], cracks
            )
            place = bring_cracks_along(border, cracks, place)
        finished = FinishedEdges(kind[count:], data[count:], work.at)
        border_kind[b], edges = _fit_border(
            border, cracks, place, budgets[b], pixels[b] >= HELD_AREA, tolerance, limits, prices,
            work, finished,
        )  # fmt: skip
        count += edges
    edge_starts[borders] = count
    return border_kind, edge_starts, kind[:count].copy(), data[:count].copy()


@njit(**LEAF)
def _longest(starts):
    """The longest of sequences that follow one another."""
    longest = 0
    for b in range(starts.shape[0] - 1):
        longest = max(longest, starts[b + 1] - starts[b])
    return longest


@njit(**STEP)
def _fit_border(
    border, cracks, place, budget, held, tolerance, limits, prices, work, finished
):  # fmt: skip
    """Write one border's edges, or its circle, moved to ``place``: its kind, and their number.

    ``budget``: the area that its edges may lose; ``held``: even where they are one circle.
    """
    costs = Costs(
        limits.crisp,
        tolerance.dead_zone_px,
        tolerance.sigma_px,
        limits.round_worst,
        limits.expected,
    )
    round_cost, nearly = circle_of_all(
        border, cracks, costs, budget, held, prices.circle, work.circle, work.near
    )
    edges = 0
    sound = False
    if cracks.n > 0 and nearly:
        # no search would find what it loses: the last check does
        edges = cut_circle(border, work.circle, work.outline)
    elif round_cost > CHEAP * prices.line + limits.expected * border.n:
        edges, sound = _search_edges(
            border, cracks, round_cost, budget, tolerance, limits, prices, work
        )
    if edges == 0:
        write_circle(border, work.circle, tolerance, place, finished)
        put_edges_back(finished, ONE, place)
        return CIRCLE, ONE
    if cracks.n > 0:
        edges = _finish_drawn(border, cracks, edges, budget, work, finished)
    else:
        edges = _finish_grey(border, edges, sound, budget, tolerance, limits, work, finished)
    _move(finished, edges, place)
    put_edges_back(finished, edges, place)
    if edges < 3 and not _any(finished.kind, edges):
        # two lines enclose nothing: so small a border is its pixels' outline
        return TINY, NONE
    return POLYGON, edges


@njit(**STEP)
def _search_edges(border, cracks, round_cost, budget, tolerance, limits, prices, work):
    """Break a border into edges, and once more where they do not cover it.

    Returns their number, 0 where its circle, which costs ``round_cost``, is better than all of
    them, and whether they are known to cover it.
    """
    outline = work.outline
    crisp = limits.crisp
    spread = tolerance.spread_px
    looks = LOOKS if crisp or spread <= QUIET_PX else 1
    finer = Prices(prices.line, prices.arc if crisp else ROUNDER_BY * prices.arc, prices.circle)
    radius = work.circle[2] if round_cost < HUGE else 0.0
    dead_zone = tolerance.dead_zone_px
    sigma = tolerance.sigma_px
    seeds = limits.seeds
    edges = 0
    sound = False
    for again in range(looks):
        costs = Costs(crisp, dead_zone, sigma, limits.worst, limits.expected)
        paid = finer if again > 0 else prices
        edges, cost = partition(
            border, outline, limits.skip, costs, seeds, paid, round_cost, radius, work
        )
        if round_cost <= cost:
            return 0, False
        edges = _join_edges(border, edges, tolerance, limits, costs, prices, paid, work)
        if cracks.n > 0 and not _any(outline.is_arc, edges):
            # what straight sides lose they lose at their corners, which the last check sees
            break
        if crisp:
            if budget >= pass_between_pixels(
                border, outline, edges, limits, work.review, work.trial, work.spare, work.push
            ):
                break
            sigma *= STRICTER_BY
            continue
        lost = area_lost(border, outline, edges, limits, work.review, work.trial, work.spare)
        if round_cost < HUGE and lost > area_beside_circle(
            border.x, border.y, NONE, border.n, work.circle, limits.free
        ):
            # its one edge covers the border better than all of these
            return 0, False
        sound = lost <= budget
        bent = again + 1 < looks and any_bent_line(border, outline, edges, spread, work.spare)
        if sound and not bent:
            break
        dead_zone *= CALMER_BY
        seeds *= FINER_BY
    return edges, sound


@njit(**STEP)
def _join_edges(border, edges, tolerance, limits, costs, prices, paid, work):
    """Fit the edges that a search found and join them; with grey, see to walls' ends and corners.

    ``paid``: the prices in the search. Returns the number of edges.
    """
    outline = work.outline
    fit_and_join(border, outline, edges, limits, work.near, work.spare)
    if limits.crisp:
        return edges
    edges, cut = cut_ends(
        border, outline, edges, tolerance.blur_px, limits.guard, work.is_end, work.corner_room
    )
    if cut:
        fit_and_join(border, outline, edges, limits, work.near, work.spare)
        square_ends(outline, edges, work.is_end)
    return _settle_corners(border, outline, edges, limits, costs, prices, paid, work)


@njit(**STEP)
def _settle_corners(border, outline, edges, limits, costs, prices, paid, work):
    """Put fillets where sharp corners do not fit, and fit again; returns the number of edges.

    What is one line then, at the prices that were ``paid`` in the search, is made one first.
    """
    blur = limits.corner_blur
    room = work.corner_room
    for e in range(edges):
        outline.is_fillet[e] = False
    searched = 0
    while True:
        edges, changed = merge_lines(border, outline, edges, costs, paid, room.corner)
        if not changed:
            edges, changed = drop_side(border, outline, edges, blur, costs, prices.line, room)
        if not changed and searched < ROUNDS:
            searched += 1
            edges, changed = insert_fillets(border, outline, edges, blur, costs, prices, room)
        if not changed:
            break
        fit_and_join(border, outline, edges, limits, work.near, work.spare)
        touch_lines(border, outline, edges, blur, costs, room.corner)
    return edges


@njit(**STEP)
def _finish_drawn(border, cracks, edges, budget, work, finished):
    """Write edges that separate the pixels of a border without grey; returns their number."""
    outline = work.outline
    for e in range(edges):
        finished.kind[e] = finish_edge(border, outline, edges, e, finished.rows, work.spare)
    find_cracks(border, cracks, work.crack_of)
    for e in range(edges):
        finished.at[e] = work.crack_of[outline.breaks[e]]
    count = separate_by_chords(
        cracks,
        finished,
        edges,
        budget - SURE,
        work.state,
        work.inside,
        work.seeds,
        work.trial,
        work.ends,
    )
    middles = BorderPoints(cracks.x, cracks.y, cracks.n)
    if outline_strays(middles, finished, count):
        count = all_chords(cracks, finished, work.seeds)
    measure_residual(middles, finished, count, NO_BLUR, NO_BLUR)
    return count


@njit(**STEP)
def _finish_grey(border, edges, sound, budget, tolerance, limits, work, finished):
    """Write edges that cover their border, chords where none do; returns their number."""
    outline = work.outline
    if not sound:
        check_edges(border, outline, edges, limits, budget, work.review, work.trial, work.spare)
    count = finish_with_chords(
        border, outline, edges, work.trial, work.review, limits.chord, work.is_seed, work.seeds,
        work.stack, finished,
    )  # fmt: skip
    if outline_strays(border, finished, count):
        count = chords_around(border, limits.chord, work.is_seed, work.seeds, work.stack, finished)
    measure_residual(border, finished, count, tolerance.blur_px, limits.guard)
    return count


@njit(**LEAF)
def _any(flags, count):
    """Whether any of the first ``count`` is not 0."""
    for i in range(count):  # noqa: SIM110 (numba knows no generators)
        if flags[i]:
            return True
    return False


@njit(**LEAF)
def _move(finished, count, place):
    """Move finished edges from the border's own origin to the picture's."""
    data = finished.rows
    for i in range(count):
        data[i, 0] += place.x
        data[i, 1] += place.y
        if finished.kind[i] != LINE:
            data[i, 2] += place.x
            data[i, 3] += place.y
