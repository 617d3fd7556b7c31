"""Numbers from outside, whatever type they come in, and angles, however often they went round."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Angle = TypeVar("Angle", float, NDArray[np.float64])


def as_float(value: float) -> float:
    """The value as a float; infinite where it is beyond all floats."""
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def wrap_angle(angle: Angle) -> Angle:
    """The same angle, or each of many, in (-pi, pi]; rounding never makes it -pi."""
    wrapped = math.pi - (math.pi - angle) % math.tau
    return wrapped + math.tau * (wrapped <= -math.pi)
