"""The answer of ``clearway plan``: as one JSON object (``clearway.plan/1``) and as text.

Every field is present, null if it does not apply; ``render`` of the timings only if a picture was
asked for. Lengths are in the scene's units, headings in radians in the scene's own sense, times in
seconds, timings in milliseconds; the text has headings in degrees. ``bottleneck`` is the narrowest
place on the path, or on the widest route if there is none. ``path``, ``length`` and
``min_clearance`` are of the path with rounded corners (``planner.round_corners``); ``unrounded``
has length and clearance of the planned path before that, and so has ``cost``, its length plus a
penalty for narrow places.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from planner.path import Limits, NoPath, Path, Trajectory
from planner.scene import Scene
from planner.shared.figures import at_most, placed, sized

SCHEMA = "clearway.plan/1"
COUNTS = (
    "border_pixels",
    "vertices",
    "generators",
    "voronoi_vertices",
    "roadmap_nodes",
    "roadmap_edges",
)
STAGES = (
    "load",
    "binarise",
    "contours",
    "geometry",
    "voronoi",
    "roadmap",
    "path",
    "trajectory",
    "render",
    "total",
)
DRAWING = "render"
NO_LIMITS = "neither pictures nor maps say what the robot can drive"


@dataclass(frozen=True, slots=True)
class PlanOutput:
    """A plan, to be written in either form; the trajectory keeps ``limits``.

    ``planned`` is the path of ``Roadmap.plan``, ``path`` the same with rounded corners.
    """

    scene: Scene
    robot_radius: float
    path: Path | NoPath
    planned: Path | NoPath
    trajectory: Trajectory | None = None
    limits: Limits | None = None
    counts: Mapping[str, int] = field(default_factory=dict)
    timings_ms: Mapping[str, float] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()

    def as_json(self) -> str:
        """Strict JSON, one line to a field."""
        return json.dumps(self.as_object(), allow_nan=False, indent=1)

    def as_object(self) -> dict[str, Any]:
        """Fields in the order in which they are written."""
        common = {
            "schema": SCHEMA,
            "status": "ok" if isinstance(self.path, Path) else "unreachable",
            "units": self.scene.units,
            "robot_radius": float(self.robot_radius),
        }
        measured = {
            "counts": {name: self.counts.get(name) for name in COUNTS},
            "timings_ms": {
                name: _rounded(self.timings_ms.get(name))
                for name in STAGES
                if name != DRAWING or name in self.timings_ms
            },
            "remarks": list(self.remarks),
        }
        return common | self._result() | measured

    def _result(self) -> dict[str, Any]:
        if isinstance(self.path, Path):
            x, y = self.path.min_clearance_at
            width = 2.0 * self.path.min_clearance
            return {
                **_path_fields(self.path),
                "unrounded": _measures(self.planned) if isinstance(self.planned, Path) else None,
                "waypoints": _waypoints(self.trajectory),
                "duration": self.trajectory.duration_s if self.trajectory else None,
                "speed_limit": self.limits.speed if self.limits else None,
                "alternatives": [_path_fields(p) for p in self.path.alternatives],
                "order": list(self.path.order),
                "reason": None,
                "bottleneck": {"x": float(x), "y": float(y), "width": float(width)},
                "widest_radius": None,
            }
        gap = self.path.bottleneck
        place = {"x": float(gap.x), "y": float(gap.y), "width": float(gap.width)} if gap else None
        widest = self.path.widest_radius
        return {
            "path": None,
            "length": None,
            "min_clearance": None,
            "cost": None,
            "unrounded": None,
            "waypoints": None,
            "duration": None,
            "speed_limit": None,
            "alternatives": None,
            "order": None,
            "reason": self.path.reason,
            "bottleneck": place,
            "widest_radius": None if widest is None else float(widest),
        }

    def no_path_sentence(self) -> str:
        """Reason why there is no path; ``ValueError`` if there is one."""
        if isinstance(self.path, Path):
            raise ValueError("there is a path")
        radius = sized(self.robot_radius, self.scene.units)
        return f"no path for a robot of radius {radius}: {self.path.reason}"

    def stage_times_ms(self) -> dict[str, float]:
        """Milliseconds of every stage that ran, in order."""
        return {name: self.timings_ms[name] for name in STAGES if name in self.timings_ms}

    def as_text(self, with_reason: bool = True) -> str:
        """The result for people, the waypoints, and how it came about.

        ``with_reason`` False omits why there is no path.
        """
        return "\n".join(self._lines(with_reason)) + "\n"

    def _lines(self, with_reason: bool) -> Iterator[str]:
        units = self.scene.units
        if isinstance(self.path, NoPath):
            if with_reason:
                yield self.no_path_sentence()
            if self.path.widest_radius is not None:
                widest = at_most(self.path.widest_radius, units)
                gap = self.path.bottleneck
                tight = f", tight at {placed(gap.x, gap.y)}" if gap else ""
                yield f"the widest robot that fits has radius {widest}{tight}"
        else:
            yield from self._path_lines(self.path, units)
        for remark in self.remarks:
            yield f"note: {remark}"
        counts = ", ".join(
            f"{value} {name.replace('_', ' ')}" for name, value in self.counts.items()
        )
        yield f"from {counts}"

    def _path_lines(self, path: Path, units: str) -> Iterator[str]:
        yield f"path of length {sized(path.length, units)}"
        least = sized(path.min_clearance, units)
        yield f"least clearance {least} at {placed(*path.min_clearance_at)}"
        planned = self.planned
        if isinstance(planned, Path):
            yield from _cost_lines(planned, path, units)
        if len(path.stations) > 2:
            yield f"stations in the order {', '.join(str(k + 1) for k in path.order)}"
        for number, other in enumerate(path.alternatives, start=1):
            cost = "" if other.cost is None else f"cost {sized(other.cost, units)}, "
            yield (
                f"alternative {number}: {cost}length {sized(other.length, units)},"
                f" least clearance {sized(other.min_clearance, units)}"
            )
        if self.trajectory:
            yield from self._waypoint_lines(self.trajectory, units)

    def _waypoint_lines(self, trajectory: Trajectory, units: str) -> Iterator[str]:
        waypoints = trajectory.waypoints
        yield f"{len(waypoints)} waypoints, {sized(trajectory.duration_s, 's')}"
        if self.limits:
            speed = sized(self.limits.speed, f"{units}/s")
            yield f"at {speed} at most, two radii a second: {NO_LIMITS}"
        names = (f"x {units}", f"y {units}", "heading deg", f"speed {units}/s", "time s")
        yield "".join(f"{name:>13}" for name in names)
        for w in waypoints:
            heading = round(math.degrees(w.heading_rad), 2) + 0.0
            yield f"{w.x:13.5g}{w.y:13.5g}{heading:13.2f}{w.speed:13.4g}{w.time_s:13.3f}"


def _cost_lines(planned: Path, path: Path, units: str) -> Iterator[str]:
    if planned.cost is not None:
        extra = sized(max(planned.cost - planned.length, 0.0), units)
        length = sized(planned.length, units)
        yield f"cost {sized(planned.cost, units)}: length {length}, narrow places {extra}"
    if path.length != planned.length or path.min_clearance != planned.min_clearance:
        yield (
            "planned path, before its corners are rounded: length"
            f" {sized(planned.length, units, beside=path.length)}, least clearance"
            f" {sized(planned.min_clearance, units, beside=path.min_clearance)}"
        )


def _path_fields(path: Path) -> dict[str, Any]:
    return {
        "path": path.points.tolist(),
        **_measures(path),
        "cost": None if path.cost is None else float(path.cost),
    }


def _measures(path: Path) -> dict[str, float]:
    return {"length": float(path.length), "min_clearance": float(path.min_clearance)}


def _waypoints(trajectory: Trajectory | None) -> list[dict[str, float]] | None:
    if trajectory is None:
        return None
    return [
        {
            "x": float(w.x),
            "y": float(w.y),
            "heading": float(w.heading_rad),
            "speed": float(w.speed),
            "time": float(w.time_s),
        }
        for w in trajectory.waypoints
    ]


def _rounded(milliseconds: float | None) -> float | None:
    return None if milliseconds is None else round(float(milliseconds), 3)
