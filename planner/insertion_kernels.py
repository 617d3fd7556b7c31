"""The Voronoi diagram by incremental insertion: Sugihara and Iri's method on flat arrays.

The method. Sites go in one at a time; a new site removes the Voronoi vertices whose empty circle
it enters and takes their place with a cell of its own. Topology comes first (Sugihara and Iri
1992): the removed vertices must form a non-empty tree, and each touched cell must meet that tree
in one connected piece. `insert` enforces this with one rule, see there; whatever the numbers
say, the result is a sphere's triangulation. Numbers only choose among the legal moves, and they
choose rightly: every doubtful sign is computed exactly.

The order. Sites are sorted along a Hilbert curve, crowded cells again within themselves (the
quaternary tree with buckets of Ohya, Iri and Murota 1984), and inserted coarse to fine: every
64th, every 16th, every 4th, all. Each site starts its search where the last one ended.

The arrays. A Voronoi vertex is a triangle of three sites, counter-clockwise in x right, y up;
`ghost`, the site at infinity, closes the sphere. Triangle t owns tri[8t : 8t + 8]: three sites,
a spare, three links, a spare. Link k and half-edge 8t + k lie opposite site k and run from site
k + 1 to site k + 2; a link holds the half-edge on the other side. circ[4t : 4t + 4] is the
vertex: x, y, and the squared radii below which a site is surely inside and above which it is
surely outside. Whatever falls between, or is NaN, as all ghosts are, is decided exactly.
Site i owns the triangles 2i and 2i + 1; sites are numbered along the curve, so neighbours in
the plane are neighbours in memory.

Exact arithmetic. Coordinates are scaled by a power of two to at most 1 and rounded to multiples
of 2^-268, so that no product of four differences underflows. Plain determinants decide where
their error bound allows; differences that fit a lattice are multiplied as integers, others as
expansions (Shewchuk 1997, "Adaptive precision floating-point arithmetic and fast robust
geometric predicates").
"""

# The arrays' types are in the docstrings; numba infers them.
# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

import math

import numpy as np
from numba import njit

COARSENING = 4
"""Of a round's sites, one in so many went in before."""
CROWD = 12
"""A cell of the curve with more sites than this is sorted within itself."""
DEAD = 0xFFFFFFFF
"""The first site of a triangle that does not exist."""
LATTICE_LIMIT = 29_600
"""12 M^4 < 2^63: in-circle of differences up to M fits a 64-bit integer."""
TINY = 2.0**-215
"""Scaled coordinates below this are rounded to multiples of 2^-268 (see above)."""
UNIT = 2.0**-53
"""Half an ulp of 1: the relative error of one rounded operation."""
CIRCLE_SLACK = 32.0 * UNIT
"""Twice the first-order error bound of a circle's centre, see `insert`."""
ORIENT_SLACK = (3.0 + 16.0 * UNIT) * UNIT
IN_CIRCLE_SLACK = (10.0 + 96.0 * UNIT) * UNIT
"""Error bounds of the plain determinants (Shewchuk 1997, ccwerrboundA and iccerrboundA)."""
UNDERFLOW = 1e-280
"""Determinants smaller than this may have lost digits to underflow."""
WHOLE_LIMIT = 2.0**57
"""Differences are scaled below this, so that two parts add up to at most 58 bits."""
NOT_WHOLE = -(1 << 62)
"""A difference that has more bits than that."""
LIMB = (1 << 29) - 1
"""A limb's 29 bits."""
SPLITTER = 134_217_729.0
"""2^27 + 1: splits a float64 into two halves (Dekker 1971)."""
VERTEX_TOLERANCE = 1e-11
"""A vertex with a larger error bound, in parts of the scene or its circle, is computed again."""
SCRATCH = 5247
"""Room for the expansions of `_in_circle_exact`, the longest of 1,536 terms."""


# An expansion is an array whose first number counts the terms that follow, least first; their
# sum is its exact value. The working space comes as an array too: nothing here allocates.


@njit(cache=True, nogil=True, error_model="numpy")
def _difference(a, b, out):
    """out = a - b, exactly (2 terms at most)."""
    s = a - b
    v = a - s
    tail = (a - (s + v)) + (v - b)
    n = 1
    if tail != 0.0:
        out[1] = tail
        n = 2
    out[n] = s
    out[0] = n


@njit(cache=True, nogil=True, error_model="numpy")
def _sum(e, f, sign, out):
    """out = e + sign * f, exactly; zero terms are dropped."""
    n_e, n_f = np.int64(e[0]), np.int64(f[0])
    i, j, m = 1, 1, 0
    q = 0.0
    while i <= n_e or j <= n_f:
        if j > n_f or (i <= n_e and abs(e[i]) < abs(f[j])):
            x = e[i]
            i += 1
        else:
            x = sign * f[j]
            j += 1
        s = q + x
        b = s - q
        tail = (q - (s - b)) + (x - b)
        q = s
        if tail != 0.0:
            m += 1
            out[m] = tail
    if q != 0.0 or m == 0:
        m += 1
        out[m] = q
    out[0] = m


@njit(cache=True, nogil=True, error_model="numpy")
def _scale(e, factor, out):
    """out = e * factor, exactly; zero terms are dropped."""
    c = SPLITTER * factor
    f_hi = c - (c - factor)
    f_lo = factor - f_hi
    m = 0
    q = 0.0
    for i in range(1, np.int64(e[0]) + 1):
        x = e[i]
        c = SPLITTER * x
        x_hi = c - (c - x)
        x_lo = x - x_hi
        p = x * factor
        p_lo = x_lo * f_lo - (((p - x_hi * f_hi) - x_lo * f_hi) - x_hi * f_lo)
        s = q + p_lo
        b = s - q
        tail = (q - (s - b)) + (p_lo - b)
        if tail != 0.0:
            m += 1
            out[m] = tail
        q = p + s
        tail = s - (q - p)
        if tail != 0.0:
            m += 1
            out[m] = tail
    if q != 0.0 or m == 0:
        m += 1
        out[m] = q
    out[0] = m


@njit(cache=True, nogil=True, error_model="numpy")
def _product(e, f, out, spare):
    """out = e * f, exactly; `spare` has room for twice the result."""
    half = spare.shape[0] // 2
    part, total = spare[:half], spare[half:]
    _scale(e, f[1], out)
    for k in range(2, np.int64(f[0]) + 1):
        _scale(e, f[k], part)
        _sum(out, part, 1.0, total)
        for i in range(np.int64(total[0]) + 1):
            out[i] = total[i]


@njit(cache=True, nogil=True, error_model="numpy")
def _two_products(a, b, c, d, sign, out, spare):
    """out = a * b + sign * c * d, exactly; `spare` has room for four products."""
    quarter = spare.shape[0] // 4
    left, right, rest = spare[:quarter], spare[quarter : 2 * quarter], spare[2 * quarter :]
    _product(a, b, left, rest)
    _product(c, d, right, rest)
    _sum(left, right, sign, out)


@njit(cache=True, nogil=True, error_model="numpy")
def _value(e):
    """The value of an expansion, rounded."""
    total = 0.0
    for i in range(1, np.int64(e[0]) + 1):
        total += e[i]
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _sign(x):
    """-1, 0 or 1."""
    return (1 if x > 0.0 else 0) - (1 if x < 0.0 else 0)


@njit(cache=True, nogil=True, error_model="numpy")
def _orient_exact(w, ax, ay, bx, by, cx, cy):
    """The sign of `orient` by expansions."""
    acx, acy, bcx, bcy = w[0:3], w[3:6], w[6:9], w[9:12]
    _difference(ax, cx, acx)
    _difference(ay, cy, acy)
    _difference(bx, cx, bcx)
    _difference(by, cy, bcy)
    out = w[12:30]
    _two_products(acx, bcy, acy, bcx, -1.0, out, w[30:110])
    return _sign(out[np.int64(out[0])])


@njit(cache=True, nogil=True, error_model="numpy")
def _in_circle_exact(w, ax, ay, bx, by, cx, cy, px, py):
    """The sign of `in_circle` by expansions."""
    adx, ady, bdx, bdy, cdx, cdy = w[0:3], w[3:6], w[6:9], w[9:12], w[12:15], w[15:18]
    _difference(ax, px, adx)
    _difference(ay, py, ady)
    _difference(bx, px, bdx)
    _difference(by, py, bdy)
    _difference(cx, px, cdx)
    _difference(cy, py, cdy)
    spare = w[3195:5247]
    bc, ca, ab = w[18:35], w[35:52], w[52:69]
    _two_products(bdx, cdy, bdy, cdx, -1.0, bc, spare)
    _two_products(cdx, ady, cdy, adx, -1.0, ca, spare)
    _two_products(adx, bdy, ady, bdx, -1.0, ab, spare)
    aa, bb, cc = w[69:86], w[86:103], w[103:120]
    _two_products(adx, adx, ady, ady, 1.0, aa, spare)
    _two_products(bdx, bdx, bdy, bdy, 1.0, bb, spare)
    _two_products(cdx, cdx, cdy, cdy, 1.0, cc, spare)
    two, third, total = w[120:1145], w[1145:1658], w[1658:3195]
    _two_products(aa, bc, bb, ca, 1.0, two, spare)
    _product(cc, ab, third, spare)
    _sum(two, third, 1.0, total)
    return _sign(total[np.int64(total[0])])


@njit(cache=True, nogil=True, error_model="numpy")
def circumcentre(w, ax, ay, bx, by, cx, cy):
    """The centre of the circle through three sites not on one line, to a few ulps of its reach."""
    acx, acy, bcx, bcy = w[0:3], w[3:6], w[6:9], w[9:12]
    _difference(ax, cx, acx)
    _difference(ay, cy, acy)
    _difference(bx, cx, bcx)
    _difference(by, cy, bcy)
    aa, bb, area = w[12:29], w[29:46], w[46:63]
    out, spare = w[63:193], w[193:713]
    _two_products(acx, bcy, acy, bcx, -1.0, area, spare)
    _two_products(acx, acx, acy, acy, 1.0, aa, spare)
    _two_products(bcx, bcx, bcy, bcy, 1.0, bb, spare)
    twice = 2.0 * _value(area)
    _two_products(aa, bcy, bb, acy, -1.0, out, spare)
    x = _value(out) / twice
    _two_products(bb, acx, aa, bcx, -1.0, out, spare)
    return cx + x, cy + _value(out) / twice


# Whole numbers of up to 58 bits, and sums of their products as four limbs of 29 bits, least
# first, the last one signed: enough for differences of nearby sites, and far faster than
# expansions.


@njit(cache=True, nogil=True, error_model="numpy")
def _whole(a, b, factor):
    """(a - b) * factor as an integer of at most 58 bits, or NOT_WHOLE; factor: a power of two."""
    high = a - b
    v = a - high
    low = ((a - (high + v)) + (v - b)) * factor
    high *= factor
    if not (abs(high) < WHOLE_LIMIT and abs(low) < WHOLE_LIMIT):
        return NOT_WHOLE
    i, j = np.int64(high), np.int64(low)
    if np.float64(i) != high or np.float64(j) != low:
        return NOT_WHOLE
    return i + j


@njit(cache=True, nogil=True, error_model="numpy")
def _minor(ax, ay, bx, by):
    """ax * by - ay * bx as limbs."""
    ax_0, ax_1, ay_0, ay_1 = ax & LIMB, ax >> 29, ay & LIMB, ay >> 29
    bx_0, bx_1, by_0, by_1 = bx & LIMB, bx >> 29, by & LIMB, by >> 29
    m_0 = ax_0 * by_0 - ay_0 * bx_0
    m_1 = ax_0 * by_1 + ax_1 * by_0 - ay_0 * bx_1 - ay_1 * bx_0 + (m_0 >> 29)
    m_2 = ax_1 * by_1 - ay_1 * bx_1 + (m_1 >> 29)
    return m_0 & LIMB, m_1 & LIMB, m_2 & LIMB, m_2 >> 29


@njit(cache=True, nogil=True, error_model="numpy")
def _limb_product(m, s):
    """The product of two numbers of four limbs as seven sums, without carries."""
    return (
        m[0] * s[0],
        m[0] * s[1] + m[1] * s[0],
        m[0] * s[2] + m[1] * s[1] + m[2] * s[0],
        m[0] * s[3] + m[1] * s[2] + m[2] * s[1] + m[3] * s[0],
        m[1] * s[3] + m[2] * s[2] + m[3] * s[1],
        m[2] * s[3] + m[3] * s[2],
        m[3] * s[3],
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _in_circle_whole(ax, ay, bx, by, cx, cy):
    """The sign of `in_circle` for whole differences to p of at most 58 bits."""
    one = _limb_product(_minor(bx, by, cx, cy), _minor(ax, -ay, ay, ax))
    two = _limb_product(_minor(cx, cy, ax, ay), _minor(bx, -by, by, bx))
    six = _limb_product(_minor(ax, ay, bx, by), _minor(cx, -cy, cy, cx))
    carry = np.int64(0)
    rest = np.int64(0)
    for k in range(6):
        carry += one[k] + two[k] + six[k]
        rest |= carry & LIMB
        carry >>= 29
    carry += one[6] + two[6] + six[6]
    if carry == 0:
        return 1 if rest != 0 else 0
    return 1 if carry > 0 else -1


@njit(cache=True, nogil=True, error_model="numpy")
def orient(w, ax, ay, bx, by, cx, cy):
    """1 where a, b, c turn left, -1 right, 0 on one line; exact. `w`: SCRATCH floats."""
    left = (ax - cx) * (by - cy)
    right = (ay - cy) * (bx - cx)
    det = left - right
    # two factors cannot underflow (see the file's head), so zeros are zeros
    bound = ORIENT_SLACK * (abs(left) + abs(right))
    if det > bound:
        return 1
    if det < -bound:
        return -1
    if bound == 0.0:
        return 0
    reach = max(max(abs(ax - cx), abs(ay - cy)), max(abs(bx - cx), abs(by - cy)))
    factor = math.ldexp(1.0, 57 - math.frexp(reach)[1])
    acx, acy = _whole(ax, cx, factor), _whole(ay, cy, factor)
    bcx, bcy = _whole(bx, cx, factor), _whole(by, cy, factor)
    if min(min(acx, acy), min(bcx, bcy)) != NOT_WHOLE:
        m = _minor(acx, acy, bcx, bcy)
        if m[3] == 0:
            return 1 if m[0] | m[1] | m[2] != 0 else 0
        return 1 if m[3] > 0 else -1
    return _orient_exact(w, ax, ay, bx, by, cx, cy)


@njit(cache=True, nogil=True, error_model="numpy")
def in_circle(w, ax, ay, bx, by, cx, cy, px, py):
    """1 where p lies inside the circle through a, b, c (turning left), -1 outside, 0 on it; exact.

    `w`: SCRATCH floats.
    """
    adx, ady = ax - px, ay - py
    bdx, bdy = bx - px, by - py
    cdx, cdy = cx - px, cy - py
    bc1, bc2 = bdx * cdy, bdy * cdx
    ca1, ca2 = cdx * ady, cdy * adx
    ab1, ab2 = adx * bdy, ady * bdx
    a_square = adx * adx + ady * ady
    b_square = bdx * bdx + bdy * bdy
    c_square = cdx * cdx + cdy * cdy
    det = a_square * (bc1 - bc2) + b_square * (ca1 - ca2) + c_square * (ab1 - ab2)
    bound = UNDERFLOW + IN_CIRCLE_SLACK * (
        a_square * (abs(bc1) + abs(bc2))
        + b_square * (abs(ca1) + abs(ca2))
        + c_square * (abs(ab1) + abs(ab2))
    )
    if det > bound:
        return 1
    if det < -bound:
        return -1
    reach = max(max(abs(adx), abs(ady)), max(max(abs(bdx), abs(bdy)), max(abs(cdx), abs(cdy))))
    factor = math.ldexp(1.0, 57 - math.frexp(reach)[1])
    i_ax, i_ay = _whole(ax, px, factor), _whole(ay, py, factor)
    i_bx, i_by = _whole(bx, px, factor), _whole(by, py, factor)
    i_cx, i_cy = _whole(cx, px, factor), _whole(cy, py, factor)
    if min(min(i_ax, i_ay), min(min(i_bx, i_by), min(i_cx, i_cy))) == NOT_WHOLE:
        return _in_circle_exact(w, ax, ay, bx, by, cx, cy, px, py)
    bits = i_ax | i_ay | i_bx | i_by | i_cx | i_cy
    unit = bits & -bits
    if reach * factor > LATTICE_LIMIT * np.float64(unit):
        return _in_circle_whole(i_ax, i_ay, i_bx, i_by, i_cx, i_cy)
    # the sites lie on a lattice: few bits
    per_unit = factor / np.float64(unit)
    i_ax, i_ay = np.int64(adx * per_unit), np.int64(ady * per_unit)
    i_bx, i_by = np.int64(bdx * per_unit), np.int64(bdy * per_unit)
    i_cx, i_cy = np.int64(cdx * per_unit), np.int64(cdy * per_unit)
    whole = (
        (i_ax * i_ax + i_ay * i_ay) * (i_bx * i_cy - i_by * i_cx)
        + (i_bx * i_bx + i_by * i_by) * (i_cx * i_ay - i_cy * i_ax)
        + (i_cx * i_cx + i_cy * i_cy) * (i_ax * i_by - i_ay * i_bx)
    )
    return (1 if whole > 0 else 0) - (1 if whole < 0 else 0)


@njit(cache=True, nogil=True, error_model="numpy")
def first_bad_row(sites, limit):
    """The first row with a NaN, an infinity or a magnitude above `limit`, or -1."""
    for i in range(sites.shape[0]):
        if not (abs(sites[i, 0]) <= limit and abs(sites[i, 1]) <= limit):
            return i
    return -1


@njit(cache=True, nogil=True, error_model="numpy")
def _hilbert(x, y, levels):
    """The place of cell (x, y) along the Hilbert curve over 2^levels by 2^levels cells."""
    place = 0
    flip = 0
    swap = 0
    for level in range(levels - 1, -1, -1):
        u = ((x >> level) & 1) ^ flip
        v = ((y >> level) & 1) ^ flip
        cross = (u ^ v) & swap
        u ^= cross
        v ^= cross
        place = (place << 2) | ((3 * u) ^ v)
        turn = v ^ 1
        flip ^= turn & u
        swap ^= turn
    return place


@njit(cache=True, nogil=True, error_model="numpy")
def _sort_run(sites, order, lo, hi, keyed, spare, counts):
    """Sort order[lo:hi] along a Hilbert curve over its own bounding square.

    keyed[lo:hi] holds key << 32 | site afterwards. Returns False where all coincide.
    """
    n = hi - lo
    x_min = y_min = np.inf
    x_max = y_max = -np.inf
    for i in range(lo, hi):
        x, y = sites[order[i], 0], sites[order[i], 1]
        x_min, x_max = min(x_min, x), max(x_max, x)
        y_min, y_max = min(y_min, y), max(y_max, y)
    side = max(x_max - x_min, y_max - y_min)
    if side == 0.0:
        return False
    levels = 2
    while (1 << (2 * levels)) < 4 * n and levels < 15:
        levels += 1
    cells = 1 << levels
    # halved, so that neither the side nor its inverse can overflow
    per_x = 0.5 * cells / (0.5 * side)
    if per_x == np.inf:
        per_x = 1e308
    top = cells - 1
    for i in range(lo, hi):
        s = order[i]
        u = min(np.int64((sites[s, 0] - x_min) * 0.5 * per_x), top)
        v = min(np.int64((sites[s, 1] - y_min) * 0.5 * per_x), top)
        keyed[i] = (np.int64(_hilbert(u, v, levels)) << 32) | np.int64(s)
    bits = 2 * levels
    passes = (bits + 10) // 11
    width = (bits + passes - 1) // passes
    mask = (1 << width) - 1
    for p in range(passes):
        shift = 32 + p * width
        counts[: mask + 2] = 0
        for i in range(lo, hi):
            counts[((keyed[i] >> shift) & mask) + 1] += 1
        for d in range(mask):
            counts[d + 1] += counts[d]
        for i in range(lo, hi):
            d = (keyed[i] >> shift) & mask
            spare[lo + counts[d]] = keyed[i]
            counts[d] += 1
        for i in range(lo, hi):
            keyed[i] = spare[i]
    for i in range(lo, hi):
        order[i] = keyed[i] & 0xFFFFFFFF
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def spatial_order(sites):
    """(n,) int64: the sites along a Hilbert curve, crowded cells sorted within themselves."""
    n = sites.shape[0]
    order = np.arange(n)
    keyed = np.empty(n, np.int64)
    spare = np.empty(n, np.int64)
    counts = np.empty(2050, np.int64)
    todo = np.empty(2 * n + 2, np.int64)
    todo[0], todo[1] = 0, n
    depth = 2
    while depth > 0:
        depth -= 2
        lo, hi = todo[depth], todo[depth + 1]
        if not _sort_run(sites, order, lo, hi, keyed, spare, counts):
            continue
        start = lo
        for i in range(lo + 1, hi + 1):
            if i == hi or (keyed[i] >> 32) != (keyed[start] >> 32):
                if i - start > CROWD and i - start < hi - lo:
                    todo[depth], todo[depth + 1] = start, i
                    depth += 2
                start = i
    return order


@njit(cache=True, nogil=True, error_model="numpy")
def _load(sites, order, xy):
    """Scale the sites into xy[: 2n], in this order; returns the factor that scales back."""
    n = order.shape[0]
    top = 0.0
    for i in range(n):
        top = max(top, max(abs(sites[i, 0]), abs(sites[i, 1])))
    _, exponent = math.frexp(top)
    # in two halves: 2^-exponent itself may be out of range
    half = exponent // 2
    down_1, down_2 = math.ldexp(1.0, -half), math.ldexp(1.0, half - exponent)
    for i in range(n):
        x = sites[order[i], 0] * down_1 * down_2
        y = sites[order[i], 1] * down_1 * down_2
        if abs(x) < TINY:
            x = (x + TINY) - TINY
        if abs(y) < TINY:
            y = (y + TINY) - TINY
        xy[2 * i] = x
        xy[2 * i + 1] = y
    xy[2 * n] = np.nan
    xy[2 * n + 1] = np.nan
    return exponent


@njit(cache=True, nogil=True, error_model="numpy")
def _conflict(w, xy, ghost, tri, t, px, py):
    """1 where p removes triangle t (given as 8 t), 0 where it lies on its circle, else -1; exact.

    A ghost's circle is the half-plane beyond its two sites, with the open segment between them.
    """
    a, b, c = np.int64(tri[t]), np.int64(tri[t + 1]), np.int64(tri[t + 2])
    if a == ghost:
        a, b, c = b, c, a
    elif b == ghost:
        a, b, c = c, a, b
    ax, ay = xy[2 * a], xy[2 * a + 1]
    bx, by = xy[2 * b], xy[2 * b + 1]
    if c != ghost:
        cx, cy = xy[2 * c], xy[2 * c + 1]
        return in_circle(w, ax, ay, bx, by, cx, cy, px, py)
    side = orient(w, ax, ay, bx, by, px, py)
    if side != 0:
        return side
    if ax != bx:
        return 1 if min(ax, bx) < px < max(ax, bx) else -1
    return 1 if min(ay, by) < py < max(ay, by) else -1


@njit(cache=True, nogil=True, error_model="numpy")
def _locate(w, xy, ghost, tri, t, px, py):
    """The triangle (as 8 t) that p removes, or -1 - site where p coincides with that site.

    An exact visibility walk; it cannot circle in a Delaunay triangulation. Should it, all
    triangles are tried, and should none be removed by p, the walk's last one has to be: the
    removed tree is never empty.
    """
    n_slots = tri.shape[0] // 8
    for _ in range(n_slots + 1):
        if _conflict(w, xy, ghost, tri, t, px, py) == 1:
            return t
        over = -1
        for k in range(3):
            v = np.int64(tri[t + k])
            if v != ghost and xy[2 * v] == px and xy[2 * v + 1] == py:
                return -1 - v
            a = np.int64(tri[t + (k + 1) % 3])
            b = np.int64(tri[t + (k + 2) % 3])
            if a == ghost or b == ghost:
                continue
            side = orient(w, xy[2 * a], xy[2 * a + 1], xy[2 * b], xy[2 * b + 1], px, py)
            # a ghost is left through its only edge, also by a site on that edge's line
            if side < 0 or (side == 0 and v == ghost):
                over = k
        if over < 0:
            break
        t = (np.int64(tri[t + 4 + over]) >> 3) << 3
    for s in range(n_slots):
        if np.int64(tri[8 * s]) != DEAD:
            if _conflict(w, xy, ghost, tri, 8 * s, px, py) == 1:
                return 8 * s
            for k in range(3):
                v = np.int64(tri[8 * s + k])
                if v != ghost and xy[2 * v] == px and xy[2 * v + 1] == py:
                    return -1 - v
    return t


@njit(cache=True, nogil=True, error_model="numpy")
def _first_triangle(w, xy, n, ghost, tri, circ):
    """Lay the first triangle and its ghosts; returns its three sites, -1 where there is none."""
    second = 1
    while second < n and xy[2 * second] == xy[0] and xy[2 * second + 1] == xy[1]:
        second += 1
    if second >= n:
        return 0, -1, -1
    third = second + 1
    side = 0
    while third < n:
        side = orient(
            w, xy[0], xy[1], xy[2 * second], xy[2 * second + 1], xy[2 * third], xy[2 * third + 1]
        )
        if side != 0:
            break
        third += 1
    if third >= n:
        return 0, second, -1
    a, b, c = 0, second, third
    if side < 0:
        b, c = c, b
    corner = (a, b, c)
    slot = (0, 8, 16 * second, 16 * second + 8)
    tri[16 * third] = DEAD
    tri[16 * third + 8] = DEAD
    for k in range(3):
        tri[k] = corner[k]
        tri[4 + k] = slot[k + 1] + 2
        g = slot[k + 1]
        tri[g] = corner[(k + 2) % 3]
        tri[g + 1] = corner[(k + 1) % 3]
        tri[g + 2] = ghost
        tri[g + 4] = slot[1 + (k + 2) % 3] + 1
        tri[g + 5] = slot[1 + (k + 1) % 3]
        tri[g + 6] = k
    for k in range(4):
        # no circle: decided exactly
        circ[(slot[k] >> 1) + 0] = np.nan
        circ[(slot[k] >> 1) + 1] = np.nan
        circ[(slot[k] >> 1) + 2] = np.nan
        circ[(slot[k] >> 1) + 3] = np.nan
    return a, second, third


@njit(cache=True, nogil=True, error_model="numpy")
def _coarse_to_fine(n, first, second, third):
    """The sites in the order of their insertion, without the three that are in already."""
    todo = np.empty(max(n - 3, 0), np.int32)
    stride = 1
    while stride * COARSENING < n:
        stride *= COARSENING
    coarser = 0
    m = 0
    while stride > 0:
        for p in range(0, n, stride):
            if (coarser > 0 and p % coarser == 0) or p in (first, second, third):
                continue
            todo[m] = p
            m += 1
        coarser = stride
        stride //= COARSENING
    return todo


@njit(cache=True, nogil=True, error_model="numpy")
def insert(w, xy, ghost, tri, circ, alias, todo, start):
    """Insert the sites ``todo`` into tri and circ; see the file's head for the arrays.

    alias[i] becomes the site that i coincides with. The search for ``todo[j]`` begins at
    triangle ``start[j]`` where that is given, and where the last one ended otherwise. Returns
    how often a site lay exactly on a circle.

    Topology first: a triangle joins the removed tree only through an edge, and only if its far
    corner is not yet on the tree's rim. So the removed part stays a disc with every corner
    once on its rim: it is a tree, and each touched cell meets it in one piece. A refused
    triangle is simply kept.

    The error of a circle through p, a, b with A = a - p, B = b - p, sums of magnitudes s and t,
    squares la and lb, determinant d and centre p + C, |C| <= c: to first order
    E <= u (7 (la t + lb s) / 2d + 11 s t c / 2d + 3 c + 2), and a site is surely inside below
    (r - 2 E)^2 and outside above (r + 2 E)^2; 32 u for each coefficient leaves a factor of two
    for the rounding of r^2, of the distance, and of this bound.
    """
    n = ghost
    size = 2 * n + 8
    stamp = np.full(n + 1, -1, np.int32)
    rim, rim_site = np.empty(size, np.uint32), np.empty(size, np.uint32)
    gone, stack = np.empty(size, np.uint32), np.empty(size, np.uint32)
    ties = 0
    given = start.shape[0]
    limit = 64 + 4 * np.int64(math.sqrt(n))
    last = np.int64(0)
    while np.int64(tri[last]) == DEAD:
        last += 8
    for j_todo in range(todo.shape[0]):
        p = np.int64(todo[j_todo])
        px, py = xy[2 * p], xy[2 * p + 1]
        t = np.int64(last)
        if j_todo < given and start[j_todo] >= 0:
            t = np.int64(start[j_todo])
        found = False
        for _ in range(limit):
            dx, dy = px - circ[t >> 1], py - circ[(t >> 1) + 1]
            if dx * dx + dy * dy < circ[(t >> 1) + 2]:
                found = True
                break
            a, b, c = np.int64(tri[t]), np.int64(tri[t + 1]), np.int64(tri[t + 2])
            ax, ay = xy[2 * a] - px, xy[2 * a + 1] - py
            bx, by = xy[2 * b] - px, xy[2 * b + 1] - py
            cx, cy = xy[2 * c] - px, xy[2 * c + 1] - py
            least = 0.0
            over = -1
            side = bx * cy - by * cx
            if side < least:
                least, over = side, 0
            side = cx * ay - cy * ax
            if side < least:
                least, over = side, 1
            side = ax * by - ay * bx
            if side < least:
                least, over = side, 2
            if over < 0:
                break
            t = (np.int64(tri[t + 4 + over]) >> 3) << 3
        if not found:
            t = _locate(w, xy, ghost, tri, t, px, py)
            if t < 0:
                alias[p] = -1 - t
                tri[16 * p] = DEAD
                tri[16 * p + 8] = DEAD
                continue
        # the removed tree, from triangle t outwards, its rim counter-clockwise
        n_gone, n_rim, depth = 1, 0, 2
        gone[0] = t
        stamp[tri[t]] = p
        stamp[tri[t + 1]] = p
        stamp[tri[t + 2]] = p
        stack[0], stack[1] = t + 2, t + 1
        e = t
        while True:
            o = np.int64(tri[e + 4])
            t = (o >> 3) << 3
            dx, dy = px - circ[t >> 1], py - circ[(t >> 1) + 1]
            square = dx * dx + dy * dy
            k = o & 3
            if square > circ[(t >> 1) + 3]:
                hit = False
            elif square < circ[(t >> 1) + 2]:
                hit = stamp[tri[o]] != p
            else:
                sign = _conflict(w, xy, ghost, tri, t, px, py)
                ties += sign == 0
                hit = sign > 0 and stamp[tri[o]] != p
            if hit:
                stamp[tri[o]] = p
                gone[n_gone] = t
                n_gone += 1
                stack[depth] = t + ((18 >> (2 * k)) & 3)
                depth += 1
                e = t + ((9 >> (2 * k)) & 3)
                continue
            # the rim's site is where the kept side's half-edge ends
            rim_site[n_rim] = tri[t + ((18 >> (2 * k)) & 3)]
            rim[n_rim] = o
            n_rim += 1
            if depth == 0:
                break
            depth -= 1
            e = np.int64(stack[depth])
        # the new cell: a fan of triangles around p
        gone[n_gone] = 16 * p
        gone[n_gone + 1] = 16 * p + 8
        before = np.int64(gone[n_rim - 1])
        here = np.int64(gone[0])
        a = np.int64(rim_site[0])
        rim_site[n_rim] = a
        gone[n_rim] = here
        ax, ay = xy[2 * a] - px, xy[2 * a + 1] - py
        a_square = ax * ax + ay * ay
        a_sum = abs(ax) + abs(ay)
        for j in range(n_rim):
            b = np.int64(rim_site[j + 1])
            after = np.int64(gone[j + 1])
            o = np.int64(rim[j])
            tri[here] = p
            tri[here + 1] = a
            tri[here + 2] = b
            tri[here + 4] = o
            tri[here + 5] = after + 2
            tri[here + 6] = before + 1
            tri[o + 4] = here
            bx, by = xy[2 * b] - px, xy[2 * b + 1] - py
            b_square = bx * bx + by * by
            b_sum = abs(bx) + abs(by)
            half = 0.5 / (ax * by - ay * bx)
            cx = (a_square * by - b_square * ay) * half
            cy = (b_square * ax - a_square * bx) * half
            spread = abs(half) * a_sum * b_sum
            reach = abs(cx) + abs(cy)
            error = CIRCLE_SLACK * (
                abs(half) * (a_square * b_sum + b_square * a_sum) + spread * reach + reach + 1.0
            )
            if spread * CIRCLE_SLACK > 0.25:
                error = np.inf
            x, y = px + cx, py + cy
            dx, dy = px - x, py - y
            square = dx * dx + dy * dy
            band = 4.0 * error * (reach + error)
            circ[here >> 1] = x
            circ[(here >> 1) + 1] = y
            circ[(here >> 1) + 2] = square - band
            circ[(here >> 1) + 3] = square + band
            a, ax, ay, a_square, a_sum = b, bx, by, b_square, b_sum
            before, here = here, after
        last = before
    return ties


@njit(cache=True, nogil=True, error_model="numpy")
def _label(order, alias):
    """(n + 1,) int32: the site's row for each place; of coincident sites, the first row's."""
    n = order.shape[0]
    label = np.empty(n + 1, np.int32)
    for i in range(n):
        label[i] = order[i]
    for i in range(n):
        v = alias[i]
        if v != i and order[i] < label[v]:
            label[v] = order[i]
    label[n] = -1
    return label


@njit(cache=True, nogil=True, error_model="numpy")
def _vertices(w, xy, ghost, exponent, tri, circ, label):
    """The finite triangles' centres (m, 2) and sites (m, 3); each triangle's spare gets its row.

    A centre whose error bound is above VERTEX_TOLERANCE of the scene or its circle is computed
    again by expansions.
    """
    vertices = np.empty((2 * ghost, 2))
    vertex_sites = np.empty((2 * ghost, 3), np.int32)
    half = exponent // 2
    up_1, up_2 = math.ldexp(1.0, half), math.ldexp(1.0, exponent - half)
    m = 0
    for t in range(0, 16 * ghost, 8):
        a, b, c = np.int64(tri[t]), np.int64(tri[t + 1]), np.int64(tri[t + 2])
        if a == DEAD:
            continue
        if a == ghost or b == ghost or c == ghost:
            tri[t + 3] = DEAD
            continue
        x, y = circ[t >> 1], circ[(t >> 1) + 1]
        band = circ[(t >> 1) + 3] - circ[(t >> 1) + 2]
        square = 0.5 * (circ[(t >> 1) + 3] + circ[(t >> 1) + 2])
        if not band <= 8.0 * VERTEX_TOLERANCE * square:
            reach = math.sqrt(square)
            if not band <= 8.0 * VERTEX_TOLERANCE * reach * (1.0 + reach):
                x, y = circumcentre(
                    w, xy[2 * a], xy[2 * a + 1], xy[2 * b], xy[2 * b + 1], xy[2 * c], xy[2 * c + 1]
                )
        vertices[m, 0] = x * up_1 * up_2
        vertices[m, 1] = y * up_1 * up_2
        vertex_sites[m, 0] = label[a]
        vertex_sites[m, 1] = label[b]
        vertex_sites[m, 2] = label[c]
        tri[t + 3] = m
        m += 1
    return vertices[:m], vertex_sites[:m]


@njit(cache=True, nogil=True, error_model="numpy")
def _edges(w, xy, ghost, tri, circ, label, ties):
    """(k, 4) int32 edges and (k,) flags of those without length; half-edge ids by triangle.

    An edge: the site on its left, the site on its right, the vertex it comes from, the vertex
    it goes to; -1 is at infinity. Where no site ever lay on a circle no edge has length zero.
    """
    edges = np.empty((3 * ghost, 4), np.int32)
    flat = np.zeros(3 * ghost, np.bool_)
    ids = np.full(8 * ghost, -1, np.int32)
    j = 0
    for t in range(0, 16 * ghost, 8):
        if np.int64(tri[t]) == DEAD:
            continue
        for k in range(3):
            e = t + k
            o = np.int64(tri[e + 4])
            if o < e:
                continue
            a = np.int64(tri[t + ((9 >> (2 * k)) & 3)])
            b = np.int64(tri[t + ((18 >> (2 * k)) & 3)])
            if a == ghost or b == ghost:
                continue
            back = (o >> 3) << 3
            edges[j, 0] = label[a]
            edges[j, 1] = label[b]
            edges[j, 2] = np.int32(tri[back + 3])
            edges[j, 3] = np.int32(tri[t + 3])
            ids[4 * (t >> 3) + k] = 2 * j
            ids[4 * (back >> 3) + (o & 3)] = 2 * j + 1
            v = np.int64(tri[t + k])
            if ties > 0 and v != ghost and np.int64(tri[o]) != ghost:
                px, py = xy[2 * v], xy[2 * v + 1]
                q = back >> 1
                square = (px - circ[q]) * (px - circ[q]) + (py - circ[q + 1]) * (py - circ[q + 1])
                if not (square < circ[q + 2] or square > circ[q + 3]):
                    flat[j] = _conflict(w, xy, ghost, tri, back, px, py) == 0
            j += 1
    return edges[:j], flat[:j], ids


@njit(cache=True, nogil=True, error_model="numpy")
def _links(n, tri, ids, n_half_edges):
    """(next, prev) of each half-edge around the cell on its left, passing over infinity."""
    after = np.empty(n_half_edges, np.int32)
    before = np.empty(n_half_edges, np.int32)
    for t in range(0, 16 * n, 8):
        if np.int64(tri[t]) == DEAD:
            continue
        for k in range(3):
            here = ids[4 * (t >> 3) + k]
            if here < 0:
                continue
            # the half-edge of the same cell that leaves this triangle; its twin is edge k + 2
            o = np.int64(tri[t + 4 + ((18 >> (2 * k)) & 3)])
            if ids[4 * (o >> 3) + (o & 3)] < 0:
                o = np.int64(tri[((o >> 3) << 3) + 4 + ((18 >> (2 * (o & 3))) & 3)])
            there = ids[4 * (o >> 3) + (o & 3)]
            after[here] = there
            before[there] = here
    return after, before


@njit(cache=True, nogil=True, error_model="numpy")
def triangulate(sites, room):
    """The triangulation of (n, 2) finite float64 sites, with room for ``room`` more of them.

    Returns status (0: done, 1: no three sites off one line, nothing else is set), order (n,),
    the row of every site, xy, tri, circ and alias (see the file's head; the ghost is site
    n + room), the exponent that scales xy back, and how often a site lay on a circle.
    """
    n = sites.shape[0]
    ghost = n + room
    order = spatial_order(sites)
    xy = np.empty(2 * ghost + 2)
    exponent = _load(sites, order, xy)
    xy[2 * ghost], xy[2 * ghost + 1] = np.nan, np.nan
    tri = np.empty(16 * ghost, np.uint32)
    tri[::8] = DEAD
    circ = np.empty(8 * ghost)
    alias = np.arange(ghost)
    w = np.empty(SCRATCH)
    first, second, third = _first_triangle(w, xy, n, ghost, tri, circ)
    ties = 0
    if third >= 0:
        todo = _coarse_to_fine(n, first, second, third)
        ties = insert(w, xy, ghost, tri, circ, alias, todo, np.empty(0, np.int64))
    return 0 if third >= 0 else 1, order, xy, tri, circ, alias, exponent, ties


@njit(cache=True, nogil=True, error_model="numpy")
def diagram(sites, linked):
    """The diagram of (n, 2) finite float64 sites.

    Returns status (0: done, 1: no three sites off one line, nothing else is set), vertices
    (m, 2), vertex_sites (m, 3), edges (k, 4), flat (k,), representative (n,), and next and prev
    (2 k,), which are empty unless `linked`. Linear time on average after sorting.
    """
    n = sites.shape[0]
    status, order, xy, tri, circ, alias, exponent, ties = triangulate(sites, 0)
    none = np.empty(0, np.int32)
    if status != 0:
        return (
            1, np.empty((0, 2)), np.empty((0, 3), np.int32), np.empty((0, 4), np.int32),
            np.empty(0, np.bool_), none, none, none,
        )  # fmt: skip
    w = np.empty(SCRATCH)
    label = _label(order, alias)
    representative = np.empty(n, np.int32)
    for i in range(n):
        representative[order[i]] = label[alias[i]]
    vertices, vertex_sites = _vertices(w, xy, n, exponent, tri, circ, label)
    edges, flat, ids = _edges(w, xy, n, tri, circ, label, ties)
    after, before = none, none
    if linked:
        after, before = _links(n, tri, ids, 2 * edges.shape[0])
    return 0, vertices, vertex_sites, edges, flat, representative, after, before


TURNED, NOT_EMPTY, WRONG_FLAG, NOT_CONVEX = 1, 2, 3, 4
"""What `certify` may find: at a vertex, at an edge, at an edge, at a half-edge."""


@njit(cache=True, nogil=True, error_model="numpy")
def certify(sites, vertex_sites, origin, before, cell, flat):
    """Check a diagram's circles exactly; returns (0, 0) or the first fault and where it is.

    Each vertex's sites turn left; no site beyond an edge lies inside the circle of the vertex
    before it, and lies on it just where the edge is flagged as without length; the unbounded
    cells' sites form a convex ring. Delaunay's lemma makes of this that all circles are empty,
    where the vertices' triangles cover the hull once.
    """
    n = sites.shape[0]
    xy = np.empty(2 * n + 2)
    _load(sites, np.arange(n), xy)
    w = np.empty(SCRATCH)
    for v in range(vertex_sites.shape[0]):
        a, b, c = vertex_sites[v, 0], vertex_sites[v, 1], vertex_sites[v, 2]
        ax, ay, bx, by = xy[2 * a], xy[2 * a + 1], xy[2 * b], xy[2 * b + 1]
        if orient(w, ax, ay, bx, by, xy[2 * c], xy[2 * c + 1]) <= 0:
            return TURNED, v
    for j in range(flat.shape[0]):
        v, u = origin[2 * j], origin[2 * j + 1]
        if v < 0 or u < 0:
            continue
        a, b, c = vertex_sites[v, 0], vertex_sites[v, 1], vertex_sites[v, 2]
        p = -1
        for k in range(3):
            s = vertex_sites[u, k]
            if s != cell[2 * j] and s != cell[2 * j + 1]:
                p = s
        ax, ay, bx, by = xy[2 * a], xy[2 * a + 1], xy[2 * b], xy[2 * b + 1]
        cx, cy, px, py = xy[2 * c], xy[2 * c + 1], xy[2 * p], xy[2 * p + 1]
        side = in_circle(w, ax, ay, bx, by, cx, cy, px, py)
        if side > 0:
            return NOT_EMPTY, j
        if (side == 0) != flat[j]:
            return WRONG_FLAG, j
    for e in range(origin.shape[0]):
        if origin[e] >= 0:
            continue
        q, s, r = cell[before[e] ^ 1], cell[e], cell[e ^ 1]
        if q == r:
            continue
        qx, qy, sx, sy = xy[2 * q], xy[2 * q + 1], xy[2 * s], xy[2 * s + 1]
        rx, ry = xy[2 * r], xy[2 * r + 1]
        side = orient(w, qx, qy, sx, sy, rx, ry)
        between = min(qx, rx) <= sx <= max(qx, rx) and min(qy, ry) <= sy <= max(qy, ry)
        if side < 0 or (side == 0 and not between):
            return NOT_CONVEX, e
    return 0, 0
