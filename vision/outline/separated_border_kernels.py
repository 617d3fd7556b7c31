"""The fit of borders of a picture of two grey values: their edges must separate its pixels.

The edges are found as in ``vision.outline.fitting_kernels``. Then chords
(``vision.outline.bilevel.separating_chord_kernels``) and merged edges
(``vision.outline.bilevel.merging_kernels``) separate each border's pixels. On the floor there are
no pixels to separate, so a run neither needs nor compiles this kernel.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from numba import njit

from planner.scene.compile_options import LEAF
from vision.outline.bilevel.merging_kernels import merge_edges
from vision.outline.bilevel.separating_chord_kernels import all_chords, separate_by_chords
from vision.outline.bilevel.separation_kernels import fill_cracks, find_cracks
from vision.outline.canonical_frame_kernels import bring_cracks_along, bring_into_place
from vision.outline.check.residual_kernels import measure_residual
from vision.outline.check.stray_kernels import outline_strays
from vision.outline.fit.outline_kernels import finish_edge
from vision.outline.fitted_borders import TINY_BORDER
from vision.outline.fitting_kernels import (
    FEWEST_POINTS,
    HELD_AREA,
    SPARE_ROW,
    find_edges,
    number_set,
    put_back,
    share_out,
)
from vision.outline.limit_kernels import limits_of
from vision.outline.outline_types import BorderPoints, Cracks, FinishedEdges
from vision.shared.typed_numbers import YES, ZERO

NO_BLUR = 0.0
"""Without grey no corner is rounded: defined."""


@njit(**LEAF, forceinline=True)
def fit_separated_borders(
    points, point_starts, budgets, pixels, crack_pixels, tolerance, prices, memory, fitted
):  # fmt: skip
    """Fit every border as ``fit_borders`` does, with edges that separate its pixels.

    ``crack_pixels``: the borders' cracks (``vision.outline.outline_types.CrackPixels``).
    """
    limits = limits_of(tolerance, YES)
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
        known = crack_pixels.starts[b + 1] - crack_pixels.starts[b]
        cracks = Cracks(places[2], places[3], places[4], places[5], known)
        these = slice(crack_pixels.starts[b], crack_pixels.starts[b + 1])
        fill_cracks(
            crack_pixels.x[these], crack_pixels.y[these], crack_pixels.direction[these], cracks
        )
        place = bring_cracks_along(border, cracks, place)
        finished = FinishedEdges(fitted.kind[count:], fitted.rows[count:], work.at)
        edges, _, one_circle = find_edges(
            border, cracks, budgets[b], pixels[b] >= HELD_AREA, tolerance, limits, prices, work
        )
        if edges > 0:
            edges = _separate(border, cracks, edges, budgets[b], one_circle, work, finished)
        fitted.border_kind[b], edges = put_back(border, edges, tolerance, place, work, finished)
        count += edges
    fitted.edge_starts[borders] = count
    return count


@njit(**LEAF, inline="always")
def _separate(border, cracks, edges, budget, one_circle, work, finished):
    """Write edges that separate the pixels of a border; returns their number.

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
    if one_circle and count == edges and number_set(finished.kind, count) == count:
        return ZERO
    if count > edges or number_set(finished.kind, count):
        count = merge_edges(cracks, finished, count, one_circle, work.trial, work.circle, scratch)
    middles = BorderPoints(cracks.x, cracks.y, cracks.n)
    if outline_strays(middles, finished, count):
        count = all_chords(cracks, finished, found)
    measure_residual(middles, finished, count, NO_BLUR, NO_BLUR)
    return count
