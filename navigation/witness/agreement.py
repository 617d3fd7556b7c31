"""Agreement of camera and wheels: the seen place minus the rolled one.

The wheels' path is laid out along the headings that the camera saw, so that wheels of unequal size
bend nothing. The rest of the camera's position is the slip; it may grow by the odometry's error,
and by that of two wrong dates at a changing speed. The heading is treated alike. The newest slip is
compared with those of the last seconds: a frozen picture, a jump, a drift, a robot that is carried,
stuck or turned round all show.

The length of the wheels' metre, and their bend, are learned during the run, within bounds. Metres,
radians, seconds.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from navigation.witness.wheels import BEGUN, WheelMotion
from planner.scene import FloatArray

ANCHOR_EVERY_S: Final = 0.1
ANCHORS: Final = 100
"""Ten seconds."""
OFF_CENTRE_M: Final = 0.005
"""Distance of a marker from the middle between the wheels: a turn moves it around that."""
SLACK_RAD: Final = 0.12
TURN_ERROR: Final = 0.1
"""Relative error of a turn: the distance between the wheels, as floors and tyres change it."""
LEARNED_OVER_M: Final = 0.25
STRAIGHT: Final = 0.8
"""Share of its driven way that a robot must get for its metre to be learned."""
METRE_SPREAD: Final = 0.05
"""Standard deviation of an unknown robot's wheels: the radius as measured by hand."""
METRE_MOST: Final = 0.15
PLACE_SIGMA_M: Final = 0.003
"""Standard deviation of a distance between two of the camera's positions: noise and calibration."""
BEND_SPREAD_RAD_M: Final = 0.2
"""Standard deviation of how unequal wheels bend a straight way: 2.4 % on 0.12 m."""
BEND_MOST_RAD_M: Final = 0.6
HEADING_SIGMA_RAD: Final = 0.02
LATERAL_TURN_RAD: Final = 0.5
"""Largest turn in a learned stretch that leaves the bend to be seen."""
UNREPORTED_S: Final = 1.0
"""Time at its last speed in which a robot covers at most what it can drive unreported: a lease of
0.55 s, half of 0.6 s of braking, and a report's interval."""


@dataclass(frozen=True, slots=True)
class AgreementLimits:
    """Limits on the difference of camera and wheels: a length, and a share of the path driven."""

    slack_m: float
    error: float


@dataclass(frozen=True, slots=True)
class Parting:
    """Motion since a moment by camera and by wheels: distance and turn."""

    over_s: float
    camera_m: float
    wheels_m: float
    camera_rad: float
    wheels_rad: float
    by_place: bool
    """True if the positions differ too much; otherwise the headings do."""

    @property
    def sentence(self) -> str:
        """One sentence for people."""
        if self.by_place and abs(self.camera_m - self.wheels_m) < 0.005:
            what = f"in another direction than its wheels drove ({self.wheels_m:.3f} m each)"
            return f"the camera saw the robot move {what} in {self.over_s:.1f} s"
        if self.by_place:
            return (
                f"the camera saw the robot move {self.camera_m:.3f} m in {self.over_s:.1f} s, "
                f"its wheels drove {self.wheels_m:.3f} m"
            )
        camera_deg, wheels_deg = math.degrees(self.camera_rad), math.degrees(self.wheels_rad)
        return (
            f"the camera saw the robot turn {camera_deg:.0f} deg in {self.over_s:.1f} s, "
            f"its wheels turned it {wheels_deg:.0f} deg"
        )


class _Learned:
    """A constant, learned by a one-state Kalman filter without motion."""

    def __init__(self, value: float, spread: float, most: float) -> None:
        self.value, self.variance = value, spread * spread
        self._middle, self._most = value, most

    @property
    def spread(self) -> float:
        return math.sqrt(self.variance)

    def learn(self, correction: float, sigma: float) -> None:
        """Take a measured difference from the value; an impossible one is left out."""
        total = self.variance + sigma * sigma
        if correction * correction > 9.0 * total:
            return
        gain = self.variance / total
        value = self.value + gain * correction
        self.value = max(self._middle - self._most, min(self._middle + self._most, value))
        self.variance *= 1.0 - gain


class _Anchor(NamedTuple):
    """One moment: slip, place and heading by both, and the robot's speed."""

    time_s: float
    slip_x_m: float
    slip_y_m: float
    slip_rad: float
    driven_m: float
    turned_rad: float
    vx_m_s: float
    vy_m_s: float
    turn_rad_s: float
    seen_x_m: float
    seen_y_m: float
    seen_rad: float


class Agreement:
    """Fed with a pose and the wheels' motion at its time; `add` reports differences."""

    def __init__(self, limits: AgreementLimits) -> None:
        self.limits = limits
        self.agreed_m = 0.0
        """Distance that the wheels have driven while both agreed; never falls."""
        self._metre = _Learned(1.0, METRE_SPREAD, METRE_MOST)
        self._bend = _Learned(0.0, BEND_SPREAD_RAD_M, BEND_MOST_RAD_M)
        self._last: tuple[float, WheelMotion] | None = None
        """Heading up to which the place is rolled, and the wheels' motion then."""
        self._rolled: tuple[float, float, float] | None = None
        self._unreported_m = 0.0
        """Distance that the robot may have driven unreported since, forwards or backwards."""
        self.slip_m, self.slip_rad = (0.0, 0.0), 0.0
        """Pose by the camera, less that by the wheels."""
        self._anchors: deque[_Anchor] = deque(maxlen=ANCHORS)
        self._table: FloatArray | None = None
        """The anchors by column; None once outdated."""
        self._lesson: tuple[_Anchor, WheelMotion] | None = None

    def begin_again(self) -> None:
        """Stop comparing with earlier moments; the slip so far stays."""
        self._lesson = None
        self._anchors.clear()
        self._table = None

    def break_off(self, ended: WheelMotion | None, unreported: bool) -> None:
        """Begin another stretch after ``ended``.

        ``unreported``: the wheels' motion in between is unknown.
        """
        if ended is not None and self._last is not None:
            heading_rad, then = self._last
            turned_rad = ended.turn_rad - then.turn_rad
            self._roll_on(heading_rad + turned_rad / 2.0, ended.way_m - then.way_m, turned_rad)
            self._last = (heading_rad + turned_rad, BEGUN)
            self._unreported_m = ended.speed_m_s * UNREPORTED_S if unreported else 0.0
        self.begin_again()

    def add(
        self,
        time_s: float,
        pose: tuple[float, float, float],
        wheels: WheelMotion,
        latency_error_s: float,
    ) -> Parting | None:
        """Worst disagreement with one of the last seconds' poses; None without any."""
        if self._rolled is None:
            self._rolled = pose
        step_m = self._roll(pose, wheels)
        here = self._anchor(time_s, pose, wheels)
        self.slip_m, self.slip_rad = (here.slip_x_m, here.slip_y_m), here.slip_rad
        parting = self._worst(here, latency_error_s) if self._anchors else None
        if parting is None:
            self.agreed_m += step_m
            self._learn(here, wheels)
        if not self._anchors or time_s - self._anchors[-1].time_s >= ANCHOR_EVERY_S:
            self._anchors.append(here)
            self._table = None
        return parting

    def _roll(self, pose: tuple[float, float, float], wheels: WheelMotion) -> float:
        """Carry the rolled place on to the newest pose's time; return the distance driven.

        Motion of the wheels while the robot was unseen counts. Unreported motion is left out and
        shows as slip.
        """
        assert self._rolled is not None
        before_rad, then = self._last if self._last is not None else (pose[2], wheels)
        self._last = (pose[2], wheels)
        middle = before_rad + math.remainder(pose[2] - before_rad, math.tau) / 2.0
        self._roll_on(middle, wheels.way_m - then.way_m, wheels.turn_rad - then.turn_rad)
        if self._unreported_m != 0.0:
            self._roll_unreported(before_rad, pose)
        return max(0.0, wheels.driven_m - then.driven_m)  # less than nothing where dated earlier

    def _roll_on(self, along_rad: float, way_m: float, turn_rad: float) -> None:
        """Move the rolled place by the wheels' motion."""
        assert self._rolled is not None
        way_m *= self._metre.value
        x, y, heading = self._rolled
        self._rolled = (
            x + way_m * math.cos(along_rad),
            y + way_m * math.sin(along_rad),
            math.remainder(heading + turn_rad + self._bend.value * way_m, math.tau),
        )

    def _roll_unreported(self, along_rad: float, pose: tuple[float, float, float]) -> None:
        """Believe the camera as far as the robot may have driven unreported."""
        assert self._rolled is not None
        most_m, self._unreported_m = self._unreported_m, 0.0
        x_m = pose[0] - self._rolled[0] - self.slip_m[0]
        y_m = pose[1] - self._rolled[1] - self.slip_m[1]
        seen_m = x_m * math.cos(along_rad) + y_m * math.sin(along_rad)
        way_m = max(min(0.0, most_m), min(max(0.0, most_m), seen_m))
        self._roll_on(along_rad, way_m / self._metre.value, 0.0)

    def _anchor(
        self, time_s: float, pose: tuple[float, float, float], wheels: WheelMotion
    ) -> _Anchor:
        assert self._rolled is not None
        x, y, heading = self._rolled
        speed = wheels.speed_m_s * self._metre.value
        return _Anchor(
            time_s, pose[0] - x, pose[1] - y, math.remainder(pose[2] - heading, math.tau),
            wheels.driven_m, wheels.turned_rad,
            speed * math.cos(pose[2]), speed * math.sin(pose[2]), wheels.turn_rad_s,
            pose[0], pose[1], pose[2],
        )  # fmt: skip

    def _worst(self, here: _Anchor, latency_error_s: float) -> Parting | None:
        table = self._table
        if table is None:
            table = self._table = np.array(self._anchors).T
        driven = here.driven_m - table[4]
        turned = here.turned_rad - table[5]
        late_m = latency_error_s * np.hypot(here.vx_m_s - table[6], here.vy_m_s - table[7])
        slip_m = np.hypot(here.slip_x_m - table[1], here.slip_y_m - table[2])
        error = self.limits.error + 2.0 * self._metre.spread
        bearable_m = (
            self.limits.slack_m + error * driven + OFF_CENTRE_M * np.minimum(turned, 2.0) + late_m
        )
        slip_rad = np.abs(_wrapped(here.slip_rad - table[3]))
        bearable_rad = (
            SLACK_RAD
            + TURN_ERROR * turned
            + 2.0 * self._bend.spread * driven
            + latency_error_s * np.abs(here.turn_rad_s - table[8])
        )
        by_place, by_heading = slip_m / bearable_m, slip_rad / bearable_rad
        worst = int(np.argmax(np.maximum(by_place, by_heading)))
        if max(by_place[worst], by_heading[worst]) <= 1.0:
            return None
        return self._parting(self._anchors[worst], here, by_place[worst] >= by_heading[worst])

    def _parting(self, then: _Anchor, here: _Anchor, by_place: bool) -> Parting:
        dx, dy = here.seen_x_m - then.seen_x_m, here.seen_y_m - then.seen_y_m
        slip_x, slip_y = here.slip_x_m - then.slip_x_m, here.slip_y_m - then.slip_y_m
        turned = math.remainder(here.seen_rad - then.seen_rad, math.tau)
        return Parting(
            here.time_s - then.time_s,
            math.hypot(dx, dy),
            math.hypot(dx - slip_x, dy - slip_y),
            turned,
            math.remainder(turned - (here.slip_rad - then.slip_rad), math.tau),
            by_place,
        )

    def _learn(self, here: _Anchor, wheels: WheelMotion) -> None:
        if self._lesson is None:
            self._lesson = (here, wheels)
            return
        then, began = self._lesson
        driven_m = wheels.driven_m - began.driven_m
        if driven_m < LEARNED_OVER_M:
            return
        self._lesson = (here, wheels)
        slip = np.array([here.slip_x_m - then.slip_x_m, here.slip_y_m - then.slip_y_m])
        rolled = np.array([here.seen_x_m - then.seen_x_m, here.seen_y_m - then.seen_y_m]) - slip
        got_m = float(np.hypot(*rolled))
        if got_m >= STRAIGHT * driven_m:
            self._metre.learn(float(slip @ rolled) / got_m**2, PLACE_SIGMA_M / driven_m)
        if wheels.turned_rad - began.turned_rad < LATERAL_TURN_RAD:
            way_m = (wheels.way_m - began.way_m) * self._metre.value
            if abs(way_m) > LEARNED_OVER_M / 2.0:
                off_rad = math.remainder(here.slip_rad - then.slip_rad, math.tau)
                self._bend.learn(off_rad / way_m, HEADING_SIGMA_RAD / abs(way_m))


def _wrapped(angles_rad: FloatArray) -> FloatArray:
    return (angles_rad + np.pi) % (2.0 * np.pi) - np.pi
