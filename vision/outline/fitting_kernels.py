"""Lines, arcs and circles through the sub-pixel points of every border.

Rules and units
- Points (k, 2) float64 in pixels (or rectified pixels), y down, border after border. Types:
  ``vision.outline.outline_types``.
- A border is tested for a circle (``vision.outline.whole_circle_kernels``), broken into edges
  (``vision.outline.partition_kernels``), and these are joined
  (``vision.outline.corners.joint_kernels``). They must cover the border
  (``vision.outline.check.area_lost_kernels``).
- Chords between border points replace an outline that still strays
  (``vision.outline.check.stray_kernels``).
- A kernel without ``forceinline`` or ``fastmath`` inherits it from its first caller to be compiled.
  ``fit_borders`` inlines all but kernels that are called rarely, or in several places: those would
  be compiled once for each.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from numba import njit

from planner.scene.compile_options import LEAF
from vision.outline.canonical_frame_kernels import bring_into_place, put_edges_back
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
from vision.shared.typed_numbers import NO, ONE, ZERO

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
SPARE_ROW = 6
"""Row of the scratch numbers for checks, and to finish an edge: defined."""
HELD_AREA = 400
"""Pixels from which an object drawn again must cover its own, even if round: indifferent."""


@njit(**LEAF, forceinline=True)
def fit_borders(points, point_starts, budgets, pixels, tolerance, prices, memory, fitted):
    """Write lines, arcs and circles of every border into ``fitted``; returns the number of edges.

    ``budgets``, ``pixels`` (b,): the area each may lose, and its object's pixels; ``memory``: for
    the longest border. Where edges must separate a border's pixels,
    ``vision.outline.separated_border_kernels`` fits them.

    Per border: POLYGON, WHOLE_CIRCLE or TINY_BORDER and its first edge. Per edge: LINE, ARC_CW or
    ARC_CCW and a row (6,) of the edge's first point x, y, then cx, cy, r of an arc, and the whole
    border's rms deviation. A circle is one edge of kind LINE with its centre and radius in the row.
    TINY_BORDER borders have no edges.
    """
    limits = limits_of(tolerance, NO)
    work = share_out(memory)
    places = work.places
    cracks = Cracks(places[2], places[3], places[4], places[5], ZERO)
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
        finished = FinishedEdges(fitted.kind[count:], fitted.rows[count:], work.at)
        edges, sound, _ = find_edges(
            border, cracks, budgets[b], pixels[b] >= HELD_AREA, tolerance, limits, prices, work
        )
        if edges > 0:
            edges = _finish(border, edges, sound, budgets[b], tolerance, limits, work, finished)
        fitted.border_kind[b], edges = put_back(border, edges, tolerance, place, work, finished)
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
def find_edges(border, cracks, budget, held, tolerance, limits, prices, work):
    """Find one border's edges: their number, 0 if it is a circle.

    Also returns True if they certainly cover it, and True if they are arcs of one circle.
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
    one_circle = cracks.n > 0 and nearly
    if one_circle:
        # only the last check sees the pixels that it loses
        edges = cut_circle(border, work.circle, work.outline)
    elif round_cost > FEWEST_LINES * prices.line + limits.expected * border.n:
        edges, sound = _search_edges(
            border, cracks, round_cost, budget, tolerance, limits, prices, work
        )
    return edges, sound, one_circle


@njit(**LEAF, inline="always")
def put_back(border, edges, tolerance, place, work, finished):
    """Move one border's finished edges, or its circle, to ``place``; return its kind, and their
    number.
    """
    if edges == 0:
        write_circle(border, work.circle, tolerance, place, finished)
        put_edges_back(finished, ONE, place)
        return WHOLE_CIRCLE, ONE
    _move(finished, edges, place)
    put_edges_back(finished, edges, place)
    if edges < FEWEST_LINES and not number_set(finished.kind, edges):
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
        if bilevel and not number_set(outline.is_arc, edges):
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
def _finish(border, edges, sound, budget, tolerance, limits, work, finished):
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
def number_set(flags, count):
    """Number of the first ``count`` flags that are set."""
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
