"""Drawing of the simulated camera's view: the floor with its obstacles, and robots on it.

Rules
- A pixel averages several samples a side, so an edge's grey value shows its place, as on a sensor.
- Geometry is exact: every sample's ray meets the plane that it looks at.
- Pictures are grey; light and lens blur come with the drawing, noise comes with the camera.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from navigation.simulator.picture.pinhole import Pinhole
from planner.scene import (
    Arc,
    CircleRecord,
    Edge,
    FloatArray,
    PolygonRecord,
    Record,
    Scene,
    SceneError,
    SceneObject,
    record_edges,
)
from vision.camera.camera import Image

FloatImage: TypeAlias = NDArray[np.float32]

FLOOR_SAMPLES, ROBOT_SAMPLES = 4, 3
"""Samples a pixel and side: the floor is drawn once, robots in every frame."""
FLOOR_PASSES, ROBOT_PASSES = 8, 1
"""Passes, each with the samples shifted by a part of a sample: outlines are right to 1 / (2 samples
passes) of a pixel, 0.016 for the floor."""
LIGHT_GREY, DARK_GREY = 205.0, 45.0
"""Floor and obstacles, or the other way round."""
BODY_TOP_GREY, BODY_SIDE_GREY = 95.0, 65.0
MARKER_WHITE, MARKER_BLACK = 230.0, 25.0
OUTLINE_STEP_PX = 1.0
"""Length of an outline's chords: an arc of 20 px is 0.006 px off."""
SUBPIXEL_BITS = 8
PATCH_MARGIN_PX = 4
RAY_STEP_PX = 4
"""A power of two below 32, as OpenCV's linear look-up has 32 steps a pixel. Between the nodes
of a mild lens (1e-4 px of bend a pixel) the linear rays are within 1e-3 px."""

FAR = 1e6
"""A ray that meets nothing that is drawn."""

_NO_MAP = np.empty(0, dtype=np.float32)
"""Empty second map of OpenCV's remap: the first holds x and y."""


@dataclass(frozen=True, slots=True)
class Appearance:
    """Blur of the lens (sigma, pixels), noise (sigma, grey levels), darkening of the darkest corner
    (part of 1), and dark or light obstacles.
    """

    blur_px: float = 0.6
    noise_grey: float = 2.5
    light_fall: float = 0.12
    polarity: Literal["dark", "light"] = "dark"


class ArenaPainter:
    """Painter of the floor and the obstacles that lie flat on it.

    ``rays`` (h, w, 2) float32 are the pixels' normalised rays, ``light`` (h, w) the light.
    """

    def __init__(self, pinhole: Pinhole, look: Appearance) -> None:
        self._pinhole, self._look = pinhole, look
        width, height = pinhole.size_px
        self.rays = _rays(pinhole)
        self.light = _light(width, height, look.light_fall)
        unlit = ~np.isfinite(self.rays[:, :, 0])
        self.light[unlit] = 0.0
        self.rays[unlit] = FAR

    def picture(self, scene: Scene) -> Image:
        """Draw the arena (h, w) without robots or noise.

        Raises ``SceneError`` for objects without area.
        """
        dark, light = DARK_GREY, LIGHT_GREY
        obstacle, floor = (dark, light) if self._look.polarity == "dark" else (light, dark)
        covered = np.zeros(self.light.shape, dtype=np.float32)
        for thing in scene.objects:
            self._cover(thing, covered)
        grey = (floor + (obstacle - floor) * covered) * self.light
        return np.asarray(np.rint(blurred(grey, self._look.blur_px)).astype(np.uint8))

    def _cover(self, thing: SceneObject, covered: FloatImage) -> None:
        """Raise ``covered`` to the part of each pixel that the object covers."""
        step_m = OUTLINE_STEP_PX * float(self._pinhole.position_m[2] / self._pinhole.matrix[0, 0])
        outlines = [
            self._pinhole.image_from_arena(_outline(record, thing.id, step_m))
            for border in (thing.records, *thing.holes)
            for record in border
        ]
        box = box_around(np.concatenate(outlines), covered.shape)
        if box is None:
            return
        x0, y0, x1, y1 = box
        part = _coverage(
            [outline - (x0, y0) for outline in outlines],
            (x1 - x0, y1 - y0),
            FLOOR_SAMPLES,
            FLOOR_PASSES,
        )
        np.maximum(covered[y0:y1, x0:x1], part, out=covered[y0:y1, x0:x1])


class _Layers(NamedTuple):
    """Place of a robot in the picture, the part of each pixel seen past it, and its light."""

    here: tuple[slice, ...]
    uncovered: FloatImage
    grey: FloatImage


class RobotPainter:
    """Painter of one robot: an upright cylinder with its marker on top."""

    def __init__(
        self,
        pinhole: Pinhole,
        look: Appearance,
        painter: ArenaPainter,
        marker: Image,
        radius_m: float,
        marker_size_m: float,
        height_m: float,
        marker_turn_rad: float = 0.0,
    ) -> None:
        self._pinhole, self._look, self._painter = pinhole, look, painter
        self._radius_m, self._height_m, self._turn_rad = radius_m, height_m, marker_turn_rad
        sample_m = float(pinhole.position_m[2] - height_m) / float(pinhole.matrix[0, 0])
        sample_m /= ROBOT_SAMPLES
        self._top, self._texel_m = _top_texture(marker, radius_m, marker_size_m, sample_m)
        self._plane_from_ray = pinhole.plane_from_ray(height_m)
        self._drawn: tuple[object, _Layers | None] = None, None
        """Pose and layers drawn last: most robots of several are at rest."""
        self._seen: tuple[object, FloatArray] = None, np.empty((0, 2))
        """Pose and rims seen last."""
        turns = np.linspace(0.0, math.tau, 128, endpoint=False)
        rim = radius_m * np.column_stack([np.cos(turns), np.sin(turns)])
        self._rims = np.concatenate(
            [
                np.column_stack([rim, np.zeros(len(rim))]),
                np.column_stack([rim, np.full(len(rim), height_m)]),
            ]
        )

    def box(
        self, pose: tuple[float, float, float], shape: tuple[int, ...]
    ) -> tuple[int, int, int, int] | None:
        """Box of the pixels that the robot may touch: x0, y0, x1, y1; None if out of sight."""
        return box_around(self._rims_seen(pose), shape)

    def from_lens_m(self, pose: tuple[float, float, float]) -> float:
        """Distance from the robot's foot to the place below the lens."""
        x, y, _ = self._pinhole.position_m.tolist()
        return math.dist(pose[:2], (x, y))

    def _rims_seen(self, pose: tuple[float, float, float]) -> FloatArray:
        """Pixels (256, 2) of the lower and the upper rim."""
        if self._seen[0] != pose:
            x, y, _ = pose
            rims = self._pinhole.image_from_arena(self._rims + np.array([x, y, 0.0]))
            self._seen = pose, rims
        return self._seen[1]

    def paint(self, picture: Image, pose: tuple[float, float, float]) -> None:
        """Draw the robot at (x, y, heading) into ``picture``, in place."""
        if self._drawn[0] != (pose, picture.shape):
            self._drawn = (pose, picture.shape), self._layers(picture.shape, pose)
        layers = self._drawn[1]
        if layers is None:
            return
        here, uncovered, grey = layers
        mixed = picture[here] * uncovered + grey
        picture[here] = np.rint(np.clip(mixed, 0.0, 255.0)).astype(np.uint8)

    def _layers(self, shape: tuple[int, ...], pose: tuple[float, float, float]) -> _Layers | None:
        """The robot in a picture of this shape; None if out of sight."""
        rims = self._rims_seen(pose)
        box = box_around(rims, shape)
        if box is None:
            return None
        hull = cv2.convexHull(rims.astype(np.float32)).reshape(-1, 2).astype(np.float64)
        x0, y0, x1, y1 = box
        here = np.s_[y0:y1, x0:x1]
        layers = np.zeros((y1 - y0, x1 - x0, 3), dtype=np.float32)
        layers[:, :, 2] = _coverage(
            [hull - (x0, y0)], (x1 - x0, y1 - y0), ROBOT_SAMPLES, ROBOT_PASSES
        )
        top_box = box_around(rims[len(rims) // 2 :], shape)
        if top_box is not None:
            left, up, right, down = top_box
            top = self._top_seen(self._painter.rays[up:down, left:right], pose)
            layers[up - y0 : down - y0, left - x0 : right - x0, :2] = top
        grey_top, is_top, is_body = cv2.split(blurred(layers, self._look.blur_px))
        grey = grey_top + np.maximum(is_body - is_top, 0.0) * BODY_SIDE_GREY
        return _Layers(here, 1.0 - is_body, grey * self._painter.light[here])

    def _top_seen(self, rays: FloatImage, pose: tuple[float, float, float]) -> FloatImage:
        """Grey value of the top times its coverage, and its coverage, (h, w, 2)."""
        x, y, heading_rad = pose
        c, s = math.cos(heading_rad + self._turn_rad), math.sin(heading_rad + self._turn_rad)
        marker_from_arena = np.array(
            [[c, s, -c * x - s * y], [-s, c, s * x - c * y], [0.0, 0.0, 1.0]]
        )
        scale, centre = 1.0 / self._texel_m, (self._top.shape[0] - 1) / 2
        texture_from_marker = np.array(
            [[scale, 0.0, centre], [0.0, -scale, centre], [0.0, 0.0, 1.0]]
        )
        texture_from_ray = texture_from_marker @ marker_from_arena @ self._plane_from_ray
        return looked_up(self._top, rays, texture_from_ray, ROBOT_SAMPLES)


def looked_up(
    texture: Image, rays: FloatImage, texture_from_ray: FloatArray, samples: int
) -> FloatImage:
    """Sample a texture of (grey times coverage, 255 times coverage) along rays (h, w, 2).

    Returns grey times coverage and coverage in 0..1, (h, w, 2).
    """
    height, width = rays.shape[:2]
    fine = (width * samples, height * samples)
    every = cv2.resize(rays, fine, interpolation=cv2.INTER_LINEAR)
    places = cv2.perspectiveTransform(every, texture_from_ray)
    seen = cv2.remap(texture, places, _NO_MAP, cv2.INTER_LINEAR, borderValue=(0.0, 0.0))
    averaged = cv2.resize(seen, (width, height), interpolation=cv2.INTER_AREA)
    return np.asarray(averaged * np.array([1.0, 1.0 / 255.0]), dtype=np.float32)


def _top_texture(
    marker: Image, radius_m: float, marker_size_m: float, sample_m: float
) -> tuple[Image, float]:
    """Texture of the body's top with the marker, and the size of a texel in metres.

    The texture (t, t, 2) is grey times coverage and 255 times coverage. A texel is about a sample,
    so the linear look-up gives edges their ramp. A marker's cell is a whole number of texels, so
    cells end in the right place.
    """
    cells = marker.shape[0]
    texels = max(4, math.ceil(marker_size_m / cells / sample_m))
    texel_m = marker_size_m / cells / texels
    side = cells * texels
    half = math.ceil((radius_m - marker_size_m / 2) / texel_m) + 2
    whole = side + 2 * half
    grey = np.full((whole, whole), BODY_TOP_GREY, dtype=np.float32)
    quiet = max(0, half - texels)
    grey[quiet : whole - quiet, quiet : whole - quiet] = MARKER_WHITE
    fine = np.kron(marker, np.ones((texels, texels), dtype=np.uint8))
    grey[half : half + side, half : half + side] = np.where(fine > 0, MARKER_WHITE, MARKER_BLACK)
    from_centre = (np.arange(whole) - (whole - 1) / 2) * texel_m
    distance_m = np.hypot(from_centre[:, None], from_centre[None, :])
    covered = np.clip((radius_m - distance_m) / texel_m + 0.5, 0.0, 1.0).astype(np.float32)
    return np.rint(np.dstack([grey * covered, 255 * covered])).astype(np.uint8), texel_m


def _outline(record: Record, thing: int, step_m: float) -> FloatArray:
    """Points (n, 2) along a closed border, about ``step_m`` apart."""
    if not isinstance(record, PolygonRecord | CircleRecord):
        raise SceneError(
            f"object {thing}: a {type(record).__name__} has no area; "
            "the simulated camera draws circles (C) and generalized polygons (L)"
        )
    return np.concatenate([_along(edge, step_m) for edge in record_edges(record)])


def _along(edge: Edge, step_m: float) -> FloatArray:
    """Points along an edge without its end."""
    if isinstance(edge, Arc):
        start_rad, sweep_rad = edge.sweep(y_down=False)
        count = max(8, math.ceil(abs(sweep_rad) * edge.radius / step_m))
        turns = start_rad + sweep_rad * np.arange(count) / count
        circle = np.column_stack([np.cos(turns), np.sin(turns)])
        return np.asarray(np.array(edge.center) + edge.radius * circle)
    count = max(1, math.ceil(edge.length / step_m))
    share = (np.arange(count) / count)[:, None]
    return np.asarray(np.array(edge.start) * (1 - share) + np.array(edge.end) * share)


def box_around(points: FloatArray, shape: tuple[int, ...]) -> tuple[int, int, int, int] | None:
    """Box (x0, y0, x1, y1) around points, inside the picture; None if outside of it."""
    x0, y0 = np.floor(points.min(axis=0)).astype(int) - PATCH_MARGIN_PX
    x1, y1 = np.ceil(points.max(axis=0)).astype(int) + PATCH_MARGIN_PX + 1
    x0, y0, x1, y1 = max(0, x0), max(0, y0), min(shape[1], x1), min(shape[0], y1)
    return (int(x0), int(y0), int(x1), int(y1)) if x0 < x1 and y0 < y1 else None


def _coverage(
    outlines: list[FloatArray], size: tuple[int, int], samples: int, passes: int
) -> FloatImage:
    """Part (h, w) of each pixel inside the outlines (even-odd), in 0..1.

    OpenCV's fill includes the samples on the border, which makes shapes half a sample too large. So
    does filling the outside; the mean of both is right.
    """
    width, height = size
    fine = (height * samples, width * samples)
    # A frame far outside turns the even-odd fill into the outside's.
    far = 2.0 * max(fine)
    frame = np.array([[-far, -far], [far, -far], [far, far], [-far, far]])
    rings = [(outline + 0.5) * samples - 0.5 for outline in outlines]
    total = np.zeros(fine, dtype=np.float32)
    for shift in (np.arange(passes) + 0.5) / passes - 0.5:
        total += _filled([ring + shift for ring in rings], fine)
        total -= _filled([ring + shift for ring in (*rings, frame)], fine)
    covered = 0.5 + total / np.float32(2 * passes)
    return np.asarray(cv2.resize(covered, size, interpolation=cv2.INTER_AREA))


def _filled(rings: list[FloatArray], shape: tuple[int, int]) -> Image:
    """1 inside the rings and on them, 0 elsewhere."""
    mask = np.zeros(shape, dtype=np.uint8)
    fixed = [np.rint(ring * (1 << SUBPIXEL_BITS)).astype(np.int32) for ring in rings]
    cv2.fillPoly(mask, fixed, 1, shift=SUBPIXEL_BITS)
    return mask


def _rays(pinhole: Pinhole) -> FloatImage:
    """Ray (h, w, 2) of every pixel: exact every ``RAY_STEP_PX``, linear between.

    All exact for a fisheye, NaN outside its view.
    """
    width, height = pinhole.size_px
    if pinhole.lens_model == "fisheye":
        pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)
        return pinhole.rays(pixels.astype(np.float64)).reshape(height, width, 2).astype(np.float32)
    x = np.arange(0, width + RAY_STEP_PX, RAY_STEP_PX)
    y = np.arange(0, height + RAY_STEP_PX, RAY_STEP_PX)
    nodes = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2).astype(np.float64)
    exact = pinhole.rays(nodes).reshape(len(y), len(x), 2).astype(np.float32)
    columns, rows = np.meshgrid(np.arange(width), np.arange(height))
    where = (np.stack([columns, rows], axis=-1) / RAY_STEP_PX).astype(np.float32)
    return np.asarray(cv2.remap(exact, where, _NO_MAP, cv2.INTER_LINEAR), dtype=np.float32)


def _light(width: int, height: int, fall: float) -> FloatImage:
    """Light from a lamp a little off the centre: 1 at its brightest, 1 - fall at its darkest."""
    x = np.linspace(-1.0, 1.0, width, dtype=np.float32)[None, :]
    y = np.linspace(-1.0, 1.0, height, dtype=np.float32)[:, None]
    darkening = (x - 0.3) ** 2 + (y + 0.2) ** 2
    return np.asarray(1.0 - fall * darkening / float(darkening.max()), dtype=np.float32)


def blurred(image: FloatImage, sigma_px: float) -> FloatImage:
    """Return the picture with the lens's blur."""
    if sigma_px == 0.0:
        return image
    return np.asarray(cv2.GaussianBlur(image, (0, 0), sigma_px))
