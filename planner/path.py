"""Answers of the planner: a path with its certified clearance, or the reason why there is none.

Units are those of the scene; angles are radians in the scene's own coordinates (counter-clockwise
in metres, y up; clockwise as seen in pictures, y down).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from planner.scene import FloatArray, Scene, Vec
from planner.scene.drawing import PATH, StyledLines, plot, to_svg

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, slots=True)
class Path:
    """Polyline from the start through the stations to the goal.

    ``points`` (n, 2) and ``clearances`` (n,) are read-only; ``min_clearance`` is exact for the
    whole polyline against every border and the bounds. ``stations`` are indices into ``points``:
    start, every via, goal. ``order`` is the order of visits to the vias, as indices into the
    request. ``headings_rad`` has one entry per station, None for any heading. ``remarks`` are
    sentences on uncertainties of the search. ``cost`` is the planner's criterion: the length, plus
    a penalty where the path is narrow, before any corner was rounded. ``scene`` is for pictures and
    not compared.
    """

    points: FloatArray
    clearances: FloatArray
    length: float
    min_clearance: float
    min_clearance_at: Vec
    robot_radius: float
    stations: tuple[int, ...]
    headings_rad: tuple[float | None, ...]
    order: tuple[int, ...] = ()
    alternatives: tuple[Path, ...] = ()
    remarks: tuple[str, ...] = ()
    cost: float | None = None
    scene: Scene | None = field(default=None, repr=False, compare=False)

    def __repr__(self) -> str:
        units = self.scene.units if self.scene is not None else ""
        length, least = (f"{v:.6g} {units}".rstrip() for v in (self.length, self.min_clearance))
        return f"<Path of {len(self.points)} points, length {length}, least clearance {least}>"

    def layers(self) -> list[StyledLines]:
        """Layers to draw: the scene, if any, the alternatives, and the path itself."""
        below = self.scene.layers() if self.scene is not None else []
        others = [other.points for other in self.alternatives]
        return [*below, StyledLines(others, PATH, 0.8), StyledLines([self.points], PATH, 2.2)]

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the path without its scene on Matplotlib axes, by default the current ones."""
        return plot(self.layers()[-2:], self.scene is not None and self.scene.y_down, axes)

    def _repr_svg_(self) -> str | None:
        """Picture for a notebook; None for a path without a scene."""
        if self.scene is None:
            return None
        title = f"a path of {len(self.points)} points"
        return to_svg(title, self.layers(), self.scene.view, self.scene.y_down)


@dataclass(frozen=True, slots=True)
class Bottleneck:
    """Narrowest place on the widest path; ``width`` is twice the clearance."""

    x: float
    y: float
    width: float


@dataclass(frozen=True, slots=True)
class NoPath:
    """Answer that there is no path for this robot; not a failure.

    ``widest_radius`` is the largest radius that could make the journey, None if no robot could
    (start or goal inside an obstacle, outside the bounds, or walled in).
    """

    reason: str
    bottleneck: Bottleneck | None = None
    widest_radius: float | None = None
    remarks: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return False


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of the robot; units of the scene and seconds, every value > 0.

    The straight line between two waypoints leaves the path by at most ``chord_tolerance``;
    waypoints are at most ``spacing`` apart. ``turns_on_spot`` is True for a differential drive.
    Below ``slow_clearance`` the speed falls linearly to ``slow_speed`` at the robot's radius. Bends
    tighter than ``turning_radius`` >= 0 are turned on the spot, at rest, or refused.
    """

    speed: float
    acceleration: float
    lateral_acceleration: float
    angular_rate_rad_s: float
    angular_acceleration_rad_s2: float
    jerk: float
    spacing: float
    chord_tolerance: float
    slow_clearance: float
    slow_speed: float
    turns_on_spot: bool = True
    turning_radius: float = 0.0


@dataclass(frozen=True, slots=True)
class TimedWaypoint:
    """Place on a trajectory; ``dwell_s`` is the length of the stay."""

    x: float
    y: float
    heading_rad: float
    speed: float
    time_s: float
    station: int | None = None
    dwell_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Trajectory:
    """Timed waypoints; the robot is at rest at the first and at the last."""

    waypoints: tuple[TimedWaypoint, ...]
    duration_s: float
