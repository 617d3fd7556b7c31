"""Records of crisp objects drawn again: how much of the object they cover."""

from __future__ import annotations

import math

import cv2
import numpy as np

from benchmarks.vision.pictures import SEED, largest, wanted
from planner.scene import PolygonRecord, object_records
from tests.support.drawn.render import centers_inside, coverage, outline_points
from vision import extract

KINDS = ("rectangle", "disc", "half disc", "stadium", "star", "ellipse", "blob")
"""The shapes that ``outline`` draws."""
BY_OPENCV = ("thick line", "filled polygon", "filled ellipse", "smooth disc")
"""Those that OpenCV draws, ``outline_by_opencv``: as pictures of arenas are often made. Its smooth
discs are polygons, drawn with grey that is rounded to black and white."""


def outline(rng: np.random.Generator, kind: str) -> np.ndarray:
    """A mask (200, 200) of one crisp object."""
    angle = rng.uniform(0, math.tau)
    y, x = np.mgrid[0:200, 0:200] - 100.0 - rng.uniform(-0.5, 0.5, 2)[:, None, None]
    u = x * math.cos(angle) + y * math.sin(angle)
    v = y * math.cos(angle) - x * math.sin(angle)
    if kind == "rectangle":
        w, h = rng.uniform(11, 65, 2)
        return (abs(u) <= w) & (abs(v) <= h)
    if kind == "disc":
        return np.hypot(u, v) <= rng.uniform(12, 85)
    if kind == "half disc":
        return (np.hypot(u, v) <= rng.uniform(20, 85)) & (v >= 0)
    if kind == "stadium":
        return np.hypot(np.maximum(abs(u) - rng.uniform(8, 45), 0), v) <= rng.uniform(12, 40)
    if kind == "ellipse":
        a, b = rng.uniform(14, 85, 2)
        return (u / a) ** 2 + (v / b) ** 2 <= 1
    if kind == "blob":
        t = np.arctan2(v, u)
        waves = 1 + 0.18 * np.sin(3 * t) + 0.08 * np.cos(5 * t + 1)
        return np.hypot(u, v) <= rng.uniform(30, 70) * waves
    n = 2 * int(rng.integers(4, 8))
    r = rng.uniform(25, 85) * np.where(np.arange(n) % 2, rng.uniform(0.4, 0.75), 1.0)
    t = angle + np.arange(n) * math.tau / n
    star = 100 + np.stack([r * np.cos(t), r * np.sin(t)], axis=1)
    return coverage([star], (200, 200), lines=1) >= 0.5


def outline_by_opencv(rng: np.random.Generator, kind: str) -> np.ndarray:
    """A mask (200, 200) of one object that OpenCV drew."""
    mask = np.zeros((200, 200), np.uint8)
    if kind == "thick line":
        begin, end = rng.integers(30, 170, (2, 2)).tolist()
        cv2.line(mask, begin, end, 1, int(rng.integers(3, 20)))
    elif kind == "filled polygon":
        corners = int(rng.integers(3, 12))
        angles = np.sort(rng.uniform(0.0, math.tau, corners))
        vertices = 100.0 + rng.uniform(8, 90) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        cv2.fillPoly(mask, [np.rint(vertices).astype(np.int32)], 1)
    elif kind == "smooth disc":
        grey = np.zeros((200, 200), np.uint8)
        center = np.rint(16.0 * (100.0 + rng.uniform(-1.0, 1.0, 2))).astype(int).tolist()
        cv2.circle(grey, center, round(16.0 * rng.uniform(10, 85)), 255, -1, cv2.LINE_AA, 4)
        return grey > 127
    else:
        axes = (int(rng.integers(10, 60)), int(rng.integers(8, 60)))
        cv2.ellipse(mask, (100, 100), axes, float(rng.uniform(0.0, 180.0)), 0, 360, 1, -1)
    return mask > 0


def cover_table(count: int, cells: list[str]) -> list[str]:
    """Records of crisp objects of 400 px and more drawn again, beside approxPolyDP's.

    A pixel is drawn where its centre lies inside.
    """
    lines = [
        "| shape | method | least IoU | below 0.995 | most Hausdorff px | edges, mean |",
        "|---|---|---|---|---|---|",
    ]
    for kind in (*KINDS, *BY_OPENCV):
        if not wanted(kind, cells):
            continue
        rows: dict[str, list[tuple[float, float, int]]] = {
            "clearway": [], "cv2.approxPolyDP, 1 px": [],
        }  # fmt: skip
        for i in range(count):
            draw = outline if kind in KINDS else outline_by_opencv
            mask = draw(np.random.default_rng([SEED, i, len(kind)]), kind)
            if mask.sum() < 400:
                continue
            picture = np.where(mask, 0, 255).astype(np.uint8)
            records = [r for o in extract(picture).objects for r in object_records(o)]
            again = centers_inside([outline_points(r) for r in records], (200, 200))
            edges = sum(len(r.edges) if isinstance(r, PolygonRecord) else 1 for r in records)
            rows["clearway"].append((*alike(mask, again), edges))
            polyline = cv2.approxPolyDP(largest(picture), 1.0, True)
            filled = np.zeros((200, 200), np.uint8)
            cv2.fillPoly(filled, [polyline], 1)
            rows["cv2.approxPolyDP, 1 px"].append((*alike(mask, filled > 0), len(polyline)))
        for name, found in rows.items():
            overlap, away, edges = np.array(found).T
            lines.append(
                f"| {kind} | {name} | {overlap.min():.4f} | {int((overlap < 0.995).sum())} of "
                f"{len(found)} | {away.max():.2f} | {edges.mean():.1f} |"
            )
    return lines


def alike(a: np.ndarray, b: np.ndarray) -> tuple[float, float]:
    """Intersection over union of two masks, and their symmetric Hausdorff distance in pixels."""
    away = [
        cv2.distanceTransform((~m).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        for m in (a, b)
    ]
    return float((a & b).sum() / (a | b).sum()), float(max(away[0][b].max(), away[1][a].max()))
