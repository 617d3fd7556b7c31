"""Lines and circles from sums over a stretch of a border, which grow with the stretch.

Rules and units
- ``px``, ``py`` as in ``vision.outline.fit.edge_shape_kernels``.
- ``sums`` (13,): the stretch's first point and the one behind its last, for a line and for a
  circle; x and y of the first, the origin; and about it, with z = xx + yy, the sums of x, y, xx,
  xy, yy, xz, yz, zz.
- Total least squares, and Taubin's circle.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from numba import njit

from planner.scene.compile_options import SUMS
from vision.outline.fit.edge_shape_kernels import put_line, taubin

FIRST, BEHIND, ROUND_BEHIND, ORIGIN_X, ORIGIN_Y = 0, 1, 2, 3, 4
"""Places of a stretch and its origin: defined."""
X, Y, XX, XY, YY, XZ, YZ, ZZ = 5, 6, 7, 8, 9, 10, 11, 12
"""Places of the sums: defined."""
SUM_FIELDS = 13
"""Their number: defined."""


@njit(**SUMS)
def grow(px, py, a, b, sums):
    """Extend ``sums`` to points a .. b - 1, for a line only."""
    begin = int(sums[BEHIND])
    if int(sums[FIRST]) != a or begin > b:
        begin = a
        sums[FIRST] = a
        sums[ROUND_BEHIND] = a
        sums[ORIGIN_X] = px[a]
        sums[ORIGIN_Y] = py[a]
        for i in range(X, SUM_FIELDS):
            sums[i] = 0.0
    ox, oy = sums[ORIGIN_X], sums[ORIGIN_Y]
    xs, ys = px[begin:b], py[begin:b]
    sx = sy = xx = xy = yy = 0.0
    for k in range(b - begin):
        x = xs[k] - ox
        y = ys[k] - oy
        sx += x
        sy += y
        xx += x * x
        xy += x * y
        yy += y * y
    sums[BEHIND] = b
    sums[X] += sx
    sums[Y] += sy
    sums[XX] += xx
    sums[XY] += xy
    sums[YY] += yy


@njit(**SUMS)
def grow_round(px, py, sums):
    """Complete ``sums`` for a circle: apart, since most stretches are lines."""
    begin = int(sums[ROUND_BEHIND])
    b = int(sums[BEHIND])
    ox, oy = sums[ORIGIN_X], sums[ORIGIN_Y]
    xs, ys = px[begin:b], py[begin:b]
    xz = yz = zz = 0.0
    for k in range(b - begin):
        x = xs[k] - ox
        y = ys[k] - oy
        z = x * x + y * y
        xz += x * z
        yz += y * z
        zz += z * z
    sums[ROUND_BEHIND] = b
    sums[XZ] += xz
    sums[YZ] += yz
    sums[ZZ] += zz


@njit(**SUMS)
def line_of(px, py, sums, out):
    """Total least squares through the points of ``sums``: out = x, y, ux, uy."""
    share = 1.0 / (sums[BEHIND] - sums[FIRST])
    mean_x, mean_y = sums[X] * share, sums[Y] * share
    means = (mean_x, mean_y, sums[XX] * share, sums[XY] * share, sums[YY] * share)
    last = int(sums[BEHIND]) - 1
    put_line(sums[ORIGIN_X], sums[ORIGIN_Y], means, px[last], py[last], out)


@njit(**SUMS)
def circle_of(px, py, sums, out):
    """Taubin's circle through the points of ``sums``: out = cx, cy, r; False on a line."""
    grow_round(px, py, sums)
    share = 1.0 / (sums[BEHIND] - sums[FIRST])
    mx = sums[X] * share
    my = sums[Y] * share
    mm = mx * mx + my * my
    ez = (sums[XX] + sums[YY]) * share
    xx = sums[XX] * share - mx * mx
    xy = sums[XY] * share - mx * my
    yy = sums[YY] * share - my * my
    # about the mean: z there is z here - 2 mx x - 2 my y - mm
    ex = sums[XZ] * share - mx * ez
    ey = sums[YZ] * share - my * ez
    xz = ex - 2.0 * (mx * xx + my * xy)
    yz = ey - 2.0 * (mx * xy + my * yy)
    zz = (
        sums[ZZ] * share
        - 2.0 * mm * ez
        + mm * mm
        + 4.0 * (mx * mx * xx + 2.0 * mx * my * xy + my * my * yy - mx * ex - my * ey)
    )
    return taubin(xx, xy, yy, xz, yz, zz, sums[ORIGIN_X] + mx, sums[ORIGIN_Y] + my, out)
