"""What the robot is and can do, in SI units, and the whole numbers that its firmware has of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Self


@dataclass(frozen=True, slots=True)
class DriveSettings:
    """What the robot is and can do.

    Every value > 0; the firmware takes a track up to 1 m, a turn acceleration up to 15 rad/s2,
    and the others up to 8 of their units, and keeps to these where more is asked for.
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

    def whole_numbers(self) -> tuple[int, ...]:
        """``cw_settings`` of the firmware: um, then mm, mrad and ms, each in its range."""
        thousandths = (
            (self.max_speed_m_s, 8_000),
            (self.acceleration_m_s2, 8_000),
            (self.lateral_m_s2, 8_000),
            (self.max_turn_rad_s, 8_000),
            (self.turn_acceleration_rad_s2, 15_000),
            (self.lookahead_m, 8_000),
            (self.lookahead_s, 8_000),
            (self.max_deviation_m, 8_000),
        )
        track_um = max(10_000, min(1_000_000, round(self.track_m * 1e6)))
        return track_um, *(max(1, min(most, round(value * 1e3))) for value, most in thousandths)


class DriveConstants(NamedTuple):
    """What the follower computes with; the same expressions stand in ``firmware/follower.c``."""

    track_eighths: int
    max_speed_mm_s: int
    max_spin_mm_s: int
    min_spin_q10: int
    brake_mm_s2: int
    spin_brake_mm_s2: int
    perimeter_um: int
    """Of a turn on the spot."""
    speed_per_cycle: int
    spin_per_cycle: int
    bend_limit: int
    lookahead_um: int
    lookahead_ms: int
    max_deviation_um: int
    angle_per_um: int
    """Turned for a micrometre that the wheels differ by."""
    turning_per_spin: int
    """65536 times mrad/s for 1/1024 mm/s of spin."""

    @classmethod
    def of(cls, settings: DriveSettings) -> Self:
        """From SI units, by way of the firmware's own settings."""
        numbers = settings.whole_numbers()
        track_um, speed, acceleration, lateral, turn, turn_acceleration = numbers[:6]
        lookahead_mm, lookahead_ms, deviation_mm = numbers[6:]
        hundredths = track_um // 100
        spin_brake = turn_acceleration * hundredths // 20_000
        return cls(
            track_eighths=track_um >> 3,
            max_speed_mm_s=speed,
            max_spin_mm_s=turn * hundredths // 20_000,
            min_spin_q10=hundredths,
            brake_mm_s2=acceleration * 8 // 5,
            spin_brake_mm_s2=spin_brake,
            perimeter_um=hundredths * 31_416 // 100,
            speed_per_cycle=acceleration * 4194 // 1000,
            spin_per_cycle=spin_brake * 4194 // 1000,
            bend_limit=lateral * (track_um // 2000) * 1024,
            lookahead_um=lookahead_mm * 1000,
            lookahead_ms=lookahead_ms,
            max_deviation_um=deviation_mm * 1000,
            angle_per_um=(683_565_276 + track_um // 2) // track_um,
            turning_per_spin=128_000_000 // track_um,
        )
