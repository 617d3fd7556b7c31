"""The floor as several cameras see it: one picture to scale, and the camera for each part.

Rules and units
- The plan shows the floor from straight above: square pixels of the finest camera's scale, y down,
  the arena's bounds and a rim of ``PLAN_MARGIN_PX``. Its own calibration turns its pixels into
  metres.
- The camera with the least error shows each pixel: that of an edge in its picture, and that of
  height, as things lean away by their height times distance over height of the camera.
- So the pixel over an obstacle's foot shows that obstacle, or one in front of it, never the floor
  behind it. An obstacle on the seam is one region, fitted through both cameras' points.
- A pixel that no camera sees, or only a blind one, is unknown. This is a share, so that the border
  of unknown ground is straight to a fraction of a pixel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from planner.scene import Bounds
from vision.calibration.blind import SAME_M
from vision.calibration.calibration import (
    Calibration,
    CalibrationError,
    FloatArray,
    nominal_camera_matrix,
)
from vision.camera.camera import Image

PLAN_MARGIN_PX: Final = 12
"""Rim around the bounds: profiles across an edge reach so far."""
RIM_PX: Final = 3.0
"""Distance from its picture's rim within which a camera sees nothing: lenses and profiles end
there."""
EDGE_ERROR_PX: Final = 0.1
"""Error of an edge in a camera's picture; `python -m benchmarks.outlines` has less."""
UNEVEN_M: Final = 0.01
"""Least height of things on a floor: chosen, a strip of wood."""
MOST_PLAN_PX: Final = 12_000_000
"""Most pixels of a plan, by larger ones."""
DARKEST_FOR_GAIN: Final = 30.0
LEAST_FOR_GAIN: Final = 200
"""Least common pixels of two pictures whose light is compared."""
GAIN_STEP: Final = 5
"""Step between pixels, both ways: enough for a median."""

Shares: TypeAlias = NDArray[np.float32]
Owners: TypeAlias = NDArray[np.int8]
Rectangle: TypeAlias = tuple[int, int, int, int]


@dataclass(frozen=True, slots=True, eq=False)
class CameraPart:
    """Part of one camera: the pixels within ``box`` (x, y, width, height) where ``mask`` is set."""

    box: Rectangle
    mask: NDArray[np.uint8]

    @classmethod
    def of(cls, owners: Owners, index: int) -> CameraPart | None:
        """Part of one camera; None if it shows nothing."""
        own = (owners == index).view(np.uint8)
        x, y, width, height = cv2.boundingRect(own)
        if width == 0:
            return None
        return cls((x, y, width, height), own[y : y + height, x : x + width].copy())


@dataclass(frozen=True, slots=True, eq=False)
class FloorPlan:
    """The floor of an arena under several cameras, made by `FloorPlan.of`.

    ``calibration`` is the plan's own, ``cameras`` are the cameras'. ``depth_px`` (n, h, w): depth
    of a pixel inside each camera's picture, in pixels of the plan, below 0 outside; ``error_m`` (n,
    h, w): the camera's error, infinite where it sees nothing. ``maps``: places of the plan's pixels
    in each picture, for ``cv2.remap``.
    """

    calibration: Calibration
    cameras: tuple[Calibration, ...]
    depth_px: Shares
    error_m: Shares
    maps: tuple[tuple[NDArray[np.int16], NDArray[np.uint16]], ...]

    @classmethod
    def of(
        cls,
        cameras: Sequence[Calibration],
        bounds: Bounds,
        names: Sequence[str] = (),
        least_m: float = 0.0,
    ) -> FloorPlan:
        """Plan of the floor within ``bounds`` (metres) under these cameras.

        ``names`` are the cameras' in messages; pixels are at least ``least_m``. Raises
        ``CalibrationError`` without a camera, or if one sees nothing of the bounds. O(pixels x
        cameras).
        """
        if not cameras:
            raise CalibrationError("a floor plan needs a camera")
        calibration = _plan_of(bounds, max(least_m, min(one.metres_per_pixel for one in cameras)))
        width, height = calibration.size
        columns, rows = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
        floor = calibration.arena_from_image(np.stack([columns, rows], axis=-1).reshape(-1, 2))
        depth, error, maps = [], [], []
        for number, camera in enumerate(cameras):
            one_depth, one_error, one_map = _view(camera, floor, calibration)
            inner = one_depth[PLAN_MARGIN_PX:-PLAN_MARGIN_PX, PLAN_MARGIN_PX:-PLAN_MARGIN_PX]
            if not (inner > 0.0).any():
                name = names[number] if names else f"{number + 1} of {len(cameras)}"
                raise CalibrationError(
                    f"camera {name} sees nothing of the arena: its calibration and the arena's "
                    "bounds must be of one floor"
                )
            depth.append(one_depth)
            error.append(one_error)
            maps.append(one_map)
        return cls(calibration, tuple(cameras), np.stack(depth), np.stack(error), tuple(maps))

    def owners(self, live: Sequence[bool]) -> Owners:
        """Live camera that shows each pixel (h, w); -1 if none sees it."""
        error = self.error_m[np.flatnonzero(live)] if any(live) else None
        if error is None:
            return np.full(self.depth_px.shape[1:], -1, np.int8)
        best: Owners = np.flatnonzero(live)[error.argmin(axis=0)].astype(np.int8)
        best[~np.isfinite(error.min(axis=0))] = -1
        return best

    def unknown(self, live: Sequence[bool]) -> Shares | None:
        """Share of each pixel (h, w) that no live camera sees; None if all is seen.

        The rim repeats the shares at the bounds.
        """
        rim = PLAN_MARGIN_PX
        depth = np.full(self.depth_px.shape[1:], -1.0, np.float32)
        for index in np.flatnonzero(live):
            depth = np.maximum(depth, self.depth_px[index])
        inner = np.clip(0.5 - depth[rim:-rim, rim:-rim], 0.0, 1.0)
        if not (inner >= 0.5).any():
            return None
        return np.asarray(np.pad(inner, rim, mode="edge"), dtype=np.float32)

    def overlap(self, one: int, other: int, inside_px: float = 0.0) -> NDArray[np.bool_]:
        """Mask (h, w) of pixels more than ``inside_px`` inside both cameras' pictures."""
        a, b = self.depth_px[one], self.depth_px[other]
        return np.asarray((a > inside_px) & (b > inside_px))

    def seen_by(self, index: int, picture: Image) -> Image:
        """Map one camera's grey picture onto the plan (h, w); black where it sees nothing."""
        return np.asarray(cv2.remap(picture, *self.maps[index], cv2.INTER_LINEAR), dtype=np.uint8)

    def gains(self, pictures: Sequence[Image | None]) -> FloatArray:
        """Factor for each camera's greys that makes the same floor equally light.

        ``pictures``: grey, None if missing. From the pixels of all pairs of cameras (least squares
        of the logarithms); 1 without overlap.
        """
        there = [i for i, picture in enumerate(pictures) if picture is not None]
        thin = np.s_[::GAIN_STEP, ::GAIN_STEP]
        seen = {i: self.seen_by(i, picture)[thin] for i, picture in enumerate(pictures)
                if picture is not None}  # fmt: skip
        rows, ratios = [], []
        for first, a in enumerate(there):
            for b in there[first + 1 :]:
                both = self.overlap(a, b)[thin]
                both &= (seen[a] > DARKEST_FOR_GAIN) & (seen[b] > DARKEST_FOR_GAIN)
                if np.count_nonzero(both) < LEAST_FOR_GAIN:
                    continue
                row = np.zeros(len(pictures))
                row[a], row[b] = 1.0, -1.0
                rows.append(row)
                ratios.append(np.log(np.median(seen[b][both] / seen[a][both].astype(float))))
        if not rows:
            return np.ones(len(pictures))
        return np.asarray(np.exp(np.linalg.lstsq(np.array(rows), np.array(ratios), rcond=None)[0]))

    def picture(self, pictures: Sequence[Image | None], owners: Owners, gains: FloatArray) -> Image:
        """Picture of the plan (h, w): each pixel from its owner, others mirrored from beside them.

        ``pictures`` are grey; the owners of pixels must have one.
        """
        canvas = np.zeros(owners.shape, np.uint8)
        for index, picture in enumerate(pictures):
            part = None if picture is None else CameraPart.of(owners, index)
            if picture is not None and part is not None:
                self.draw(canvas, index, picture, part, float(gains[index]))
        _mirror_into(canvas, owners < 0)
        return canvas

    def draw(
        self, canvas: Image, index: int, picture: Image, part: CameraPart, gain: float = 1.0
    ) -> None:
        """Draw one camera's part into a picture of the plan (h, w), in place."""
        x, y, width, height = part.box
        box = np.s_[y : y + height, x : x + width]
        whole, fine = self.maps[index]
        shown = cv2.remap(picture, whole[box], fine[box], cv2.INTER_LINEAR)
        if gain != 1.0:
            shown = cv2.convertScaleAbs(shown, alpha=gain)
        cv2.copyTo(shown, part.mask, canvas[box])

    def rectangle(self, index: int, rectangle: Rectangle) -> Rectangle | None:
        """Rectangle of the plan that holds a camera's (x, y, width, height); None outside it."""
        x, y, w, h = rectangle
        along = np.linspace(0.0, 1.0, 9)
        xs, ys = x - 0.5 + w * along, y - 0.5 + h * along
        rim = [(u, v) for u in xs for v in (ys[0], ys[-1])]
        rim += [(u, v) for v in ys for u in (xs[0], xs[-1])]
        at = self.calibration.image_from_arena(self.cameras[index].arena_from_image(rim))
        width, height = self.calibration.size
        low = np.clip(np.floor(at.min(axis=0)), 0, (width, height)).astype(int)
        high = np.clip(np.ceil(at.max(axis=0)) + 1, 0, (width, height)).astype(int)
        if not (high > low).all():
            return None
        return int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1])

    def is_unknown(self, unknown: Shares, x_m: float, y_m: float, radius_m: float) -> bool:
        """True if a disc on the floor touches unknown ground."""
        ((x, y),) = self.calibration.image_from_arena([(x_m, y_m)]).tolist()
        radius = radius_m / self.calibration.metres_per_pixel
        height, width = unknown.shape
        x0, x1 = max(0, int(x - radius)), min(width, int(x + radius) + 2)
        y0, y1 = max(0, int(y - radius)), min(height, int(y + radius) + 2)
        if x0 >= x1 or y0 >= y1:
            return False
        rows, columns = np.ogrid[y0:y1, x0:x1]
        disc = (columns - x) ** 2 + (rows - y) ** 2 <= radius * radius
        return bool((unknown[y0:y1, x0:x1][disc] >= 0.5).any())


def _mirror_into(canvas: Image, uncovered: NDArray[np.bool_]) -> None:
    """Fill unseen pixels with the mirror image of seen ones beside them.

    This continues light and noise.
    """
    if not uncovered.any() or uncovered.all():
        return
    hidden = uncovered.view(np.uint8)
    _, labels = cv2.distanceTransformWithLabels(
        hidden, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    seen_rows, seen_columns = np.nonzero(~uncovered)
    place = np.zeros(int(labels.max()) + 1, np.int64)
    place[labels[seen_rows, seen_columns]] = np.arange(len(seen_rows))
    rows, columns = np.nonzero(uncovered)
    nearest = place[labels[rows, columns]]
    near_rows, near_columns = seen_rows[nearest], seen_columns[nearest]
    height, width = uncovered.shape
    over_rows = np.clip(2 * near_rows - rows, 0, height - 1)
    over_columns = np.clip(2 * near_columns - columns, 0, width - 1)
    beyond = uncovered[over_rows, over_columns]
    over_rows[beyond], over_columns[beyond] = near_rows[beyond], near_columns[beyond]
    canvas[rows, columns] = canvas[over_rows, over_columns]


def _plan_of(bounds: Bounds, metres_per_pixel: float) -> Calibration:
    coarsest = (bounds.width * bounds.height / MOST_PLAN_PX) ** 0.5
    s = max(metres_per_pixel, coarsest)
    width = int(np.ceil(bounds.width / s)) + 2 * PLAN_MARGIN_PX
    height = int(np.ceil(bounds.height / s)) + 2 * PLAN_MARGIN_PX
    x0 = bounds.x_min - (PLAN_MARGIN_PX - 0.5) * s
    y1 = bounds.y_max + (PLAN_MARGIN_PX - 0.5) * s
    floor = np.array([[s, 0.0, x0], [0.0, -s, y1], [0.0, 0.0, 1.0]])
    size = (width, height)
    return Calibration(size, nominal_camera_matrix(size), np.zeros(5), floor)


def _view(
    camera: Calibration, floor: FloatArray, plan: Calibration
) -> tuple[Shares, Shares, tuple[NDArray[np.int16], NDArray[np.uint16]]]:
    width, height = plan.size
    shape = (height, width)
    with np.errstate(all="ignore"):
        seen = camera.image_from_arena(floor)
    right, low = camera.size[0] - 0.5, camera.size[1] - 0.5
    x, y = seen.T
    rim = np.minimum(np.minimum(x + 0.5, right - x), np.minimum(y + 0.5, low - y))
    rim = np.where(np.isfinite(rim), rim, -np.inf)
    blind = camera.blind
    if blind is not None:
        to_blind = cv2.distanceTransform((~blind).view(np.uint8), cv2.DIST_L2, 5)
        at = np.flatnonzero(rim > 0.0)
        columns, rows = np.rint(seen[at]).astype(np.int64).T
        rim[at] = np.minimum(rim[at], to_blind[rows, columns])
    inside = np.flatnonzero(rim > 0.0)
    back = camera.arena_from_image(seen[inside])
    away = ~(np.hypot(*(back - floor[inside]).T) < SAME_M)
    rim[inside[away]] = -np.inf
    x_grid, y_grid = x.reshape(shape), y.reshape(shape)
    (xv, xu), (yv, yu) = np.gradient(x_grid), np.gradient(y_grid)
    with np.errstate(all="ignore"):
        zoom = np.sqrt(np.abs(xu * yv - xv * yu)).reshape(-1)
        depth = (rim - RIM_PX) / zoom
        pixel_m = plan.metres_per_pixel / zoom
    depth = np.where(np.isfinite(depth), depth, -1e6)
    foot, high_m = _place(camera)
    lean = np.hypot(*(floor - foot).T) / high_m
    error = np.hypot(EDGE_ERROR_PX * pixel_m, UNEVEN_M * lean)
    error = np.where(depth > 0.0, error, np.inf)
    where = np.nan_to_num(seen, nan=-1e4, posinf=-1e4, neginf=-1e4).clip(-1e4, 3e4)
    maps = cv2.convertMaps(
        where[:, 0].reshape(shape).astype(np.float32),
        where[:, 1].reshape(shape).astype(np.float32),
        cv2.CV_16SC2,
    )
    whole, fine = np.asarray(maps[0], dtype=np.int16), np.asarray(maps[1], dtype=np.uint16)
    return (
        depth.reshape(shape).astype(np.float32),
        error.reshape(shape).astype(np.float32),
        (whole, fine),
    )


def _place(camera: Calibration) -> tuple[FloatArray, float]:
    """Point below the camera and its height; if unknown, as if it looked straight down."""
    center = camera.camera_center_m
    if center is not None:
        return np.array(center[:2]), center[2]
    width, height = camera.size
    middle = camera.arena_from_image([((width - 1) / 2.0, (height - 1) / 2.0)])[0]
    return middle, float(camera.metres_per_pixel * max(width, height))
