"""Pictures with known contents, and what OpenCV finds in them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np

SEED = 20


def largest(picture: np.ndarray) -> np.ndarray:
    binary = cv2.threshold(cv2.medianBlur(picture, 3), 127, 255, cv2.THRESH_BINARY_INV)[1]
    contours = cv2.findContours(binary, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)[0]
    return max(contours, key=len)


def wanted(cell: str, cells: list[str]) -> bool:
    """Whether a row is asked for, by the beginning of its first column."""
    return not cells or any(cell.startswith(one) for one in cells)


def taken(drawn: np.ndarray, noise: float, rng: np.random.Generator) -> np.ndarray:
    """A drawing as a camera sees it: blurred, with less contrast, and noisy."""
    seen = cv2.GaussianBlur(drawn, (0, 0), 0.7).astype(np.float32) * np.float32(0.7) + 40.0
    if noise > 0.0:
        seen += rng.normal(0.0, noise, drawn.shape).astype(np.float32)
    return np.clip(np.rint(seen), 0, 255).astype(np.uint8)


def arena(size: tuple[int, int], count: int, seed: int) -> np.ndarray:
    """Polygons and discs on a jittered grid, without grey."""
    rng = np.random.default_rng([SEED, seed, count])
    width, height = size
    columns = math.ceil(math.sqrt(count * width / height))
    rows = math.ceil(count / columns)
    cell = min(width / columns, height / rows)
    picture = np.full((height, width), 255, np.uint8)
    for i in range(count):
        x = (i % columns + 0.5) * width / columns
        y = (i // columns + 0.5) * height / rows
        radius = cell * rng.uniform(0.25, 0.42)
        if i % 3 == 0:
            cv2.circle(picture, (round(x), round(y)), round(radius), 0, -1, cv2.LINE_AA)
            continue
        n = int(rng.integers(3, 8))
        angles = (np.arange(n) + rng.uniform(-0.3, 0.3, n)) * math.tau / n
        radii = radius * (1.0 if i % 3 == 1 else np.where(np.arange(n) % 2, 0.6, 1.0))
        points = np.stack([x + radii * np.cos(angles), y + radii * np.sin(angles)], axis=1)
        cv2.fillPoly(picture, [np.rint(points * 16).astype(np.int32)], 0, cv2.LINE_AA, 4)
    return picture


def opencv_contours(picture: np.ndarray) -> tuple[Sequence[np.ndarray], object]:
    binary = cv2.threshold(cv2.medianBlur(picture, 3), 127, 255, cv2.THRESH_BINARY_INV)[1]
    return cv2.findContours(binary, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
