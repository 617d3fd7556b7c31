"""Evidence of camera and wheels together, once a control cycle.

Metres, radians, seconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

FREE_LATENCY_S: Final = 0.15
"""Age of pictures up to which driving is no slower: a USB camera's 30 to 100 ms and a picture's
exposure. Before it is measured the latency is taken to lie between 0 and this."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """Evidence of the witnesses; the defaults are for a robot never seen to move."""

    parted: str | None = None
    """Sentence on the difference of camera and wheels, in the cycle that found it."""
    agreed_m: float = 0.0
    """Distance driven while both agreed; never falls."""
    wheels_rad: float = 0.0
    """Angle by which the wheels have turned the robot, left positive."""
    camera_rad: float = 0.0
    """Angle by which the camera saw it turn in the same time, as far as it was seen."""
    driven_m: float = 0.0
    """Distance that the wheels have driven, forwards and backwards."""
    slip_m: tuple[float, float] = (0.0, 0.0)
    """Place by the camera, less the place by the wheels, summed up: it creeps with the odometry's
    errors and leaps when the robot is carried."""
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
"""Evidence before anything was seen."""
