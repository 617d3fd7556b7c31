"""Corners of a contour by the small eigenvalue of its covariance matrix, in O(n).

The method is Tsai, Hou and Su's (1999), as in the paper's section 3.1; the letters k and lambda_S
are the paper's. Contours are closed: indices wrap.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF, OWNING


@njit(**OWNING)
def small_eigenvalues(xs, ys, starts, k):
    """lambda_S, equation 13, around every pixel of every contour: (n,) float64.

    The sums of equations 7 to 11 slide along the contour; one of fewer than 2 k + 1 pixels is its
    own region of support.
    """
    values = np.zeros(xs.shape[0], np.float64)
    sums = np.empty(5)
    for b in range(starts.shape[0] - 1):
        first = starts[b]
        n = starts[b + 1] - first
        reach = min(k, (n - 1) // 2)
        count = 2 * reach + 1
        sums[:] = 0.0
        for j in range(-reach, reach + 1):
            _add(xs, ys, first, first + j % n, 1.0, sums)
        for i in range(n):
            cx = sums[0] / count  # (10)
            cy = sums[1] / count  # (11)
            c11 = sums[2] / count - cx * cx  # (7)
            c22 = sums[3] / count - cy * cy  # (8)
            c12 = sums[4] / count - cx * cy  # (9)
            values[first + i] = 0.5 * (
                c11 + c22 - math.sqrt((c11 - c22) * (c11 - c22) + 4.0 * c12 * c12)
            )  # (13)
            _add(xs, ys, first, first + (i - reach) % n, -1.0, sums)
            _add(xs, ys, first, first + (i + reach + 1) % n, 1.0, sums)
    return values


@njit(**LEAF)
def _add(xs, ys, first, p, sign, sums):
    """Add pixel p, or remove it, relative to pixel ``first``: x, y, xx, yy, xy."""
    x = np.float64(xs[p] - xs[first])
    y = np.float64(ys[p] - ys[first])
    sums[0] += sign * x
    sums[1] += sign * y
    sums[2] += sign * x * x
    sums[3] += sign * y * y
    sums[4] += sign * x * y


@njit(**OWNING)
def strongest_apart(values, starts, k, threshold):
    """Mask of corners: above the threshold, strongest first, k pixels apart."""
    chosen = np.zeros(values.shape[0], np.bool_)
    for b in range(starts.shape[0] - 1):
        first = starts[b]
        n = starts[b + 1] - first
        order = np.argsort(-values[first : first + n], kind="mergesort")
        for i in order:
            if values[first + i] <= threshold:
                break
            free = True
            for j in range(1, min(k, n)):
                if chosen[first + (i + j) % n] or chosen[first + (i - j) % n]:
                    free = False
                    break
            chosen[first + i] = free
    return chosen


@njit(**OWNING)
def is_digital_circle(xs, ys, first, last, slack):
    """Sauer's condition, equation 14, for the contour pixels first .. last - 1.

    Return ``(accepted, x_m, y_m, r)`` with the centroid and the mean radius. The circle passes
    within half a pixel in y, or in x where it is steeper than 45 degrees. ``slack`` widens the half
    pixel.
    """
    n = last - first
    x_m = 0.0
    y_m = 0.0
    for i in range(first, last):
        x_m += xs[i]
        y_m += ys[i]
    x_m /= n
    y_m /= n
    r = 0.0
    for i in range(first, last):
        r += math.sqrt((xs[i] - x_m) ** 2 + (ys[i] - y_m) ** 2)
    r /= n
    half = 0.5 + slack
    for i in range(first, last):
        u = abs(xs[i] - x_m)
        v = abs(ys[i] - y_m)
        if u > v:
            u, v = v, u
        if u > r:
            return False, x_m, y_m, r
        on_circle = math.sqrt(r * r - u * u)
        if on_circle < v - half or on_circle > v + half:
            return False, x_m, y_m, r
    return True, x_m, y_m, r
