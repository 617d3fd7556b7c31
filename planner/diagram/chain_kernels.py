"""Where the chains run exactly: their points on the bisectors, their widths and lengths.

Rules and units
- Chains are those of :mod:`planner.diagram.trace_kernels`. A chain's stations are its nodes and
  turning points, which are solved; between two stations it follows the bisector of one pair of
  pieces, the run's.
- Places within a run are put in where the straight line would bulge or be too long. They are
  slid onto the bisector from the sampled vertices that the run passes, and each proves itself
  by its own empty circle. Where one does not slide, as at a hairpin's turn, and the run is wide
  on both sides of it, it stays as sampled, unproved: a chord would not be as narrow as the turn.
- Left and right are those of ``cross(along, left - right) > 0`` in the scene's coordinates.
"""

# The arrays' types are in the docstrings; numba infers them.
# mypy: disable-error-code="no-untyped-def,no-untyped-call"

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.borders.box_tree_kernels import segment_clearance
from planner.diagram.bisector_kernels import heading, narrowest, slide_between
from planner.diagram.kept_run_kernels import find_run
from planner.diagram.mesh_kernels import nearest_piece
from planner.diagram.vertex_kernels import EXACT, INTRUDED, KEPT, UNUSED
from planner.scene.compile_options import BORROWING
from planner.scene.primitive_kernels import POINT, SEGMENT, distance, foot, point_to_segment

BULGE = 0.1
"""How far a link may leave its bisector, in half spacings (5 % of the spacing)."""
LONG = 1.0
"""A link's length in parts of the clearance at its start, where that is more than a spacing."""
HALVINGS = 30
"""How often a run is halved at most."""
HALF_AT_MOST = 0.75
"""A half of a line's part of it, at most: what slides elsewhere is another branch's."""


@njit(**BORROWING, error_model="numpy")
def solve_rings(mesh, node, at, kind, data, before, after, half, tolerance, xy, rho, state):
    """Slide the nodes of closed runs onto their bisectors: they were passages until now."""
    tri, label = mesh[1], mesh[2]
    for i in node:
        if state[i] != UNUSED:
            continue
        a, b = label[np.int64(tri[8 * i])], label[np.int64(tri[8 * i + 1])]
        if a == b:
            b = label[np.int64(tri[8 * i + 2])]
        x, y, found = slide_between(kind, data, a, b, at[i, 0], at[i, 1], tolerance)
        if not found or (x - at[i, 0]) ** 2 + (y - at[i, 1]) ** 2 > 16.0 * half * half:
            x, y, found = at[i, 0], at[i, 1], False
        r = min(distance(kind, data, a, x, y), distance(kind, data, b, x, y))
        d, which = nearest_piece(
            mesh, kind, data, before, after, 8 * i, x, y, r - 4.0 * tolerance, half, a, b, -1
        )
        xy[i, 0], xy[i, 1], rho[i] = x, y, r if which < 0 else d
        state[i] = INTRUDED if which >= 0 else (EXACT if found else KEPT)


@njit(**BORROWING, error_model="numpy")
def _order_turns(kind, data, at, link, half, place, pair, run, last):
    """Swap turning points of the two sides that sampling put in the wrong order.

    Where the left border turned from A to its corner P and then the right one from its corner
    Q to B, with P Q between, but the places are the other way round, A B is between. Sampling
    mistakes only what is near: a long run may well end behind where it began.
    """
    near = 16.0 * half * half
    for i in range(1, last - 1):
        m = link[(run[i, 0] + run[i, 1]) // 2] >> 3
        if (at[m, 0] - place[i, 0]) ** 2 + (at[m, 1] - place[i, 1]) ** 2 > near:
            continue
        if (place[i + 1, 0] - place[i, 0]) ** 2 + (place[i + 1, 1] - place[i, 1]) ** 2 > near:
            continue
        left, right = pair[i, 0], pair[i, 1]
        mid_left, mid_right = pair[i - 1, 0], pair[i + 1, 1]
        if left == mid_left:
            mid_left, mid_right = pair[i + 1, 0], pair[i - 1, 1]
        one_each = (pair[i - 1, 0] == left) != (pair[i - 1, 1] == right)
        other = (pair[i + 1, 0] == left) == (pair[i - 1, 1] == right)
        tx, ty, _ = heading(kind, data, left, right, place[i, 0], place[i, 1])
        dx, dy = place[i + 1, 0] - place[i, 0], place[i + 1, 1] - place[i, 1]
        if one_each and other and dx * tx + dy * ty < 0.0:
            for c in range(4):
                place[i, c], place[i + 1, c] = place[i + 1, c], place[i, c]
            pair[i, 0], pair[i, 1] = mid_left, mid_right
            run[i, 1] = run[i, 0]


@njit(**BORROWING, error_model="numpy")
def _is_between(kind, data, left, right, ax, ay, ux, uy, mx, my, bx, by, half, tolerance):
    """Whether m lies ahead of a, where u is ahead, and before b, as far as that can be told."""
    near = 16.0 * half * half
    # a ring that begins and ends at a or near it returns there: what is far is not judged
    span = 9.0 * ((bx - ax) ** 2 + (by - ay) ** 2)
    tx, ty, _ = heading(kind, data, left, right, mx, my)
    dx, dy = mx - ax, my - ay
    square, ahead = dx * dx + dy * dy, dx * ux + dy * uy > tolerance
    # farther away only what runs as a does is behind it
    if not ahead and (square <= near or (square < span and tx * ux + ty * uy > 0.0)):
        return False
    dx, dy = bx - mx, by - my
    square, ahead = dx * dx + dy * dy, dx * tx + dy * ty > tolerance
    if ahead or square > max(near, span):
        return True
    vx, vy, _ = heading(kind, data, left, right, bx, by)
    return square > near and tx * vx + ty * vy <= 0.0


@njit(**BORROWING, error_model="numpy")
def _across(kind, data, left, right, x, y):
    """A place and a direction of the line that the two pieces are nearest along, as seen there.

    Through the centres of two round pieces or points, or through one and square to a segment;
    no direction between two segments, whose bisector is nowhere narrower than at its ends.
    """
    if kind[left] == SEGMENT and kind[right] == SEGMENT:
        return x, y, 0.0, 0.0
    if kind[left] == SEGMENT:
        left, right = right, left
    px, py = data[left, 0], data[left, 1]
    if kind[right] == SEGMENT:
        return px, py, data[right, 1] - data[right, 3], data[right, 2] - data[right, 0]
    return px, py, data[right, 0] - px, data[right, 1] - py


@njit(**BORROWING, error_model="numpy")
def _narrowest_between(kind, data, left, right, ax, ay, bx, by, tolerance):
    """The narrowest place of the bisector between a and b, if inside: x, y, found.

    There the feet lie opposite each other: on the line across both pieces, halfway.
    """
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


@njit(**BORROWING, error_model="numpy")
def _is_on_bisector(kind, data, left, right, x, y, rho, tolerance):
    """Whether a place is as near to both pieces as to anything."""
    return (
        abs(distance(kind, data, left, x, y) - rho) <= 4.0 * tolerance
        and abs(distance(kind, data, right, x, y) - rho) <= 4.0 * tolerance
    )


@njit(**BORROWING, error_model="numpy")
def _is_straight(kind, data, left, right, ax, ay, bx, by, tolerance):
    """Whether the middle of a straight bisector's link is as near to both of its pieces.

    It is not where the link passes the end of one of them.
    """
    x, y = 0.5 * (ax + bx), 0.5 * (ay + by)
    gap = distance(kind, data, left, x, y) - distance(kind, data, right, x, y)
    return abs(gap) <= 4.0 * tolerance


@njit(**BORROWING, error_model="numpy")
def bend(
    mesh, at, first, link, kind, data, before, after, half, relevant, tolerance, xy, rho, state,
    known, results, sure, ahead, stations, todo
):  # fmt: skip
    """The chains' points on their bisectors, with the narrowest place of every run.

    Fills ``results``, as :func:`planner.diagram.bisector_trace.bend_chains` returns them, and
    ``sure`` (p,) and ``ahead`` (p,): a link is proved where both of its points are, and where it
    follows the bisector between them. ``stations`` are place (m, 4), its bits, sides (m, 2) and run
    (m, 2), ``todo`` the stack of places ahead. Returns how many points and missing sites there are,
    -1 for those that found no room.
    """
    tri, label = mesh[1], mesh[2]
    k = len(kind) - len(before)
    chains = len(first) - 1
    out, pair, proved, start, extra, extra_label, where = results
    place, bits, sides, run = stations
    stack, stack_q, bare, rough = todo
    most = len(out) - 2
    missing = 0
    n = 0
    for c in range(chains):
        # the stations, and the run of links after each
        lo, hi = first[c], first[c + 1]
        m = 0
        for q in range(lo, hi + 1):
            h = link[q] if q < hi else np.int64(tri[link[hi - 1] + 4])
            i = h >> 3
            if lo < q < hi:
                s0, s1 = label[np.int64(tri[8 * i])], label[np.int64(tri[8 * i + 1])]
                s2 = label[np.int64(tri[8 * i + 2])]
                if s0 == s1 or s1 == s2 or s2 == s0:
                    run[m - 1, 1] = q + 1
                    continue
            place[m, 0], place[m, 1] = xy[i, 0], xy[i, 1]
            place[m, 2], place[m, 3] = rho[i], state[i]
            if q < hi:
                j = h - 8 * i
                sides[m, 0] = label[np.int64(tri[8 * i + ((18 >> (2 * j)) & 3)])]
                sides[m, 1] = label[np.int64(tri[8 * i + ((9 >> (2 * j)) & 3)])]
                run[m, 0], run[m, 1] = q, q + 1
            m += 1
        last = m - 1
        _order_turns(kind, data, at, link, half, place, sides, run, last)
        for s in range(last + 1):
            if n >= most:
                return -1, missing
            out[n, 0], out[n, 1], out[n, 2] = place[s, 0], place[s, 1], place[s, 2]
            sure[n], ahead[n] = place[s, 3] == EXACT, True
            pair[n, 0], pair[n, 1] = -1, -1
            n += 1
            if s == last:
                break
            left, right = sides[s, 0], sides[s, 1]
            p, way = find_run(known, place, bits, s, left, right)
            if way != 0:
                while True:
                    pair[n - 1, 0], pair[n - 1, 1] = left, right
                    p += way
                    x, y = known[0][p, 0], known[0][p, 1]
                    if x == place[s + 1, 0] and y == place[s + 1, 1]:
                        break
                    if n >= most:
                        return -1, missing
                    out[n, 0], out[n, 1], out[n, 2] = x, y, known[0][p, 2]
                    sure[n], ahead[n] = True, True
                    n += 1
                continue
            straight = kind[left] == kind[right] and (kind[left] == SEGMENT or kind[left] == POINT)
            # halve the run where the line bulges or is long
            q_a, begin = run[s, 0], n - 1
            stack[0, 0], stack[0, 1] = place[s + 1, 0], place[s + 1, 1]
            stack_q[0], bare[0], rough[0] = run[s, 1], False, False
            top = 1
            ax, ay = place[s, 0], place[s, 1]
            ux, uy, falls = heading(kind, data, left, right, ax, ay)
            while top > 0:
                bx, by, q_b = stack[top - 1, 0], stack[top - 1, 1], stack_q[top - 1]
                dx, dy = bx - ax, by - ay
                span = math.sqrt(dx * dx + dy * dy)
                is_long = span > max(2.0 * half, LONG * out[n - 1, 2])
                # what ought to be halved and cannot be is a chord, not the bisector
                split, astray, as_sampled = False, is_long, False
                is_wide = min(out[n - 1, 2], distance(kind, data, left, bx, by)) >= relevant
                # from the sampled vertex in the middle of the run, then from that of the line
                for guess in range(2 if is_long or not straight else 0):
                    q_m = q_a
                    mx, my = 0.5 * (ax + bx), 0.5 * (ay + by)
                    if guess == 0 and q_b - q_a >= 2 and not bare[top - 1]:
                        q_m = (q_a + q_b) // 2
                        i = link[q_m] >> 3
                        mx, my = at[i, 0], at[i, 1]
                    elif guess == 0 or span <= half:
                        continue
                    px, py = mx, my
                    mx, my, split = slide_between(kind, data, left, right, mx, my, tolerance)
                    if guess == 0 and (mx - px) ** 2 + (my - py) ** 2 > 16.0 * half * half:
                        # at a hairpin's turn: what it slid to is before or behind it
                        split, astray = False, True
                        if is_wide:
                            break
                        continue
                    slid = split
                    if split and not is_long:
                        bulge, _ = point_to_segment(mx, my, ax, ay, bx, by)
                        split = bulge > BULGE * half
                    wanted = split
                    split = split and _is_between(
                        kind, data, left, right, ax, ay, ux, uy, mx, my, bx, by, half, tolerance
                    )
                    if guess == 1:
                        reach = HALF_AT_MOST * HALF_AT_MOST * span * span
                        split = split and (mx - ax) ** 2 + (my - ay) ** 2 <= reach
                        split = split and (bx - mx) ** 2 + (by - my) ** 2 <= reach
                        astray = is_long or wanted or not slid
                    if split:
                        # sampled vertices are in order among themselves only
                        bare[top] = guess == 1
                        bare[top - 1] |= guess == 1
                        break
                if astray and not split and is_wide and q_b - q_a >= 2 and not bare[top - 1]:
                    # the way round may be narrow where the chord is not: it goes as sampled
                    q_m = (q_a + q_b) // 2
                    i = link[q_m] >> 3
                    mx, my, split, as_sampled = at[i, 0], at[i, 1], True, True
                    bare[top] = False
                if split and top <= HALVINGS:
                    stack[top, 0], stack[top, 1], stack_q[top] = mx, my, q_m
                    rough[top] = as_sampled
                    top += 1
                    continue
                # the link from a to b is short and straight enough
                top -= 1
                near = link[q_b if q_b < hi else q_a] & ~7
                pair[n - 1, 0], pair[n - 1, 1] = left, right
                if n >= most:
                    return -1, missing
                vx, vy, grows = heading(kind, data, left, right, bx, by)
                whole = not (split or astray)
                if straight and not is_long:
                    whole = _is_straight(kind, data, left, right, ax, ay, bx, by, tolerance)
                # nor is a line that leaves or arrives against the bisector's way
                whole &= dx * ux + dy * uy >= -tolerance and dx * vx + dy * vy >= -tolerance
                ahead[n - 1] = whole
                for turn in range(2):
                    x, y = bx, by
                    if turn == 0:
                        if falls >= -1e-9 or grows <= 1e-9:
                            continue
                        x, y, found = _narrowest_between(
                            kind, data, left, right, ax, ay, bx, by, tolerance
                        )
                        if not found:
                            ahead[n - 1] = False
                            continue
                    elif top == 0:
                        break
                    r = distance(kind, data, left, x, y)
                    loose = turn == 1 and rough[top]
                    if loose:
                        r = min(r, distance(kind, data, right, x, y))
                    d, which = nearest_piece(
                        mesh, kind, data, before, after, near, x, y, r - 4.0 * tolerance, half,
                        left, right, -1,
                    )  # fmt: skip
                    if which >= 0 and d >= relevant:
                        if missing + 3 >= len(extra):
                            return n, -1
                        for side in range(3):
                            lab = which if side == 2 else np.int64(sides[s, side])
                            if lab < k:
                                fx, fy = foot(kind, data, lab, x, y)
                                extra[missing, 0], extra[missing, 1] = fx, fy
                                extra_label[missing], where[missing] = lab, near
                                missing += 1
                    out[n, 0], out[n, 1], out[n, 2] = x, y, d if which >= 0 else r
                    sure[n], ahead[n] = which < 0 and not loose, whole or turn == 1
                    pair[n, 0], pair[n, 1] = left, right
                    n += 1
                ax, ay, q_a = bx, by, q_b
                ux, uy, falls = vx, vy, grows
            # the places between were slid onto the bisector; the run's ends may be off it
            ahead[begin] &= _is_on_bisector(
                kind, data, left, right, place[s, 0], place[s, 1], place[s, 2], tolerance
            )
            ahead[n - 1] &= _is_on_bisector(
                kind, data, left, right, bx, by, place[s + 1, 2], tolerance
            )
        for i in range(start[c], n - 1):
            proved[i] = ahead[i] and sure[i] and sure[i + 1]
        proved[n - 1] = False
        start[c + 1] = n
    return n, missing


@njit(**BORROWING, error_model="numpy")
def most_links(first):
    """How many links the longest of the chains has, at least 1; ``first`` (c + 1,) offsets."""
    most = 1
    for c in range(len(first) - 1):
        most = max(most, first[c + 1] - first[c])
    return most


@njit(cache=True, nogil=True, error_model="numpy")
def measure_chains(kind, data, order, large, boxes, points, proved, first):
    """Lengths and clearances of chains whose narrowest places are points of theirs.

    A proved link is as wide as its narrower end; any other is measured as a straight line
    against the borders. Returns the ``points`` (p, 3) as places (p, 2) and clearances (p,),
    ``gap``, ``step`` per point, and ``length``, ``clearance`` per chain.
    """
    p, c = len(points), len(first) - 1
    xy, rho = np.empty((p, 2)), np.empty(p)
    for i in range(p):
        xy[i, 0], xy[i, 1], rho[i] = points[i, 0], points[i, 1], points[i, 2]
    gap = np.full(p, np.inf)
    step = np.zeros(p)
    length = np.zeros(c)
    clearance = np.full(c, np.inf)
    for j in range(c):
        clearance[j] = points[first[j], 2]
        for i in range(first[j], first[j + 1] - 1):
            ax, ay, bx, by = points[i, 0], points[i, 1], points[i + 1, 0], points[i + 1, 1]
            step[i] = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
            gap[i] = min(points[i, 2], points[i + 1, 2])
            if not proved[i]:
                gap[i], _, _ = segment_clearance(
                    kind, data, order, large, boxes, ax, ay, bx, by, gap[i]
                )
            length[j] += step[i]
            clearance[j] = min(clearance[j], gap[i])
    return xy, rho, gap, step, length, clearance


@njit(cache=True, nogil=True, error_model="numpy")
def clearance_of_nodes(nodes, ends, first, rho):
    """The clearance (n,) of every node: that of the chains' points that are there."""
    out = np.empty(nodes)
    for side in range(2):
        for c in range(len(ends)):
            out[ends[c, side]] = rho[first[c] if side == 0 else first[c + 1] - 1]
    return out
