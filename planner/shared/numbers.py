"""Numbers from outside, whatever type they come in."""

from __future__ import annotations

import math


def as_float(value: float) -> float:
    """The value as a float; infinite where it is beyond all floats."""
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf
