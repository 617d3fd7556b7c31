"""The kinds of values in a configuration: bounded numbers, files, places and headings."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationInfo

MOST_STATIONS = 1000
"""Of one mission, configured or ordered."""
LONGEST_DWELL_S = 3600.0
"""At one station. On the wire it is a waypoint for every 25 s: at most 144 000 of a mission."""

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]
Fraction = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, lt=1)]
RelativeError = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=-0.5, lt=0.5)]
Count = Annotated[int, Field(strict=True, ge=0)]
Text = Annotated[str, Field(strict=True, min_length=1)]


def _beside_the_file(path: Path, info: ValidationInfo) -> Path:
    """A relative path is meant from the folder of the configuration."""
    folder = (info.context or {}).get("folder")
    return path if folder is None or path.is_absolute() else Path(folder) / path


NeighbourFile = Annotated[Path, AfterValidator(_beside_the_file)]


class Section(BaseModel):
    """A section: nothing but its own keys, and unchangeable."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=False)


class Place(Section):
    """A place in the arena."""

    x_m: Number = Field(description="metres to the right")
    y_m: Number = Field(description="metres up")


class Pose(Place):
    """A place and a heading."""

    heading_deg: Number = Field(default=0.0, description="degrees counter-clockwise from +x")

    @property
    def heading_rad(self) -> float:
        """The heading in radians in (-pi, pi]."""
        return wrapped_rad(self.heading_deg)


class Station(Place):
    """A place to visit."""

    heading_deg: Number | None = Field(
        default=None, description="heading to stand at, degrees; empty: any heading"
    )
    dwell_s: NotNegative = Field(default=0.0, description="how long to stay there")

    @property
    def heading_rad(self) -> float | None:
        """The heading in radians in (-pi, pi], None for any."""
        return None if self.heading_deg is None else wrapped_rad(self.heading_deg)


def wrapped_rad(heading_deg: float) -> float:
    """Degrees as radians in (-pi, pi]."""
    turned = math.remainder(math.radians(heading_deg), math.tau)
    return math.pi if turned == -math.pi else turned
