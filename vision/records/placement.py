"""Coordinates of a picture's records: its own pixels, or metres on the floor.

Rectified pixels are metres divided by the nominal pixel, y down as in the picture, so fits see the
same orientation and tolerances.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from planner.scene import (
    Arc,
    Bounds,
    CircleRecord,
    PointRecord,
    Record,
    SceneObject,
    Units,
    record_edges,
)
from vision.picture_error import PictureError
from vision.records.unseen import blind_of

_MILD = 0.2
"""Difference from nominal that does not matter: a fifth, as tolerances are chosen no finer."""


class PixelsToFloor(Protocol):
    """Part of a calibration that turns pixels into metres."""

    @property
    def metres_per_pixel(self) -> float:
        """Nominal size of a pixel on the floor."""
        ...

    def arena_from_image(self, points_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert points of the picture (n, 2) in pixels to arena metres (n, 2), y up."""
        ...


@dataclass(frozen=True, slots=True)
class Placement:
    """Scaling from rectified pixels to the scene's coordinates: x * scale, y * y_scale."""

    units: Units
    bounds: Bounds
    bounds_given: bool
    scale: float
    calibration: PixelsToFloor | None

    @classmethod
    def of(
        cls,
        calibration: PixelsToFloor | None,
        bounds: Bounds | Sequence[float] | NDArray[np.float64] | None,
        size: tuple[int, int],
    ) -> Placement:
        """Pixels without a calibration; otherwise metres inside the bounds or the seen ground.

        Raises ``PictureError`` for a calibration of another size, or for none.
        """
        width, height = size
        if calibration is not None and not hasattr(calibration, "arena_from_image"):
            raise PictureError(
                f"calibration: a {type(calibration).__name__}, must be a Calibration, as "
                f"load_calibration gives it"
            )
        # a caller's own calibration need not know its pictures' size
        fits: tuple[int, int] = getattr(calibration, "size", size)
        if tuple(fits) != (width, height):
            raise PictureError(
                f"the picture is {width} x {height} pixels: its calibration is for "
                f"{fits[0]} x {fits[1]}"
            )
        whole = Bounds(-0.5, -0.5, width - 0.5, height - 0.5)
        if calibration is None:
            return cls("px", whole, True, 1.0, None)
        scale = float(calibration.metres_per_pixel)
        if bounds is not None:
            return cls("m", _as_bounds(bounds), True, scale, calibration)
        blind = blind_of(calibration)
        rim = np.array(whole.corners())
        if blind is not None:
            rim = np.argwhere(~blind)[:, ::-1].astype(np.float64)
        seen = calibration.arena_from_image(rim)
        low, high = seen.min(axis=0), seen.max(axis=0)
        derived = Bounds(float(low[0]), float(low[1]), float(high[0]), float(high[1]))
        return cls("m", derived, False, scale, calibration)

    @property
    def y_scale(self) -> float:
        """Factor of a rectified y: metres have y up."""
        return self.scale if self.calibration is None else -self.scale

    def rectified(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert points of the picture (n, 2) to rectified pixels."""
        if self.calibration is None or len(points) == 0:
            return points
        metres = self.calibration.arena_from_image(points)
        return np.stack([metres[:, 0] / self.scale, metres[:, 1] / -self.scale], axis=1)

    def stretches(
        self,
        points: NDArray[np.float64],
        rectified: NDArray[np.float64],
        starts: NDArray[np.int64],
    ) -> NDArray[np.float64]:
        """Ratio (b,) of each border's length in rectified pixels to its length in the picture.

        A fit's tolerance is that of the picture's own pixels.
        """
        if self.calibration is None:
            return np.ones(len(starts) - 1)
        lengths = []
        for line in (rectified, points):
            steps = np.hypot(*(np.roll(line, -1, axis=0) - line).T)
            # a border's last step would lead to the next border's first point
            steps[starts[1:][starts[1:] > starts[:-1]] - 1] = 0.0
            total = np.concatenate([[0.0], np.cumsum(steps)])
            lengths.append(total[starts[1:]] - total[starts[:-1]])
        ratio = np.ones(len(starts) - 1)
        np.divide(lengths[0], lengths[1], out=ratio, where=(lengths[1] > 0.0) & (lengths[0] > 0.0))
        ratio[np.abs(np.log(ratio)) < _MILD] = 1.0
        return ratio


def ignored_pixels(
    ignore: NDArray[np.bool_] | Sequence[tuple[float, float, float]] | None, image: NDArray[Any]
) -> NDArray[np.bool_] | None:
    """Mask (h, w) of pixels that are not obstacle, from a mask or discs (x, y, radius)."""
    if ignore is None:
        return None
    if isinstance(ignore, np.ndarray) and ignore.dtype == np.bool_:
        return ignore
    try:
        discs = np.asarray(ignore, dtype=np.float64).reshape(-1, 3)
    except (TypeError, ValueError):
        raise PictureError("ignore: must be a mask, or discs (x, y, radius)") from None
    if not np.isfinite(discs).all() or (discs[:, 2] < 0.0).any():
        raise PictureError("ignore: a disc's centre and radius must be finite, the radius >= 0")
    height, width = image.shape[:2]
    mask = np.zeros((height, width), dtype=np.bool_)
    for x, y, radius in discs:
        left, right = max(0, int(x - radius)), min(width, int(x + radius) + 2)
        top, bottom = max(0, int(y - radius)), min(height, int(y + radius) + 2)
        if left >= right or top >= bottom:
            continue
        ys, xs = np.ogrid[top:bottom, left:right]
        mask[top:bottom, left:right] |= (xs - x) ** 2 + (ys - y) ** 2 <= radius * radius
    return mask


def _as_bounds(bounds: Bounds | Sequence[float] | NDArray[np.float64]) -> Bounds:
    if isinstance(bounds, Bounds):
        return bounds
    try:
        x_min, y_min, x_max, y_max = (float(value) for value in bounds)
    except (TypeError, ValueError):
        raise PictureError("bounds: must be Bounds, or x_min, y_min, x_max, y_max") from None
    given = Bounds(x_min, y_min, x_max, y_max)
    if not all(map(math.isfinite, (x_min, y_min, x_max, y_max))) or not (
        given.width > 0.0 and given.height > 0.0
    ):
        raise PictureError(
            f"bounds {x_min:g}, {y_min:g}, {x_max:g}, {y_max:g}: must be finite, the least of x "
            "and y first"
        )
    return given


def drop_outside(
    objects: tuple[SceneObject, ...], placement: Placement
) -> tuple[tuple[SceneObject, ...], tuple[str, ...]]:
    """Leave out objects whose box does not meet the bounds, and report their number."""
    if placement.calibration is None:
        return objects, ()
    kept = tuple(o for o in objects if _meets(o, placement.bounds))
    dropped = len(objects) - len(kept)
    if dropped == 0:
        return objects, ()
    which = "1 object was" if dropped == 1 else f"{dropped} objects were"
    return kept, (f"{which} left out: outside the bounds",)


def _meets(obj: SceneObject, bounds: Bounds) -> bool:
    low_x = low_y = np.inf
    high_x = high_y = -np.inf
    for record in obj.records:
        for x, y, r in _extents(record):
            low_x, high_x = min(low_x, x - r), max(high_x, x + r)
            low_y, high_y = min(low_y, y - r), max(high_y, y + r)
    return bool(
        low_x <= bounds.x_max
        and high_x >= bounds.x_min
        and low_y <= bounds.y_max
        and high_y >= bounds.y_min
    )


def _extents(record: Record) -> list[tuple[float, float, float]]:
    if isinstance(record, PointRecord):
        return [(*record.at, 0.0)]
    if isinstance(record, CircleRecord):
        return [(*record.center, record.radius)]
    found = []
    for edge in record_edges(record):
        found += [(*edge.start, 0.0), (*edge.end, 0.0)]
        if isinstance(edge, Arc):
            found.append((*edge.center, edge.radius))
    return found
