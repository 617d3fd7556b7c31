"""Numbers from outside, of any type, and angles after any number of turns."""

from __future__ import annotations

import math
import reprlib
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Angle = TypeVar("Angle", float, NDArray[np.float64])


def as_float(value: Any, name: str) -> float:
    """Convert the value to a float; infinite if it is beyond all floats.

    ``name`` is the value's in the message of the ``TypeError`` if it is not a number.
    """
    try:
        if not isinstance(value, str | bytes):  # which float() would parse
            return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf
    except (TypeError, ValueError):
        pass
    raise TypeError(f"{name} = {reprlib.repr(value)}: must be a number")


def wrap_angle(angle: Angle) -> Angle:
    """Wrap an angle, or each of many, to (-pi, pi]; rounding never makes it -pi."""
    wrapped = math.pi - (math.pi - angle) % math.tau
    return wrapped + math.tau * (wrapped <= -math.pi)
