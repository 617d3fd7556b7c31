"""A robot on a known way, as its wheels report it and a camera sees it, in plain numbers.

The way is integrated finely by itself; reports and poses are drawn from it with the errors that a
test asks for. Metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from firmware_protocol.wire.messages import (
    CommandResult,
    RobotState,
    Status,
    StatusFlag,
    StopReason,
)
from navigation.witness import Evidence, Witness, WitnessLimits
from navigation.witness.agreement import AgreementLimits
from vision.markers.markers import RobotPose

FINE_S = 0.001
REPORT_S = 0.05
PICTURE_S = 1.0 / 30.0
SMOOTHING_S = 0.03
WIRE_S = 0.008
LIMITS = WitnessLimits(AgreementLimits(slack_m=0.015, error=0.04), report_age_s=WIRE_S)

Motion = Callable[[float], tuple[float, float]]
"""Speed and turning rate at a time."""
Sight = Callable[[float, tuple[float, float, float]], tuple[float, float, float] | None]
"""What a picture shows of a true pose; None: nothing."""


def shuttle(time_s: float) -> tuple[float, float]:
    """Stand, drive, turn, drive on: accelerations as a real robot's."""
    phase_s = time_s % 8.0
    speed = 0.3 * float(np.clip(min(phase_s - 1.0, 4.0 - phase_s) / 0.6, 0.0, 1.0))
    turn = 1.5 * float(np.clip(min(phase_s - 5.0, 6.5 - phase_s) / 0.25, 0.0, 1.0))
    return speed, turn


@dataclass(slots=True)
class MovingRobot:
    """``way`` (n, 4) of time, x, y, heading; ``speeds`` (n, 3) of time, speed, turning rate."""

    motion: Motion = shuttle
    seconds: float = 20.0
    metre: float = 1.0
    """What the wheels call a metre, in metres."""
    bend_rad_m: float = 0.0
    seed: int = 1
    way: np.ndarray = field(init=False)
    speeds: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.way, self.speeds = _driven(self.motion, self.seconds)

    def pose(self, time_s: float) -> tuple[float, float, float]:
        row = self.way[int(np.clip(time_s / FINE_S, 0, len(self.way) - 1))]
        return float(row[1]), float(row[2]), math.remainder(float(row[3]), math.tau)

    def report(self, time_s: float) -> Status:
        """What the robot says at a time: smoothed speeds, to the wire's resolution."""
        last = int(time_s / FINE_S) + 1
        first = max(0, last - int(2.0 * SMOOTHING_S / FINE_S))
        speed, turn = self.speeds[first:last, 1:].mean(axis=0)
        turn -= self.bend_rad_m * speed
        return status(time_s, round(speed / self.metre, 3), round(turn, 3))

    def evidence_with(
        self,
        witness: Witness,
        *,
        latency_s: float = 0.0,
        sight: Sight = lambda _t, pose: pose,
        noise_m: float = 0.0005,
        noise_rad: float = 0.003,
        late_s: Callable[[float], float] = lambda _t: 0.0,
    ) -> Iterator[tuple[float, Evidence]]:
        """Everything in the order of its arrival; the evidence after each picture."""
        rng = np.random.default_rng(self.seed)
        events = [(t + WIRE_S + late_s(t), 0, t) for t in np.arange(0.0, self.seconds, REPORT_S)]
        events += [(t + latency_s, 1, t) for t in np.arange(0.01, self.seconds, PICTURE_S)]
        for arrived_s, is_picture, at_s in sorted(events):
            if not is_picture:
                witness.report(self.report(at_s), arrived_s)
                continue
            seen = sight(at_s, self.pose(at_s))
            if seen is not None:
                x, y, heading = np.array(seen) + rng.normal(0.0, [noise_m, noise_m, noise_rad])
                pose = RobotPose(7, x, y, heading, arrived_s, np.zeros((4, 2)))
                witness.saw(pose, arrived_s)
            yield at_s, witness.evidence()


@lru_cache(maxsize=16)
def _driven(motion: Motion, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    times = np.arange(0.0, seconds, FINE_S)
    speeds = np.array([motion(t) for t in times])
    heading = np.cumsum(speeds[:, 1]) * FINE_S
    x = np.cumsum(speeds[:, 0] * np.cos(heading)) * FINE_S
    y = np.cumsum(speeds[:, 0] * np.sin(heading)) * FINE_S
    return np.column_stack([times, x, y, heading]), np.column_stack([times, speeds])


def status(time_s: float, speed_m_s: float, turn_rad_s: float, boot_id: int = 5) -> Status:
    """A report with these speeds, and nothing else in it that matters."""
    return Status(
        time_us=round(time_s * 1e6) % (1 << 32), boot_id=boot_id, mission=0, accept_next=0,
        exec_next=0, prefix_crc=0, exec_crc=0, state=RobotState.RUN, flags=StatusFlag.NONE,
        reason=StopReason.NONE, result=CommandResult.NONE, command=0, x_m=0.0, y_m=0.0,
        heading_rad=0.0, speed_m_s=speed_m_s, turn_rad_s=turn_rad_s, pose_age_s=0.0,
        lease_left_s=0.5,
    )  # fmt: skip
