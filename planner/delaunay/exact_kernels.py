"""Exact arithmetic: sums of floats, and products of whole numbers.

Rules
- An expansion is an array: the number of terms, then the terms, least first; their sum is its exact
  value (Shewchuk 1997). Nothing here allocates.
- Whole numbers have up to 58 bits. A sum of their products is four limbs of 29 bits, least first,
  the last one signed: far faster than expansions.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF

WHOLE_LIMIT = 2.0**57
"""Limit of scaled differences, so that two parts add up to at most 58 bits."""
NOT_WHOLE = -(1 << 62)
"""A difference of more bits."""
LIMB = (1 << 29) - 1
"""A limb's 29 bits."""
SPLITTER = 134_217_729.0
"""2^27 + 1: splits a float64 into two halves (Dekker 1971)."""


@njit(**LEAF)
def difference(a, b, out):
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


@njit(**LEAF, forceinline=True)
def _close(out, m, q):
    """End an expansion of m terms with the largest, q, unless it is a superfluous zero."""
    if q != 0.0 or m == 0:
        m += 1
        out[m] = q
    out[0] = m


@njit(**LEAF)
def add(e, f, sign, out):
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
    _close(out, m, q)


@njit(**LEAF)
def scale(e, factor, out):
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
    _close(out, m, q)


@njit(**LEAF)
def product(e, f, out, spare):
    """out = e * f, exactly; `spare` holds twice the result."""
    half = spare.shape[0] // 2
    part, total = spare[:half], spare[half:]
    scale(e, f[1], out)
    for k in range(2, np.int64(f[0]) + 1):
        scale(e, f[k], part)
        add(out, part, 1.0, total)
        for i in range(np.int64(total[0]) + 1):
            out[i] = total[i]


@njit(**LEAF)
def two_products(a, b, c, d, sign, out, spare):
    """out = a * b + sign * c * d, exactly; `spare` holds four products."""
    quarter = spare.shape[0] // 4
    left, right, rest = spare[:quarter], spare[quarter : 2 * quarter], spare[2 * quarter :]
    product(a, b, left, rest)
    product(c, d, right, rest)
    add(left, right, sign, out)


@njit(**LEAF)
def value(e):
    """Value of an expansion, rounded."""
    total = 0.0
    for i in range(1, np.int64(e[0]) + 1):
        total += e[i]
    return total


@njit(**LEAF)
def sign_of(x):
    """-1, 0 or 1."""
    return (1 if x > 0.0 else 0) - (1 if x < 0.0 else 0)


@njit(**LEAF)
def as_whole(a, b, factor):
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


@njit(**LEAF)
def minor(ax, ay, bx, by):
    """ax * by - ay * bx as limbs."""
    ax_0, ax_1, ay_0, ay_1 = ax & LIMB, ax >> 29, ay & LIMB, ay >> 29
    bx_0, bx_1, by_0, by_1 = bx & LIMB, bx >> 29, by & LIMB, by >> 29
    m_0 = ax_0 * by_0 - ay_0 * bx_0
    m_1 = ax_0 * by_1 + ax_1 * by_0 - ay_0 * bx_1 - ay_1 * bx_0 + (m_0 >> 29)
    m_2 = ax_1 * by_1 - ay_1 * bx_1 + (m_1 >> 29)
    return m_0 & LIMB, m_1 & LIMB, m_2 & LIMB, m_2 >> 29


@njit(**LEAF)
def limb_product(m, s):
    """Product of two numbers of four limbs as seven sums, without carries."""
    return (
        m[0] * s[0],
        m[0] * s[1] + m[1] * s[0],
        m[0] * s[2] + m[1] * s[1] + m[2] * s[0],
        m[0] * s[3] + m[1] * s[2] + m[2] * s[1] + m[3] * s[0],
        m[1] * s[3] + m[2] * s[2] + m[3] * s[1],
        m[2] * s[3] + m[3] * s[2],
        m[3] * s[3],
    )
