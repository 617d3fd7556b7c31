"""How a differential-drive robot really moves: slow motors, wrong wheels, slip, coarse encoders.

Wheels do not turn however slowly they are ordered to: an order in the dead zone does nothing, one
that sets out from rest has to overcome the stiction too, and orders may go in steps only.
The motors' controller regulates what the encoders measure; the wheels' true radii, and slip,
decide what becomes of it on the floor. Metres, radians, seconds; the random generator is
passed in.
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
    """Where the robot is."""

    x_m: float
    y_m: float
    heading_rad: float


@dataclass(frozen=True, slots=True)
class DriveModel:
    """The robot's body. ``*_scale`` is the true radius of a wheel over the nominal one.

    ``slip`` is the standard deviation of the part of each wheel's travel that is lost or
    gained, changing over about ``slip_time_s``; ``ticks_per_m`` is the encoders' resolution. A
    wheel that turns stops at orders below ``dead_zone_m_s``, and one at rest stays there up to an
    order that is larger by the part ``stiction``. Orders are rounded towards zero to whole
    ``step_m_s``; 0: to none.
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
        """The speed that an order makes a wheel aim at."""
        size = min(self.max_wheel_m_s, abs(order_m_s))
        if self.step_m_s > 0.0:
            size = math.floor(size / self.step_m_s + ROUNDING) * self.step_m_s
        if size < self.dead_zone_m_s * (1.0 + self.stiction if at_rest else 1.0):
            return 0.0
        return math.copysign(size, order_m_s)


class Drive:
    """The moving robot: :meth:`step` it in steps of at most a few milliseconds."""

    def __init__(self, model: DriveModel, pose: TruePose, rng: np.random.Generator) -> None:
        self.model = model
        self.pose = pose
        self.has_power = True
        """Whether the motors have; without it the wheels run down, whatever is ordered."""
        self._rng = rng
        self._speed = [0.0, 0.0]
        self._travel = [0.0, 0.0]
        self._slip = [0.0, 0.0]

    @property
    def encoders_m(self) -> tuple[float, float]:
        """The wheels' travel as the encoders count it, from the nominal radius."""
        ticks = self.model.ticks_per_m
        return (
            math.floor(self._travel[0] * ticks) / ticks,
            math.floor(self._travel[1] * ticks) / ticks,
        )

    @property
    def moving(self) -> bool:
        """Whether a wheel turns faster than 1 mm/s."""
        return max(abs(self._speed[0]), abs(self._speed[1])) > AT_REST_M_S

    def step(self, dt_s: float, wanted: WheelSpeeds) -> None:
        """Move for ``dt_s`` while the motors are told ``wanted``."""
        model = self.model
        blend = -math.expm1(-dt_s / model.lag_s)
        keep = math.exp(-dt_s / model.slip_time_s)
        kick = model.slip * math.sqrt(1.0 - keep * keep)
        ground = [0.0, 0.0]
        powered = wanted.powered and self.has_power
        for side, scale in enumerate((model.left_scale, model.right_scale)):
            at_rest = abs(self._speed[side]) < AT_REST_M_S
            target = model.driven(wanted[side], at_rest=at_rest) if powered else 0.0
            self._speed[side] += blend * (target - self._speed[side])
            if abs(self._speed[side]) < STANDS_M_S:
                self._speed[side] = 0.0
                continue
            self._slip[side] = keep * self._slip[side] + kick * float(self._rng.standard_normal())
            self._travel[side] += self._speed[side] * dt_s
            ground[side] = self._speed[side] * dt_s * scale * (1.0 - self._slip[side])
        travel = (ground[0] + ground[1]) / 2.0
        turn = (ground[1] - ground[0]) / model.track_m
        x, y, heading = self.pose
        middle = heading + turn / 2.0
        self.pose = TruePose(
            x + travel * math.cos(middle),
            y + travel * math.sin(middle),
            math.remainder(heading + turn, math.tau),
        )
