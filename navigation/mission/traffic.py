"""Other robots: moving obstacles, seen by their markers, never part of the scene.

- A robot is its body's disc, extrapolated with its velocity for our robot's stopping time.
- A robot not seen for ``LOST_S`` is assumed to be at rest where it was last seen.
- A robot that comes no nearer than it is now is no reason to hold: otherwise two robots at rest
  side by side would never move.

Metres, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from planner.borders.polyline import distances_to_polyline
from planner.scene import FloatArray, Vec

LOST_S: Final = 0.5
STANDING_M_S: Final = 0.04
"""A slower robot is at rest: about the noise of its velocity."""
LOOK_AHEAD_M: Final = 1.0
"""Distance along the path within which a robot at rest makes ours plan another path."""
REACTION_S: Final = 0.5
"""From the exposure of a picture to wheels that brake, with a reserve."""
STEPS: Final = 8
NEARER_M: Final = 0.004
"""A gap that shrinks by less does not shrink: two poses' noise."""
ROOM: Final = 1.5
"""A plan keeps this times the distance at which the robot holds."""
AHEAD_S: Final = 1.0
"""A plan also avoids where another robot will be after this time."""


@dataclass(frozen=True, slots=True)
class Mover:
    """Another robot, and the age of its sighting."""

    id: int
    x_m: float
    y_m: float
    vx_m_s: float
    vy_m_s: float
    radius_m: float
    age_s: float = 0.0

    @property
    def stands(self) -> bool:
        """True if it is at rest, or assumed to be."""
        return self.age_s > LOST_S or math.hypot(self.vx_m_s, self.vy_m_s) < STANDING_M_S

    def places(self, horizon_s: float) -> FloatArray:
        """Its centre over the next seconds, (n, 2)."""
        if self.stands:
            return np.array([(self.x_m, self.y_m)])
        t = np.linspace(0.0, horizon_s, STEPS)
        return np.column_stack([self.x_m + t * self.vx_m_s, self.y_m + t * self.vy_m_s])


@dataclass(frozen=True, slots=True)
class TrafficLimits:
    """Our robot's size and abilities, and its distance from others."""

    radius_m: float
    speed_m_s: float
    acceleration_m_s2: float
    keep_m: float

    @property
    def stop_s(self) -> float:
        """Time it takes to stop."""
        return REACTION_S + self.speed_m_s / self.acceleration_m_s2

    @property
    def stop_m(self) -> float:
        """Distance it covers meanwhile."""
        return self.speed_m_s * (REACTION_S + 0.5 * self.speed_m_s / self.acceleration_m_s2)


@dataclass(frozen=True, slots=True)
class Encounter:
    """Another robot in the way: hold (``stands`` False), or plan around it."""

    id: int
    stands: bool
    sentence: str


def encounter(
    here: Vec, way: FloatArray, movers: Sequence[Mover], limits: TrafficLimits
) -> Encounter | None:
    """Most urgent of the other robots; None if all is clear.

    ``way`` (n, 2) is the rest of the path from ``here``; with no rows our robot stays at rest.
    """
    if not movers:
        return None
    soon = cut(here, way, limits.stop_m)
    later = cut(here, way, LOOK_AHEAD_M)
    for mover in movers:
        gap_m = _gap(here, soon, mover, limits, limits.stop_s)
        if gap_m is not None:
            what = "blocks the path" if mover.stands else "comes too near"
            return Encounter(mover.id, mover.stands, f"robot {mover.id} {what}{_leaves(gap_m)}")
    for mover in movers:
        gap_m = _gap(here, later, mover, limits, 0.0) if mover.stands else None
        if gap_m is not None:
            sentence = f"robot {mover.id} blocks the path{_leaves(gap_m)}"
            return Encounter(mover.id, True, sentence)
    return None


def _leaves(gap_m: float) -> str:
    return f": it leaves {max(gap_m, 0.0):.3f} m"


def _gap(
    here: Vec, way: FloatArray, mover: Mover, limits: TrafficLimits, horizon_s: float
) -> float | None:
    """Least distance between both bodies if it is too small and shrinks, else None."""
    bodies_m = limits.radius_m + mover.radius_m
    now_m = math.dist(here, (mover.x_m, mover.y_m)) - bodies_m
    least_m = float(distances_to_polyline(way, mover.places(horizon_s)).min()) - bodies_m
    return least_m if least_m < min(limits.keep_m, now_m - NEARER_M) else None


def cut(here: Vec, way: FloatArray, length_m: float) -> FloatArray:
    """First metres of the path from ``here`` through its points, (n >= 1, 2)."""
    points = np.vstack([np.array(here), way.reshape(-1, 2)])
    steps = np.hypot(*np.diff(points, axis=0).T)
    gone = np.concatenate([[0.0], np.cumsum(steps)])
    last = int(np.searchsorted(gone, length_m))
    if last >= len(points):
        return points
    share = (length_m - gone[last - 1]) / steps[last - 1] if last else 0.0
    end = points[last - 1] + share * (points[last] - points[last - 1])
    return np.vstack([points[:last], end])


@dataclass(frozen=True, slots=True)
class Disc:
    """Place of a robot to keep clear of."""

    x_m: float
    y_m: float
    radius_m: float
    robot_id: int
    moves: bool
    """True if the robot will not stay there."""


def discs_to_avoid(here: Vec, movers: Sequence[Mover], limits: TrafficLimits) -> tuple[Disc, ...]:
    """Discs around other robots, now and soon, for a plan from ``here`` to avoid.

    Our robot is outside each: a disc too near shrinks, so that it can drive off.
    """
    return tuple(disc for mover in movers if (disc := _disc(here, mover, limits)) is not None)


def _disc(here: Vec, mover: Mover, limits: TrafficLimits) -> Disc | None:
    wanted_m = mover.radius_m + ROOM * limits.keep_m
    first, last = mover.places(AHEAD_S)[[0, -1]]
    room_m = math.dist(here, first) - limits.radius_m - NEARER_M
    center, reach_m = (first + last) / 2.0, float(np.hypot(*(last - first))) / 2.0
    if math.dist(here, center) - limits.radius_m - NEARER_M < wanted_m + reach_m:
        center, reach_m = first, 0.0
    radius_m = min(wanted_m + reach_m, room_m) if reach_m == 0.0 else wanted_m + reach_m
    if radius_m <= 0.0:
        return None
    return Disc(float(center[0]), float(center[1]), radius_m, mover.id, not mover.stands)
