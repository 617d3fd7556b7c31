"""Distances between a straight line and a primitive, to fifty digits and written apart.

Between segments everything is rational: whether they meet is decided exactly. Circles and arcs
take square roots, sines and cosines to ``DIGITS``. A primitive is ``kind`` and its row of numbers
as in :class:`planner.scene.Primitives`; nothing here is the planner's.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from decimal import Decimal, getcontext, localcontext
from functools import lru_cache
from itertools import pairwise

POINT, SEGMENT, CIRCLE, ARC = 0, 1, 2, 3
DIGITS = 50

Place = tuple[Decimal, Decimal]


def exact_distance(
    a: Sequence[float], b: Sequence[float], kind: int, row: Sequence[float]
) -> float:
    """The distance between the segment a b and a primitive, correctly rounded but for an ulp."""
    numbers = [float(v) for v in row]
    if kind == POINT:
        return _straight_distance(a, b, numbers[:2], numbers[:2])
    if kind == SEGMENT:
        return _straight_distance(a, b, numbers[:2], numbers[2:4])
    with localcontext() as context:
        context.prec = DIGITS
        return _round_distance(a, b, kind, numbers)


def exact_clearance(
    line: Sequence[Sequence[float]], kinds: Iterable[int], rows: Sequence[Sequence[float]]
) -> float:
    """The least distance between a polyline and many primitives."""
    ends = list(pairwise(line)) or [(line[0], line[0])]
    return min(
        exact_distance(a, b, kind, row)
        for kind, row in zip(kinds, rows, strict=True)
        for a, b in ends
    )


Whole = tuple[int, int]


def _straight_distance(
    a: Sequence[float], b: Sequence[float], c: Sequence[float], d: Sequence[float]
) -> float:
    """The distance between two segments: rational up to its root, in whole numbers of a unit."""
    ratios = [float(v).as_integer_ratio() for place in (a, b, c, d) for v in place[:2]]
    unit = max(under for _, under in ratios)  # the largest power of two
    x = [over * (unit // under) for over, under in ratios]
    over, under = _squared((x[0], x[1]), (x[2], x[3]), (x[4], x[5]), (x[6], x[7]))
    with localcontext() as context:
        context.prec = DIGITS
        return float((Decimal(over) / Decimal(under * unit * unit)).sqrt())


def _squared(a: Whole, b: Whole, c: Whole, d: Whole) -> Whole:
    """The square of the distance between two segments, exact: a fraction's two numbers."""

    def side(p: Whole, q: Whole, r: Whole) -> int:
        turn = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        return (turn > 0) - (turn < 0)

    def away(p: Whole, q: Whole, r: Whole) -> Whole:
        u, v = (r[0] - q[0], r[1] - q[1]), (p[0] - q[0], p[1] - q[1])
        square, along = u[0] ** 2 + u[1] ** 2, u[0] * v[0] + u[1] * v[1]
        if along <= 0:
            return v[0] ** 2 + v[1] ** 2, 1
        if along >= square:
            return (v[0] - u[0]) ** 2 + (v[1] - u[1]) ** 2, 1
        return (u[0] * v[1] - u[1] * v[0]) ** 2, square

    if side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0:
        return 0, 1
    least = away(c, a, b)
    for other in (away(d, a, b), away(a, c, d), away(b, c, d)):
        if other[0] * least[1] < least[0] * other[1]:
            least = other
    return least


def _round_distance(a: Sequence[float], b: Sequence[float], kind: int, row: list[float]) -> float:
    """To a circle or an arc: what is nearest is a point of the circle, or one of the arc's ends."""
    cx, cy, r = (Decimal(v) for v in row[:3])
    p, q = (Decimal(float(a[0])) - cx, Decimal(float(a[1])) - cy), (
        Decimal(float(b[0])) - cx,
        Decimal(float(b[1])) - cy,
    )  # fmt: skip
    step = (q[0] - p[0], q[1] - p[1])
    square = step[0] ** 2 + step[1] ** 2
    candidates = [Decimal(0), Decimal(1)]
    if square:
        middle = -(p[0] * step[0] + p[1] * step[1]) / square
        candidates.append(middle)
        high = (p[0] + middle * step[0]) ** 2 + (p[1] + middle * step[1]) ** 2
        if high <= r * r:
            half = ((r * r - high) / square).sqrt()
            candidates += [middle - half, middle + half]
    best = Decimal("Infinity")
    for t in candidates:
        if 0 <= t <= 1:
            at = (p[0] + t * step[0], p[1] + t * step[1])
            if kind == CIRCLE or _on_arc(at, row):
                best = min(best, abs((at[0] ** 2 + at[1] ** 2).sqrt() - r))
    if kind == ARC:
        for angle in (row[3], row[3] + row[4]):
            c, s = _cos_sin(angle)
            end = (r * c, r * s)
            t = Decimal(0)
            if square:
                t = ((end[0] - p[0]) * step[0] + (end[1] - p[1]) * step[1]) / square
                t = min(Decimal(1), max(Decimal(0), t))
            off = (end[0] - p[0] - t * step[0], end[1] - p[1] - t * step[1])
            best = min(best, (off[0] ** 2 + off[1] ** 2).sqrt())
    return float(best)


def _on_arc(at: Place, row: list[float]) -> bool:
    """Whether the direction ``at`` lies between the arc's ends, by turns and not by angles."""
    (bx, by), (ex, ey) = _cos_sin(row[3]), _cos_sin(row[3] + row[4])
    after = bx * at[1] - by * at[0] >= 0
    before = ex * at[1] - ey * at[0] <= 0
    if row[4] <= 3.141592653589793:
        return after and before
    return after or before


@lru_cache(maxsize=4096)
def _cos_sin(angle: float) -> Place:
    """By their series, the angle halved first and the result doubled again."""
    halvings = 8
    x = Decimal(angle) / 2**halvings
    c, s, term, k = Decimal(0), Decimal(0), Decimal(1), 0
    while abs(term) > Decimal(10) ** -(getcontext().prec + 5):
        if k % 2 == 0:
            c += term if k % 4 == 0 else -term
        else:
            s += term if k % 4 == 1 else -term
        k += 1
        term *= x / k
    for _ in range(halvings):
        c, s = c * c - s * s, 2 * c * s
    return c, s
