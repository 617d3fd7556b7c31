"""Check that finished edges cover their border; chords replace the others.

Types: ``vision.outline.outline_types``; ``circle`` (3,) is scratch space.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF, SUMS
from planner.scene.primitive_kernels import predecessor, successor
from vision.outline.bilevel.joint_relaxation_kernels import relax_joints
from vision.outline.check.loss_kernels import edge_loss
from vision.outline.corners.crossing_kernels import onto
from vision.outline.fit.edge_shape_kernels import FIT_ROUNDS, HUGE
from vision.outline.fit.outline_kernels import arc_sweep, edge_end, finish_edge
from vision.outline.fitted_borders import LINE
from vision.shared.typed_numbers import ZERO

RAGGED_SHARE = 0.15
"""Area lost per point of a ragged stretch, where its border loses too much: chosen."""
CRISP_RAGGED_SHARE = 0.03
"""The same without grey: indifferent."""


@njit(**LEAF)
def pass_between_pixels(border, outline, edges, limits, review, finished, circle, push):
    """Finish edges between the pixels of a picture without grey; return the area lost, HUGE if one
    strays.

    ``push`` (2 * edges, 6) is scratch space.
    """
    total = HUGE
    for again in range(2):
        total = area_lost(border, outline, edges, limits, review, finished, circle)
        if total == 0.0 or again == 1:
            break
        relax_joints(border, outline, edges, finished, push)
    return total


@njit(**SUMS)
def area_beside_circle(px, py, lo, hi, circle, free):
    """Area that a circle would lose of points lo .. hi - 1, as ``area_lost`` of edges."""
    xs, ys = px[lo:hi], py[lo:hi]
    cx, cy, r = circle[0], circle[1], circle[2]
    lost = 0.0
    for k in range(hi - lo):
        x = xs[k] - cx
        y = ys[k] - cy
        lost += max(abs(math.sqrt(x * x + y * y) - r) - free, 0.0)
    return lost


@njit(**LEAF)
def area_lost(border, outline, edges, limits, review, finished, circle):
    """Finish the edges; return the area that they lose, HUGE if one strays too far."""
    for e in range(edges):
        review.ragged[e] = False
        review.stale[e] = True
    _finish_stale(border, outline, edges, review, finished, circle)
    bad, total = _find_losses(border, outline, edges, limits, review, finished)
    return HUGE if bad else total


@njit(**LEAF)
def _find_losses(border, outline, edges, limits, review, finished):
    ragged = review.ragged
    losses = review.losses
    stale = review.stale
    kinds = finished.kind
    strayed = False
    total = 0.0
    for e in range(edges):
        if ragged[e]:
            losses[e] = 0.0
            continue
        after = successor(e, edges)
        before = predecessor(e, edges)
        if stale[before] or stale[e] or stale[after]:
            lo = outline.breaks[e]
            hi = edge_end(outline.breaks, edges, border.n, e)
            farthest, losses[e] = edge_loss(border, lo, hi, finished, e, edges, limits)
            bad = farthest > limits.allowed
            if kinds[e] != LINE:
                longest = 2.0 * (hi - lo) + 4.0
                _, sweep = arc_sweep(kinds, finished.rows, e, after)
                bad = bad or abs(sweep) * finished.rows[e, 4] > longest
            if bad:
                ragged[e] = True
                strayed = True
        total += losses[e]
    return strayed, total


@njit(**LEAF, forceinline=False)
def check_edges(border, outline, edges, limits, budget, review, finished, circle):
    """Finish the edges, and mark as ragged those that do not cover the border well enough.

    A ragged edge ends at border points, which moves its neighbours' ends: the check repeats until
    nothing changes. ``budget``: the area that may be lost.
    """
    ragged = review.ragged
    losses = review.losses
    stale = review.stale
    for e in range(edges):
        ragged[e] = False
        stale[e] = True
        losses[e] = 0.0
    for _ in range(FIT_ROUNDS):
        _finish_stale(border, outline, edges, review, finished, circle)
        changed, total = _find_losses(border, outline, edges, limits, review, finished)
        while total > budget:
            worst = ZERO
            densest = 0.0
            for e in range(edges):
                length = edge_end(outline.breaks, edges, border.n, e) - outline.breaks[e]
                density = losses[e] / max(length, 4)
                if density > densest:
                    densest = density
                    worst = e
            if densest < (CRISP_RAGGED_SHARE if limits.crisp else RAGGED_SHARE):
                break
            changed = True
            total -= losses[worst]
            losses[worst] = 0.0
            ragged[worst] = True
        if not changed:
            return
        for e in range(edges):
            stale[e] = False
        for e in range(edges):
            if ragged[e]:
                _end_at_points(border, outline, edges, review, e)
    _finish_stale(border, outline, edges, review, finished, circle)


@njit(**LEAF)
def _end_at_points(border, outline, edges, review, e):
    review.stale[e] = True
    for side in range(2):
        end = e if side == 0 else successor(e, edges)
        x = border.x[outline.breaks[end]]
        y = border.y[outline.breaks[end]]
        other = predecessor(e, edges) if side == 0 else end
        review.stale[other] = True
        if not review.ragged[other]:
            # the neighbour stays on its fit
            fx, fy = onto(outline.shape, other, outline.is_arc[other], x, y)
            if (fx - x) ** 2 + (fy - y) ** 2 < 1.0:
                x = fx
                y = fy
        outline.joints[end, 0] = x
        outline.joints[end, 1] = y


@njit(**LEAF)
def _finish_stale(border, outline, edges, review, finished, circle):
    for e in range(edges):
        if review.stale[e]:
            finished.kind[e] = finish_edge(border, outline, edges, e, finished.rows, circle)
