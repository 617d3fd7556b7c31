"""Kinds of values in a configuration: bounded numbers, files, places and headings.

The bounds are far beyond any arena's or robot's needs and far below a size that fills a memory.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationInfo,
    create_model,
)

MOST_STATIONS = 1000
"""Largest number of stations of a mission, configured or ordered."""
SIMULATED = "simulated"
"""Camera source or serial port that stands for the simulated one."""
LONGEST_DWELL_S = 3600.0
"""Longest stay at a station.

On the wire it is a waypoint for every 25 s: at most 144 000 of a mission.
"""

MOST_ROBOTS = 100
MOST_FLEET = 20
"""Robots driven together: chosen; the fleet's planner is measured with 12
(`benchmarks/results/fleet_arenas.md`)."""
MOST_CAMERAS = 8
"""Above one arena: their pictures are looked at one after another."""
MOST_HAPPENINGS = 1000
LARGEST = 1e6

Number = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-LARGEST, le=LARGEST)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=LARGEST)]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=LARGEST)]
Metres = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-1000, le=1000)]
Degrees = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-3600, le=3600)]


def _from(least: float) -> AfterValidator:
    """Require at least this; a value not above 0 is reported as that first."""

    def check(value: float) -> float:
        if value < least:
            raise ValueError(f"must be >= {least:g}, not {value:g}")
        return value

    return AfterValidator(check)


Length = Annotated[Positive, Field(le=100), _from(0.001)]
Fine = Annotated[Positive, Field(le=10), _from(1e-6)]
Rate = Annotated[Positive, Field(le=1000), _from(0.001)]
"""A speed, an acceleration or a frequency that is divided by."""
PathSpeed = Annotated[Positive, Field(le=1000), _from(0.01)]
"""A robot's speed along a path; the firmware's least is 10 mm/s (`CRAWL` of its follower)."""
LeastWheelSpeed = Annotated[NotNegative, Field(le=0.2)]
"""Speed up to the fastest of the firmware's pulses (`LEAST_WHEEL_MAX_MM_S`)."""
Fraction = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, lt=1)]
RelativeError = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=-0.5, lt=0.5)]


def _auto_or(least: float, most: float) -> BeforeValidator:
    """The word ``auto`` or a number, refused in one sentence: a union has one for each part."""

    def check(value: Any) -> Any:
        if isinstance(value, str) and value == "auto":
            return value
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if is_number and least <= value <= most:
            return float(value)
        raise ValueError(f"must be 'auto' or a number in {least:g}..{most:g}, not {value!r}")

    return BeforeValidator(check)


ExposureTime = Annotated[
    Annotated[float, Field(ge=0.01, le=10_000)] | Literal["auto"], _auto_or(0.01, 10_000.0)
]
"""Milliseconds."""
DriverUnits = Annotated[
    Annotated[float, Field(ge=0, le=65_535)] | Literal["auto"], _auto_or(0.0, 65_535.0)
]
Kelvin = Annotated[
    Annotated[float, Field(ge=1000, le=20_000)] | Literal["auto"], _auto_or(1000.0, 20_000.0)
]
"""A colour temperature, from candlelight to a blue sky."""


def _source(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, int | str):
        raise ValueError("must be 'simulated', a camera's number, or a device, file or address")
    if isinstance(value, int) and value < 0:
        raise ValueError(f"must be a camera's number >= 0, not {value}")
    if value == "":
        raise ValueError("must not be empty")
    return value


def _preference(value: Any) -> Any:
    words = ("clearance", "length", "balanced")
    if value in words and isinstance(value, str):
        return value
    if isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value <= 1:
        return float(value)
    near = difflib.get_close_matches(str(value), words, n=1)
    hint = f"; did you mean '{near[0]}'?" if near else ""
    raise ValueError(
        f"must be 'clearance', 'length', 'balanced' or a number in 0..1, not {value!r}{hint}"
    )


Source = Annotated[int | str, BeforeValidator(_source)]
Preference = Annotated[
    float | Literal["clearance", "length", "balanced"], BeforeValidator(_preference)
]

Count = Annotated[int, Field(strict=True, ge=0, le=0xFFFFFFFF)]
Text = Annotated[str, Field(strict=True, min_length=1)]
Name = Annotated[
    str, Field(strict=True, min_length=1, max_length=32, pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")
]


def _beside_the_file(path: Path, info: ValidationInfo) -> Path:
    folder = (info.context or {}).get("folder")
    return path if folder is None or path.is_absolute() else Path(folder) / path


NeighbourFile = Annotated[Path, AfterValidator(_beside_the_file)]


class Section(BaseModel):
    """A section: only its own keys, and immutable."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=False)


_Entry = TypeVar("_Entry", bound=Section)


def as_in(
    *sections: type[Section], leave_out: Collection[str] = ()
) -> Callable[[type[_Entry]], type[_Entry]]:
    """Give a list's entry the keys of ``sections`` that it lacks; an empty one is as there."""

    def made(entry: type[_Entry]) -> type[_Entry]:
        keys: dict[str, Any] = {
            key: (
                Annotated[
                    field.rebuild_annotation(), Field(json_schema_extra=field.json_schema_extra)
                ]
                | None,
                Field(default=None, description=field.description),
            )
            for section in sections
            for key, field in section.model_fields.items()
            if key not in entry.model_fields and key not in leave_out
        }
        whole = create_model(
            entry.__name__,
            __base__=entry,
            __module__=entry.__module__,
            __doc__=entry.__doc__,
            **keys,
        )
        whole.__qualname__ = entry.__qualname__
        return whole

    return made


_Whole = TypeVar("_Whole", bound=Section)


def with_own(section: _Whole, entry: Section) -> _Whole:
    """Section with the entry's values for its keys."""
    own = {
        key: value
        for key in type(section).model_fields
        if (value := getattr(entry, key, None)) is not None
    }
    return section.model_copy(update=own)


class Place(Section):
    """A place in the arena."""

    x_m: Metres = Field(description="metres to the right")
    y_m: Metres = Field(description="metres up")


class Pose(Place):
    """A place and a heading."""

    heading_deg: Degrees = Field(default=0.0, description="degrees counter-clockwise from +x")

    @property
    def heading_rad(self) -> float:
        """In (-pi, pi]."""
        return wrapped_rad(self.heading_deg)


class StationSection(Place):
    """A place to visit."""

    heading_deg: Degrees | None = Field(
        default=None, description="heading to stand at, degrees; empty: any heading"
    )
    dwell_s: Annotated[NotNegative, Field(le=LONGEST_DWELL_S)] = Field(
        default=0.0, description="how long to stay there"
    )

    @property
    def heading_rad(self) -> float | None:
        """In (-pi, pi], None for any."""
        return None if self.heading_deg is None else wrapped_rad(self.heading_deg)


class FloorMarkerSection(Section):
    """A marker on the floor, for watching the camera's place."""

    marker_id: Count = Field(description="its number, in robot.dictionary")
    size_m: Length = Field(description="side of its black square")
    place_m: tuple[Metres, Metres] | None = Field(
        default=None,
        description="[x, y] of its centre, needed to renew the anchoring; empty: where it is seen "
        "when a run begins",
    )
    heading_deg: Degrees | None = Field(
        default=None,
        description="where its right side points to, degrees; with it all four corners anchor",
    )


class ArenaSection(Section):
    """The rectangle the robot may use; its sides are walls."""

    bounds_m: tuple[Metres, Metres, Metres, Metres] = Field(
        description="[x_min, y_min, x_max, y_max] of the free space"
    )
    floor_markers: tuple[FloorMarkerSection, ...] = Field(
        default=(),
        max_length=MOST_ROBOTS,
        description="markers that lie on the floor, best outside the bounds, and tell whether the "
        "camera was knocked; without three of them corners in the picture do",
    )


def wrapped_rad(heading_deg: float) -> float:
    """Degrees as radians in (-pi, pi]."""
    turned = math.remainder(math.radians(heading_deg), math.tau)
    return math.pi if turned == -math.pi else turned
