"""The robot's abilities in whole numbers, and the follower's numbers.

Lengths are counts of 64 um, speeds eighths of mm/s unless named otherwise. ``follower.c`` has the
same expressions.
"""

HEADING_TOLERANCE = 62
"""6 mrad, 2^16 a turn."""
AIM_MS = 16
"""Above half of a pulse of three cycles: no heading is nearer than half a pulse of one wheel."""


class Settings:
    """The numbers, units and limits of ``settings.h``."""

    def __init__(
        self,
        track_um: int = 120000,
        max_speed_mm_s: int = 500,
        acceleration_mm_s2: int = 500,
        lateral_mm_s2: int = 600,
        max_turn_mrad_s: int = 2500,
        turn_acceleration_mrad_s2: int = 8000,
        lookahead_mm: int = 40,
        lookahead_ms: int = 150,
        max_deviation_mm: int = 150,
        least_wheel_mm_s: int = 10,
    ) -> None:
        hundredths = track_um // 100
        self.track_um = track_um
        self.max_speed_mm_s = max_speed_mm_s
        self.lookahead_ms = lookahead_ms
        self.lookahead = lookahead_mm * 1000 // 64
        self.max_deviation = max_deviation_mm * 1000 // 64
        self.track = track_um // 64
        self.perimeter = hundredths * 31416 // 6400
        """Travel of a wheel in a full turn on the spot."""
        self.min_spin = hundredths // 128 + 1
        self.max_spin_mm_s = max_turn_mrad_s * hundredths // 20000
        self.spin_brake_mm_s2 = turn_acceleration_mrad_s2 * hundredths // 20000
        self.brake_mm_s2 = acceleration_mm_s2 * 8 // 5
        self.speed_per_cycle = acceleration_mm_s2 * 4194 // 8000
        self.spin_per_cycle = self.spin_brake_mm_s2 * 4194 // 8000
        self.bend_limit = lateral_mm_s2 * (track_um // 2000)
        """In 1024."""
        self.turning_per_spin = 64000000 // track_um
        """256 times mrad/s for an eighth of mm/s of spin."""
        self.least_wheel = least_wheel_mm_s * 8
        """Least speed of a wheel; slower orders become pulses of it."""
        angle_per_um = (683565276 + track_um // 2) // track_um
        half_a_pulse = least_wheel_mm_s * AIM_MS * angle_per_um >> 16
        self.heading_tolerance = max(HEADING_TOLERANCE, half_a_pulse)
        """Tolerance of the final heading, 2^16 a turn."""
