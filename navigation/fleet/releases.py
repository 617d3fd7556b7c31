"""Released part of each promise, and the robots waited for.

A robot is given its targets up to the first gate that another robot has not passed. A robot has
passed a target if it reports so and the camera sees it there; without a promise it has passed
nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from navigation.fleet.request import Gate, Promise
from planner.scene import FloatArray
from planner.zones.rules import SPEED_SLACK, Rules


@dataclass(slots=True)
class Held:
    """A promise being kept, and its robot's progress."""

    promise: Promise
    executed: int = 0
    """Targets executed."""
    base: int = 0
    """Targets executed when the present plan began."""
    broken: bool = False
    """The robot will not drive the rest."""
    sent: int = 0
    """Targets that the robot may have been given."""
    errand: bool = False
    """The robot has not been given this errand yet."""

    @property
    def is_finished(self) -> bool:
        """True at the promise's end."""
        return self.executed >= len(self.promise.targets)


def breach_of_rest(rest: FloatArray, promise: Promise, executed: int, rules: Rules) -> str | None:
    """Sentence on a zone's rule that a promise breaks from its executed targets on, or None.

    ``rest`` (n, 2) begins at the robot. A gate in a no-waiting zone is a wait there.
    """
    if not rules.grounds:
        return None
    speeds = np.array([one.speed_m_s for one in promise.targets[executed:]])
    broken = rules.breach(rest) or rules.too_fast(rest[1:], speeds / SPEED_SLACK)
    if broken is not None:
        return broken
    for gate in promise.gates:
        x, y = promise.points[gate.before].tolist()
        for one in rules.of("wait"):
            if gate.before > executed and rules.is_held_by(one, (x, y)):
                return f"may wait in {one.zone}"
    return None


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
