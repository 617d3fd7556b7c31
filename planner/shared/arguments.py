"""Checks of arguments where they come in: the wrong kind of value is named with its argument.

``TypeError`` is for a value of the wrong kind, ``ValueError`` for one out of range. Each message is
one sentence: the argument, what it is, and what it must be.
"""

from __future__ import annotations

import math
import operator
import reprlib
from collections.abc import Iterable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T")


def brief(value: Any) -> str:
    """Short text of a value on one line."""
    return " ".join(reprlib.repr(value).split())


def of_kind(name: str, value: Any, *kinds: type[T]) -> T:
    """Return the value; ``TypeError`` unless it is of one of the kinds."""
    for kind in kinds:
        if isinstance(value, kind):
            return value
    known = " or ".join(kind.__name__ for kind in kinds)
    raise TypeError(f"{name} is a {type(value).__name__}: must be a {known}")


def one_of(name: str, value: Any, *words: str) -> str:
    """Return the value; ``ValueError`` unless it is one of the words."""
    if not isinstance(value, str) or value not in words:
        known = " or ".join(map(repr, words))
        raise ValueError(f"{name} = {brief(value)}: must be {known}")
    return value


def as_float(name: str, value: Any) -> float:
    """Convert the value to a float; infinite if it is beyond all floats."""
    try:
        if not isinstance(value, str | bytes):  # which float() would parse
            return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf
    except (TypeError, ValueError):
        pass
    raise TypeError(f"{name} = {brief(value)}: must be a number")


def as_positive(name: str, value: Any, *, zero: bool = False) -> float:
    """Convert the value to a finite float > 0, or >= 0 with ``zero``."""
    number = as_float(name, value)
    if not (0.0 < number < math.inf or (zero and number == 0.0)):
        raise ValueError(f"{name} = {brief(value)}: must be {'>=' if zero else '>'} 0 and finite")
    return number


def as_index(name: str, value: Any) -> int:
    """Convert the value to a whole number."""
    try:
        return operator.index(value)
    except TypeError:
        raise TypeError(f"{name} = {brief(value)}: must be a whole number") from None


def as_whole(name: str, value: Any) -> int:
    """Convert the value to a whole number >= 0."""
    number = as_index(name, value)
    if number < 0:
        raise ValueError(f"{name} = {number}: must be >= 0")
    return number


def as_list(name: str, values: Any, what: str) -> list[Any]:
    """List of an iterable that is no text and no mapping."""
    if isinstance(values, Iterable) and not isinstance(values, str | bytes | dict):
        return list(values)
    raise TypeError(f"{name} = {brief(values)}: must be a list of {what}")


def as_numbers(name: str, values: Any, what: str) -> NDArray[np.float64]:
    """Copy of the values as an array of any shape."""
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "USV" and values is not None:
            return np.array(array, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError):  # rows of unequal length are a ValueError
        pass
    raise TypeError(f"{name} = {brief(values)}: must be {what}")
