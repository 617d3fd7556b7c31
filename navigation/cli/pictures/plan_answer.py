"""The answer of ``clearway plan``: as one JSON object (``clearway.plan/1``) and as text.

Every field is always there, null where it does not apply. Lengths are in the scene's units,
headings in radians in the scene's own sense, times in seconds, timings in milliseconds.
``bottleneck`` is the narrowest place: of the path where there is one, else of the widest way.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from planner.path import NoPath, Path, Trajectory
from planner.scene import Scene

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
    "total",
)


@dataclass(frozen=True, slots=True)
class PlanAnswer:
    """All that a plan has to say, ready to be written in either form."""

    scene: Scene
    robot_radius: float
    path: Path | NoPath
    trajectory: Trajectory | None = None
    counts: Mapping[str, int] = field(default_factory=dict)
    timings_ms: Mapping[str, float] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()

    def as_json(self) -> str:
        """The object as strict JSON, one line to a field."""
        return json.dumps(self.as_object(), allow_nan=False, indent=1)

    def as_object(self) -> dict[str, Any]:
        """The fields in the order of the design."""
        common = {
            "schema": SCHEMA,
            "status": "ok" if isinstance(self.path, Path) else "unreachable",
            "units": self.scene.units,
            "robot_radius": float(self.robot_radius),
        }
        measured = {
            "counts": {name: self.counts.get(name) for name in COUNTS},
            "timings_ms": {name: _rounded(self.timings_ms.get(name)) for name in STAGES},
            "remarks": list(self.remarks),
        }
        return common | self._result() | measured

    def _result(self) -> dict[str, Any]:
        if isinstance(self.path, Path):
            x, y = self.path.min_clearance_at
            width = 2.0 * self.path.min_clearance
            return {
                **_path_fields(self.path),
                "waypoints": _waypoints(self.trajectory),
                "duration": self.trajectory.duration_s if self.trajectory else None,
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
            "waypoints": None,
            "duration": None,
            "alternatives": None,
            "order": None,
            "reason": self.path.reason,
            "bottleneck": place,
            "widest_radius": None if widest is None else float(widest),
        }

    def no_path_sentence(self) -> str:
        """Why there is no path, for people; ``ValueError`` where there is one."""
        if isinstance(self.path, Path):
            raise ValueError("there is a path")
        units = self.scene.units
        return f"no path for a robot of radius {self.robot_radius:g} {units}: {self.path.reason}"

    def as_text(self) -> str:
        """For people: the result first, then the waypoints, then how it came about."""
        return "\n".join(self._lines()) + "\n"

    def _lines(self) -> Iterator[str]:
        units = self.scene.units
        if isinstance(self.path, NoPath):
            yield self.no_path_sentence()
            gap = self.path.bottleneck
            if gap:
                place = f"({gap.x:.6g}, {gap.y:.6g})"
                yield f"the widest way is {gap.width:.6g} {units} wide at {place}"
            if self.path.widest_radius is not None:
                yield f"the widest robot that fits has radius {self.path.widest_radius:.6g} {units}"
        else:
            yield from self._path_lines(self.path, units)
        for remark in self.remarks:
            yield f"note: {remark}"
        counts = ", ".join(
            f"{value} {name.replace('_', ' ')}" for name, value in self.counts.items()
        )
        yield f"from {counts}"
        stages = (f"{n} {self.timings_ms[n]:.1f}" for n in STAGES if n in self.timings_ms)
        yield f"ms: {', '.join(stages)}"

    def _path_lines(self, path: Path, units: str) -> Iterator[str]:
        x, y = path.min_clearance_at
        yield f"path of length {path.length:.6g} {units}"
        yield f"least clearance {path.min_clearance:.6g} {units} at ({x:.6g}, {y:.6g})"
        if len(path.stations) > 2:
            yield f"stations in the order {', '.join(str(k + 1) for k in path.order)}"
        for number, other in enumerate(path.alternatives, start=1):
            yield (
                f"alternative {number}: length {other.length:.6g} {units},"
                f" least clearance {other.min_clearance:.6g} {units}"
            )
        if self.trajectory:
            waypoints = self.trajectory.waypoints
            yield f"{len(waypoints)} waypoints, {self.trajectory.duration_s:.6g} s"
            yield f"{'x':>12}{'y':>12}{'heading':>10}{'speed':>10}{'time':>10}"
            for w in waypoints:
                yield (
                    f"{w.x:12.5g}{w.y:12.5g}{w.heading_rad:10.4f}{w.speed:10.4g}{w.time_s:10.3f}"
                )


def _path_fields(path: Path) -> dict[str, Any]:
    return {
        "path": path.points.tolist(),
        "length": float(path.length),
        "min_clearance": float(path.min_clearance),
    }


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
