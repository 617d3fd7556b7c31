"""Both witnesses, fed in order of time, and the evidence of a cycle.

A pose waits until the wheels are known up to its time, which takes a report's interval of 50 ms.
Metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Final

from firmware_protocol.wire.messages import Status
from navigation.witness.agreement import Agreement, AgreementLimits, Parting
from navigation.witness.evidence import FREE_LATENCY_S, Evidence
from navigation.witness.latency import Latency, LatencyEstimate
from navigation.witness.wheels import WheelTrack
from vision.markers.markers import RobotPose

LONGEST_LOSS_S: Final = 0.5
"""Interval beyond which poses are not compared: the proof has to cover it."""
MOST_WAITING: Final = 60
UNKNOWN: Final = Latency(FREE_LATENCY_S / 2.0, FREE_LATENCY_S / 2.0)
"""Latency assumed before a motion has shown it."""
REDATED_S: Final = 0.02
"""Difference of a latency from the one compared with at which the comparison begins again."""
SLEW_S: Final = 0.005
"""Largest change of the latency that poses are dated by from one picture to the next: less than a
picture's interval, so that their order stays."""


@dataclass(frozen=True, slots=True)
class WitnessLimits:
    """Settings of the comparison, from the configuration."""

    agreement: AgreementLimits
    report_age_s: float
    """Age of the robot's report on arrival: its bytes' time on the wire."""


class Witness:
    """One robot's two witnesses."""

    def __init__(self, limits: WitnessLimits) -> None:
        self._limits = limits
        self.wheels = WheelTrack(limits.report_age_s)
        self._agreement = Agreement(limits.agreement)
        self._latency = LatencyEstimate()
        self._measured: Latency | None = None
        self._waiting: deque[tuple[float, tuple[float, float, float]]] = deque()
        self._stretch = 0
        self._seen_rad: float | None = None
        self._camera_rad = 0.0
        self._last_s = -math.inf
        self._dated_by_s = 0.0
        self._compared_s = UNKNOWN.latency_s
        self._parting: Parting | None = None

    # Inputs.

    def report(self, status: Status, arrived_s: float) -> None:
        """Take the robot's newest report; a repeated one changes nothing."""
        self.wheels.see(status, arrived_s)
        self._compare()

    def saw(self, pose: RobotPose, arrived_s: float) -> None:
        """Take the camera's pose of the robot; ``arrived_s`` is the stamp of the picture."""
        if self._seen_rad is not None:
            self._camera_rad += math.remainder(pose.heading_rad - self._seen_rad, math.tau)
        self._seen_rad = pose.heading_rad
        if len(self._waiting) == MOST_WAITING:
            self._waiting.popleft()
        self._waiting.append((arrived_s, (pose.x, pose.y, pose.heading_rad)))
        self._compare()

    def measure_again(self) -> None:
        """Measure the latency again; the old value holds until the next motion shows one."""
        self._latency = LatencyEstimate()

    def forget_latency(self) -> None:
        """Forget the latency of a camera that was replaced, or that a person has seen to."""
        self._latency, self._measured = LatencyEstimate(), None

    # Outputs.

    def latency_s(self) -> float:
        """Delay to subtract from the next picture's stamp; moves slowly to the measured one."""
        wanted_s = 0.0 if self._measured is None else self._measured.latency_s
        change_s = max(-SLEW_S, min(SLEW_S, wanted_s - self._dated_by_s))
        self._dated_by_s += change_s
        return self._dated_by_s

    def evidence(self) -> Evidence:
        """Evidence so far; a parting is reported once."""
        parting, self._parting = self._parting, None
        known = self._measured
        return Evidence(
            parted=None if parting is None else parting.sentence,
            agreed_m=self._agreement.agreed_m,
            wheels_rad=self.wheels.turn_rad,
            camera_rad=self._camera_rad,
            driven_m=self.wheels.driven_m,
            slip_m=self._agreement.slip_m,
            slip_rad=self._agreement.slip_rad,
            wheels_stand=self.wheels.stand,
            latency_s=None if known is None else known.latency_s,
            latency_error_s=FREE_LATENCY_S / 2.0 if known is None else known.error_s,
        )

    def carried(self, pose: RobotPose, now_s: float) -> tuple[float, float, float]:
        """The robot's pose now: its dated pose, and the wheels' motion since."""
        way_m, turn_rad = self.wheels.since(pose.captured_s, now_s)
        middle = pose.heading_rad + turn_rad / 2.0
        heading = math.remainder(pose.heading_rad + turn_rad, math.tau)
        return pose.x + way_m * math.cos(middle), pose.y + way_m * math.sin(middle), heading

    # Inside.

    def _compare(self) -> None:
        if self.wheels.stretch != self._stretch:
            self._stretch = self.wheels.stretch
            self._latency.break_off()
            self._agreement.break_off(self.wheels.ended, self.wheels.unreported)
        while self._waiting and self._waiting[0][0] <= self.wheels.newest_s:
            time_s, pose = self._waiting.popleft()
            if time_s - self._last_s > LONGEST_LOSS_S:
                self._latency.break_off()
                self._agreement.begin_again()
            self._last_s = time_s
            self._latency.add(time_s, pose, self.wheels)
            self._measured = self._latency.estimate() or self._measured
            self._judge(time_s, pose)

    def _judge(self, time_s: float, pose: tuple[float, float, float]) -> None:
        known = self._measured or UNKNOWN
        if abs(known.latency_s - self._compared_s) > REDATED_S:
            self._compared_s = known.latency_s
            # a change of dates shows as a parting, perhaps one just now and not yet reported
            self._parting = None
            self._agreement.begin_again()
        wheels = self.wheels.at(time_s - self._compared_s)
        if wheels is None:
            return
        error_s = known.error_s + abs(known.latency_s - self._compared_s)
        parting = self._agreement.add(time_s, pose, wheels, error_s)
        if parting is not None:
            self._parting = parting
            self._agreement.begin_again()
