"""Trajectory Planning: from a scene to a roadmap, a path and timed waypoints.

Names are imported on first use, so that a module that needs the scene's types only does not
pay for the compiled kernels.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path as _FilePath
from typing import TYPE_CHECKING, Any

from planner.shared.kernel_cache import choose_kernel_cache

if TYPE_CHECKING:
    from planner.delaunay.half_edges import HalfEdges
    from planner.delaunay.voronoi_diagram import voronoi
    from planner.fleet.assignment import Assignment, assign_tasks
    from planner.fleet.fleet_plan import FleetPlan, NoFleetPlan
    from planner.fleet.on_graph import plan_on_graph
    from planner.fleet.on_roadmap import plan_fleet
    from planner.fleet.schedule import FleetSchedule
    from planner.formats.scene_io import load_scene, read_scene_text, write_scene_text
    from planner.motion.trajectory import time_path
    from planner.path import Bottleneck, Limits, NoPath, Path, Trajectory, Waypoint
    from planner.roadmap.roadmap import Roadmap, build_roadmap
    from planner.scene import (
        Arc,
        ArcRecord,
        Bounds,
        CircleRecord,
        PointRecord,
        PolygonRecord,
        Scene,
        SceneError,
        SceneObject,
        Segment,
        SegmentRecord,
    )

__all__ = [
    "Arc",
    "ArcRecord",
    "Assignment",
    "Bottleneck",
    "Bounds",
    "CircleRecord",
    "FleetPlan",
    "FleetSchedule",
    "HalfEdges",
    "Limits",
    "NoFleetPlan",
    "NoPath",
    "Path",
    "PointRecord",
    "PolygonRecord",
    "Roadmap",
    "Scene",
    "SceneError",
    "SceneObject",
    "Segment",
    "SegmentRecord",
    "Trajectory",
    "Waypoint",
    "assign_tasks",
    "build_roadmap",
    "load_scene",
    "plan_fleet",
    "plan_on_graph",
    "read_scene_text",
    "time_path",
    "voronoi",
    "write_scene_text",
]

choose_kernel_cache(_FilePath(__file__).parent)

_HOME = {
    "Arc": "planner.scene",
    "ArcRecord": "planner.scene",
    "Assignment": "planner.fleet.assignment",
    "Bottleneck": "planner.path",
    "Bounds": "planner.scene",
    "CircleRecord": "planner.scene",
    "FleetPlan": "planner.fleet.fleet_plan",
    "FleetSchedule": "planner.fleet.schedule",
    "HalfEdges": "planner.delaunay.half_edges",
    "Limits": "planner.path",
    "NoFleetPlan": "planner.fleet.fleet_plan",
    "NoPath": "planner.path",
    "Path": "planner.path",
    "PointRecord": "planner.scene",
    "PolygonRecord": "planner.scene",
    "Roadmap": "planner.roadmap.roadmap",
    "Scene": "planner.scene",
    "SceneError": "planner.scene",
    "SceneObject": "planner.scene",
    "Segment": "planner.scene",
    "SegmentRecord": "planner.scene",
    "Trajectory": "planner.path",
    "Waypoint": "planner.path",
    "assign_tasks": "planner.fleet.assignment",
    "build_roadmap": "planner.roadmap.roadmap",
    "load_scene": "planner.formats.scene_io",
    "plan_fleet": "planner.fleet.on_roadmap",
    "plan_on_graph": "planner.fleet.on_graph",
    "read_scene_text": "planner.formats.scene_io",
    "time_path": "planner.motion.trajectory",
    "voronoi": "planner.delaunay.voronoi_diagram",
    "write_scene_text": "planner.formats.scene_io",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'planner' has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
