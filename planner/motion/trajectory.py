"""Timed waypoints along a path: place, heading, speed and time.

- The waypoints lie on the path. The lines between them leave it by at most ``chord_tolerance`` and
  its clearance beyond the robot's radius, so they are as free of collisions.
- Corners slow the robot, or stop it and turn it on the spot (``stops_and_bends.py``).
- Between two stops the speed keeps its limits with bounded jerk (``speed_profile.py``).
- The robot stops at stations with a heading, to turn, or with a dwell.

Units are the scene's, seconds and radians; headings are in (-pi, pi] and in the coordinates' own
sense (``planner.path``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields, replace

from planner.borders.polyline import points_at
from planner.motion.speed_profile import plan_speed
from planner.motion.stops_and_bends import (
    Clearance,
    CutPath,
    SpeedLimits,
    Stop,
    Stretch,
    speed_cells,
)
from planner.path import Limits, Path, TimedWaypoint, Trajectory
from planner.scene import FloatArray
from planner.shared.angles import wrap_angle
from planner.shared.arguments import as_float, as_list, of_kind

HEADING_TOLERANCE_RAD = 1e-6
"""Headings nearer than this are equal: far below a robot's accuracy."""
MOST_WAYPOINTS = 1_000_000
"""A path that needs more is a mistake in the units of its limits."""


class TrajectoryError(ValueError):
    """A path that cannot be timed with these limits; the message says why."""


def default_limits(robot_radius: float) -> Limits:
    """Moderate limits for a differential drive of this radius: one diameter a second."""
    if not (math.isfinite(robot_radius) and robot_radius > 0.0):
        raise TrajectoryError(f"robot radius = {robot_radius:g}: must be > 0 and finite")
    r = robot_radius
    return Limits(
        speed=2.0 * r,
        acceleration=2.0 * r,
        lateral_acceleration=2.0 * r,
        angular_rate_rad_s=2.0,
        angular_acceleration_rad_s2=6.0,
        jerk=8.0 * r,
        spacing=4.0 * r,
        chord_tolerance=0.05 * r,
        slow_clearance=2.0 * r,
        slow_speed=0.5 * r,
    )


def time_path(
    path: Path,
    limits: Limits,
    *,
    clearance: Clearance | None = None,
    dwell_s: Sequence[float] = (),
    speed_limits: SpeedLimits | None = None,
) -> Trajectory:
    """Return timed waypoints along ``path`` that keep all ``limits``.

    ``clearance`` maps (n, 2) points to (n,) exact clearances, to slow between the path's points
    too; without it the path's own are interpolated. ``dwell_s`` has one entry per station, start
    and goal included; empty means none. ``speed_limits`` maps points (n, 2) and a reach (n,) around
    each to the highest speeds (n,) allowed there. Times never fall, and grow wherever place or
    heading changes. Raises :class:`TrajectoryError` on limits that are not > 0, dwells that are not
    >= 0, and if a robot that cannot turn on the spot would have to: for a station's heading, or in
    a bend tighter than its turning radius.
    """
    dwells = tuple(as_float("dwell_s", d) for d in as_list("dwell_s", dwell_s, "seconds"))
    if not (clearance is None or callable(clearance)):
        raise TypeError(f"clearance is a {type(clearance).__name__}: must be a function")
    _check(of_kind("path", path, Path), of_kind("limits", limits, Limits), dwells)
    dwells = dwells or (0.0,) * len(path.stations)
    track = CutPath(path, limits, clearance, dwells, speed_limits)
    clock = _Clock(limits)
    legs = track.legs()
    for leg in legs:
        if tight := track.too_tight(leg):
            x, y, radius = tight
            raise TrajectoryError(
                f"at ({x:g}, {y:g}) the path bends with a radius of {radius:.3g}, but"
                f" limits.turning_radius = {limits.turning_radius:g} and the robot cannot turn on"
                " the spot"
            )
    first = path.headings_rad[0]
    facing = next((float(leg.heading[0]) for leg in legs if len(leg.heading)), 0.0)
    clock.begin(track.points[0], first if first is not None else facing)
    for number, stop in enumerate(track.stops):
        if number > 0:
            clock.drive(legs[number - 1], track)
        clock.stand(stop)
    return clock.finish()


def _check(path: Path, limits: Limits, dwell_s: Sequence[float]) -> None:
    for item in fields(limits):
        if item.name == "turns_on_spot":
            continue
        value = as_float(f"limits.{item.name}", getattr(limits, item.name))
        if item.name == "turning_radius" and value == 0.0:
            continue
        if not (math.isfinite(value) and value > 0.0):
            raise TrajectoryError(f"limits.{item.name} = {value:g}: must be > 0 and finite")
    if len(dwell_s) not in (0, len(path.stations)):
        raise TrajectoryError(
            f"{len(dwell_s)} dwells for {len(path.stations)} stations: one each is needed"
        )
    if not all(math.isfinite(d) and d >= 0.0 for d in dwell_s):
        raise TrajectoryError(f"dwell_s = {list(dwell_s)}: must be >= 0 and finite")
    if len(path.points) == 0 or len(path.stations) < 2:
        raise TrajectoryError("a path needs a point and two stations, start and goal")
    if path.length > MOST_WAYPOINTS * limits.spacing:
        raise TrajectoryError(
            f"limits.spacing = {limits.spacing:g} on a path of length {path.length:g}: more than"
            f" {MOST_WAYPOINTS} waypoints"
        )


class _Clock:
    """A writer of waypoints that keeps the time."""

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.now_s = 0.0
        self.waypoints: list[TimedWaypoint] = []

    def begin(self, point: FloatArray, heading_rad: float) -> None:
        x, y = float(point[0]), float(point[1])
        self.waypoints.append(TimedWaypoint(x, y, wrap_angle(heading_rad), 0.0, 0.0))

    def stand(self, stop: Stop) -> None:
        """Turn to the stop's heading, if it has one, and dwell."""
        if stop.heading is not None:
            self._turn(stop.heading)
        last = self.waypoints[-1]
        if stop.station is not None:
            if last.station is None:
                self.waypoints.pop()
            marked = replace(
                last, time_s=self.now_s, station=stop.station, dwell_s=float(stop.dwell_s)
            )
            self.waypoints.append(marked)
        self.now_s += stop.dwell_s

    def drive(self, leg: Stretch, track: CutPath) -> None:
        """Turn into the leg's direction, then drive it from rest to rest."""
        if len(leg.lengths) == 0:
            return
        self._turn(float(leg.heading[0]))
        nodes = speed_cells(leg, self.limits.spacing)
        speed, gentle = track.speed_limits(leg, nodes)
        profile = plan_speed(nodes, speed, self.limits.acceleration, self.limits.jerk, gentle)
        at = track.waypoint_lengths(leg)
        times = profile.time_at(at)
        speeds = profile.speed(times)
        headings = leg.headings(at)
        points = points_at(leg.points, leg.lengths, at)
        speeds[-1] = 0.0
        rows = zip(at, points.tolist(), headings.tolist(), speeds.tolist(), times, strict=True)
        for length, (x, y), heading, speed, time in list(rows)[1:]:
            self.waypoints.append(
                TimedWaypoint(
                    x,
                    y,
                    wrap_angle(heading),
                    speed,
                    self.now_s + float(time),
                    leg.stations.get(float(length)),
                )
            )
        self.now_s += profile.duration_s

    def _turn(self, heading_rad: float) -> None:
        """Turn on the spot, the shorter way round, from rest to rest."""
        here = self.waypoints[-1]
        turn = abs(wrap_angle(heading_rad - here.heading_rad))
        if turn <= HEADING_TOLERANCE_RAD:
            return
        if not self.limits.turns_on_spot:
            raise TrajectoryError(
                f"at ({here.x:g}, {here.y:g}) the heading must change by"
                f" {math.degrees(turn):.3g} degrees, but the robot cannot turn on the spot"
            )
        self.now_s += turning_time(
            turn, self.limits.angular_rate_rad_s, self.limits.angular_acceleration_rad_s2
        )
        heading = wrap_angle(heading_rad)
        self.waypoints.append(TimedWaypoint(here.x, here.y, heading, 0.0, self.now_s))

    def finish(self) -> Trajectory:
        return Trajectory(tuple(self.waypoints), self.now_s)


def turning_time(turn_rad: float, rate: float, acceleration: float) -> float:
    """Seconds to turn on the spot by ``turn_rad`` >= 0, from rest to rest."""
    if turn_rad <= rate * rate / acceleration:
        return 2.0 * math.sqrt(turn_rad / acceleration)
    return turn_rad / rate + rate / acceleration
