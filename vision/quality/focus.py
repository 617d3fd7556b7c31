"""Sharpness of a picture, tile by tile: the spread of its edges.

Rules and units
- An edge's blur is the sigma, in pixels, of the Gaussian that makes it from a step: the step's
  height over its steepest slope times sqrt(2 pi).
- A tile without a clear edge is not judged.
- From 3 pixels on, noise cuts off the edge's ends, and the blur is larger than reported.
- A blur of at most `SHARP_PX` is in focus.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from planner.scene import FloatArray
from vision.camera.camera import Image

SHARP_PX: Final = 1.5
"""A marker's cell of 6 pixels keeps its plateau up to here, 4 sigma of its border."""
LEAST_STEP: Final = 40.0
"""Grey levels; less is a shadow or texture."""
REACH_PX: Final = 10
"""Half the length of the profile across an edge: room for a blur of 4 pixels."""
STEP_PX: Final = 0.25
AVERAGED_PX: Final = 1.0 / math.sqrt(12.0)
"""Blur that averaging the slopes over a pixel adds."""
TILES: Final = (8, 6)
MOST_EDGES: Final = 60
"""Most edge pixels of a tile."""
LEAST_EDGES: Final = 8


@dataclass(frozen=True, slots=True, eq=False)
class Focus:
    """Blur by tiles: ``blur_px`` (rows, columns), NaN where a tile has no edge to judge."""

    blur_px: FloatArray

    @property
    def judged(self) -> float:
        """Share of tiles that can be judged."""
        return float(np.mean(np.isfinite(self.blur_px)))

    @property
    def sharp(self) -> float | None:
        """Share of the judged tiles in focus; None if none is judged."""
        known = self.blur_px[np.isfinite(self.blur_px)]
        return float(np.mean(known <= SHARP_PX)) if len(known) else None

    @property
    def median_px(self) -> float | None:
        """Median blur of the judged tiles."""
        known = self.blur_px[np.isfinite(self.blur_px)]
        return float(np.median(known)) if len(known) else None


def focus_of(image: Image, mask: Image | None = None) -> Focus:
    """Blur of a grey picture's tiles; only edges within ``mask`` count."""
    smooth = cv2.GaussianBlur(image, (0, 0), 1.5)
    edges = cv2.Canny(smooth, 30, 90, L2gradient=True)
    if mask is not None:
        edges = cv2.bitwise_and(edges, mask)
    right = cv2.Sobel(smooth, cv2.CV_32F, 1, 0)
    down = cv2.Sobel(smooth, cv2.CV_32F, 0, 1)
    columns, rows = TILES
    height, width = image.shape
    blur = np.full((rows, columns), np.nan)
    for row in range(rows):
        for column in range(columns):
            top, left = row * height // rows, column * width // columns
            part = edges[top : (row + 1) * height // rows, left : (column + 1) * width // columns]
            y, x = np.nonzero(part)
            if len(x) < LEAST_EDGES:
                continue
            some = np.linspace(0, len(x) - 1, min(len(x), MOST_EDGES)).astype(int)
            points = np.stack([x[some] + left, y[some] + top], axis=1)
            normals = np.stack(
                [right[points[:, 1], points[:, 0]], down[points[:, 1], points[:, 0]]], axis=1
            )
            blur[row, column] = blur_across(image, points.astype(np.float64), normals)
    return Focus(blur)


def blur_along(image: Image, corners_px: FloatArray) -> float | None:
    """Blur of a quadrilateral's sides, such as a marker's (4, 2); None if too few are clear."""
    points, normals = [], []
    for begin, end in zip(corners_px, np.roll(corners_px, -1, axis=0), strict=True):
        side = end - begin
        for share in np.linspace(0.2, 0.8, 12):
            points.append(begin + share * side)
            normals.append((-side[1], side[0]))
    blur = blur_across(image, np.array(points), np.array(normals))
    return None if math.isnan(blur) else blur


def blur_across(image: Image, points: FloatArray, normals: FloatArray) -> float:
    """Median blur of the edges at points (n, 2), across them; NaN if too few are clear."""
    lengths = np.hypot(normals[:, 0], normals[:, 1])
    keep = lengths > 0.0
    points, normals = points[keep], normals[keep] / lengths[keep, None]
    if len(points) < LEAST_EDGES:
        return math.nan
    offsets = np.arange(-REACH_PX, REACH_PX + STEP_PX / 2, STEP_PX)
    at = points[:, None, :] + offsets[None, :, None] * normals[:, None, :]
    profiles = cv2.remap(
        image, at[..., 0].astype(np.float32), at[..., 1].astype(np.float32),
        cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE,
    ).astype(np.float64)  # fmt: skip
    sigmas = np.array([_sigma_of(profile) for profile in profiles])
    known = sigmas[np.isfinite(sigmas)]
    return float(np.median(known)) if len(known) >= LEAST_EDGES else math.nan


def _sigma_of(profile: FloatArray) -> float:
    """Blur of one step; NaN if the profile turns or is too low."""
    middle = len(profile) // 2
    if profile[-1] < profile[0]:
        profile = -profile
    slopes = np.convolve(np.diff(profile) / STEP_PX, np.ones(4) / 4.0, mode="same")
    near = slice(middle - 8, middle + 8)
    peak = near.start + int(np.argmax(slopes[near]))
    rest = 0.05 * slopes[peak]
    left, right = peak, peak
    while left > 0 and slopes[left - 1] > rest:
        left -= 1
    while right < len(slopes) - 1 and slopes[right + 1] > rest:
        right += 1
    if left == 0 or right == len(slopes) - 1:
        return math.nan
    low = profile[max(0, left - 3) : left + 1].mean()
    high = profile[right + 1 : right + 5].mean()
    step = high - low
    if step < LEAST_STEP or slopes[peak] <= 0.0:
        return math.nan
    sigma = step / (math.sqrt(2.0 * math.pi) * slopes[peak])
    return math.sqrt(max(sigma * sigma - AVERAGED_PX**2, 0.0))
