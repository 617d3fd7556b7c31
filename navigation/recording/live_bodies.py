"""Links and waiting robots in a recording, read for the page, and limits of its numbers.

Pydantic's error is a ValueError, as a reader expects of a damaged message.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Final, TypeAlias

from pydantic import Field, TypeAdapter
from pydantic.dataclasses import dataclass

MOST_S: Final = 1e12
"""Largest time that is read: chosen, 30 000 years, so that no difference of two is infinite."""
MOST_M: Final = 1e6
"""Largest coordinate that is read, in metres: chosen, far beyond any arena."""

Waits: TypeAlias = tuple[dict[str, str], dict[str, str]]
"""Sentences of waiting robots, and the robots they wait for, by name."""


@dataclass(frozen=True, slots=True)
class TapedLink:
    """State and counters of a robot's link; another version's may lack some."""

    state: str = ""
    down_reason: str | None = None
    rtt_s: Annotated[float, Field(strict=True, ge=0.0, le=MOST_S)] | None = None
    executed: Annotated[int, Field(strict=True)] | None = None
    sent: Mapping[str, int] = Field(default_factory=dict)
    received: Mapping[str, int] = Field(default_factory=dict)


_LINK: Final = TypeAdapter(TapedLink)
_WAITS: Final = TypeAdapter(Waits)


def link_of(body: Any) -> TapedLink:
    """Read a link's body; ValueError if invalid."""
    return _LINK.validate_python(body)


def waits_of(body: Any) -> Waits:
    """Read who waits; ValueError, TypeError or LookupError if invalid."""
    return _WAITS.validate_python((body["waits"], body["waits_for"]))


def bounded(value: Any, most: float) -> float:
    """Read a number of at most ``most``, either way; ValueError or TypeError if it is none."""
    number = float(value)
    if not abs(number) <= most:
        raise ValueError(f"a number is {number:g}: must be at most {most:g}")
    return number
