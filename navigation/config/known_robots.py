"""Robots on the market, with the data that their vendors state.

`clearway init --robot` writes these numbers, `clearway check` compares with them, and the drivers
convert by them. Metres, seconds, radians.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

DriverName: TypeAlias = Literal["clearway", "create2", "turtlebot3", "epuck2", "waveshare"]

ModelName: TypeAlias = Literal["ugv01", "ugv_rover", "rasp_rover"]

CLEARWAY: Final = "clearway"

OWN_LEAST_WHEEL_M_S: Final = 0.01
"""Default speed below which wheels are driven in pulses: small motors do not turn up to 5 mm/s or
so, and pulses of twice that cost no accuracy (`DriveSettings`)."""


@dataclass(frozen=True, slots=True)
class KnownRobot:
    """One robot; its speeds and accelerations are the highest.

    ``radius_m`` is the smallest disc around its axle's middle that holds its body.
    ``metres_per_count`` is a wheel's travel per encoder count, None if the robot reports speeds.
    ``watchdog_s``: time after the last order until its own motors stop, None if never. ``help``:
    things to check when it does not answer. ``models``: the maker's robots that `robot.model` may
    name, the first by default; none if the robot reports it.
    """

    title: str
    baud: int
    track_m: float
    radius_m: float
    height_m: float
    marker_m: float
    """Side of a marker that its top has room for."""
    wheel_m_s: float
    speed_m_s: float
    turn_rad_s: float
    acceleration_m_s2: float
    turn_acceleration_rad_s2: float
    metres_per_count: float | None
    watchdog_s: float | None
    help: str
    models: tuple[ModelName, ...] = ()
    least_wheel_m_s: float = OWN_LEAST_WHEEL_M_S


KNOWN_ROBOTS: Final[Mapping[str, KnownRobot]] = {
    "create2": KnownRobot(
        title="iRobot Create 2",
        baud=115_200,
        track_m=0.235,
        radius_m=0.175,
        height_m=0.092,
        marker_m=0.18,
        wheel_m_s=0.5,
        speed_m_s=0.5,
        turn_rad_s=4.25,
        acceleration_m_s2=0.8,
        turn_acceleration_rad_s2=4.0,
        metres_per_count=3.14159265 * 0.072 / 508.8,
        watchdog_s=None,
        help="press CLEAN to wake it, and look at the cable",
        least_wheel_m_s=0.0,  # `Create2Wheel` shares out the steps of its wheels
    ),
    "turtlebot3": KnownRobot(
        title="TurtleBot3",
        baud=1_000_000,
        track_m=0.160,
        radius_m=0.105,
        height_m=0.192,
        marker_m=0.09,
        wheel_m_s=0.21,
        speed_m_s=0.21,
        turn_rad_s=2.6,
        acceleration_m_s2=0.5,
        turn_acceleration_rad_s2=6.0,
        metres_per_count=2 * 3.14159265 * 0.033 / 4_096,
        watchdog_s=0.5,
        help="is its battery switched on, and the OpenCR board plugged in by USB?",
        least_wheel_m_s=0.02,  # for one wheel alone: a linear speed of 1 cm/s, a whole step
    ),
    "epuck2": KnownRobot(
        title="e-puck2",
        baud=115_200,
        track_m=0.053,
        radius_m=0.037,
        height_m=0.053,
        marker_m=0.045,
        wheel_m_s=0.128,
        speed_m_s=0.128,
        turn_rad_s=4.8,
        acceleration_m_s2=0.3,
        turn_acceleration_rad_s2=10.0,
        metres_per_count=3.14159265 * 0.041 / 1_000,
        watchdog_s=None,
        help="is it switched on, with its selector at 8 for USB or 3 for Bluetooth?",
    ),
    "waveshare": KnownRobot(
        title="Waveshare UGV",
        baud=115_200,
        track_m=0.141,
        radius_m=0.155,
        height_m=0.10,
        marker_m=0.14,
        wheel_m_s=0.35,
        speed_m_s=0.35,
        turn_rad_s=2.5,
        acceleration_m_s2=0.5,
        turn_acceleration_rad_s2=4.0,
        metres_per_count=None,
        watchdog_s=0.5,
        help="is it switched on, a model with encoders, and its UART connected?",
        models=("ugv01", "ugv_rover", "rasp_rover"),
    ),
}


def least_wheel_m_s(driver: DriverName, chosen_m_s: float | None) -> float:
    """`robot.least_wheel_m_s`, or the robot's own value without it."""
    if chosen_m_s is not None:
        return chosen_m_s
    return OWN_LEAST_WHEEL_M_S if driver == CLEARWAY else KNOWN_ROBOTS[driver].least_wheel_m_s
