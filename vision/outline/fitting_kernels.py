"""Lines, arcs and circles through the sub-pixel points of every border.

Rules and units
- Points (k, 2) float64 in pixels (or rectified pixels), y down, border after border. Types:
  ``vision.outline.outline_types``.
- A border is tested for a circle (``vision.outline.whole_circle_kernels``), broken into edges
  (``vision.outline.partition_kernels``), and these are joined
  (``vision.outline.corners.joint_kernels``). They must cover the border
  (``vision.outline.check.area_lost_kernels``) or, without grey, separate its pixels
  (``vision.outline.bilevel.separating_chord_kernels``).
- Chords between border points replace an outline that still strays
  (``vision.outline.check.stray_kernels``).
- A kernel without ``forceinline`` or ``fastmath`` inherits it from its first caller to be compiled.
  ``fit_borders`` inlines all but rarely called kernels.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from numba import njit

from planner.scene.compile_options import LEAF
from vision.outline.bilevel.merging_kernels import merge_edges
from vision.outline.bilevel.separating_chord_kernels import all_chords, separate_by_chords
from vision.outline.bilevel.separation_kernels import fill_cracks, find_cracks
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
from vision.outline.corners.edit_search_kernels import edit_outline
from vision.outline.corners.joint_kernels import fit_and_join
from vision.outline.corners.missed_arc_kernels import any_bent_line
from vision.outline.fit.edge_shape_kernels import HUGE
from vision.outline.fit.outline_kernels import finish_edge
from vision.outline.fitted_borders import FEWEST_LINES, LINE, POLYGON, TINY_BORDER, WHOLE_CIRCLE
from vision.outline.limit_kernels import QUIET_PX, limits_of
from vision.outline.outline_types import (
    BorderPoints,
    Costs,
    Cracks,
    FinishedEdges,
    Outline,
    Prices,
    Review,
    Scratch,
    Work,
)
from vision.outline.partition_kernels import partition
from vision.outline.whole_circle_kernels import circle_of_all, cut_circle, write_circle
from vision.shared.typed_numbers import ONE, ZERO

FEWEST_POINTS = 10
"""Least points of a fitted border: chosen."""
SEARCHES = 2
"""Searches for a border's edges (defined): the second by more careful rules, if the first ones do
not cover it."""
STRICTER_BY = 0.1
"""Factor on a deviation of equal cost then, without grey: chosen."""
DEAD_ZONE_BY, FINER_BY = 0.25, 0.4
"""Factors on the free deviation and on the distance of possible breaks then, with grey: chosen."""
ROUNDER_BY = 0.85
"""Factor on an arc's price then, with grey: chosen, no dearer than two chords."""
NO_BLUR = 0.0
"""Without grey no corner is rounded: defined."""
SPARE_ROW = 6
"""Row of the scratch numbers for checks, and to finish an edge: defined."""
HELD_AREA = 400
"""Pixels from which an object drawn again must cover its own, even if round: indifferent."""


@njit(**LEAF, forceinline=True)
def fit_borders(
    points, point_starts, budgets, pixels, crack_pixels, tolerance, prices, memory, fitted
):  # fmt: skip
    """Write lines, arcs and circles of every border into ``fitted``; returns the number of edges.

    ``budgets``, ``pixels`` (b,): the area each may lose, and its object's pixels;
    ``crack_pixels``: the borders' cracks if edges must separate their pixels, else none;
    ``memory``: for the longest border.

    Per border: POLYGON, WHOLE_CIRCLE or TINY_BORDER and its first edge. Per edge: LINE, ARC_CW or
    ARC_CCW and a row (6,) of the edge's first point x, y, then cx, cy, r of an arc, and the whole
    border's rms deviation. A circle is one edge of kind LINE with its centre and radius in the row.
    TINY_BORDER borders have no edges.
    """
    bilevel = crack_pixels.x.shape[0] > 0
    limits = limits_of(tolerance, bilevel)
    work = share_out(memory)
    places = work.places
    borders = point_starts.shape[0] - 1
    count = 0
    for b in range(borders):
        fitted.edge_starts[b] = count
        here = points[point_starts[b] : point_starts[b + 1]]
        if here.shape[0] < FEWEST_POINTS:
            fitted.border_kind[b] = TINY_BORDER
            continue
        border = BorderPoints(places[0], places[1], here.shape[0])
        place = bring_into_place(here, work.scratch.numbers[0], border)
        known = crack_pixels.starts[b + 1] - crack_pixels.starts[b] if bilevel else 0
        cracks = Cracks(places[2], places[3], places[4], places[5], known)
        if bilevel:
            these = slice(crack_pixels.starts[b], crack_pixels.starts[b + 1])
            fill_cracks(
                crack_pixels.x[these], crack_pixels.y[these], crack_pixels.direction[these], cracks
            )
            place = bring_cracks_along(border, cracks, place)
        finished = FinishedEdges(fitted.kind[count:], fitted.rows[count:], work.at)
        fitted.border_kind[b], edges = _fit_border(
            border, cracks, place, budgets[b], pixels[b] >= HELD_AREA, tolerance, limits, prices,
            work, finished,
        )  # fmt: skip
        count += edges
    fitted.edge_starts[borders] = count
    return count


@njit(**LEAF, inline="always")
def share_out(memory):
    """Share out the memory for one border as ``Work``."""
    most = memory.most
    numbers = memory.numbers
    indices = memory.indices
    flags = memory.flags
    table = memory.table
    outline = Outline(
        indices[7], flags[5], flags[6], table[:most], table[most : 2 * most], memory.pairs[:most],
        memory.fresh, indices[8],
    )  # fmt: skip
    for e in range(most):
        outline.is_fillet[e] = False
    return Work(
        numbers[0:6],
        outline,
        FinishedEdges(memory.kinds, table[2 * most : 3 * most], indices[9]),
        Review(flags[7], numbers[6], flags[8]),
        indices[10],
        numbers[7],
        Scratch(numbers[8:15], indices[0:7], flags[0:5], memory.pairs[most:], table[3 * most :]),
    )


@njit(**LEAF, inline="always")
def _fit_border(
    border, cracks, place, budget, held, tolerance, limits, prices, work, finished
):  # fmt: skip
    """Write one border's edges or circle, moved to ``place``; return its kind, and their number.

    ``budget``: area that they may lose; ``held``: it binds a single circle too.
    """
    costs = Costs(
        limits.crisp,
        tolerance.dead_zone_px,
        tolerance.sigma_px,
        limits.round_worst,
        limits.expected,
    )
    round_cost, nearly = circle_of_all(
        border, cracks, costs, budget, held, prices.circle, work.circle, work.scratch.numbers[0:2]
    )
    edges = 0
    sound = False
    bilevel = cracks.n > 0
    one_circle = bilevel and nearly
    if one_circle:
        # only the last check sees the pixels that it loses
        edges = cut_circle(border, work.circle, work.outline)
    elif round_cost > FEWEST_LINES * prices.line + limits.expected * border.n:
        edges, sound = _search_edges(
            border, cracks, round_cost, budget, tolerance, limits, prices, work
        )
    if edges > 0 and bilevel:
        edges = _finish_bilevel(border, cracks, edges, budget, one_circle, work, finished)
    elif edges > 0:
        edges = _finish_grey(border, edges, sound, budget, tolerance, limits, work, finished)
    if edges == 0:
        write_circle(border, work.circle, tolerance, place, finished)
        put_edges_back(finished, ONE, place)
        return WHOLE_CIRCLE, ONE
    _move(finished, edges, place)
    put_edges_back(finished, edges, place)
    if edges < FEWEST_LINES and not _number_set(finished.kind, edges):
        # two lines enclose nothing: the border keeps its pixels' outline
        return TINY_BORDER, ZERO
    return POLYGON, edges


@njit(**LEAF, inline="always")
def _search_edges(border, cracks, round_cost, budget, tolerance, limits, prices, work):
    """Break a border into edges, and a second time if they do not cover it.

    Returns their number, 0 if its circle, of cost ``round_cost``, beats them; and True if they
    certainly cover it.
    """
    outline = work.outline
    spare = work.scratch.numbers[SPARE_ROW]
    crisp = limits.crisp
    bilevel = cracks.n > 0
    spread = tolerance.spread_px
    looks = SEARCHES if crisp or spread <= QUIET_PX else 1
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
            border, outline, limits.skip, costs, seeds, paid, round_cost, radius, work.scratch
        )
        if round_cost <= cost:
            return 0, False
        fit_and_join(border, outline, edges, limits, work.scratch)
        if not crisp:
            edges = edit_outline(
                border, outline, edges, limits, tolerance.blur_px, costs, prices, work.scratch
            )
        if bilevel and not _number_set(outline.is_arc, edges):
            # straight sides lose area at corners: the last check sees it
            break
        if crisp:
            if budget >= pass_between_pixels(
                border, outline, edges, limits, work.review, work.trial, spare, work.scratch.table
            ):
                break
            sigma *= STRICTER_BY
            continue
        lost = area_lost(border, outline, edges, limits, work.review, work.trial, spare)
        if round_cost < HUGE and lost > area_beside_circle(
            border.x, border.y, ZERO, border.n, work.circle, limits.free
        ):
            # the circle alone covers the border better
            return 0, False
        sound = lost <= budget
        bent = again + 1 < looks and any_bent_line(border, outline, edges, spread, spare)
        if sound and not bent:
            break
        dead_zone *= DEAD_ZONE_BY
        seeds *= FINER_BY
    return edges, sound


@njit(**LEAF, inline="always")
def _finish_bilevel(border, cracks, edges, budget, one_circle, work, finished):
    """Write edges that separate the pixels of a border without grey; returns their number.

    ``one_circle``: the edges are arcs of one circle; 0 if they stay that.
    """
    outline = work.outline
    scratch = work.scratch
    crack_of = scratch.indices[0]
    found = scratch.indices[1]
    for e in range(edges):
        finished.kind[e] = finish_edge(
            border, outline, edges, e, finished.rows, scratch.numbers[SPARE_ROW]
        )
    find_cracks(border, cracks, crack_of)
    for e in range(edges):
        finished.at[e] = crack_of[outline.breaks[e]]
    count = separate_by_chords(
        cracks, finished, edges, budget, scratch.indices[2], scratch.flags[0], found, work.trial,
        scratch.numbers[0:2],
    )  # fmt: skip
    if one_circle and count == edges and _number_set(finished.kind, count) == count:
        return ZERO
    if count > edges or _number_set(finished.kind, count):
        count = merge_edges(cracks, finished, count, one_circle, work.trial, work.circle, scratch)
    middles = BorderPoints(cracks.x, cracks.y, cracks.n)
    if outline_strays(middles, finished, count):
        count = all_chords(cracks, finished, found)
    measure_residual(middles, finished, count, NO_BLUR, NO_BLUR)
    return count


@njit(**LEAF, inline="always")
def _finish_grey(border, edges, sound, budget, tolerance, limits, work, finished):
    outline = work.outline
    review = work.review
    scratch = work.scratch
    if not sound:
        check_edges(
            border, outline, edges, limits, budget, review, work.trial, scratch.numbers[SPARE_ROW]
        )
    count = finish_with_chords(
        border, outline, edges, work.trial, review, limits.chord, scratch, finished
    )
    if outline_strays(border, finished, count):
        count = chords_around(border, limits.chord, scratch, finished)
    measure_residual(border, finished, count, tolerance.blur_px, limits.guard)
    return count


@njit(**LEAF)
def _number_set(flags, count):
    number = 0
    for i in range(count):
        number += flags[i] != 0
    return number


@njit(**LEAF)
def _move(finished, count, place):
    data = finished.rows
    for i in range(count):
        data[i, 0] += place.x
        data[i, 1] += place.y
        if finished.kind[i] != LINE:
            data[i, 2] += place.x
            data[i, 3] += place.y
