"""Distance of a replay from its recording, and the tolerances.

Scenes and paths are compared as curves: the greatest distance from a place on one to the nearest
place on the other, both ways (Hausdorff). Metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np

from navigation.draw.outlines import object_lines
from planner.borders.polyline import distances_to_polyline
from planner.path import NoPath, Path
from planner.scene import FloatArray, Scene

SAMPLE_M: Final = 0.01
"""Distance of the places at which curves are compared."""
ROWS_AT_ONCE: Final = 512


@dataclass(frozen=True, slots=True)
class ComparisonTolerances:
    """Largest differences that count as equal; defaults allow for JPEG and skipped pictures."""

    position_m: float = 0.003
    heading_rad: float = math.radians(1.0)
    scene_m: float = 0.006
    path_m: float = 0.03
    clearance_m: float = 0.01


@dataclass(frozen=True, slots=True)
class Difference:
    """Kind (``pose``, ``scene``, ``plan``), time and sentence."""

    kind: str
    time_s: float
    sentence: str


def scene_distance_m(one: Scene, other: Scene) -> float:
    """Distance of two scenes' borders; inf if only one has any."""
    return _curve_distance_m(_borders(one), _borders(other))


def _borders(scene: Scene) -> list[FloatArray]:
    return [line for thing in scene.objects for line in object_lines(thing, scene.y_down)]


def path_distance_m(one: FloatArray, other: FloatArray) -> float:
    """Distance of two polylines (n, 2) and (m, 2)."""
    return _curve_distance_m([one], [other])


def _curve_distance_m(one: list[FloatArray], other: list[FloatArray]) -> float:
    if not one and not other:
        return 0.0
    if not one or not other:
        return math.inf
    return max(_directed_m(one, other), _directed_m(other, one))


def _directed_m(lines: list[FloatArray], others: list[FloatArray]) -> float:
    places = np.vstack([_places(line) for line in lines])
    worst = 0.0
    for part in np.split(places, range(ROWS_AT_ONCE, len(places), ROWS_AT_ONCE)):
        gaps = np.min([distances_to_polyline(line, part) for line in others], axis=0)
        worst = max(worst, float(gaps.max()))
    return worst


def _places(line: FloatArray) -> FloatArray:
    if len(line) == 1:
        return line
    parts = []
    for start, end in pairwise(line):
        count = max(1, math.ceil(math.dist(start, end) / SAMPLE_M))
        parts.append(start + (end - start) * (np.arange(count) / count)[:, None])
    return np.vstack([*parts, line[-1:]])


def pose_offset(
    recorded: tuple[float, float, float], seen: tuple[float, float, float]
) -> tuple[float, float]:
    """Distance of two poses: metres, radians."""
    off_rad = abs(math.remainder(recorded[2] - seen[2], math.tau))
    return math.dist(recorded[:2], seen[:2]), off_rad


def pose_problem(off_m: float, off_rad: float, limits: ComparisonTolerances) -> str | None:
    """Difference of two poses in words; None if they agree."""
    if off_m <= limits.position_m and off_rad <= limits.heading_rad:
        return None
    return (
        f"is {off_m * 1e3:.1f} mm and {math.degrees(off_rad):.2f} deg off: at most "
        f"{limits.position_m * 1e3:g} mm and {math.degrees(limits.heading_rad):g} deg"
    )


def plan_offset_m(recorded: dict[str, Any], found: Path | NoPath) -> float:
    """Distance of two paths; 0 if one or both are missing."""
    if recorded["status"] != "ok" or isinstance(found, NoPath):
        return 0.0
    return path_distance_m(np.asarray(recorded["path"], dtype=np.float64), found.points)


def gates_problem(recorded: Sequence[Mapping[str, Any]], others: Sequence[str]) -> str | None:
    """Difference in right of way, in words; None if they agree."""
    before = [gate["other"] for gate in recorded]
    if before == list(others):
        return None
    here, there = (", then ".join(names) or "nobody" for names in (others, before))
    return f"gives way to {here}, the recorded one to {there}"


def plan_problem(
    recorded: dict[str, Any], found: Path | NoPath, off_m: float, limits: ComparisonTolerances
) -> str | None:
    """Difference of a plan from the recorded answer, in words; None if they agree."""
    if recorded["status"] != "ok":
        if isinstance(found, NoPath):
            return None
        return f"was impossible ({recorded['reason']}), now there is one of {found.length:.3f} m"
    if isinstance(found, NoPath):
        return f"of {recorded['length_m']:.3f} m is impossible now: {found.reason}"
    if off_m > limits.path_m:
        return f"leaves the recorded one by {off_m * 1e3:.1f} mm: at most {limits.path_m * 1e3:g}"
    if abs(recorded["min_clearance_m"] - found.min_clearance) > limits.clearance_m:
        return (
            f"keeps {found.min_clearance:.4f} m of clearance, the recorded one "
            f"{recorded['min_clearance_m']:.4f}: at most {limits.clearance_m * 1e3:g} mm apart"
        )
    return None
