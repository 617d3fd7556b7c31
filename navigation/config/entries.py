"""Entries of a configuration's lists: robots, where each of them goes, and cameras."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from navigation.config.values import (
    MOST_STATIONS,
    Count,
    Degrees,
    DriverUnits,
    ExposureTime,
    Kelvin,
    LeastWheelSpeed,
    Length,
    Name,
    NeighbourFile,
    NotNegative,
    Rate,
    Section,
    Source,
    Station,
    Text,
)


class RobotEntry(Section):
    """One of several driven robots; what is empty is as in ``robot`` and ``serial``."""

    name: Name = Field(description="what orders and reports call it: letters, digits, _ and -")
    marker_id: Count = Field(description="the number of the marker on this robot")
    port: Text | None = Field(default=None, description="the line to this robot")
    baud: Annotated[int, Field(strict=True, ge=1200, le=4_000_000)] | None = Field(
        default=None, description="bits a second on that line"
    )
    marker_size_m: Length | None = Field(default=None, description="side of the black square")
    marker_height_m: Annotated[NotNegative, Field(le=100)] | None = Field(
        default=None, description="height of the marker above the floor"
    )
    marker_turn_deg: Degrees | None = Field(default=None, description="how the marker is mounted")
    radius_m: Length | None = Field(default=None, description="radius of the disc that holds it")
    speed_m_s: Rate | None = Field(default=None, description="highest speed")
    acceleration_m_s2: Rate | None = Field(default=None, description="highest acceleration")
    angular_rate_rad_s: Rate | None = Field(default=None, description="highest turning rate")
    track_m: Length | None = Field(default=None, description="distance between the driven wheels")
    least_wheel_m_s: LeastWheelSpeed | None = Field(
        default=None, description="the slowest that a wheel at rest is sure to turn"
    )


class RobotMissionSection(Section):
    """Where one of several robots goes."""

    name: Name = Field(description="which of robots it is")
    stations: tuple[Station, ...] = Field(
        default=(), max_length=MOST_STATIONS, description="places to visit; the last is the goal"
    )


class CameraEntry(Section):
    """One of several cameras over one arena; what is empty is as in ``camera``."""

    name: Name = Field(description="what messages call it: letters, digits, _ and -")
    source: Source | None = Field(default=None, description="where its pictures come from")
    calibration: NeighbourFile | None = Field(
        default=None, description="its own file, of the same floor as the others'"
    )
    size_px: (
        tuple[
            Annotated[int, Field(strict=True, ge=16, le=32768)],
            Annotated[int, Field(strict=True, ge=16, le=32768)],
        ]
        | None
    ) = Field(default=None, description="[width, height] asked of it")
    rate_hz: Rate | None = Field(default=None, description="frames a second asked of it")
    format: Literal["auto", "mjpg", "yuyv", "grey"] | None = Field(
        default=None, description="pixel format asked of it"
    )
    exposure_ms: ExposureTime | None = Field(default=None, description="exposure time, or auto")
    gain: DriverUnits | None = Field(default=None, description="gain, or auto")
    focus: DriverUnits | None = Field(default=None, description="focus, or auto")
    white_balance_k: Kelvin | None = Field(default=None, description="white balance, or auto")
    rolling_shutter_ms: Annotated[NotNegative, Field(le=1000)] | None = Field(
        default=None, description="from the exposure of its first row to that of the last"
    )
