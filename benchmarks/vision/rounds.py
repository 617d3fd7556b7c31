"""Circles and arcs: how often found, and how far radius and centre are off."""

from __future__ import annotations

import math

import cv2
import numpy as np

from benchmarks.vision.pictures import SEED, largest, wanted
from planner.scene import Arc, CircleRecord, PolygonRecord
from tests.support.drawn.render import cut_disc, draw
from vision import extract


def circle_table(count: int, cells: list[str]) -> list[str]:
    lines = [
        "| radius, noise | method | found | radius rms px | centre rms px |",
        "|---|---|---|---|---|",
    ]
    for radius in (5, 8, 20, 50, 100):
        for noise in (0.0, 10.0, 20.0):
            if not wanted(f"{radius},{noise:.0f}", cells):
                continue
            rows: dict[str, list[tuple[float, float]]] = {
                "clearway": [], "cv2.fitEllipse": [], "cv2.minEnclosingCircle": [],
                "cv2.HoughCircles": [],
            }  # fmt: skip
            size = 2 * radius + 40
            for i in range(count):
                rng = np.random.default_rng([SEED, i, radius, int(noise)])
                center = size / 2 + rng.uniform(-0.5, 0.5, 2)
                record = CircleRecord((float(center[0]), float(center[1])), float(radius))
                picture = draw([record], (size, size), noise=noise, rng=rng)
                for name, found in circles(picture, radius).items():
                    if found is not None:
                        x, y, r = found
                        error = (r - radius, math.hypot(x - center[0], y - center[1]))
                        rows[name].append(error)
            for name, errors in rows.items():
                rms = np.sqrt(np.mean(np.square(errors), axis=0)) if errors else (math.nan,) * 2
                lines.append(
                    f"| {radius}, {noise:.0f} | {name} | {len(errors) / count:.0%} "
                    f"| {rms[0]:.3f} | {rms[1]:.3f} |"
                )
    return lines


def circles(picture: np.ndarray, radius: float) -> dict[str, tuple[float, float, float] | None]:
    records = [r for o in extract(picture).objects for r in o.records]
    own = records[0] if len(records) == 1 and isinstance(records[0], CircleRecord) else None
    contour = largest(picture)
    (ex, ey), (a, b), _ = cv2.fitEllipse(contour)
    (mx, my), mr = cv2.minEnclosingCircle(contour)
    hough = cv2.HoughCircles(
        picture, cv2.HOUGH_GRADIENT, 1, 20, param1=100, param2=12,
        minRadius=int(radius * 0.7), maxRadius=int(radius * 1.3) + 1,
    )  # fmt: skip
    seen = None if hough is None else tuple(hough.reshape(-1, 3)[0].tolist())
    return {
        "clearway": None if own is None else (*own.center, own.radius),
        "cv2.fitEllipse": (ex, ey, (a + b) / 4.0),
        "cv2.minEnclosingCircle": (mx, my, mr),
        "cv2.HoughCircles": seen,
    }


def stepped_disc(radius: int, blur: float, noise: float, rng: np.random.Generator) -> np.ndarray:
    """A disc drawn without anti-aliasing, then blurred (sigma, px), with noise in grey levels."""
    size = 2 * radius + 40
    picture = np.full((size, size), 220, np.uint8)
    cv2.circle(picture, (size // 2, size // 2), radius, 30, -1)
    grey = cv2.GaussianBlur(picture.astype(float), (0, 0), blur)
    if noise > 0.0:
        grey += rng.normal(0.0, noise, grey.shape)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def stepped_table(count: int, cells: list[str]) -> list[str]:
    """Discs of ``stepped_disc``, radii 5 to 200: how many are one circle; at most 20 a radius."""
    count = min(count, 20)
    lines = [
        "| blur, noise | radius 5 | 8 to 30 | 40 to 80 | 100 to 200 | all |",
        "|---|---|---|---|---|---|",
    ]
    groups = ((5,), (8, 12, 16, 20, 30), (40, 60, 80), (100, 150, 200))
    for blur in (0.7, 1.0, 1.5, 2.0):
        for noise in (0.0, 2.0, 4.0, 8.0):
            cell = f"{blur}, {noise:.0f}"
            if not wanted(cell.replace(" ", ""), cells):
                continue
            shares = []
            for group in groups:
                right = 0
                for radius in group:
                    for i in range(count):
                        rng = np.random.default_rng([SEED, i, radius, int(noise)])
                        scene = extract(stepped_disc(radius, blur, noise, rng))
                        records = [r for o in scene.objects for r in o.records]
                        right += len(records) == 1 and isinstance(records[0], CircleRecord)
                shares.append((right, len(group) * count))
            shares.append((sum(s[0] for s in shares), sum(s[1] for s in shares)))
            row = " | ".join(f"{right / drawn:.0%}" for right, drawn in shares)
            lines.append(f"| {cell} | {row} |")
    return lines


def arc_table(count: int, cells: list[str]) -> list[str]:
    """Discs with a piece cut off: the arc that is left, against a circle through everything."""
    lines = [
        "| radius, half the cut, noise | method | found | radius rms px | centre rms px |",
        "|---|---|---|---|---|",
    ]
    for radius in (20, 50):
        for half in (0.6, 1.5):
            for noise in (0.0, 10.0, 20.0):
                cell = f"{radius}, {half}, {noise:.0f}"
                if not wanted(cell.replace(" ", ""), cells):
                    continue
                errors: dict[str, list[tuple[float, float]]] = {
                    "clearway": [], "cv2.fitEllipse": [], "cv2.minEnclosingCircle": [],
                }  # fmt: skip
                for i in range(count):
                    rng = np.random.default_rng([SEED, i, radius, int(half * 10), int(noise)])
                    size = 2 * radius + 40
                    center = size / 2 + rng.uniform(-0.5, 0.5, 2)
                    disc = cut_disc(center, radius, rng.uniform(0, math.tau), half)
                    picture = draw([disc], (size, size), noise=noise, rng=rng)
                    for name, found in arcs(picture).items():
                        if found is not None:
                            x, y, r = found
                            away = math.hypot(x - center[0], y - center[1])
                            errors[name].append((r - radius, away))
                for name, pairs in errors.items():
                    rms = np.sqrt(np.mean(np.square(pairs), axis=0)) if pairs else (math.nan,) * 2
                    lines.append(
                        f"| {cell} | {name} | {len(pairs) / count:.0%} | {rms[0]:.3f} "
                        f"| {rms[1]:.3f} |"
                    )
    return lines


def arcs(picture: np.ndarray) -> dict[str, tuple[float, float, float] | None]:
    """The arc of the only object: ours counts where the record is one line and one arc."""
    records = [r for o in extract(picture).objects for r in o.records]
    own = None
    if len(records) == 1 and isinstance(records[0], PolygonRecord) and len(records[0].edges) == 2:
        bent = [e for e in records[0].edges if isinstance(e, Arc)]
        own = (*bent[0].center, bent[0].radius) if len(bent) == 1 else None
    contour = largest(picture)
    (ex, ey), (a, b), _ = cv2.fitEllipse(contour)
    (mx, my), mr = cv2.minEnclosingCircle(contour)
    return {
        "clearway": own,
        "cv2.fitEllipse": (ex, ey, (a + b) / 4.0),
        "cv2.minEnclosingCircle": (mx, my, mr),
    }
