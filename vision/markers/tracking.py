"""A track from sightings: a gate against impossible jumps and a filter for the velocity.

Rules and units
- Metres, radians, seconds; time comes with the sightings. Headings are unwrapped inside.
- Reported position and heading are the measured ones: a filter would add lag. The velocity comes
  from a Kalman filter of constant velocity with white acceleration, one an axis.
- A new track needs ``confirm`` consistent sightings. A sighting out of reach is refused;
  ``confirm`` consistent ones in a row restart the track there: the robot was carried.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

Pose = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class TrackLimits:
    """Limits of a robot's motion between two sightings.

    ``slack_m`` and ``slack_rad`` allow for noise; ``position_noise_m`` and ``heading_noise_rad``
    are a sighting's standard deviations, the accelerations the motion's. A track unseen for
    ``forget_s`` must be confirmed again.
    """

    max_speed_m_s: float = 2.0
    max_turn_rate_rad_s: float = 12.0
    slack_m: float = 0.03
    slack_rad: float = 0.3
    position_noise_m: float = 0.0005
    heading_noise_rad: float = 0.002
    acceleration_m_s2: float = 1.0
    angular_acceleration_rad_s2: float = 6.0
    confirm: int = 2
    forget_s: float = 2.0


@dataclass(frozen=True, slots=True)
class Velocity:
    """Metres a second in the arena's axes, radians a second counter-clockwise."""

    vx: float = 0.0
    vy: float = 0.0
    turn_rate_rad_s: float = 0.0


class VelocityFilter:
    """Kalman filter of (value, rate) for one axis, with irregular steps.

    Bar-Shalom, Estimation with applications to tracking and navigation (2001), 6.3.
    """

    def __init__(self, noise: float, acceleration: float) -> None:
        self._variance = noise * noise
        self._power = acceleration * acceleration
        self.value = 0.0
        self.rate = 0.0
        self._pvv = self._pvr = self._prr = 0.0

    def start(self, value: float, rate_spread: float) -> None:
        """Begin at a value with an unknown rate of about ``rate_spread``."""
        self.value, self.rate = value, 0.0
        self._pvv, self._pvr, self._prr = self._variance, 0.0, rate_spread * rate_spread

    def update(self, value: float, dt_s: float) -> None:
        """Take in a value measured ``dt_s`` > 0 after the last one."""
        q = self._power
        predicted = self.value + self.rate * dt_s
        pvv = self._pvv + dt_s * (2.0 * self._pvr + dt_s * self._prr) + q * dt_s**4 / 4.0
        pvr = self._pvr + dt_s * self._prr + q * dt_s**3 / 2.0
        prr = self._prr + q * dt_s * dt_s
        total = pvv + self._variance
        gain_value, gain_rate = pvv / total, pvr / total
        error = value - predicted
        self.value = predicted + gain_value * error
        self.rate += gain_rate * error
        self._pvv = (1.0 - gain_value) * pvv
        self._pvr = (1.0 - gain_value) * pvr
        self._prr = prr - gain_rate * pvr


class MarkerTrack:
    """One robot's track. ``offer`` each sighting; report only what it returns."""

    def __init__(self, limits: TrackLimits) -> None:
        self.limits = limits
        self.last_s: float | None = None
        self.refused = 0
        """Impossible jumps in a row."""
        self._pose: Pose | None = None
        self._x = VelocityFilter(limits.position_noise_m, limits.acceleration_m_s2)
        self._y = VelocityFilter(limits.position_noise_m, limits.acceleration_m_s2)
        self._turn = VelocityFilter(limits.heading_noise_rad, limits.angular_acceleration_rad_s2)
        self._candidate: tuple[Pose, float] | None = None
        self._votes = 0

    @property
    def velocity(self) -> Velocity:
        """Velocity at the last believed sighting; zero without one."""
        if self._pose is None:
            return Velocity()
        return Velocity(self._x.rate, self._y.rate, self._turn.rate)

    def offer(self, pose: Pose, time_s: float) -> Velocity | None:
        """Take a sighting: the velocity there if believed, None if not (yet).

        None if not newer than the last.
        """
        if self.last_s is not None and time_s <= self.last_s:
            return None
        if self._pose is not None and self.last_s is not None:
            dt_s = time_s - self.last_s
            if dt_s <= self.limits.forget_s and self._reachable(self._pose, pose, dt_s):
                return self._accept(pose, time_s, dt_s)
            self.refused += dt_s <= self.limits.forget_s
        return self._vote(pose, time_s)

    def predict(self, time_s: float) -> Pose | None:
        """The robot's expected pose, at most ``forget_s`` after the last sighting."""
        if self._pose is None or self.last_s is None:
            return None
        dt_s = time_s - self.last_s
        if not 0.0 <= dt_s <= self.limits.forget_s:
            return None
        x, y, heading = self._pose
        return (
            x + self._x.rate * dt_s,
            y + self._y.rate * dt_s,
            wrap(heading + self._turn.rate * dt_s),
        )

    def _vote(self, pose: Pose, time_s: float) -> Velocity | None:
        before = self._candidate
        self._candidate = (pose, time_s)
        fits = (
            before is not None
            and 0.0 < time_s - before[1] <= self.limits.forget_s
            and self._reachable(before[0], pose, time_s - before[1])
        )
        self._votes = self._votes + 1 if fits else 1
        if self._votes < self.limits.confirm:
            return None
        self._start(pose, time_s)
        return Velocity()

    def _start(self, pose: Pose, time_s: float) -> None:
        limits = self.limits
        self._x.start(pose[0], limits.max_speed_m_s / 2.0)
        self._y.start(pose[1], limits.max_speed_m_s / 2.0)
        self._turn.start(pose[2], limits.max_turn_rate_rad_s / 2.0)
        self._settle(pose, time_s)

    def _accept(self, pose: Pose, time_s: float, dt_s: float) -> Velocity:
        self._x.update(pose[0], dt_s)
        self._y.update(pose[1], dt_s)
        # the filter's heading runs on past pi: give it the nearest turn
        heading = self._turn.value
        self._turn.update(heading + wrap(pose[2] - heading), dt_s)
        self._settle(pose, time_s)
        return Velocity(self._x.rate, self._y.rate, self._turn.rate)

    def _settle(self, pose: Pose, time_s: float) -> None:
        self._pose, self.last_s = pose, time_s
        self.refused, self._votes, self._candidate = 0, 0, None

    def _reachable(self, a: Pose, b: Pose, dt_s: float) -> bool:
        limits = self.limits
        moved = math.hypot(b[0] - a[0], b[1] - a[1])
        turned = abs(wrap(b[2] - a[2]))
        return (
            moved <= limits.slack_m + limits.max_speed_m_s * dt_s
            and turned <= limits.slack_rad + limits.max_turn_rate_rad_s * dt_s
        )


def wrap(angle_rad: float) -> float:
    """The same angle in (-pi, pi]."""
    turned = math.remainder(angle_rad, math.tau)
    return math.pi if turned == -math.pi else turned
