"""Evidence of camera and wheels together, once a control cycle.

Metres, radians, seconds; immutable.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

FREE_LATENCY_S: Final = 0.15
"""Pictures up to so old are no reason to drive more slowly: a USB camera's 30 to 100 ms and a
picture's exposure. Before it is measured the latency is taken to lie between 0 and this."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """Evidence of the witnesses; the defaults are for a robot never seen to move."""

    parted: str | None = None
    """The sentence that says how camera and wheels differ, in the cycle that found it."""
    agreed_m: float = 0.0
    """Distance that the robot has driven since the beginning while both agreed; never falls."""
    wheels_rad: float = 0.0
    """Angle by which the wheels have turned the robot since the beginning, left positive."""
    camera_rad: float = 0.0
    """Angle by which the camera saw it turn in the same time, as far as it was seen."""
    driven_m: float = 0.0
    """Distance that the wheels have driven since the beginning, forwards and backwards."""
    slip_m: tuple[float, float] = (0.0, 0.0)
    """Place of the robot by the camera, less its place by the wheels, summed up since the
    beginning: it creeps with the odometry's errors and leaps when the robot is carried."""
    slip_rad: float = 0.0
    """The same of its heading, in (-pi, pi]."""
    wheels_stand: bool = True
    """True if the wheels were still in the robot's last report."""
    latency_s: float | None = None
    """Age of pictures when they arrive; None until a motion has shown it."""
    latency_error_s: float = FREE_LATENCY_S / 2.0
    """Possible error of the latency."""

    @property
    def longest_latency_s(self) -> float:
        """Latency to count on; before it is measured, one that needs no slower driving."""
        if self.latency_s is None:
            return FREE_LATENCY_S
        return self.latency_s + self.latency_error_s


NO_EVIDENCE: Final = Evidence()
"""Before anything was seen."""
