"""Released part of each promise, and the robots waited for.

Rules
- A robot is given its targets up to the first gate that another robot has not passed.
- A robot has passed a target if it reports so and the camera sees it there.
- A robot whose promise is unknown has passed nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from navigation.fleet.request import Gate, Promise


@dataclass(slots=True)
class Held:
    """A promise being kept, and its robot's progress."""

    promise: Promise
    executed: int = 0
    """Number of the promise's targets that were executed."""
    base: int = 0
    """Number of them that were executed when the plan that is driven now began."""
    broken: bool = False
    """The robot will not drive the rest."""
    sent: int = 0
    """Number of the targets that the robot may have been given."""
    errand: bool = False
    """The robot has no mission of its own there, and has not been given this one yet."""

    @property
    def is_finished(self) -> bool:
        """True if the robot is at its end."""
        return self.executed >= len(self.promise.targets)


class Release(NamedTuple):
    """Number of targets that may be sent, and the gate that ends them."""

    targets: int
    gate: Gate | None


def release_of(name: str, held: Mapping[str, Held]) -> Release:
    """Part of its promise that the robot may drive now."""
    promise = held[name].promise
    count, closed = len(promise.targets), None
    for gate in promise.gates:
        other = held.get(gate.other)
        passed = -1 if other is None else other.executed
        if passed < gate.passed and gate.before < count:
            count, closed = gate.before, gate
    return Release(count, closed)
