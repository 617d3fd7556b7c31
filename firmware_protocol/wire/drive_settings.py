"""What the robot is and can do, in SI units, and the whole numbers that its firmware has of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple, Self

from firmware_protocol.wire.fixed_point import mrad

WHEEL_MAX_MM_S: Final = 2_000
"""Of speed and of turning, each: their eighths of mm/s fit 16 bits together."""

LEAST_WHEEL_MAX_MM_S: Final = 200
"""Wheels that do not turn below this cannot bring a robot to a place."""
PULSE_US: Final = 25_000
"""A wheel that is to turn more slowly than it can owes this much at its least speed when a pulse
begins, and nothing when it ends: so a pulse lasts three cycles, in which a wheel breaks loose."""
HEADING_TOLERANCE: Final = mrad(6)
AIM_MS: Final = 16
"""A little more than half of a pulse of three cycles. A heading that is nearer than half a pulse of
one wheel is the nearest that there is."""


@dataclass(frozen=True, slots=True)
class DriveSettings:
    """What the robot is and can do.

    Every value > 0, but for ``least_wheel_m_s``, which may be 0: its wheels turn however slowly
    they are ordered to. The firmware computes with a track up to 1 m, a speed up to 2 m/s, turning
    that gives the wheels no more than 2 m/s, 15 rad/s2, 8 m/s2, looking ahead by 1 m and 0.5 s,
    a deviation up to 2 m, and a least speed up to 0.2 m/s, and keeps to these where more is asked
    for.
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
    """The slowest that a wheel at rest is sure to turn; what is slower is driven in pulses of it.
    No robot is driven straight more slowly than 10 mm/s (``CRAWL``), and pulses of that turn one
    whose wheels are 120 mm apart by half of what its heading may be off: so it costs nothing."""

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


class DriveConstants(NamedTuple):
    """What the follower computes with; the same expressions stand in ``firmware/follower.c``.

    Lengths are counts of 64 um, speeds in eighths of mm/s unless their names say otherwise.
    """

    track: int
    max_speed_mm_s: int
    max_spin_mm_s: int
    min_spin: int
    brake_mm_s2: int
    spin_brake_mm_s2: int
    perimeter: int
    """Of a turn on the spot."""
    speed_per_cycle: int
    spin_per_cycle: int
    bend_limit: int
    lookahead: int
    lookahead_ms: int
    max_deviation: int
    angle_per_um: int
    """Turned for a micrometre that the wheels differ by."""
    turning_per_spin: int
    """256 times mrad/s for an eighth of mm/s of spin."""
    least_wheel: int
    """What is slower is driven in pulses of this."""
    heading_tolerance: int
    """How far from the heading that is asked for the robot may stand, 2**16 a turn."""

    @classmethod
    def of(cls, settings: DriveSettings) -> Self:
        """From SI units, by way of the firmware's own settings."""
        numbers = settings.whole_numbers()
        track_um, speed, acceleration, lateral, turn, turn_acceleration = numbers[:6]
        lookahead_mm, lookahead_ms, deviation_mm, least_mm_s = numbers[6:]
        hundredths = track_um // 100
        spin_brake = turn_acceleration * hundredths // 20_000
        angle_per_um = (683_565_276 + track_um // 2) // track_um
        return cls(
            track=track_um // 64,
            max_speed_mm_s=speed,
            max_spin_mm_s=turn * hundredths // 20_000,
            min_spin=hundredths // 128 + 1,
            brake_mm_s2=acceleration * 8 // 5,
            spin_brake_mm_s2=spin_brake,
            perimeter=hundredths * 31_416 // 6400,
            speed_per_cycle=acceleration * 4194 // 8000,
            spin_per_cycle=spin_brake * 4194 // 8000,
            bend_limit=lateral * (track_um // 2000) * 1024,
            lookahead=lookahead_mm * 1000 // 64,
            lookahead_ms=lookahead_ms,
            max_deviation=deviation_mm * 1000 // 64,
            angle_per_um=angle_per_um,
            turning_per_spin=64_000_000 // track_um,
            least_wheel=least_mm_s * 8,
            heading_tolerance=max(HEADING_TOLERANCE, least_mm_s * AIM_MS * angle_per_um >> 16),
        )
