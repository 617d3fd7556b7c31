"""True places of obstacles and robots, known only to a simulation.

The report judges a run by them; nothing that drives the robot reads them. Metres, radians, seconds
of the world's clock.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from navigation.simulator.arena import SimulatedArena
from navigation.simulator.drive_model import TruePose
from navigation.simulator.happenings import ScriptedTrack
from planner.scene import FloatArray


class TrueRobot(Protocol):
    """A simulated robot, seen from outside."""

    def pose(self) -> TruePose:
        """Present pose."""

    def track(self) -> FloatArray:
        """Track so far: (n, 4) of the clock's seconds, x_m, y_m, heading_rad."""


@dataclass(slots=True)
class Truth:
    """The driven robot, and arena and other robots over the time since ``began_s``.

    ``arenas``: each from its time after the beginning; the first from 0.
    """

    arenas: list[tuple[float, SimulatedArena]]
    robot: TrueRobot
    others: Mapping[int, tuple[ScriptedTrack, float]] = field(default_factory=dict)
    """By marker id: the track, and the radius of the body."""
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

    def others_clearance(self, track: FloatArray) -> float:
        """Least distance of a track's centre from another robot's body at the time."""
        gaps = [
            math.dist((x, y), scripted.pose(time_s - self.began_s)[:2]) - radius_m
            for scripted, radius_m in self.others.values()
            for time_s, x, y, _ in track
        ]
        return min(gaps, default=math.inf)
