"""Safe reading and repeating of data from outside the program.

Repeated text is short and printable: no control characters, half surrogate pairs or endless numbers
reach sentences, logs and answers.
"""

from __future__ import annotations

import json
import math
from typing import Any, Final

SHORT: Final = 40
"""Most characters of a strange value that are repeated."""
REPLACEMENT: Final = "\N{REPLACEMENT CHARACTER}"


class OutsideError(ValueError):
    """Error: data from outside is not what it must be."""


def read_object(data: bytes | str) -> dict[str, Any]:
    """Read one JSON object; `OutsideError` for anything else."""
    try:
        found = json.loads(data)
    except ValueError:
        raise OutsideError("the request is no JSON") from None
    except RecursionError:
        raise OutsideError("the request is nested too deeply") from None
    if not isinstance(found, dict):
        raise OutsideError("a request must be one JSON object")
    return found


def printable(text: str, most: int) -> str:
    """The text on one line of at most ``most`` characters, unprintable ones replaced."""
    shown = "".join(c if c.isprintable() else REPLACEMENT for c in text[:most])
    return shown if len(text) <= most else shown[:-1] + "…"


def in_short(value: object) -> str:
    """A JSON value for a sentence: itself if short, else its kind."""
    match value:
        case None | bool() | float():
            return repr(value)
        case int() if abs(value) < 10**SHORT:
            return repr(value)
        case int():
            return "a number of more than 40 digits"
        case str():
            return repr(printable(value, SHORT))
        case list():
            return "a list"
        case dict():
            return "an object"
    return f"a {type(value).__name__}"


def finite_number(value: object) -> float | None:
    """A JSON number as a finite float, else None."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None
