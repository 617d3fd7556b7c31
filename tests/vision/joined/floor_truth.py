"""A floor with known shapes, as any camera over it sees it: the oracle of several cameras.

A shape is a closed polyline in metres, dense enough for a lens to bend its sides. A camera's
picture is the shape's exact coverage of its pixels, so it knows nothing of floor plans or seams.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from planner.scene import Arc, Bounds, Scene, record_edges
from tests.support.drawn.render import coverage
from vision.calibration.calibration import Calibration

Points = NDArray[np.float64]
Picture = NDArray[np.uint8]

SIZE = (640, 480)
BOUNDS = Bounds(0.0, 0.0, 2.0, 1.2)
LENS = (-0.08, 0.02, 0.0004, -0.0003, 0.0)
FLOOR, OBSTACLE = 205.0, 40.0


def camera(
    x_m: float,
    y_m: float,
    high_m: float = 2.0,
    tilt_deg: tuple[float, float] = (0.0, 0.0),
    turn_deg: float = 0.0,
    focal_px: float = 700.0,
    size: tuple[int, int] = SIZE,
) -> Calibration:
    """A camera that looks down, at most a little aside."""
    about = [math.radians(v) for v in (*tilt_deg, turn_deg)]
    turned = np.eye(3)
    for axis, angle in enumerate(about):
        one = np.zeros(3)
        one[axis] = angle
        turned = np.asarray(cv2.Rodrigues(one)[0]) @ turned
    rotation = turned @ np.diag([1.0, -1.0, -1.0])
    shift = -rotation @ np.array([x_m, y_m, high_m])
    matrix = [[focal_px, 0, (size[0] - 1) / 2], [0, focal_px, (size[1] - 1) / 2], [0, 0, 1]]
    return Calibration.from_camera(size, matrix, LENS, np.column_stack([rotation, shift]))


def disc(x_m: float, y_m: float, radius_m: float) -> Points:
    """A circle's polyline."""
    angles = np.linspace(0.0, math.tau, 360, endpoint=False)
    return np.array([x_m, y_m]) + radius_m * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def polygon(corners: list[tuple[float, float]]) -> Points:
    """A polygon's polyline with points every few millimetres."""
    ends = np.array(corners, dtype=float)
    sides = zip(ends, np.roll(ends, -1, axis=0), strict=True)
    share = np.linspace(0.0, 1.0, 80, endpoint=False)[:, None]
    return np.concatenate([a + (b - a) * share for a, b in sides])


def picture(
    calibration: Calibration,
    shapes: list[Points],
    *,
    noise: float = 2.0,
    light: float = 1.0,
    seed: int = 0,
) -> Picture:
    """What a camera sees of the shapes on the floor, with blur and noise."""
    outlines = [calibration.image_from_arena(shape) for shape in shapes]
    share = coverage(outlines, calibration.size) if outlines else np.zeros(calibration.size[::-1])
    grey = cv2.GaussianBlur(light * (FLOOR + (OBSTACLE - FLOOR) * share), (0, 0), 0.6)
    noisy = grey + np.random.default_rng(seed).normal(0.0, noise, grey.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


def outlines_of(scene: Scene) -> list[Points]:
    """Each object's border as points every few millimetres."""
    return [
        np.concatenate([_along(edge) for record in thing.records for edge in record_edges(record)])
        for thing in scene.objects
    ]


def _along(edge: object) -> Points:
    share = np.linspace(0.0, 1.0, 120)[:, None]
    if isinstance(edge, Arc):
        begin, sweep = edge.sweep(y_down=False)
        angles = begin + sweep * share
        ring = np.hstack([np.cos(angles), np.sin(angles)])
        return np.asarray(np.array(edge.center) + edge.radius * ring)
    a, b = np.array(edge.start), np.array(edge.end)  # type: ignore[attr-defined]
    return np.asarray(a + (b - a) * share)


def farthest_m(points: Points, line: Points) -> float:
    """How far the points lie from a closed polyline at most."""
    a, b = line, np.roll(line, -1, axis=0)
    along = b - a
    length2 = np.maximum((along**2).sum(axis=1), 1e-18)
    offset = points[:, None, :] - a
    share = np.clip((offset * along).sum(axis=2) / length2, 0.0, 1.0)[..., None]
    return float(np.hypot(*(offset - share * along).transpose(2, 0, 1)).min(axis=1).max())
