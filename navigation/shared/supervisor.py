"""Restarts failed parts of the program with growing pauses, and reports which and why.

A failing part makes the robot hold. The pause starts at ``FIRST_PAUSE_S``, doubles up to
``LONGEST_PAUSE_S``, and starts again after ``WELL_S`` without failure.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

FIRST_PAUSE_S: Final = 0.25
LONGEST_PAUSE_S: Final = 8.0
WELL_S: Final = 30.0


@dataclass(frozen=True, slots=True)
class SupervisedPart:
    """A part's failure in words, None while it is well, and its restart."""

    failure: Callable[[], str | None]
    restart: Callable[[], None]


@dataclass(slots=True)
class _Record:
    failures: int = 0
    reason: str | None = None
    due_s: float = 0.0
    restarted_s: float = 0.0


class Supervisor:
    """Named parts; call `look` once a control cycle."""

    def __init__(self, parts: Mapping[str, SupervisedPart]) -> None:
        self._parts = dict(parts)
        self._records = {name: _Record() for name in parts}

    def add(self, name: str, part: SupervisedPart) -> None:
        """Add a part."""
        self._parts[name] = part
        self._records[name] = _Record()

    @property
    def restarts(self) -> int:
        """Number of restarts."""
        return sum(record.failures for record in self._records.values())

    def look(self, now_s: float) -> str | None:
        """All failures in one sentence; None if every part is well."""
        for name, part in self._parts.items():
            self._look_at(part, self._records[name], now_s)
        return "; ".join(
            f"the {name} failed ({record.reason}): starting it again"
            for name, record in self._records.items()
            if record.reason is not None
        ) or None  # fmt: skip

    def _look_at(self, part: SupervisedPart, record: _Record, now_s: float) -> None:
        failure = part.failure()
        if failure is None:
            record.reason = None
            return
        if record.reason is None:
            if now_s - record.restarted_s > WELL_S:
                record.failures = 0
            pause_s = FIRST_PAUSE_S * 2.0 ** min(record.failures, 30)
            record.reason, record.due_s = failure, now_s + min(pause_s, LONGEST_PAUSE_S)
        if now_s >= record.due_s:
            record.failures += 1
            record.restarted_s = now_s
            record.reason = None
            part.restart()


def in_words(error: BaseException) -> str:
    """Type of an error, and its text if it has one."""
    text = str(error).strip().splitlines()
    return f"{type(error).__name__}: {text[0]}" if text else type(error).__name__
