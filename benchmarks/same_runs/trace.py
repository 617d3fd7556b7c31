"""A run's trace: what crossed the program's borders, line by line, and the hashes of it.

Virtual seconds. Numbers are written exactly: a difference in the last bit is a difference.
"""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from planner.scene import FloatArray

HASH_CHARACTERS: Final = 12
BLOCK: Final = 16
BLOCK_CHARACTERS: Final = 4
"""For each block of lines: enough to find where a run becomes another; the hash decides whether."""
STREAMS: Final = ("calls", "heard", "said")
"""Orders given to links, orders that reached robots, and what people are told."""
PARTS: Final = (*STREAMS, "driven", "report")


@dataclass(frozen=True, slots=True)
class Line:
    """One thing that happened; ``robot`` is its number in the configuration."""

    time_s: float
    stream: str
    robot: int
    text: str

    def __str__(self) -> str:
        return f"{self.time_s!r} robot {self.robot} {self.stream}: {self.text}"


class Trace:
    """Notes what happens in a run; ``clock`` gives virtual seconds once the world is made."""

    def __init__(self) -> None:
        self.lines: list[Line] = []
        self.clock: Callable[[], float] = lambda: 0.0
        self._whole: dict[str, str] = {}

    def note(self, stream: str, robot: int, text: str) -> None:
        """One thing that happens now."""
        self.lines.append(Line(self.clock(), stream, robot, text))

    def noted(
        self, name: str, call: Callable[..., Any], stream: str, robot: int
    ) -> Callable[..., Any]:
        """The same call, noted with all its arguments by name before it is made."""
        signature = inspect.signature(call)

        def note_and_call(*args: Any, **kwargs: Any) -> Any:
            given = signature.bind(*args, **kwargs)
            given.apply_defaults()
            words = ", ".join(f"{key}={value!r}" for key, value in given.arguments.items())
            self.note(stream, robot, f"{name}({words})")
            return call(*args, **kwargs)

        return note_and_call

    def keep(self, report: str, tracks: list[FloatArray]) -> None:
        """What is known at the end: the report, and where each robot really drove."""
        driven = b"".join(np.ascontiguousarray(track).tobytes() for track in tracks)
        self._whole = {"driven": _hash(driven), "report": _hash(report.encode())}

    def hashes(self) -> dict[str, str]:
        """The hash of each part by its name."""
        found = {}
        for stream in STREAMS:
            lines = "\n".join(str(line) for line in self.lines if line.stream == stream)
            found[stream] = _hash(lines.encode())
        return found | self._whole

    def by_block(self) -> str:
        """``BLOCK_CHARACTERS`` for each ``BLOCK`` of lines, of all that happened until its end."""
        so_far, parts = hashlib.sha256(), []
        for first in range(0, len(self.lines), BLOCK):
            so_far.update("\n".join(self.of_block(first // BLOCK)).encode())
            parts.append(so_far.hexdigest()[:BLOCK_CHARACTERS])
        return "".join(parts)

    def of_block(self, block: int) -> list[str]:
        """The lines of one block, as text."""
        return [str(line) for line in self.lines[block * BLOCK : (block + 1) * BLOCK]]


def first_difference(before: str, now: str) -> int | None:
    """The first block in which two runs differ by their `Trace.by_block`; None where none is."""
    step = BLOCK_CHARACTERS
    for at in range(0, max(len(before), len(now)), step):
        if before[at : at + step] != now[at : at + step]:
            return at // step
    return None


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:HASH_CHARACTERS]
