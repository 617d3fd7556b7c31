"""A planning request, parsed: stations, preference, order, alternatives, margin."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from planner.scene import Vec
from planner.shared.arguments import as_float, as_list, as_positive, brief, one_of

PREFERENCES = {"length": 0.0, "balanced": 0.5, "clearance": 1.0}
"""Numbers of the names of ``prefer``."""

MOST_ALTERNATIVES = 1_000_000
"""More are refused: their routes would take gigabytes."""


@dataclass(frozen=True, slots=True)
class Request:
    """Request with ``stations`` start, every via, goal, each with a heading or None.

    If ``relaxed``, the margin is given up around stations within it.
    """

    stations: tuple[Vec, ...]
    headings_rad: tuple[float | None, ...]
    preference: float
    best_order: bool
    alternatives: int
    margin: float
    relaxed: bool = False

    def in_order(self, order: Sequence[int]) -> Request:
        """The same request with its vias in another order."""
        if tuple(order) == tuple(range(len(order))):
            return self
        picked = (0, *(i + 1 for i in order), len(self.stations) - 1)
        return replace(
            self,
            stations=tuple(self.stations[i] for i in picked),
            headings_rad=tuple(self.headings_rad[i] for i in picked),
        )

    @classmethod
    def of(
        cls,
        start: Sequence[float],
        goal: Sequence[float],
        prefer: str | float,
        via: Sequence[Sequence[float]],
        order: str,
        alternatives: int,
        margin: float,
        *,
        relaxed: bool = False,
    ) -> Request:
        """Parse the arguments of ``Roadmap.plan``; ``ValueError`` reports faults."""
        vias = enumerate(as_list("via", via, "places"))
        named = [("start", start), *((f"via[{i}]", v) for i, v in vias), ("goal", goal)]
        parsed = [_station(name, value) for name, value in named]
        one_of("order", order, "fixed", "best")
        spare = as_positive("margin", margin, zero=True)
        return cls(
            tuple(p[0] for p in parsed),
            tuple(p[1] for p in parsed),
            preference_of(prefer),
            order == "best",
            _count(alternatives),
            spare,
            relaxed,
        )


def _count(alternatives: int) -> int:
    try:
        wanted = as_float("alternatives", alternatives)
    except TypeError:
        wanted = math.nan
    if not wanted >= 0.0 or math.isinf(wanted) or wanted != int(wanted):
        raise ValueError(f"alternatives = {brief(alternatives)}: must be a whole number >= 0")
    if wanted > MOST_ALTERNATIVES:
        raise ValueError(f"alternatives = {alternatives}: must be at most {MOST_ALTERNATIVES}")
    return int(wanted)


def _station(name: str, value: Sequence[float]) -> tuple[Vec, float | None]:
    try:
        numbers = [as_float(name, v) for v in as_list(name, value, "numbers")]
    except TypeError:
        raise TypeError(f"{name} = {brief(value)}: must be x, y or x, y, heading") from None
    if len(numbers) not in (2, 3) or not all(math.isfinite(v) for v in numbers):
        raise ValueError(f"{name} = {tuple(value)}: must be x, y or x, y, heading, all finite")
    return (numbers[0], numbers[1]), numbers[2] if len(numbers) == 3 else None


def preference_of(prefer: str | float) -> float:
    """Number from 0 (length) to 1 (clearance); ``ValueError`` for any other ``prefer``."""
    if isinstance(prefer, str):
        if prefer not in PREFERENCES:
            raise ValueError(f"prefer = {prefer!r}: must be one of {', '.join(PREFERENCES)}")
        return PREFERENCES[prefer]
    value = as_float("prefer", prefer)
    if not 0.0 <= value <= 1.0:
        raise ValueError(f"prefer = {prefer}: must be from 0 (length) to 1 (clearance)")
    return value
