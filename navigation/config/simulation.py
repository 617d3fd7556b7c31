"""The section ``simulation``: the simulated world, its camera's and its robot's errors.

Units as in `sections`; pictures in pixels.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, StrictBool, ValidationInfo, field_validator

from navigation.config.values import (
    MOST_CAMERAS,
    MOST_FLEET,
    MOST_HAPPENINGS,
    MOST_ROBOTS,
    Count,
    Degrees,
    Fraction,
    Length,
    Metres,
    Name,
    NeighbourFile,
    NotNegative,
    Number,
    Place,
    Pose,
    Positive,
    Rate,
    RelativeError,
    Section,
    Text,
    as_in,
)


class SimulatedKnockSection(Section):
    """A knock after which the simulated camera hangs differently."""

    from_s: NotNegative = Field(description="when, after the beginning")
    until_s: Positive | None = Field(
        default=None, description="when it is put back as it was; empty: never"
    )
    shift_m: tuple[Metres, Metres, Metres] = Field(
        default=(0.0, 0.0, 0.0), description="[x, y, height] by which the lens is moved"
    )
    tilt_deg: tuple[Degrees, Degrees] = Field(
        default=(0.0, 0.0),
        description="by which it leans: [about x, about y]; a degree is focal_px / 57 pixels",
    )
    turn_deg: Degrees = Field(default=0.0, description="by which it is turned about its own axis")


class SimulatedCameraSection(Section):
    """The simulated camera above the arena: a pinhole with lens distortion, or a fisheye."""

    position_m: tuple[Metres, Metres, Length] = Field(
        default=(1.155, 0.975, 2.5), description="[x, y, height] of the lens"
    )
    tilt_deg: tuple[Degrees, Degrees] = Field(
        default=(1.2, -0.8), description="leaning from straight down: [about x, about y]"
    )
    turn_deg: Degrees = Field(default=0.7, description="turned about its own axis")
    focal_px: Annotated[Positive, Field(ge=1)] = Field(default=1235.0, description="focal length")
    centre_offset_px: tuple[Number, Number] = Field(
        default=(5.3, -3.8),
        description="principal point against the picture's centre: [right, down]",
    )
    lens_model: Literal["brown", "fisheye"] = Field(
        default="brown", description="whose distortion: Brown's, or OpenCV's fisheye model"
    )
    distortion: tuple[Number, ...] = Field(
        default=(-0.08, 0.02, 0.0004, -0.0003, 0.0),
        description="OpenCV's [k1, k2, p1, p2, k3], or a fisheye's [k1, k2, k3, k4]",
    )
    blur_px: Annotated[NotNegative, Field(le=100)] = Field(
        default=0.6, description="sigma of the lens's blur"
    )
    noise_grey: Annotated[NotNegative, Field(le=255)] = Field(
        default=2.5, description="sigma of the sensor's noise, grey levels"
    )
    light_fall: Fraction = Field(
        default=0.12, description="how much darker the darkest corner's light is"
    )
    latency_s: Annotated[NotNegative, Field(le=10)] = Field(
        default=0.0, description="from the exposure to the program"
    )
    knocks: tuple[SimulatedKnockSection, ...] = Field(
        default=(),
        max_length=MOST_HAPPENINGS,
        description="knocks against it; where they overlap the later one counts",
    )

    @field_validator("distortion")
    @classmethod
    def _terms_of_the_model(
        cls, terms: tuple[float, ...], info: ValidationInfo
    ) -> tuple[float, ...]:
        model = info.data.get("lens_model", "brown")
        wanted = {"brown": 5, "fisheye": 4}[model]
        if len(terms) != wanted:
            raise ValueError(f"{len(terms)} numbers: must be {wanted}, as lens_model is {model}")
        return terms


@as_in(
    SimulatedCameraSection, leave_out=("centre_offset_px", "lens_model", "blur_px", "noise_grey")
)
class SimulatedCameraEntry(Section):
    """Differences of one of several simulated cameras from ``simulation.camera``; empty keys are as
    there.
    """

    name: Name = Field(description="which of cameras it is")
    distortion: tuple[Number, Number, Number, Number, Number] | None = Field(
        default=None, description="OpenCV's [k1, k2, p1, p2, k3]"
    )


class SimulatedRobotSection(Section):
    """Differences of the simulated robot from the ideal one."""

    wheel_radius_error: tuple[RelativeError, RelativeError] = Field(
        default=(0.01, -0.005), description="relative error of the [left, right] wheel's radius"
    )
    track_error: RelativeError = Field(
        default=0.01, description="relative error of the distance between the wheels"
    )
    slip: Fraction = Field(
        default=0.01, description="sigma of the part of each wheel's travel that is lost or gained"
    )
    motor_time_s: Annotated[Positive, Field(le=10)] = Field(
        default=0.05, description="time constant of the motors"
    )
    encoder_ticks_per_m: Annotated[Positive, Field(ge=1)] = Field(
        default=4000.0, description="resolution of the encoders"
    )
    wheel_speed_m_s: Rate = Field(default=0.8, description="highest speed of a wheel")
    dead_zone_m_s: Annotated[NotNegative, Field(le=1)] = Field(
        default=0.005, description="a wheel that turns stops at slower orders"
    )
    stiction: Annotated[NotNegative, Field(le=10)] = Field(
        default=0.2,
        description="a wheel at rest needs an order that is larger than the dead zone by this part",
    )
    speed_step_m_s: Annotated[NotNegative, Field(le=1)] = Field(
        default=0.0,
        description="orders are rounded towards zero to whole steps of this; 0: to none",
    )
    faults: str = Field(
        default="", description="faults of the line, as in `clearway robot --faults`"
    )
    poses: Path | None = Field(
        default=None,
        description="file in which a robot of another process tells the simulated camera where "
        "it is, as `clearway robot --poses` writes it (from the current folder)",
    )


class RobotStartSection(Pose):
    """Start of one of several simulated robots."""

    name: Name = Field(description="which of robots it is")


class SimulatedTrackSection(Section):
    """Track of one of ``other_robots``, which drives by itself and stops to turn at each place."""

    marker_id: Count = Field(description="which of other_robots it is")
    track: tuple[Place, ...] = Field(
        min_length=1,
        max_length=MOST_HAPPENINGS,
        description="the places it drives through; with only one it stays there",
    )
    speed_m_s: Rate = Field(default=0.2, description="how fast it drives")
    start_s: NotNegative = Field(default=0.0, description="when it sets off, after the beginning")
    back_and_forth: StrictBool = Field(
        default=False, description="whether it drives back at the end, and so on for ever"
    )


class SimulatedObstacleSection(Section):
    """An obstacle that is not always there; two that follow each other make a moving one."""

    record: Text = Field(
        description="one record of the scene text, metres: 'C (1.2,0.9) 0.08' or 'L 3 (..) ..'"
    )
    from_s: NotNegative = Field(default=0.0, description="when it appears, after the beginning")
    until_s: Positive | None = Field(default=None, description="when it vanishes; empty: never")


class SimulationSection(Section):
    """The simulated world; ignored if camera and port are real."""

    seed: Count = Field(default=1, description="of everything random")
    arena: NeighbourFile | None = Field(
        default=None, description="scene text file of the obstacles, metres, relative to this file"
    )
    arena_text: Text | None = Field(default=None, description="the same, written here")
    start: Pose | None = Field(
        default=None,
        description="where the robot is at the beginning; needed without `robots`",
    )
    starts: tuple[RobotStartSection, ...] = Field(
        default=(),
        max_length=MOST_FLEET,
        description="with several robots: where each is at the beginning, by name",
    )
    time_limit_s: Positive = Field(default=120.0, description="the run fails when it takes longer")
    camera: SimulatedCameraSection = Field(
        default=SimulatedCameraSection(), description="the simulated camera"
    )
    cameras: tuple[SimulatedCameraEntry, ...] = Field(
        default=(),
        max_length=MOST_CAMERAS,
        description="with several cameras: what differs from `simulation.camera`, by name",
    )
    robot: SimulatedRobotSection = Field(
        default=SimulatedRobotSection(), description="the simulated robot's errors"
    )
    other_robots: tuple[SimulatedTrackSection, ...] = Field(
        default=(),
        max_length=MOST_ROBOTS,
        description="how the other robots drive; one without a track is not there",
    )
    obstacles: tuple[SimulatedObstacleSection, ...] = Field(
        default=(),
        max_length=MOST_HAPPENINGS,
        description=f"obstacles that come and go, at most {MOST_HAPPENINGS}",
    )
