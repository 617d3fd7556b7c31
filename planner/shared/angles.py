"""Angles after any number of turns."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Angle = TypeVar("Angle", float, NDArray[np.float64])


def wrap_angle(angle: Angle) -> Angle:
    """Wrap an angle, or each of many, to (-pi, pi]; rounding never makes it -pi."""
    wrapped = math.pi - (math.pi - angle) % math.tau
    return wrapped + math.tau * (wrapped <= -math.pi)
