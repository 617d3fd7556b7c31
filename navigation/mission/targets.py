"""Waypoints on the wire from a timed trajectory.

The robot turns on the spot by itself, so waypoints at one place become one target; it rests where
the trajectory does. The first waypoint, its own place, is not sent. Metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Final

import numpy as np

from firmware_protocol.wire.messages import Waypoint, WaypointFlag
from planner.path import Path, TimedWaypoint, Trajectory
from planner.zones.rules import Rules

LONGEST_DWELL_S = 25.0
"""Longest stay at one waypoint (the wire's limit is 25.5 s); a longer one is several at one
place."""

STEERED_RAD: Final = 0.2
"""The reference robot turns standing for more (``TURN_STANDING`` of its follower)."""


@dataclass(frozen=True, slots=True)
class Target:
    """The robot's next place; ``station`` counts along the path's stations, 0 the start.

    ``heading_rad`` is None if any will do; the robot comes to rest if ``stops``.
    """

    x_m: float
    y_m: float
    speed_m_s: float
    stops: bool
    heading_rad: float | None = None
    dwell_s: float = 0.0
    station: int | None = None


def drop_steered_heading(path: Path) -> Path:
    """Drop the start's heading if it is within ``STEERED_RAD`` of the path's direction.

    The camera's headings never match the path's exactly, and a robot that cannot turn on the spot
    steers such a difference away while it drives.
    """
    heading_rad = path.headings_rad[0]
    ahead = np.flatnonzero(np.any(path.points != path.points[0], axis=1))
    if heading_rad is None or not len(ahead):
        return path
    dx, dy = path.points[ahead[0]] - path.points[0]
    off_rad = math.remainder(math.atan2(dy, dx) - heading_rad, math.tau)
    if abs(off_rad) > STEERED_RAD:
        return path
    return replace(path, headings_rad=(None, *path.headings_rad[1:]))


def targets_of(path: Path, trajectory: Trajectory) -> tuple[Target, ...]:
    """Targets after the start; at least one, even for a robot that is there."""
    groups = [list(g) for _, g in groupby(trajectory.waypoints, key=lambda w: (w.x, w.y))]
    return tuple(_targets(path, groups[1:] or groups[-1:]))


def _targets(path: Path, groups: list[list[TimedWaypoint]]) -> Iterator[Target]:
    for group in groups:
        here = group[-1]
        station = next((w.station for w in group if w.station is not None), None)
        stops = here.speed == 0.0
        heading = path.headings_rad[station] if station is not None and stops else None
        target = Target(here.x, here.y, here.speed, stops, heading, 0.0, None)
        left_s = sum(w.dwell_s for w in group)
        while left_s > LONGEST_DWELL_S:
            yield replace(target, dwell_s=LONGEST_DWELL_S)
            left_s -= LONGEST_DWELL_S
        yield replace(target, dwell_s=left_s, station=station)


def to_wire(targets: tuple[Target, ...]) -> list[Waypoint]:
    """Targets as the protocol's waypoints."""
    return [
        Waypoint(
            t.x_m,
            t.y_m,
            t.speed_m_s,
            t.heading_rad,
            dwell_s=t.dwell_s,
            flags=WaypointFlag.STOP if t.stops else WaypointFlag.NONE,
        )
        for t in targets
    ]


def within_caps(
    start: tuple[float, float], targets: Sequence[Target], rules: Rules
) -> tuple[Target, ...]:
    """Targets no faster than zones allow on the pieces before and after each.

    A robot keeps to the faster end of a piece. Between two stops that would be its own highest
    speed, so the second gets the zone's, and remains a stop.
    """
    if all(one.zone.speed is None for one in rules.grounds):
        return tuple(targets)
    caps = rules.caps(np.array([start, *((t.x_m, t.y_m) for t in targets)]))
    beside = np.minimum(caps, np.append(caps[1:], np.inf)).tolist()
    limited, before = [], 0.0
    for one, cap, least in zip(targets, caps.tolist(), beside, strict=True):
        speed = min(one.speed_m_s, least)
        if before == speed == 0.0 and math.isfinite(cap):
            speed = least
        limited.append(replace(one, speed_m_s=speed))
        before = speed
    return tuple(limited)
