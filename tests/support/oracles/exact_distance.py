"""Distances between a straight line and a primitive, to fifty digits and written apart.

Between segments everything is rational: whether they meet is decided exactly. Circles and arcs
take square roots, sines and cosines to ``DIGITS``. A primitive is ``kind`` and its row of numbers
as in :class:`planner.scene.Primitives`; nothing here is the planner's.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from decimal import Decimal, getcontext, localcontext
from fractions import Fraction
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
        return _root(_squared(*_fractions(a, b), *_fractions(numbers[:2], numbers[:2])))
    if kind == SEGMENT:
        return _root(_squared(*_fractions(a, b), *_fractions(numbers[:2], numbers[2:4])))
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


def _fractions(*places: Sequence[float]) -> list[tuple[Fraction, Fraction]]:
    return [(Fraction(float(p[0])), Fraction(float(p[1]))) for p in places]


def _root(square: Fraction) -> float:
    with localcontext() as context:
        context.prec = DIGITS
        return float((Decimal(square.numerator) / Decimal(square.denominator)).sqrt())


def _squared(
    a: tuple[Fraction, Fraction],
    b: tuple[Fraction, Fraction],
    c: tuple[Fraction, Fraction],
    d: tuple[Fraction, Fraction],
) -> Fraction:
    """The square of the distance between two segments, exact."""

    def side(p: tuple[Fraction, ...], q: tuple[Fraction, ...], r: tuple[Fraction, ...]) -> int:
        turn = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        return (turn > 0) - (turn < 0)

    def away(p: tuple[Fraction, ...], q: tuple[Fraction, ...], r: tuple[Fraction, ...]) -> Fraction:
        u, v = (r[0] - q[0], r[1] - q[1]), (p[0] - q[0], p[1] - q[1])
        square = u[0] ** 2 + u[1] ** 2
        t = Fraction(0)
        if square:
            t = min(Fraction(1), max(Fraction(0), (u[0] * v[0] + u[1] * v[1]) / square))
        return (v[0] - t * u[0]) ** 2 + (v[1] - t * u[1]) ** 2

    if side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0:
        return Fraction(0)
    return min(away(c, a, b), away(d, a, b), away(a, c, d), away(b, c, d))


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
