"""The zones' rules for one robot: breaches by a path or a place, and the cost and speed along it.

- Inside means any of the body, a disc of the robot's radius; for one-way zones and lanes it means
  the centre.
- A path may cross a one-way zone, but not progress against the line's direction by more than
  ``AGAINST_DRIVEN`` radii, for new paths ``AGAINST``.
- Lengths, costs and directions are measured on pieces of ``PIECE`` radii, keep-out and no-waiting
  zones exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.scene import FloatArray, Scene, Vec
from planner.shared.figures import placed, sized
from planner.zones.zone import Zone, ZoneKind
from planner.zones.zone_ground import PathPieces, ZoneGround, cut

PIECE = 0.05
"""Longest piece, in radii: chosen, a border is missed by half of it."""
AGAINST = 0.02
"""Progress against a one-way zone, in radii, that is rounding on a planned path: chosen."""
AGAINST_DRIVEN = 0.1
"""The same on shared paths, whose pieces are judged one by one, and on a driven path's rest:
chosen, a twentieth of the body's width."""
SPEED_SLACK = 1.01
"""A target is no faster than a zone allows within this factor: chosen, the wire's rounding."""
RADIUS_ROUNDING = 1e-6
"""A clearance is the radius within this share of it: paths are certified to 1e-9 of the extent."""


@dataclass(frozen=True, slots=True)
class Rules:
    """Zones of a robot of ``radius``; ``speed`` is the fastest it drives, if known."""

    grounds: tuple[ZoneGround, ...]
    radius: float
    units: str
    speed: float | None = None

    def of(self, *kinds: ZoneKind) -> tuple[ZoneGround, ...]:
        """Return the zones of these kinds."""
        return tuple(one for one in self.grounds if one.zone.kind in kinds)

    @property
    def directed(self) -> bool:
        """True if a zone makes some free ground better than other."""
        return bool(self.of("one_way", "lane", "slow"))

    def is_held_by(self, one: ZoneGround, place: Vec) -> bool:
        """True if any of the body at the place is inside the zone."""
        distance = float(one.distances(np.array([place]))[0])
        return distance < self.radius * (1.0 - RADIUS_ROUNDING)

    def station_breach(self, name: str, place: Vec) -> str | None:
        """Why a robot must not be sent to a place, or None."""
        for one in self.of("keep_out", "wait"):
            if not self.is_held_by(one, place):
                continue
            distance = float(one.distances(np.array([place]))[0])
            at = f"{name} {placed(*place)}"
            if distance < 0.0:
                return f"{at} is in {one.zone}"
            gap = sized(distance, self.units, beside=self.radius)
            body = sized(self.radius, self.units, beside=distance)
            return f"{at} is {gap} from {one.zone}, nearer than the radius of {body}"
        return None

    def too_fast(self, points: FloatArray, speeds: FloatArray) -> str | None:
        """Sentence about a zone that allows less than ``speeds`` (n,) at points (n, 2), or None.

        Between two points the lower speed counts.
        """
        if not len(points):
            return None
        middles, between = 0.5 * (points[1:] + points[:-1]), np.minimum(speeds[1:], speeds[:-1])
        at, fast = np.concatenate([points, middles]), np.concatenate([speeds, between])
        for one in self.grounds:
            limit = one.zone.speed
            if limit is not None and (fast[one.distances(at) < self.radius] > limit).any():
                return f"is faster than {one.zone} allows"
        return None

    def permits(self, line: FloatArray, keep: float) -> bool:
        """True if a polyline (n, 2) keeps a distance from keep-out zones, and its directions."""
        least = keep * (1.0 - RADIUS_ROUNDING)
        apart = all(one.clearance(line) >= least for one in self.of("keep_out"))
        return apart and not self.against(line)

    def breach(self, line: FloatArray, *, stops: bool = True) -> str | None:
        """Sentence about the first rule that driving along a polyline (n, 2) breaks, or None.

        ``stops``: the robot stays at the line's end. A line that begins in a keep-out zone may
        leave it, and not come back.
        """
        for one in self.of("keep_out"):
            outside = self._after_leaving(one, line)
            if outside is None or one.clearance(outside) < self.radius * (1.0 - RADIUS_ROUNDING):
                return f"leads through {one.zone}"
        if stops:
            for one in self.of("wait"):
                if self.is_held_by(one, (float(line[-1, 0]), float(line[-1, 1]))):
                    return f"ends in {one.zone}"
        against = self.against(line, AGAINST_DRIVEN)
        return f"leads against {against[0].zone}" if against else None

    def _after_leaving(self, one: ZoneGround, line: FloatArray) -> FloatArray | None:
        """Line from where it leaves a zone that it begins in; None if it stays inside."""
        if not self.is_held_by(one, (float(line[0, 0]), float(line[0, 1]))):
            return line
        if len(line) < 2:
            return None
        pieces = self.pieces(line)
        ends = pieces.middles + 0.5 * pieces.steps
        out = np.flatnonzero(one.distances(ends) >= self.radius * (1.0 - RADIUS_ROUNDING))
        return ends[out[0] :] if len(out) else None

    def against(self, line: FloatArray, most: float = AGAINST) -> tuple[ZoneGround, ...]:
        """One-way zones that a polyline (n, 2) is driven against by more than ``most`` radii."""
        one_ways = self.of("one_way")
        if not one_ways or len(line) < 2:
            return ()
        pieces = self.pieces(line)
        return tuple(one for one in one_ways if _progress_against(one, pieces) > most * self.radius)

    def pieces(self, line: FloatArray) -> PathPieces:
        """Cut a line as the rules measure it."""
        return cut(line, PIECE * self.radius)

    def cost(self, line: FloatArray) -> float:
        """Length of a polyline (n, 2), weighted by lanes' costs and slow zones' times."""
        if len(line) < 2:
            return 0.0
        pieces = self.pieces(line)
        return float((self.factors(pieces.middles) * pieces.lengths).sum())

    def factors(self, points: FloatArray) -> FloatArray:
        """Cost (n,) of a unit of length at points (n, 2)."""
        factors = np.ones(len(points))
        for one in self.of("lane"):
            assert one.zone.cost is not None
            inside = one.distances(points) < 0.0
            factors[inside] = np.minimum(factors[inside], one.zone.cost)
        if self.speed is not None:
            factors *= self.speed / np.minimum(self.speed_limits(points, 0.0), self.speed)
        return factors

    def speed_limits(self, points: FloatArray, reach: FloatArray | float) -> FloatArray:
        """Highest speeds (n,) within ``reach`` (n,) of points (n, 2), infinite without a limit."""
        limits = np.full(len(points), np.inf)
        for one in self.grounds:
            if one.zone.speed is not None:
                inside = one.distances(points) < self.radius + reach
                limits[inside] = np.minimum(limits[inside], one.zone.speed)
        return limits

    def caps(self, line: FloatArray) -> FloatArray:
        """Highest speed (n - 1,) on each piece of a polyline (n, 2): exact."""
        caps = np.full(len(line) - 1, np.inf)
        pieces = [line[k : k + 2] for k in range(len(caps))]
        for one in self.grounds:
            if one.zone.speed is not None:
                inside = one.ground.clearances(pieces)[0] < self.radius
                caps[inside] = np.minimum(caps[inside], one.zone.speed)
        return caps

    def least_factor(self) -> float:
        """Least cost of a unit of length."""
        return min((one.zone.cost or 1.0 for one in self.of("lane")), default=1.0)


def rules_for(
    zones: Sequence[Zone], scene: Scene, radius: float, speed: float | None = None
) -> Rules:
    """Index zones in a scene's units and frame."""
    grounds = tuple(ZoneGround.of(zone, scene) for zone in zones)
    return Rules(grounds, radius, scene.units, speed)


def _progress_against(one: ZoneGround, pieces: PathPieces) -> float:
    inside = one.distances(pieces.middles) < 0.0
    if not inside.any():
        return 0.0
    along = (pieces.steps[inside] * one.directions(pieces.middles[inside])).sum(axis=1)
    return float(-along[along < 0.0].sum())


def listed_zones(zones: Sequence[ZoneGround]) -> str:
    """Names for a sentence: "keep-out zone 'desk' and one-way zone 'hall'"."""
    names = [str(one.zone) for one in zones]
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
