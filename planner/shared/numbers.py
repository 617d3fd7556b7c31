"""Numbers from outside, of any type, and angles after any number of turns."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Angle = TypeVar("Angle", float, NDArray[np.float64])


def as_float(value: float) -> float:
    """Convert the value to a float; infinite if it is beyond all floats."""
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def wrap_angle(angle: Angle) -> Angle:
    """Wrap an angle, or each of many, to (-pi, pi]; rounding never makes it -pi."""
    wrapped = math.pi - (math.pi - angle) % math.tau
    return wrapped + math.tau * (wrapped <= -math.pi)
