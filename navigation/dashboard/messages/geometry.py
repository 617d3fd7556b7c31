"""The scene and its diagram as arrays for the page: borders, chains, the usable part.

Metres in the arena's frame, as float32: good to a micrometre in an arena of ten metres. A roadmap
never changes, so any thread may do this.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from navigation.dashboard.messages.packed import pack
from navigation.draw.outlines import chain_points
from planner.path import Path
from planner.scene import CircleRecord, FloatArray, PolygonRecord, Scene
from planner.zones.zoned_roadmap import ZonedRoadmap


def world_message(zoned: ZonedRoadmap, number: int) -> bytes:
    """The arena's contents: closed borders by object, open ones, and the diagram's chains.

    The chains are those of the search, around keep-out zones too, which are no borders. Arrays:
    ``border`` points with ``border_first`` (where each begins, and the end), ``border_object`` and
    ``border_closed``; ``chain`` points with ``chain_clearance``, ``chain_first`` and
    ``chain_usable`` (1: on the roadmap of this robot), cut where that ends.
    """
    scene = zoned.scene
    borders, owner, closed = border_lines(scene)
    chains = zoned.closed.clipped.chains
    usable = np.zeros(len(chains), dtype=np.uint8)
    usable[list(zoned.closed.kept)] = 1
    arrays: dict[str, NDArray[np.generic]] = {
        "border": _single(borders),
        "border_first": _firsts(borders),
        "border_object": np.array(owner, dtype=np.int32),
        "border_closed": np.array(closed, dtype=np.uint8),
        "chain": np.asarray(chains.points, dtype=np.float32),
        "chain_clearance": chain_clearances(zoned).astype(np.float32),
        "chain_first": np.asarray(chains.first, dtype=np.int32),
        "chain_usable": usable,
    }
    generators, vertices = zoned.walls.agvd.counts  # the ordinary diagram need not be made
    counts = {"generators": generators, "voronoi_vertices": vertices}
    counts["chains"] = len(zoned.walls.chains)
    fields = {"number": number, "objects": len(scene.objects), "counts": counts}
    return pack("world", fields, arrays)


def chain_clearances(zoned: ZonedRoadmap) -> FloatArray:
    """Distance (n,) of each of the chains' points from walls and obstacles: zones are none."""
    chains = zoned.closed.clipped.chains
    return chains.rho if zoned.closed is zoned.walls else zoned.clearance(chains.points)


def plan_message(path: Path | None, number: int) -> bytes:
    """The plan being driven; no points without one."""
    if path is None:
        return pack("plan", {"number": number}, {"points": np.empty(0, dtype=np.float32)})
    fields = {"number": number, **path_facts(path)}
    return pack("plan", fields, {"points": np.asarray(path.points, dtype=np.float32)})


def plans_message(paths: Mapping[str, Path | None], number: int) -> bytes:
    """Plans of several robots, ``plans`` by name; ``points`` of all, each from ``first`` on."""
    points = [np.empty((0, 2)) if path is None else path.points for path in paths.values()]
    plans = [
        {"name": name, **({} if path is None else path_facts(path))} for name, path in paths.items()
    ]
    arrays: dict[str, NDArray[np.generic]] = {"points": _single(points), "first": _firsts(points)}
    return pack("plans", {"number": number, "plans": plans}, arrays)


def path_facts(path: Path) -> dict[str, object]:
    """Length and clearance of a path, metres, and its remarks."""
    return {
        "length_m": path.length,
        "clearance_m": path.min_clearance,
        "narrowest_m": list(path.min_clearance_at),
        "radius_m": path.robot_radius,
        "remarks": list(path.remarks),
    }


def border_lines(scene: Scene) -> tuple[list[FloatArray], list[int], list[bool]]:
    """Every border as a polyline, its object, and true if it is closed."""
    borders: list[FloatArray] = []
    owner: list[int] = []
    closed: list[bool] = []
    for index, obj in enumerate(scene.objects):
        for record in (*obj.records, *(r for hole in obj.holes for r in hole)):
            borders.append(chain_points(record, scene.y_down))
            owner.append(index)
            closed.append(isinstance(record, PolygonRecord | CircleRecord))
    return borders, owner, closed


def _single(pieces: Iterable[FloatArray]) -> NDArray[np.float32]:
    return np.concatenate([np.empty((0, 2)), *pieces]).astype(np.float32)


def _firsts(pieces: list[FloatArray]) -> NDArray[np.int32]:
    return np.cumsum([0, *(len(piece) for piece in pieces)]).astype(np.int32)
