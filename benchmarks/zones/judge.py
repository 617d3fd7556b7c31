"""Violations of zones on true tracks, by plain geometry that shares nothing with the planner.

A track is (n, 4): seconds, x, y, heading; a robot is a disc. What is allowed beyond a rule is what
camera and wheels cannot do better, see the constants.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from navigation.config.zones import ZoneSection
from planner.scene import FloatArray

INTO_M: Final = 0.005
"""How far a body may reach into a keep-out zone: chosen, the camera's error."""
FASTER: Final = 1.05
"""By how much a slow zone's speed may be passed, and by this many m/s besides: chosen, the true
wheels are 1 % wrong, and speed is a difference of noisy places."""
FASTER_M_S: Final = 0.005
BACK_M: Final = 0.03
"""Progress against a one-way zone: chosen, a robot that turns on the spot drifts by less."""
SAME_M: Final = 1e-9
"""Distances that differ by less are equal: chosen, far above rounding."""
STANDS_S: Final = 0.5
"""A robot without motion for so long waits: chosen, twice what the program calls rest."""
STANDS_M_S: Final = 0.002
STANDS_RAD_S: Final = 0.02
REACTS_S: Final = 1.0
"""From a zone's drawing until robots act on it: chosen, one at full speed needs 0.5 s to stop."""
REPLANNED_S: Final = 3.0
"""A stop for a zone that was just drawn lasts no longer: chosen, the time limit of one search."""


@dataclass(frozen=True, slots=True)
class Violation:
    """A broken rule: the zone, the robot, when, and by how much."""

    zone: str
    kind: str
    robot: str
    time_s: float
    amount: float


def depth_m(zone: ZoneSection, points: FloatArray) -> FloatArray:
    """Depth (n,) of points (n, 2) in a zone's area, negative outside: distance to its border."""
    if zone.circle is not None:
        x, y, radius = zone.circle
        return radius - np.hypot(points[:, 0] - x, points[:, 1] - y)
    if zone.line is not None and zone.width_m is not None:
        least = np.full(len(points), np.inf)
        for a, b in pairwise(np.array(zone.line)):
            least = np.minimum(least, _to_segment(points, a, b))
        return 0.5 * zone.width_m - least
    assert zone.polygon is not None
    ring = np.array(zone.polygon)
    least, inside = np.full(len(points), np.inf), np.zeros(len(points), np.bool_)
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        least = np.minimum(least, _to_segment(points, a, b))
        crosses = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
        rise = b[1] - a[1] if b[1] != a[1] else math.inf
        inside ^= crosses & (points[:, 0] < (b[0] - a[0]) * (points[:, 1] - a[1]) / rise + a[0])
    return np.where(inside, least, -least)


def _to_segment(points: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    step = b - a
    share = np.clip((points - a) @ step / float(step @ step), 0.0, 1.0)
    away: FloatArray = np.hypot(*(points - a - share[:, None] * step).T)
    return away


def violations(
    zone: ZoneSection,
    robot: str,
    radius_m: float,
    track: FloatArray,
    begins_s: float,
    drawn_s: Collection[float] = (),
) -> list[Violation]:
    """All violations of one zone by one robot from a time on.

    A robot that stops for another zone, drawn at one of ``drawn_s``, may stand where it is until
    it has a plan again.
    """
    if zone.robots and robot not in zone.robots:
        return []
    track = track[track[:, 0] >= begins_s]
    if len(track) < 2:
        return []
    depth = depth_m(zone, track[:, 1:3])
    steps, lasts = np.diff(track[:, 1:3], axis=0), np.maximum(np.diff(track[:, 0]), 1e-9)
    found: list[Violation] = []

    def note(row: int, amount: float) -> None:
        found.append(Violation(zone.name, zone.kind, robot, float(track[row, 0]), amount))

    if zone.kind == "keep_out":
        _keep_out(depth + radius_m, note)
    if zone.speed_m_s is not None:
        speed = np.hypot(*steps.T) / lasts
        speed = np.convolve(speed, np.ones(5) / 5, mode="same")  # 50 ms: as a person would see it
        allowed = zone.speed_m_s * FASTER + FASTER_M_S
        over = np.where(depth[1:] + radius_m > INTO_M, speed - allowed, -1.0)
        if over.max() > 0.0:
            note(int(over.argmax()) + 1, float(over.max()))
    if zone.kind == "one_way":
        against = _against(zone, track[1:, 1:3], steps, depth[1:])
        if against > BACK_M:
            note(len(track) - 1, against)
    if zone.kind == "wait":
        _waiting(track, depth + radius_m, drawn_s, note)
    return found


def _keep_out(into: FloatArray, note: object) -> None:
    """A robot that begins inside may leave, and not come back or go deeper."""
    assert callable(note)
    outside = np.flatnonzero(into <= 0.0)
    if into[0] > 0.0:
        leaving = into[: outside[0]] if len(outside) else into
        deeper = leaving - np.minimum.accumulate(leaving)
        if deeper.max() > BACK_M:
            note(int(deeper.argmax()), float(deeper.max()))
        if not len(outside):
            return
    after = into[outside[0] :] if into[0] > 0.0 else into
    if after.max() > INTO_M:
        note(int(after.argmax()), float(after.max()))


def _against(zone: ZoneSection, points: FloatArray, steps: FloatArray, depth: FloatArray) -> float:
    """Longest progress against the line's direction inside."""
    assert zone.line is not None
    line = np.array(zone.line)
    away = np.array([_to_segment(points, a, b) for a, b in pairwise(line)])
    units = np.array([(b - a) / np.hypot(*(b - a)) for a, b in pairwise(line)])
    # beyond a corner both pieces are equally near: the first counts
    nearest = (away <= away.min(axis=0) + SAME_M).argmax(axis=0)
    along = (steps * units[nearest]).sum(axis=1)
    longest = total = 0.0
    for step, deep in zip(along.tolist(), depth.tolist(), strict=True):
        total = max(total - step, 0.0) if deep > INTO_M else 0.0
        longest = max(longest, total)
    return longest


def _waiting(track: FloatArray, into: FloatArray, drawn_s: Collection[float], note: object) -> None:
    """A robot that begins inside may stay where it is until it begins to drive."""
    assert callable(note)
    times, lasts = track[:, 0], np.maximum(np.diff(track[:, 0]), 1e-9)
    speed = np.hypot(*np.diff(track[:, 1:3], axis=0).T) / lasts
    turns = np.abs(np.angle(np.exp(1j * np.diff(track[:, 3])))) / lasts
    still = (speed < STANDS_M_S) & (turns < STANDS_RAD_S) & (into[1:] > INTO_M)
    moved = into[0] <= INTO_M
    since: float | None = None
    for k, stands in enumerate(still.tolist(), 1):
        moved |= not stands and speed[k - 1] > STANDS_M_S
        since = None if not stands or not moved else since or float(times[k])
        if since is None:
            continue
        stops = any(0.0 <= since - drawn <= REACTS_S for drawn in drawn_s)
        if times[k] - since > (REPLANNED_S if stops else STANDS_S):
            note(k, float(times[k] - since))
            return
