"""One zone's area, indexed for exact distances; and paths cut into short pieces."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from planner.borders.ground import Ground
from planner.borders.polyline import arc_lengths, points_at
from planner.scene import FloatArray, Scene, SceneObject
from planner.zones.areas import BandArea
from planner.zones.zone import Zone

SAME = 1e-9
"""Squared distances are equal within this share: chosen, far above rounding."""


@dataclass(frozen=True, slots=True)
class ZoneGround:
    """A zone, its outlines as objects, and the distances to them."""

    zone: Zone
    objects: tuple[SceneObject, ...]
    ground: Ground

    @classmethod
    def of(cls, zone: Zone, scene: Scene) -> ZoneGround:
        """Index a zone in a scene's units and frame."""
        objects = zone.area.outlines(y_down=scene.y_down)
        alone = replace(scene, objects=objects, unknown=None)
        return cls(zone, objects, Ground.of(alone, bounds=False))

    def distances(self, points: FloatArray) -> FloatArray:
        """Distance (n,) of points (n, 2) to the area's border, negative inside."""
        return self.ground.signed(points)

    def clearance(self, line: FloatArray) -> float:
        """Least distance of a polyline (n, 2) to the area, 0 where it touches it: exact."""
        if len(line) == 1:
            return max(float(self.distances(line)[0]), 0.0)
        return float(self.ground.clearances([line])[0][0])

    def directions(self, points: FloatArray) -> FloatArray:
        """Unit vectors (n, 2) of the band's line where it is nearest to points (n, 2).

        Beyond a corner of the line two pieces are equally near: the first counts.
        """
        assert isinstance(self.zone.area, BandArea)
        line = np.array(self.zone.area.line)
        begin, along = line[:-1], np.diff(line, axis=0)
        length = np.hypot(*along.T)
        off = points[:, None] - begin[None]
        share = np.clip((off * along).sum(axis=2) / length**2, 0.0, 1.0)
        away = off - share[..., None] * along
        apart = (away**2).sum(axis=2)
        nearest = np.argmax(apart <= (1.0 + SAME) * apart.min(axis=1, keepdims=True), axis=1)
        units: FloatArray = along[nearest] / length[nearest, None]
        return units


@dataclass(frozen=True, slots=True)
class PathPieces:
    """A path as short straight pieces: middles (n, 2) and steps (n, 2)."""

    middles: FloatArray
    steps: FloatArray

    @property
    def lengths(self) -> FloatArray:
        """Length (n,) of each piece."""
        lengths: FloatArray = np.hypot(*self.steps.T)
        return lengths


def cut(line: FloatArray, step: float) -> PathPieces:
    """Cut a polyline (n, 2) at its points and in pieces of at most ``step``."""
    along = arc_lengths(line)
    count = np.maximum(np.ceil(np.diff(along) / step).astype(int), 1)
    marks = [
        np.linspace(a, b, k, endpoint=False)
        for a, b, k in zip(along[:-1], along[1:], count, strict=True)
    ]
    at = np.concatenate([*marks, along[-1:]])
    points = points_at(line, along, at)
    return PathPieces(0.5 * (points[1:] + points[:-1]), np.diff(points, axis=0))
