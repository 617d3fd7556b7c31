"""Parts of a picture that show no floor to drive on: a lens folds, or looks sideways.

Rules and units
- A pixel is blind if no ray within the lens's reach is seen there, if its ray misses the floor, or
  if it covers more than ``MOST_STRETCH`` nominal pixels of length, where objects are missed. The
  mask is grown by ``MARGIN_PX``, so that edges are read where rays are.
- A plan shows places within the bounds that no pixel sees, or only a blind one.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from planner.scene import Bounds
from vision.calibration.lens_model import FloatArray

MOST_STRETCH = 30.0
"""A wall as thick, 6 cm where a pixel is 2 mm, is one pixel there."""
BLOCK_PX = 8
"""First step between pixels."""
MARGIN_PX = 6
"""Profiles across an edge are 4 px long (``vision.borders.edge_profile_kernels``)."""
_LOOKS_PX = np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
_PLAN_PX = 1024
"""Most places along a plan's longer side."""
_PLAN_MARGIN_PX = 8
"""Pixels by which the plan's blind part is grown: its outline is right to a pixel, without the
teeth of the mask's pixels, which are long on the floor."""
_REACH = 1e6
SAME_M = 1e-3
"""Distance from a place within which its pixel's place on the floor is the same."""


class Plan(NamedTuple):
    """``blind`` (h, w) of places, row 0 at the top; the first is at ``first_m`` (x, y), the others
    ``step_m`` apart."""

    blind: NDArray[np.bool_]
    first_m: tuple[float, float]
    step_m: float


class Seeing(Protocol):
    """The part of a calibration that this file uses."""

    def __hash__(self) -> int:
        """By identity: nothing in it changes."""

    @property
    def size(self) -> tuple[int, int]:
        """The picture's width and height."""

    @property
    def metres_per_pixel(self) -> float:
        """The nominal scale of the floor."""

    def arena_from_image(self, points_px: FloatArray) -> FloatArray:
        """Raw pixels (n, 2) to places, NaN where there is none."""

    def image_from_arena(self, points_m: FloatArray) -> FloatArray:
        """Places (n, 2) to raw pixels, NaN where there is none."""


@lru_cache(maxsize=16)
def blind_pixels(calibration: Seeing) -> NDArray[np.bool_] | None:
    """The mask (h, w), read-only; None if every pixel shows floor."""
    width, height = calibration.size
    stretch = _stretch(calibration)
    if (stretch <= MOST_STRETCH).all():
        return None
    hidden = ~(stretch <= MOST_STRETCH)
    corners = np.stack([hidden[:-1, :-1], hidden[:-1, 1:], hidden[1:, :-1], hidden[1:, 1:]])
    whole = np.kron(corners.all(axis=0), np.ones((BLOCK_PX, BLOCK_PX), np.bool_))
    mixed = np.kron(corners.any(axis=0), np.ones((BLOCK_PX, BLOCK_PX), np.bool_)) & ~whole
    mask = whole[:height, :width].astype(np.uint8)
    rows, columns = np.nonzero(mixed[:height, :width])
    pixels = np.column_stack([columns, rows]).astype(np.float64)
    mask[rows, columns] = ~(_stretch_at(calibration, pixels) <= MOST_STRETCH)
    grown = cv2.dilate(mask, _disc(MARGIN_PX)) > 0
    grown.setflags(write=False)
    return np.asarray(grown)


@lru_cache(maxsize=16)
def coarsest_pixel_m(calibration: Seeing) -> float:
    """Greatest length of floor, metres, that a pixel covers that is not blind."""
    stretch = _stretch(calibration)
    return float(stretch[stretch <= MOST_STRETCH].max()) * calibration.metres_per_pixel


@lru_cache(maxsize=16)
def blind_plan(calibration: Seeing, bounds: Bounds) -> Plan | None:
    """The blind part of the bounds as a plan; None if all of them is seen."""
    mask = blind_pixels(calibration)
    if mask is None:
        return None
    pixel_m = max(calibration.metres_per_pixel, max(bounds.width, bounds.height) / _PLAN_PX)
    columns, rows = math.ceil(bounds.width / pixel_m), math.ceil(bounds.height / pixel_m)
    x = bounds.x_min + (np.arange(columns) + 0.5) * pixel_m
    y = bounds.y_max - (np.arange(rows) + 0.5) * pixel_m
    places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    blind = _is_blind(calibration.image_from_arena(places), mask).reshape(rows, columns)
    if not blind.any():
        return None
    grown = cv2.dilate(blind.astype(np.uint8), _disc(_PLAN_MARGIN_PX)) > 0
    grown.setflags(write=False)
    return Plan(np.asarray(grown), (float(x[0]), float(y[0])), pixel_m)


def is_shown(calibration: Seeing, places_m: FloatArray) -> NDArray[np.bool_]:
    """True for each place (n, 2) on the floor in a part of the picture that is not blind."""
    width, height = calibration.size
    with np.errstate(all="ignore"):
        pixels = calibration.image_from_arena(places_m)
    inside = ((pixels > -0.5) & (pixels < (width - 0.5, height - 0.5))).all(axis=1)
    shown = np.zeros(len(places_m), np.bool_)
    back = calibration.arena_from_image(pixels[inside])
    shown[inside] = np.hypot(*(back - places_m[inside]).T) < SAME_M  # else it shows another place
    mask = blind_pixels(calibration)
    return shown if mask is None else shown & ~_is_blind(pixels, mask)


def _is_blind(pixels: FloatArray, mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """True if a place's pixel is blind or missing; beyond the rim the nearest pixel counts."""
    height, width = mask.shape
    near = np.nan_to_num(np.rint(pixels), nan=0.0, posinf=_REACH, neginf=-_REACH)
    near = np.clip(near, 0, (width - 1, height - 1)).astype(np.int64)
    return np.asarray(mask[near[:, 1], near[:, 0]] | ~np.isfinite(pixels[:, 0]))


def _stretch(calibration: Seeing) -> FloatArray:
    """Length that a pixel covers, in nominal pixels, at nodes (r, c); NaN without floor."""
    width, height = calibration.size
    xs = -0.5 + BLOCK_PX * np.arange(math.ceil(width / BLOCK_PX) + 1)
    ys = -0.5 + BLOCK_PX * np.arange(math.ceil(height / BLOCK_PX) + 1)
    nodes = np.stack(np.meshgrid(xs.clip(max=width - 0.5), ys.clip(max=height - 0.5)), axis=-1)
    return _stretch_at(calibration, nodes.reshape(-1, 2)).reshape(nodes.shape[:2])


def _stretch_at(calibration: Seeing, pixels: FloatArray) -> FloatArray:
    """The same at pixels (n, 2)."""
    looks = pixels[:, None, :] + _LOOKS_PX - 0.5 * (_LOOKS_PX[1] + _LOOKS_PX[2])
    seen = calibration.arena_from_image(looks.reshape(-1, 2)).reshape(-1, 3, 2)
    right, down = seen[:, 1] - seen[:, 0], seen[:, 2] - seen[:, 0]
    e, f, g = (right**2).sum(axis=1), (right * down).sum(axis=1), (down**2).sum(axis=1)
    longest = np.sqrt(0.5 * (e + g) + np.hypot(0.5 * (e - g), f))
    return np.asarray(longest / calibration.metres_per_pixel)


def _disc(radius: int) -> NDArray[np.uint8]:
    side = (2 * radius + 1, 2 * radius + 1)
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, side), dtype=np.uint8)
