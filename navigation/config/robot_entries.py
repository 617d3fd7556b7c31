"""Entries of a configuration's lists of robots: which are driven, and where each goes."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from navigation.config.values import (
    MOST_STATIONS,
    Count,
    Degrees,
    Length,
    Name,
    NotNegative,
    Rate,
    Section,
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


class RobotMissionSection(Section):
    """Where one of several robots goes."""

    name: Name = Field(description="which of robots it is")
    stations: tuple[Station, ...] = Field(
        default=(), max_length=MOST_STATIONS, description="places to visit; the last is the goal"
    )
