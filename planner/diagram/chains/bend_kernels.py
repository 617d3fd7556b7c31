"""Bending of a chain's run onto its bisector, by halving until its links are short and straight.

Rules and units
- A run leads from one station of a chain to the next along the bisector of one pair of pieces, see
  :mod:`planner.diagram.chains.chain_kernels`.
- Places are inserted where the straight line bulges or is too long, slid onto the bisector from the
  run's sampled vertices, and proved by empty circles. A place that does not slide, as at a
  hairpin's turn, stays as sampled, unproved, if the run is wide on both sides of it: a chord is not
  as narrow as the turn.
- Left and right are as in :mod:`planner.diagram.bisector_kernels`.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from planner.diagram.bisector_kernels import heading, narrowest, slide_between
from planner.diagram.mesh_kernels import nearest_piece
from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import NONE, POINT, SEGMENT, distance, foot, point_to_segment

LINK_BULGE = 0.1
"""Largest distance of a link from its bisector, in half spacings."""
LONG = 1.0
"""Longest link in parts of the clearance at its start, if that exceeds a spacing."""
RUN_HALVINGS = 30
"""Most halvings of a run."""
HALF_AT_MOST = 0.75
"""Largest half of a line, as its part: anything farther is on another branch."""


class ChainPoints(NamedTuple):
    """The chains' points, as in :class:`planner.diagram.diagram_arrays.Bent`, with flags.

    ``sure`` (p,): the point's circle is empty; ``ahead`` (p,): the link to the next point follows
    the bisector. The capacity is p points.
    """

    points: NDArray[np.float64]
    pieces: NDArray[np.int32]
    proved: NDArray[np.bool_]
    start: NDArray[np.int32]
    sure: NDArray[np.bool_]
    ahead: NDArray[np.bool_]


class MissingSites(NamedTuple):
    """Sites that are missing around non-empty circles.

    ``place`` (m, 2), the piece ``label`` (m,) of each, and a triangle ``where`` (m,) near it.
    """

    place: NDArray[np.float64]
    label: NDArray[np.int32]
    where: NDArray[np.int64]


class ChainStations(NamedTuple):
    """Stations of a chain.

    ``place`` (s, 4): x, y, clearance and state; ``bits``: the same as integers; ``sides`` (s, 2):
    the pieces left and right of the following run; ``run`` (s, 2): its first link and the one
    behind its last.
    """

    place: NDArray[np.float64]
    bits: NDArray[np.int64]
    sides: NDArray[np.int32]
    run: NDArray[np.int64]


class Stack(NamedTuple):
    """Places ahead in a run, the nearest last.

    ``place`` (d, 2), the sampled ``link`` (d,) there, ``bare``: no sampled vertices lead there,
    ``rough``: it stayed as sampled.
    """

    place: NDArray[np.float64]
    link: NDArray[np.int64]
    bare: NDArray[np.bool_]
    rough: NDArray[np.bool_]


class BendArrays(NamedTuple):
    """Arrays that chains are bent into, and the working space for it."""

    out: ChainPoints
    missing: MissingSites
    stations: ChainStations
    stack: Stack


class RunPieces(NamedTuple):
    """The pieces beside a run; straight if their bisector is a line."""

    left: np.int64
    right: np.int64
    is_straight: bool


class BendLink(NamedTuple):
    """Straight line from place a to place b of a run, u the bisector's direction at a.

    ``first`` and ``last`` are the sampled links at a and b, ``span`` is the line's length. Flags
    mark long lines, and lines that are wide at both ends.
    """

    ax: float
    ay: float
    ux: float
    uy: float
    bx: float
    by: float
    first: int
    last: int
    span: float
    is_long: bool
    is_wide: bool


@njit(**LEAF)
def _is_between(kind, data, left, right, a, m, b, half, tolerance):
    """True if m lies ahead of a, in direction u, and before b, unless this is undecidable.

    ``a`` is x, y and the direction u there, ``m`` and ``b`` are x and y.
    """
    ax, ay, ux, uy = a
    mx, my = m
    bx, by = b
    near = 16.0 * half * half
    # a ring that ends at or near a returns there: distant places are not judged
    span = 9.0 * ((bx - ax) ** 2 + (by - ay) ** 2)
    tx, ty, _ = heading(kind, data, left, right, mx, my)
    dx, dy = mx - ax, my - ay
    square, ahead = dx * dx + dy * dy, dx * ux + dy * uy > tolerance
    # farther away, a place is behind a only if the bisector runs there as at a
    if not ahead and (square <= near or (square < span and tx * ux + ty * uy > 0.0)):
        return False
    dx, dy = bx - mx, by - my
    square, ahead = dx * dx + dy * dy, dx * tx + dy * ty > tolerance
    if ahead or square > max(near, span):
        return True
    vx, vy, _ = heading(kind, data, left, right, bx, by)
    return square > near and tx * vx + ty * vy <= 0.0


@njit(**LEAF)
def _across(kind, data, left, right, x, y):
    """Place and direction of the line along which the two pieces are nearest, as seen there.

    It runs through the centres of two round pieces or points, or through one and square to a
    segment. Between two segments it has no direction.
    """
    if kind[left] == SEGMENT and kind[right] == SEGMENT:
        return x, y, 0.0, 0.0
    if kind[left] == SEGMENT:
        left, right = right, left
    px, py = data[left, 0], data[left, 1]
    if kind[right] == SEGMENT:
        return px, py, data[right, 1] - data[right, 3], data[right, 2] - data[right, 0]
    return px, py, data[right, 0] - px, data[right, 1] - py


@njit(**LEAF)
def _narrowest_between(kind, data, left, right, ax, ay, bx, by, tolerance):
    """Narrowest place of the bisector between a and b, if inside: x, y, found."""
    mx, my = 0.5 * (ax + bx), 0.5 * (ay + by)
    reach = (bx - ax) ** 2 + (by - ay) ** 2
    px, py, ux, uy = _across(kind, data, left, right, mx, my)
    square = ux * ux + uy * uy
    if square > 0.0:
        along = ((mx - px) * ux + (my - py) * uy) / square
        qx, qy = px + along * ux, py + along * uy
        lx, ly = foot(kind, data, left, qx, qy)
        rx, ry = foot(kind, data, right, qx, qy)
        x, y = 0.5 * (lx + rx), 0.5 * (ly + ry)
        if (x - mx) ** 2 + (y - my) ** 2 <= reach:
            gap = distance(kind, data, left, x, y) - distance(kind, data, right, x, y)
            _, _, slope = heading(kind, data, left, right, x, y)
            if abs(gap) <= tolerance and abs(slope) < 1e-9:
                return x, y, True
    x, y, found = narrowest(kind, data, left, right, ax, ay, bx, by, tolerance)
    return x, y, found and (x - mx) ** 2 + (y - my) ** 2 <= reach


@njit(**LEAF)
def _is_on_bisector(kind, data, left, right, x, y, rho, tolerance):
    return (
        abs(distance(kind, data, left, x, y) - rho) <= 4.0 * tolerance
        and abs(distance(kind, data, right, x, y) - rho) <= 4.0 * tolerance
    )


@njit(**LEAF)
def _is_straight(kind, data, left, right, ax, ay, bx, by, tolerance):
    """True if a straight bisector's link has its middle equally near to both pieces."""
    x, y = 0.5 * (ax + bx), 0.5 * (ay + by)
    gap = distance(kind, data, left, x, y) - distance(kind, data, right, x, y)
    return abs(gap) <= 4.0 * tolerance


@njit(**LEAF, forceinline=True)
def _halve(pieces, at, link, tolerances, run, line, stack, top):
    """Choose the place to halve a link, if it has to be halved.

    Tries the sampled vertex in the middle of the run, then the middle of the line. Returns split,
    astray (a chord that cannot be halved), as_sampled, x, y and the sampled link there.
    """
    half, tolerance, bare = tolerances.half, tolerances.equal, stack.bare
    kind, data, left, right = pieces.kind, pieces.data, run.left, run.right
    a, b = (line.ax, line.ay, line.ux, line.uy), (line.bx, line.by)
    ax, ay, bx, by = line.ax, line.ay, line.bx, line.by
    is_sampled = line.last - line.first >= 2
    middle = (line.first + line.last) // 2
    split, astray, as_sampled = False, line.is_long, False
    q, x, y = line.first, ax, ay
    for guess in range(2 if line.is_long or not run.is_straight else 0):
        q = line.first
        x, y = 0.5 * (ax + bx), 0.5 * (ay + by)
        if guess == 0 and is_sampled and not bare[top - 1]:
            q = middle
            x, y = at[link[q] >> 3, 0], at[link[q] >> 3, 1]
        elif guess == 0 or line.span <= half:
            continue
        px, py = x, y
        x, y, split = slide_between(kind, data, left, right, x, y, tolerance)
        if guess == 0 and (x - px) ** 2 + (y - py) ** 2 > 16.0 * half * half:
            # at a hairpin's turn: the place is before or behind it
            split, astray = False, True
            if line.is_wide:
                break
            continue
        slid = split
        if split and not line.is_long:
            bulge, _ = point_to_segment(x, y, ax, ay, bx, by)
            split = bulge > LINK_BULGE * half
        wanted = split
        split = split and _is_between(kind, data, left, right, a, (x, y), b, half, tolerance)
        if guess == 1:
            reach = HALF_AT_MOST * HALF_AT_MOST * line.span * line.span
            split = split and (x - ax) ** 2 + (y - ay) ** 2 <= reach
            split = split and (bx - x) ** 2 + (by - y) ** 2 <= reach
            astray = line.is_long or wanted or not slid
        if split:
            bare[top] = guess == 1
            bare[top - 1] |= guess == 1
            break
    if astray and not split and line.is_wide and is_sampled and not bare[top - 1]:
        # the route around may be narrower than the chord: keep it as sampled
        q = middle
        x, y, split, as_sampled = at[link[q] >> 3, 0], at[link[q] >> 3, 1], True, True
        bare[top] = False
    return split, astray, as_sampled, x, y, q


@njit(**LEAF, forceinline=True)
def _add_place(mesh, pieces, tolerances, arrays, run, near, x, y, is_rough, counts):
    """Write a place of a run and, if its circle is not empty, the missing sites.

    ``near`` is a triangle near it; ``counts``, of points and missing sites, are returned updated,
    the latter -1 if space ran out.
    """
    n, missing = counts
    out, extra = arrays.out, arrays.missing
    kind, data, left, right = pieces.kind, pieces.data, run.left, run.right
    r = distance(kind, data, left, x, y)
    if is_rough:
        r = min(r, distance(kind, data, right, x, y))
    d, which = nearest_piece(
        mesh, pieces, near, x, y, r - 4.0 * tolerances.equal, tolerances.half, left, right, NONE
    )
    if which >= 0 and d >= tolerances.relevant:
        if missing + 3 >= len(extra.place):
            return n, -1
        k = len(kind) - len(pieces.before)
        for side in range(3):
            lab = which if side == 2 else right if side == 1 else left
            if lab < k:
                fx, fy = foot(kind, data, lab, x, y)
                extra.place[missing, 0], extra.place[missing, 1] = fx, fy
                extra.label[missing], extra.where[missing] = lab, near
                missing += 1
    out.points[n, 0], out.points[n, 1], out.points[n, 2] = x, y, d if which >= 0 else r
    out.sure[n] = which < 0 and not is_rough
    out.pieces[n, 0], out.pieces[n, 1] = left, right
    return n + 1, missing


@njit(**LEAF, forceinline=True)
def bend_run(mesh, pieces, triangles, link, end, tolerances, arrays, s, counts):
    """Write the places of the run after station s, without the stations.

    ``end`` is the link behind the chain's last; ``counts`` as in :func:`_add_place`.
    """
    n, missing = counts
    kind, data = pieces.kind, pieces.data
    half, relevant, tolerance = tolerances
    out, stack, place = arrays.out, arrays.stack, arrays.stations.place
    sides = arrays.stations.sides
    left, right = np.int64(sides[s, 0]), np.int64(sides[s, 1])
    straight = kind[left] == kind[right] and (kind[left] == SEGMENT or kind[left] == POINT)
    run = RunPieces(left, right, straight)
    # halve the run where the line bulges or is long
    q_a, begin = arrays.stations.run[s, 0], n - 1
    stack.place[0, 0], stack.place[0, 1] = place[s + 1, 0], place[s + 1, 1]
    stack.link[0], stack.bare[0], stack.rough[0] = arrays.stations.run[s, 1], False, False
    top = np.int64(1)
    ax, ay = place[s, 0], place[s, 1]
    bx, by = ax, ay
    ux, uy, falls = heading(kind, data, left, right, ax, ay)
    while top > 0:
        bx, by, q_b = stack.place[top - 1, 0], stack.place[top - 1, 1], stack.link[top - 1]
        dx, dy = bx - ax, by - ay
        span = math.sqrt(dx * dx + dy * dy)
        wide = out.points[n - 1, 2]
        is_long = span > max(2.0 * half, LONG * wide)
        is_wide = min(wide, distance(kind, data, left, bx, by)) >= relevant
        line = BendLink(ax, ay, ux, uy, bx, by, q_a, q_b, span, is_long, is_wide)
        split, astray, as_sampled, mx, my, q_m = _halve(
            pieces, triangles.at, link, tolerances, run, line, stack, top
        )
        if split and top <= RUN_HALVINGS:
            stack.place[top, 0], stack.place[top, 1], stack.link[top] = mx, my, q_m
            stack.rough[top] = as_sampled
            top += 1
            continue
        top -= 1
        near = link[q_b if q_b < end else q_a] & ~7
        out.pieces[n - 1, 0], out.pieces[n - 1, 1] = left, right
        if n >= len(out.points) - 2:
            return -1, missing
        vx, vy, grows = heading(kind, data, left, right, bx, by)
        whole = not (split or astray)
        if straight and not is_long:
            whole = _is_straight(kind, data, left, right, ax, ay, bx, by, tolerance)
        # a line against the bisector's direction does not follow it
        whole &= dx * ux + dy * uy >= -tolerance and dx * vx + dy * vy >= -tolerance
        out.ahead[n - 1] = whole
        if falls < -1e-9 and grows > 1e-9:
            x, y, found = _narrowest_between(kind, data, left, right, ax, ay, bx, by, tolerance)
            if found:
                n, missing = _add_place(
                    mesh, pieces, tolerances, arrays, run, near, x, y, np.bool_(False), (n, missing)
                )
                if missing < 0:
                    return n, missing
                out.ahead[n - 1] = whole
            else:
                out.ahead[n - 1] = False
        if top > 0:
            n, missing = _add_place(
                mesh, pieces, tolerances, arrays, run, near, bx, by, stack.rough[top], (n, missing)
            )
            if missing < 0:
                return n, missing
            out.ahead[n - 1] = True
        ax, ay, q_a = bx, by, q_b
        ux, uy, falls = vx, vy, grows
    # places between lie on the bisector; the run's ends may not
    out.ahead[begin] &= _is_on_bisector(
        kind, data, left, right, place[s, 0], place[s, 1], place[s, 2], tolerance
    )
    out.ahead[n - 1] &= _is_on_bisector(kind, data, left, right, bx, by, place[s + 1, 2], tolerance)
    return n, missing
