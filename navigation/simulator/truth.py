"""True places of obstacles and robots, known only to a simulation.

The report judges a run by them; nothing that drives the robot reads them. Metres, radians, seconds
of the world's clock.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from navigation.simulator.arena import SimulatedArena
from navigation.simulator.drive_model import TruePose
from planner.scene import FloatArray


class TrueRobot(Protocol):
    """A simulated robot, seen from outside."""

    def pose(self) -> TruePose:
        """Present pose."""

    def track(self) -> FloatArray:
        """Track so far: (n, 4) of the clock's seconds, x_m, y_m, heading_rad."""


@dataclass(slots=True)
class Truth:
    """The driven robot, and the arena over the time since ``began_s``.

    ``arenas``: each from its time after the beginning; the first from 0.
    """

    arenas: list[tuple[float, SimulatedArena]]
    robot: TrueRobot
    began_s: float = 0.0

    @property
    def arena(self) -> SimulatedArena:
        """Arena at the beginning."""
        return self.arenas[0][1]

    def track(self) -> FloatArray:
        """Track of the robot: (n, 4) of the clock's seconds, x_m, y_m, heading_rad."""
        return self.robot.track()

    def track_clearance(self, track: FloatArray) -> float:
        """Least distance of a track (n, 4) from the obstacles of the time."""
        least = math.inf
        ends = [*(from_s for from_s, _ in self.arenas[1:]), math.inf]
        for (from_s, arena), until_s in zip(self.arenas, ends, strict=True):
            since = track[:, 0] - self.began_s
            part = track[(since >= from_s) & (since < until_s), 1:3]
            if len(part):
                least = min(least, arena.track_clearance(part)[0])
        return least
