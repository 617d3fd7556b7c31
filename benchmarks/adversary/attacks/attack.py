"""What an attack is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.adversary.rig import Needs, Rig

Act = Callable[[Rig], None]
"""Does it, while the robot drives; returns when there is no more to see but the stop."""


PLAIN = Needs()


@dataclass(frozen=True, slots=True)
class Attack:
    """``kind``: line, camera, process, driver, flood or disk. ``onset_m``: between which distances
    from its start the robot is when ``act`` begins. With ``before``, done before the program
    starts, the robot need not drive at all.
    """

    kind: str
    name: str
    act: Act
    needs: Needs = PLAIN
    onset_m: tuple[float, float] = (0.05, 0.5)
    before: Act | None = None
