"""What comes from outside the program: read without surprises, and made fit to be repeated.

Rules
- `read_object` reads any bytes or text: one JSON object, or one `OutsideError` with a sentence.
- What is repeated in sentences, logs and answers is printable and short: no control character,
  no half of a surrogate pair and no endless number gets further than here.
"""

from __future__ import annotations

import json
import math
from typing import Any, Final

SHORT: Final = 40
"""So many characters of a strange value are repeated at most."""
REPLACEMENT: Final = "\N{REPLACEMENT CHARACTER}"


class OutsideError(ValueError):
    """What came is not what was asked for; the message says what it must be."""


def read_object(data: bytes | str) -> dict[str, Any]:
    """One JSON object; `OutsideError` for anything else, however long, deep or broken it is."""
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
    """The text on one line, at most so many characters; what cannot be printed is replaced."""
    shown = "".join(c if c.isprintable() else REPLACEMENT for c in text[:most])
    return shown if len(text) <= most else shown[:-1] + "…"


def in_short(value: object) -> str:
    """A value from JSON as a sentence repeats it: itself where it is short, else what it is."""
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
    """A number from JSON that is finite as a float; None for everything else."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None
