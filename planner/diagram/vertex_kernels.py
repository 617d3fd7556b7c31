"""The diagram's vertices on the borders themselves: valid edges, and the places where they meet.

Rules and units
- A triangle's vertex is equally far from its three sites' pieces. Its ``mask`` holds bit k if the
  Voronoi edge opposite its site k is valid.
- A vertex with two valid edges between the same two pieces is a passage, and is not solved. All
  others with a valid edge are.
- If a border lies inside a vertex's circle, the sampling got the topology wrong and is refined at
  the feet around that circle.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.delaunay.predicate_kernels import SCRATCH
from planner.delaunay.triangle_kernels import DEAD, next_side, previous_side
from planner.diagram.agvd_kernels import is_end, is_valid
from planner.diagram.bisector_kernels import meet_three, slide_between, turn_at
from planner.diagram.mesh_kernels import FREE, find_changed, mark_sides, nearest_piece
from planner.scene.compile_options import LEAF, OWNING
from planner.scene.primitive_kernels import ARC, NONE, POINT, distance, foot

TURN_TRIES = 4
"""Pieces tried opposite a turning point: the sampled one, then whichever is nearer."""
MANY = 8
"""One changed triangle in this many, beyond which all are searched for vertices."""
WAITING, DONE = 0x80, 3
"""In a mask while edges are marked: the triangle waits; its edges seen from across, shifted."""
SAMPLE_NEAR, PROVED_NEAR = 4.0, 16.0
"""Largest distance of a vertex from its sample, in half spacings; and of a turning point with an
empty circle, which samples show late where a border leaves its tangent slowly."""
EVERY_EDGE = np.bool_(False)
"""Edges within one object may be valid, too."""
UNUSED, EXACT, KEPT, INTRUDED = 0, 1, 2, 3
"""State of a vertex: unknown; equidistant to its pieces with an empty circle; left as sampled by
near-parallel pieces; with a border inside its circle."""


@njit(**LEAF)
def _mark_valid(tri, label, triangles, changed, pieces, tolerance, between):
    """Set bit k in the ``mask`` of free triangles if the edge opposite site k is valid.

    With ``between``, only edges between two objects are valid. Only the ``changed`` triangles'
    edges are examined.
    """
    side, mask, owner = triangles.side, triangles.mask, pieces.owner
    for i in changed:
        mask[i] = WAITING
    for i in changed:
        done = mask[i] >> DONE
        mask[i] &= 7
        if side[i] != FREE or np.int64(tri[8 * i]) == DEAD:
            if np.int64(tri[8 * i]) != DEAD:
                for j in range(3):
                    o = np.int64(tri[8 * i + j + 4])
                    mask[o >> 3] &= ~np.uint8(1 << (o & 3))
            continue
        for j in range(3):
            if done >> j & 1:
                continue
            o = np.int64(tri[8 * i + j + 4])
            n, bit = o >> 3, np.uint8(1 << (o & 3))
            if mask[n] & WAITING:
                mask[n] |= bit << DONE
            valid = False
            if side[n] == FREE:
                a = np.int64(label[np.int64(tri[8 * i + next_side(j)])])
                b = np.int64(label[np.int64(tri[8 * i + previous_side(j)])])
                if between:
                    valid = owner[a] != owner[b]
                else:
                    valid = a != b and is_valid(pieces, a, b, tolerance)
            if valid:
                mask[i] |= np.uint8(1 << j)
                mask[n] |= bit
            else:
                mask[n] &= ~bit


@njit(**LEAF)
def _is_corner(kind, data, a, b, x, y, relevant, tolerance):
    """True if two pieces are equally far from (x, y) because both feet are one corner.

    Within ``tolerance`` of such a place a foot moves by the root of that.
    """
    ax, ay = foot(kind, data, a, x, y)
    bx, by = foot(kind, data, b, x, y)
    square = (ax - x) ** 2 + (ay - y) ** 2
    apart = (bx - ax) ** 2 + (by - ay) ** 2
    return square >= relevant * relevant and apart <= 16.0 * tolerance * math.sqrt(square)


@njit(**LEAF, forceinline=True)
def _meeting(pieces, a, b, c, x, y, tolerances):
    kind, data, half, tolerance = pieces.kind, pieces.data, tolerances.half, tolerances.equal
    reach = 4.0 * half + distance(kind, data, a, x, y)
    qx, qy, found = meet_three(kind, data, a, b, c, x, y, reach, tolerance)
    found = found and not (
        _is_corner(kind, data, a, b, qx, qy, half, tolerance)
        or _is_corner(kind, data, b, c, qx, qy, half, tolerance)
        or _is_corner(kind, data, c, a, qx, qy, half, tolerance)
    )
    return qx, qy, found


@njit(**LEAF, forceinline=True)
def _turning(mesh, pieces, t, a, b, c, x, y, tolerances):
    """Turning point of a piece and its own corner, ``a`` and ``b``, opposite ``c``.

    Returns x, y, found, and True if its circle is known to be empty.
    """
    kind, data, half, tolerance = pieces.kind, pieces.data, tolerances.half, tolerances.equal
    # a point of one object may lie on another's piece: they touch
    corner, side = (a, b) if is_end(pieces, a, b, tolerance) else (b, a)
    if kind[side] == POINT:
        return x, y, False, False
    qx, qy, found = turn_at(kind, data, corner, side, c, x, y, tolerance)
    empty = False
    for _ in range(TURN_TRIES):
        if not found:
            break
        s = math.sqrt((qx - data[corner, 0]) ** 2 + (qy - data[corner, 1]) ** 2)
        _, i = nearest_piece(mesh, pieces, t, qx, qy, s - 4.0 * tolerance, half, side, c, NONE)
        empty = i < 0
        if empty:
            break
        if is_end(pieces, corner, i, tolerance):
            # the corner's other side is nearer along this normal
            found = False
            break
        c = i
        qx, qy, found = turn_at(kind, data, corner, side, i, qx, qy, tolerance)
    return qx, qy, found, empty


@njit(**LEAF, forceinline=True)
def _middle_of_arc(pieces, a, b, c, x, y):
    """Label, of three, of an arc with centre (x, y), or -1."""
    kind, data = pieces.kind, pieces.data
    k = len(kind) - len(pieces.before)
    for i in (a, b, c):
        if i < k and kind[i] == ARC:
            gone = (x - data[i, 0]) ** 2 + (y - data[i, 1]) ** 2
            if gone < (1e-3 * data[i, 2]) ** 2:
                return i
    return NONE


@njit(**LEAF, forceinline=True)
def _slid(pieces, a, b, x, y, tolerance):
    """(x, y) on the bisector of two pieces, and its state."""
    qx, qy, found = slide_between(pieces.kind, pieces.data, a, b, x, y, tolerance)
    return qx, qy, EXACT if found else KEPT, False


@njit(**LEAF)
def solve_one(mesh, pieces, t, a, b, c, x, y, tolerances):
    """Exact place of the sampled vertex (x, y) of labels a, b, c.

    Returns x, y, state, and True if its circle is known to be empty.
    """
    tolerance = tolerances.equal
    if a in (b, c) or b == c:
        if a == b:
            b = c
        if a == b:
            return x, y, KEPT, False
        return _slid(pieces, a, b, x, y, tolerance)
    ab = is_valid(pieces, a, b, tolerance)
    bc = is_valid(pieces, b, c, tolerance)
    ca = is_valid(pieces, c, a, tolerance)
    if ab and bc and ca:
        qx, qy, found = _meeting(pieces, a, b, c, x, y, tolerances)
        if found:
            return qx, qy, EXACT, False
    elif ab + bc + ca == 2:
        if not bc:
            a, b, c = b, c, a
        elif not ca:
            a, b, c = c, a, b
        qx, qy, found, empty = _turning(mesh, pieces, t, a, b, c, x, y, tolerances)
        if found:
            return qx, qy, EXACT, empty
    elif ab + bc + ca == 1:
        i = _middle_of_arc(pieces, a, b, c, x, y)
        if i >= 0:
            return pieces.data[i, 0], pieces.data[i, 1], EXACT, False
        if bc:
            a, b = b, c
        elif ca:
            a, b = c, a
        return _slid(pieces, a, b, x, y, tolerance)
    return x, y, KEPT, False


@njit(**LEAF)
def _choose(tri, label, changed, mask, state, wanted, todo):
    """Choose the vertices to solve among the changed triangles and their neighbours, in order.

    Writes them into ``todo`` (t,) and returns their number. ``wanted`` (t,) bool is False at first.
    """
    n = len(mask)
    some = MANY * len(changed) < n
    for m in range(len(changed) if some else 0):
        i = np.int64(changed[m])
        wanted[i] = True
        for k in range(0 if np.int64(tri[8 * i]) == DEAD else 3):
            wanted[np.int64(tri[8 * i + 4 + k]) >> 3] = True
    count = 0
    for p in range(n):
        if (some and not wanted[p]) or mask[p] == 0 or state[p] != UNUSED:
            continue
        a, b = label[np.int64(tri[8 * p])], label[np.int64(tri[8 * p + 1])]
        c, bits = label[np.int64(tri[8 * p + 2])], mask[p]
        # two valid edges of two labels only pass from one to the next
        if not ((bits == 3 or bits == 5 or bits == 6) and (a == b or b == c or c == a)):
            todo[count] = p
            count += 1
    return count


@njit(**LEAF)
def _solve(mesh, pieces, triangles, todo, doubt, tolerances, bad):
    """Solve the vertices ``todo``; return the number of rows set in ``bad`` (v, 2).

    Those are vertices with non-empty circles, and the label missing there, see
    :func:`solve_vertices`.
    """
    tri, label, kind, data = mesh.tri, mesh.label, pieces.kind, pieces.data
    at, xy, rho, state = triangles.at, triangles.place, triangles.rho, triangles.state
    half, relevant, tolerance = tolerances
    count = 0
    for i in todo:
        t = 8 * np.int64(i)
        a, b = np.int64(label[np.int64(tri[t])]), np.int64(label[np.int64(tri[t + 1])])
        c = np.int64(label[np.int64(tri[t + 2])])
        px, py = at[i, 0], at[i, 1]
        x, y, got, empty = solve_one(mesh, pieces, t, a, b, c, px, py, tolerances)
        far = (PROVED_NEAR if empty else SAMPLE_NEAR) * half
        if (x - px) ** 2 + (y - py) ** 2 > far * far:
            x, y, got, empty = px, py, KEPT, False
        r = min(distance(kind, data, a, x, y), distance(kind, data, b, x, y))
        r = min(r, distance(kind, data, c, x, y))
        near, which = r, NONE
        if not empty:
            near, which = nearest_piece(mesh, pieces, t, x, y, r - 4.0 * tolerance, half, a, b, c)
        if which >= 0:
            r = near
            got = INTRUDED
            overshot = (a in (b, c) or b == c) and not (
                is_valid(pieces, which, a, tolerance)
                and is_valid(pieces, which, b, tolerance)
                and is_valid(pieces, which, c, tolerance)
            )
            if r >= relevant and not overshot:
                bad[count, 0], bad[count, 1] = i, which
                count += 1
        elif got == KEPT and r >= relevant:
            # the pieces do not meet here: a nearer piece has too few sites
            far = max(distance(kind, data, a, x, y), distance(kind, data, b, x, y))
            far = max(far, distance(kind, data, c, x, y))
            if doubt:
                _, which = nearest_piece(mesh, pieces, t, x, y, far, half, a, b, c)
            if which < 0 and far - r > 4.0 * tolerance:
                # or the nearest of them has: a circle reached through it
                which = a
                if distance(kind, data, b, x, y) == r:
                    which = b
                elif distance(kind, data, c, x, y) == r:
                    which = c
            if which >= 0:
                bad[count, 0], bad[count, 1] = i, which
                count += 1
        xy[i, 0], xy[i, 1], rho[i], state[i] = x, y, r, got
    return count


@njit(**OWNING, error_model="numpy")
def mark_changed(mesh, circ, pieces, triangles, closed, box, half, same_place, between):
    """Update centres, sides and valid edges of the changed triangles, and return these.

    ``circ`` are their circles, ``closed`` and ``box`` define the free space, ``half`` is half a
    spacing, and ends within ``same_place`` of a piece lie on it. ``between`` as in ``_mark_valid``.
    """
    n = len(triangles.mask)
    changed, queue = np.empty(n, np.int32), np.empty(n, np.int32)
    changed = changed[: find_changed(mesh, circ, triangles, changed, np.empty(SCRATCH))]
    mark_sides(mesh, triangles, changed, pieces, closed, box, half, queue)
    _mark_valid(mesh.tri, mesh.label, triangles, changed, pieces, same_place, between)
    return changed


@njit(**OWNING, error_model="numpy")
def solve_vertices(mesh, circ, pieces, triangles, closed, box, doubt, tolerances, same_place):
    """Find the exact places of vertices of valid edges, except passages.

    Updates the changed triangles (:func:`mark_changed`), then writes ``place``, ``rho`` (the exact
    clearance) and ``state`` of every UNUSED vertex among them and their neighbours. Returns the
    sites missing around non-empty circles of relevant clearance: places (e, 2), labels (e,) and a
    triangle near each (e,); also where pieces did not meet because one is nearer than its sites or,
    with ``doubt``, another is.
    """
    tri, label = mesh.tri, mesh.label
    at, xy, rho = triangles.at, triangles.place, triangles.rho
    k = len(pieces.kind) - len(pieces.before)
    n = len(triangles.mask)
    changed = mark_changed(
        mesh, circ, pieces, triangles, closed, box, tolerances.half, same_place, EVERY_EDGE
    )
    todo, wanted = np.empty(n, np.int32), np.zeros(n, np.bool_)
    todo = todo[: _choose(tri, label, changed, triangles.mask, triangles.state, wanted, todo)]
    bad = np.empty((len(todo), 2), np.int32)
    count = _solve(mesh, pieces, triangles, todo, doubt, tolerances, bad)
    extra = np.empty((4 * count, 2))
    extra_label = np.empty(4 * count, np.int32)
    where = np.empty(4 * count, np.int64)
    n = 0
    for j in range(count):
        i = np.int64(bad[j, 0])
        for m in range(4):
            lab = np.int64(bad[j, 1] if m == 3 else label[np.int64(tri[8 * i + m])])
            if lab >= k:
                continue
            fx, fy = foot(pieces.kind, pieces.data, lab, xy[i, 0], xy[i, 1])
            extra[n, 0], extra[n, 1], extra_label[n], where[n] = fx, fy, lab, 8 * i
            n += 1
        xy[i, 0], xy[i, 1] = at[i, 0], at[i, 1]
        rho[i], _ = nearest_piece(
            mesh, pieces, 8 * i, at[i, 0], at[i, 1], np.inf, tolerances.half, NONE, NONE, NONE
        )
    return extra[:n], extra_label[:n], where[:n]
