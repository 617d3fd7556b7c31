"""One entry of the list `zones`, which becomes the planner's zone.

A mask is read once, where the entry is checked: the zone does not change with the file. It is not
read where the context of the check has its area, under `MASK`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final, Self

from pydantic import AfterValidator, Field, PrivateAttr, ValidationInfo, model_validator

from navigation.config.values import Name, NeighbourFile, Number, PathSpeed, Positive, Section
from planner.formats.mask_files import load_mask
from planner.scene import SceneError
from planner.zones.areas import Area, BandArea, CircleArea, MaskArea, PolygonArea
from planner.zones.zone import LEAST_COST, Zone, ZoneKind

MOST_ZONES: Final = 100
"""Chosen: more than a page can show apart."""
MOST_CORNERS: Final = 1000
"""Corners of a polygon: chosen."""
MOST_LINE_PLACES: Final = 100
"""Places of a line: chosen, a plan across a winding one-way zone of 100 takes a second."""
MASK: Final = "mask"
"""Key of a check's context: the area of a mask."""

Corner = tuple[Number, Number]


def _each_once(robots: tuple[str, ...]) -> tuple[str, ...]:
    for index, name in enumerate(robots):
        first = robots.index(name)
        if first < index:
            raise ValueError(f"'{name}' is robots[{first}] and robots[{index}]: must be named once")
    return robots


class ZoneSection(Section):
    """An area of the floor, and the rule that holds there: no obstacle, but as binding."""

    name: Name = Field(description="what messages call it: letters, digits, _ and -")
    kind: ZoneKind = Field(
        description="keep_out: no robot's body enters; slow: no faster than speed_m_s; one_way: "
        "not against the direction of its line; lane: preferred; wait: no goal and no waiting "
        "inside"
    )
    polygon: Annotated[tuple[Corner, ...], Field(min_length=3, max_length=MOST_CORNERS)] | None = (
        Field(default=None, description="corners [x, y] of the area, in order")
    )
    circle: tuple[Number, Number, Positive] | None = Field(
        default=None, description="instead: [x, y, radius]"
    )
    line: Annotated[tuple[Corner, ...], Field(min_length=2, max_length=MOST_LINE_PLACES)] | None = (
        Field(default=None, description="instead: places [x, y] of a band's middle, in order")
    )
    width_m: Positive | None = Field(default=None, description="the band's width, with line")
    mask: Annotated[NeighbourFile, AfterValidator(Path.absolute)] | None = Field(
        default=None,
        description="instead: the YAML file of a Nav2 keep-out mask, relative to this file",
    )
    robots: Annotated[tuple[Name, ...], AfterValidator(_each_once)] = Field(
        default=(), description="names of the robots that it is for; empty: all"
    )
    speed_m_s: PathSpeed | None = Field(
        default=None,
        description="highest speed inside, at least 0.01: needed for slow, possible for all but "
        "keep_out",
    )
    cost: Annotated[float, Field(strict=True, ge=LEAST_COST, le=1.0)] | None = Field(
        default=None,
        description="of a lane: cost of a metre along it, beside 1 on open floor; empty: 0.5",
    )
    _area: Area = PrivateAttr()

    @model_validator(mode="after")
    def _fits_together(self, info: ValidationInfo) -> Self:
        given = [key for key in ("polygon", "circle", "line", "mask") if getattr(self, key)]
        if len(given) != 1:
            told = " and ".join(given) if given else "no area"
            raise ValueError(f"has {told}: must have polygon, circle, line or mask, one of them")
        if (self.line is None) != (self.width_m is None):
            raise ValueError("line and width_m: must be given together")
        try:
            self._area = self._read_area((info.context or {}).get(MASK))
            self.zone()
        except SceneError as error:
            raise ValueError(str(error)) from None
        return self

    def zone(self) -> Zone:
        """Zone as the planner has it; `SceneError` if it is none."""
        return Zone(self.name, self.kind, self._area, self.robots, self.speed_m_s, self.cost)

    def is_for(self, robot: str) -> bool:
        """True if it holds for the robot of this name."""
        return not self.robots or robot in self.robots

    def _read_area(self, mask: MaskArea | None) -> Area:
        if self.polygon is not None:
            return PolygonArea(self.polygon)
        if self.circle is not None:
            x, y, radius = self.circle
            return CircleArea((x, y), radius)
        if self.line is not None and self.width_m is not None:
            return BandArea(self.line, self.width_m)
        assert self.mask is not None
        if mask is not None:
            return mask
        from navigation.shared.map_pictures import read_png_shades

        found = load_mask(self.mask, read_picture=read_png_shades)
        return MaskArea(found.objects, str(self.mask))
