"""The zones: a name, a kind, an area, the robots it is for, and a speed or cost.

- ``keep_out``: the body never enters.
- ``slow``: no faster than ``speed`` while any of the body is inside.
- ``one_way``: a band that is not driven against the direction of its line; it may be crossed.
- ``lane``: a band whose length costs ``cost`` times as much as open floor.
- ``wait``: no goal and no waiting inside: a crossing, a door.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, get_args

from planner.scene import SceneError
from planner.shared.arguments import as_float, as_list, brief, of_kind, one_of
from planner.zones.areas import Area, BandArea, CircleArea, MaskArea, PolygonArea

ZoneKind: TypeAlias = Literal["keep_out", "slow", "one_way", "lane", "wait"]
KIND_NAMES: Final[dict[ZoneKind, str]] = {
    "keep_out": "keep-out zone",
    "slow": "slow zone",
    "one_way": "one-way zone",
    "lane": "lane",
    "wait": "no-waiting zone",
}
LANE_COST: Final = 0.5
"""Default cost of a lane's length: chosen, a detour to a lane may double the length."""
LEAST_COST: Final = 0.05
"""Least cost of a lane's length: chosen, far below any that a person would set."""


@dataclass(frozen=True, slots=True)
class Zone:
    """One zone; :class:`SceneError` if its parts do not fit together.

    ``robots`` are the names of those it is for, none for all. ``speed`` > 0, in the scene's units a
    second, is needed for ``slow`` and possible for ``one_way``, ``lane`` and ``wait``. ``cost``,
    from ``LEAST_COST`` to 1, is a lane's only.
    """

    name: str
    kind: ZoneKind
    area: Area
    robots: tuple[str, ...] = ()
    speed: float | None = None
    cost: float | None = None

    def __post_init__(self) -> None:
        if not (isinstance(self.name, str) and self.name.isprintable() and self.name):
            raise SceneError(f"name {brief(self.name)}: must be printable text")
        one_of("kind", self.kind, *get_args(ZoneKind))
        of_kind("area", self.area, PolygonArea, CircleArea, BandArea, MaskArea)
        object.__setattr__(self, "robots", tuple(as_list("robots", self.robots, "names")))
        if self.kind in ("one_way", "lane") and not isinstance(self.area, BandArea):
            raise SceneError(f"{self}: needs a line with a width, which gives its direction")
        if self.speed is not None:
            self._check_speed()
        elif self.kind == "slow":
            raise SceneError(f"{self}: needs a speed")
        if self.cost is None and self.kind == "lane":
            object.__setattr__(self, "cost", LANE_COST)
        if self.cost is not None:
            self._check_cost(self.cost)

    def _check_speed(self) -> None:
        speed = as_float("speed", self.speed)
        if self.kind == "keep_out":
            raise SceneError(f"{self}: has no speed: nothing drives in it")
        if not 0.0 < speed < math.inf:
            raise SceneError(f"{self}: speed = {speed:g}: must be > 0 and finite")

    def _check_cost(self, given: float) -> None:
        cost = as_float("cost", given)
        if self.kind != "lane":
            raise SceneError(f"{self}: has no cost: only a lane has")
        if not LEAST_COST <= cost <= 1.0:
            raise SceneError(f"{self}: cost = {cost:g}: must be from {LEAST_COST:g} to 1")

    def __str__(self) -> str:
        return f"{KIND_NAMES[self.kind]} '{self.name}'"

    def is_for(self, robot: str) -> bool:
        """True if it holds for a robot."""
        return not self.robots or robot in self.robots


def zones_for(zones: Iterable[Zone], robot: str) -> tuple[Zone, ...]:
    """Return the zones that hold for a robot, in order."""
    return tuple(zone for zone in zones if zone.is_for(robot))
