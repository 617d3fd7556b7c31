"""Exact signs of determinants: left or right, inside or outside.

Plain determinants decide within their error bound; otherwise differences on a lattice are
multiplied as integers, the rest as expansions (Shewchuk 1997). Coordinates are at most 1 and
multiples of 2^-268, so that no product of four differences underflows. The working space `w` holds
SCRATCH floats.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.delaunay.exact_kernels import (
    LIMB,
    NOT_WHOLE,
    add,
    as_whole,
    difference,
    limb_product,
    minor,
    product,
    sign_of,
    two_products,
    value,
)
from planner.scene.compile_options import LEAF

LATTICE_LIMIT = 29_600
"""12 M^4 < 2^63: in-circle of differences up to M fits a 64-bit integer."""
UNIT = 2.0**-53
"""Half an ulp of 1, the relative error of one operation."""
ORIENT_SLACK = (3.0 + 16.0 * UNIT) * UNIT
IN_CIRCLE_SLACK = (10.0 + 96.0 * UNIT) * UNIT
"""Error bounds of the plain determinants (Shewchuk 1997, ccwerrboundA and iccerrboundA)."""
UNDERFLOW = 1e-280
"""Determinants below which digits may be lost to underflow."""
SCRATCH = 5247
"""Space for the expansions of `_in_circle_exact`, the longest of 1,536 terms."""


@njit(**LEAF, forceinline=True)
def _differences(w, ax, ay, bx, by, cx, cy):
    """a - c and b - c, exactly: x and y in three numbers each."""
    difference(ax, cx, w[0:3])
    difference(ay, cy, w[3:6])
    difference(bx, cx, w[6:9])
    difference(by, cy, w[9:12])


@njit(**LEAF)
def _orient_exact(w, ax, ay, bx, by, cx, cy):
    """Sign of `orient` by expansions."""
    acx, acy, bcx, bcy = w[0:3], w[3:6], w[6:9], w[9:12]
    _differences(w, ax, ay, bx, by, cx, cy)
    out = w[12:30]
    two_products(acx, bcy, acy, bcx, -1.0, out, w[30:110])
    return sign_of(out[np.int64(out[0])])


@njit(**LEAF)
def _in_circle_exact(w, ax, ay, bx, by, cx, cy, px, py):
    """Sign of `in_circle` by expansions."""
    adx, ady, bdx, bdy, cdx, cdy = w[0:3], w[3:6], w[6:9], w[9:12], w[12:15], w[15:18]
    _differences(w, ax, ay, bx, by, px, py)
    difference(cx, px, cdx)
    difference(cy, py, cdy)
    spare = w[3195:5247]
    bc, ca, ab = w[18:35], w[35:52], w[52:69]
    two_products(bdx, cdy, bdy, cdx, -1.0, bc, spare)
    two_products(cdx, ady, cdy, adx, -1.0, ca, spare)
    two_products(adx, bdy, ady, bdx, -1.0, ab, spare)
    aa, bb, cc = w[69:86], w[86:103], w[103:120]
    two_products(adx, adx, ady, ady, 1.0, aa, spare)
    two_products(bdx, bdx, bdy, bdy, 1.0, bb, spare)
    two_products(cdx, cdx, cdy, cdy, 1.0, cc, spare)
    two, third, total = w[120:1145], w[1145:1658], w[1658:3195]
    two_products(aa, bc, bb, ca, 1.0, two, spare)
    product(cc, ab, third, spare)
    add(two, third, 1.0, total)
    return sign_of(total[np.int64(total[0])])


@njit(**LEAF)
def _in_circle_whole(ax, ay, bx, by, cx, cy):
    """Sign of `in_circle` for whole differences to p of at most 58 bits."""
    one = limb_product(minor(bx, by, cx, cy), minor(ax, -ay, ay, ax))
    two = limb_product(minor(cx, cy, ax, ay), minor(bx, -by, by, bx))
    six = limb_product(minor(ax, ay, bx, by), minor(cx, -cy, cy, cx))
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


@njit(**LEAF)
def orient(w, ax, ay, bx, by, cx, cy):
    """1 if a, b, c turn left, -1 if right, 0 on one line; exact. `w`: SCRATCH floats."""
    left = (ax - cx) * (by - cy)
    right = (ay - cy) * (bx - cx)
    det = left - right
    # two factors cannot underflow: zero means zero
    bound = ORIENT_SLACK * (abs(left) + abs(right))
    if det > bound:
        return 1
    if det < -bound:
        return -1
    if bound == 0.0:
        return 0
    reach = max(max(abs(ax - cx), abs(ay - cy)), max(abs(bx - cx), abs(by - cy)))
    factor = math.ldexp(1.0, 57 - math.frexp(reach)[1])
    acx, acy = as_whole(ax, cx, factor), as_whole(ay, cy, factor)
    bcx, bcy = as_whole(bx, cx, factor), as_whole(by, cy, factor)
    if min(min(acx, acy), min(bcx, bcy)) != NOT_WHOLE:
        m = minor(acx, acy, bcx, bcy)
        if m[3] == 0:
            return 1 if m[0] | m[1] | m[2] != 0 else 0
        return 1 if m[3] > 0 else -1
    return _orient_exact(w, ax, ay, bx, by, cx, cy)


@njit(**LEAF)
def in_circle(w, ax, ay, bx, by, cx, cy, px, py):
    """1 if p lies inside the circle through a, b, c (turning left), -1 outside, 0 on it; exact.

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
    i_ax, i_ay = as_whole(ax, px, factor), as_whole(ay, py, factor)
    i_bx, i_by = as_whole(bx, px, factor), as_whole(by, py, factor)
    i_cx, i_cy = as_whole(cx, px, factor), as_whole(cy, py, factor)
    if min(min(i_ax, i_ay), min(min(i_bx, i_by), min(i_cx, i_cy))) == NOT_WHOLE:
        return _in_circle_exact(w, ax, ay, bx, by, cx, cy, px, py)
    bits = i_ax | i_ay | i_bx | i_by | i_cx | i_cy
    unit = bits & -bits
    if reach * factor > LATTICE_LIMIT * np.float64(unit):
        return _in_circle_whole(i_ax, i_ay, i_bx, i_by, i_cx, i_cy)
    # sites on a lattice: few bits
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


@njit(**LEAF)
def circumcentre(w, ax, ay, bx, by, cx, cy):
    """Centre of the circle through three sites not on one line, to a few ulps of its reach."""
    acx, acy, bcx, bcy = w[0:3], w[3:6], w[6:9], w[9:12]
    _differences(w, ax, ay, bx, by, cx, cy)
    aa, bb, area = w[12:29], w[29:46], w[46:63]
    out, spare = w[63:193], w[193:713]
    two_products(acx, bcy, acy, bcx, -1.0, area, spare)
    two_products(acx, acx, acy, acy, 1.0, aa, spare)
    two_products(bcx, bcx, bcy, bcy, 1.0, bb, spare)
    twice = 2.0 * value(area)
    two_products(aa, bcy, bb, acy, -1.0, out, spare)
    x = value(out) / twice
    two_products(bb, acx, aa, bcx, -1.0, out, spare)
    return cx + x, cy + value(out) / twice
