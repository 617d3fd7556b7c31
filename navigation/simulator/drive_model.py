"""True motion of a differential-drive robot: slow motors, wrong wheels, slip, coarse encoders.

The motors' controller regulates what the encoders measure; true wheel radii and slip decide the
motion on the floor. Metres, radians, seconds; the random generator is passed in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from firmware_protocol.robot.controller import WheelSpeeds

AT_REST_M_S: Final = 0.001
"""A slower wheel sticks: it has to break loose again."""
STANDS_M_S: Final = 1e-5
ROUNDING: Final = 1e-9
"""An order of a whole number of steps is that many, whatever its last bit says."""


class TruePose(NamedTuple):
    """Pose of the robot."""

    x_m: float
    y_m: float
    heading_rad: float


@dataclass(frozen=True, slots=True)
class DriveModel:
    """The robot's body. ``*_scale`` is a wheel's true radius over the nominal one.

    ``slip`` is the standard deviation of the share of each wheel's travel lost or gained, changing
    over about ``slip_time_s``. A turning wheel stops at orders below ``dead_zone_m_s``; one at rest
    needs an order larger by the share ``stiction``. Orders are rounded towards zero to whole
    ``step_m_s``; 0: not rounded.
    """

    track_m: float = 0.12
    lag_s: float = 0.05
    left_scale: float = 1.0
    right_scale: float = 1.0
    slip: float = 0.01
    slip_time_s: float = 0.3
    ticks_per_m: float = 4000.0
    max_wheel_m_s: float = 0.8
    dead_zone_m_s: float = 0.005
    stiction: float = 0.2
    step_m_s: float = 0.0

    def driven(self, order_m_s: float, *, at_rest: bool) -> float:
        """Return the speed that an ordered wheel aims at."""
        size = min(self.max_wheel_m_s, abs(order_m_s))
        if self.step_m_s > 0.0:
            size = math.floor(size / self.step_m_s + ROUNDING) * self.step_m_s
        if size < self.dead_zone_m_s * (1.0 + self.stiction if at_rest else 1.0):
            return 0.0
        return math.copysign(size, order_m_s)


class _Wheel:
    """A wheel that follows its motor and slips; keeps the constants of every step."""

    def __init__(self, model: DriveModel, scale: float, rng: np.random.Generator) -> None:
        self.speed_m_s = 0.0
        self.travel_m = 0.0
        """From the nominal radius."""
        self._slip = 0.0
        self._model, self._scale = model, scale
        self._standard_normal = rng.standard_normal
        self._dt_s = math.nan
        self._order_m_s = math.nan
        self._was_at_rest = False
        self._target_m_s = 0.0

    def _take_steps_of(self, dt_s: float) -> None:
        model = self._model
        self._dt_s = dt_s
        self._blend = -math.expm1(-dt_s / model.lag_s)
        self._keep = math.exp(-dt_s / model.slip_time_s)
        self._kick = model.slip * math.sqrt(1.0 - self._keep * self._keep)

    def turn(self, dt_s: float, order_m_s: float) -> float:
        """Turn for ``dt_s``; return the travel over the floor."""
        if dt_s != self._dt_s:
            self._take_steps_of(dt_s)
        speed_m_s = self.speed_m_s
        at_rest = -AT_REST_M_S < speed_m_s < AT_REST_M_S
        if order_m_s != self._order_m_s or at_rest is not self._was_at_rest:
            self._order_m_s, self._was_at_rest = order_m_s, at_rest
            self._target_m_s = self._model.driven(order_m_s, at_rest=at_rest)
        speed_m_s += self._blend * (self._target_m_s - speed_m_s)
        if -STANDS_M_S < speed_m_s < STANDS_M_S:
            self.speed_m_s = 0.0
            return 0.0
        self.speed_m_s = speed_m_s
        self._slip = slip = self._keep * self._slip + self._kick * self._standard_normal()
        travel_m = speed_m_s * dt_s
        self.travel_m += travel_m
        return travel_m * self._scale * (1.0 - slip)


class Drive:
    """The moving robot; :meth:`step` it by at most a few milliseconds."""

    def __init__(self, model: DriveModel, pose: TruePose, rng: np.random.Generator) -> None:
        self.model = model
        self.put_down(pose)
        self.has_power = True
        """Power of the motors; without it the wheels run down, whatever is ordered."""
        self._left = _Wheel(model, model.left_scale, rng)
        self._right = _Wheel(model, model.right_scale, rng)

    def put_down(self, pose: TruePose) -> None:
        """Put the robot there by hand; its wheels turn as before."""
        self.pose = pose._replace(heading_rad=math.remainder(pose.heading_rad, math.tau))

    @property
    def encoders_m(self) -> tuple[float, float]:
        """Travel of the wheels as the encoders count it, from the nominal radius."""
        ticks = self.model.ticks_per_m
        return (
            math.floor(self._left.travel_m * ticks) / ticks,
            math.floor(self._right.travel_m * ticks) / ticks,
        )

    @property
    def moving(self) -> bool:
        """True if a wheel turns faster than 1 mm/s."""
        return max(abs(self._left.speed_m_s), abs(self._right.speed_m_s)) > AT_REST_M_S

    def step(self, dt_s: float, wanted: WheelSpeeds) -> None:
        """Move for ``dt_s`` with the motors ordered to ``wanted``."""
        left_m_s, right_m_s, powered = wanted
        if not (powered and self.has_power):
            left_m_s = right_m_s = 0.0
        if left_m_s == right_m_s == self._left.speed_m_s == self._right.speed_m_s == 0.0:
            return
        left_m = self._left.turn(dt_s, left_m_s)
        right_m = self._right.turn(dt_s, right_m_s)
        if not (left_m or right_m):
            return  # both wheels are at rest: exactly zero
        travel_m = (left_m + right_m) / 2.0
        turn_rad = (right_m - left_m) / self.model.track_m
        x_m, y_m, heading_rad = self.pose
        middle_rad = heading_rad + turn_rad / 2.0
        self.pose = TruePose(
            x_m + travel_m * math.cos(middle_rad),
            y_m + travel_m * math.sin(middle_rad),
            math.remainder(heading_rad + turn_rad, math.tau),
        )
