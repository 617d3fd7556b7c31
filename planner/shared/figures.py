"""Figures in sentences: three significant digits, or more if two would look the same."""

from __future__ import annotations

import math

DIGITS = 3
"""Significant digits; every digit before the point is written all the same."""
MOST_DIGITS = 17
SMALL, LARGE = 1e-6, 1e7
"""A figure below or from here on is written with an exponent."""

SHORTEST_LENGTH = 1e-300
"""A length below this has no digits that could be cut off."""
NOTHING = 1e-12
"""A length below this share of another is rounding: the planner's distances are exact to that."""


def sized(length: float, units: str = "", beside: float | None = None) -> str:
    """Write a length with its units.

    ``beside`` is the length it is compared with: both get the digits that distinguish them, and
    next to it a length of a few roundings is 0.
    """
    digits = DIGITS
    if beside is not None and abs(length) <= NOTHING * abs(beside):
        length = 0.0
    if beside is not None and beside != length:
        while digits < MOST_DIGITS and _rounded(length, digits) == _rounded(beside, digits):
            digits += 1
    return f"{_rounded(length, digits)} {units}".rstrip()


def at_most(length: float, units: str = "") -> str:
    """Write a length rounded towards zero, so that it never looks longer than it is."""
    if abs(length) >= LARGE:
        return f"{length:.6g} {units}".rstrip()
    if abs(length) < SHORTEST_LENGTH:
        return sized(0.0, units)
    scale = 10.0 ** _decimals(length, DIGITS)
    return sized(math.trunc(length * scale * (1.0 + 1e-12)) / scale, units)


def placed(x: float, y: float) -> str:
    """Write a place as (x, y), both to the same decimal: three significant digits of the larger."""
    if _has_exponent(max(abs(x), abs(y))):
        return f"({x:g}, {y:g})"
    decimals = _decimals(max(abs(x), abs(y)), DIGITS)
    return f"({_fixed(x, decimals)}, {_fixed(y, decimals)})"


def _has_exponent(value: float) -> bool:
    """True if a figure is too large or too small to be read digit by digit."""
    return abs(value) >= LARGE or 0.0 < abs(value) < SMALL


def _rounded(value: float, digits: int) -> str:
    if _has_exponent(value):
        return f"{value:.{digits}g}"
    return _fixed(value, _decimals(value, digits))


def _decimals(value: float, digits: int) -> int:
    if value == 0.0 or not math.isfinite(value):
        return 0
    return max(0, digits - 1 - math.floor(math.log10(abs(value))))


def _fixed(value: float, decimals: int) -> str:
    text = f"{value:.{decimals}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text == "-0" else text
