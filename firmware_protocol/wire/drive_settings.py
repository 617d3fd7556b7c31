"""A robot's size and abilities in SI units, and as whole numbers for its firmware."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

WHEEL_MAX_MM_S: Final = 2_000
"""Highest speed of driving, and of turning: their eighths of mm/s together fit 16 bits."""

LEAST_WHEEL_MAX_MM_S: Final = 200
"""Wheels that turn only above this bring a robot to no place."""


@dataclass(frozen=True, slots=True)
class DriveSettings:
    """A robot's size and abilities.

    Every value > 0, but ``least_wheel_m_s`` may be 0. The firmware clips to a track of 1 m, a speed
    of 2 m/s, turning that gives the wheels 2 m/s, 15 rad/s2, 8 m/s2, lookahead of 1 m and 0.5 s, a
    deviation of 2 m, and a least speed of 0.2 m/s.
    """

    track_m: float = 0.12
    max_speed_m_s: float = 0.5
    acceleration_m_s2: float = 0.5
    lateral_m_s2: float = 0.6
    max_turn_rad_s: float = 2.5
    turn_acceleration_rad_s2: float = 8.0
    lookahead_m: float = 0.04
    lookahead_s: float = 0.15
    max_deviation_m: float = 0.15
    least_wheel_m_s: float = 0.01
    """The slowest that a wheel at rest is sure to turn; slower orders become pulses of it. Pulses
    of 10 mm/s (``CRAWL``) turn a robot with wheels 120 mm apart by half of its heading's tolerance:
    they cost nothing."""

    def whole_numbers(self) -> tuple[int, ...]:
        """``cw_settings`` of the firmware: um, then mm, mrad and ms, each in its range."""
        track_um = max(10_000, min(1_000_000, round(self.track_m * 1e6)))
        thousandths = (
            (self.max_speed_m_s, WHEEL_MAX_MM_S),
            (self.acceleration_m_s2, 8_000),
            (self.lateral_m_s2, 8_000),
            (self.max_turn_rad_s, min(8_000, WHEEL_MAX_MM_S * 20_000 // (track_um // 100))),
            (self.turn_acceleration_rad_s2, 15_000),
            (self.lookahead_m, 1_000),
            (self.lookahead_s, 500),
            (self.max_deviation_m, 2_000),
        )
        least_mm_s = max(0, min(LEAST_WHEEL_MAX_MM_S, round(self.least_wheel_m_s * 1e3)))
        others = (max(1, min(most, round(value * 1e3))) for value, most in thousandths)
        return track_um, *others, least_mm_s
