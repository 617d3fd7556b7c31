"""Corners, circles and speed of the extractor beside OpenCV, on rendered scenes with truth.

Run ``python benchmarks/vision.py [--count 200] [--sections corners,circles,speed]``: prints
the tables and keeps them in ``benchmarks/results/vision.md``. Seeds are in the file. Absolute
times vary from machine to machine: compare the ratios.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from planner.scene import CircleRecord, PolygonRecord, object_records
from tests.support.render import draw, polygon
from vision import extract

SEED = 20
CELLS = [(0.7, 0.0), (0.7, 5.0), (0.7, 10.0), (0.7, 20.0), (1.5, 0.0), (1.5, 20.0)]
NEAR_PX = 3.0


def shape(rng: np.random.Generator) -> np.ndarray:
    """A polygon of 90 to 120 degrees or an L, sides of 20 to 50 px, at any angle."""
    kind = rng.integers(0, 3)
    if kind == 0:
        w, h = rng.uniform(20, 50, 2)
        v = np.array([(0, 0), (w, 0), (w, h), (0, h)])
    elif kind == 1:
        p, q, r, s = rng.uniform(20, 30, 4)
        v = np.array([(0, 0), (p + r, 0), (p + r, q), (p, q), (p, q + s), (0, q + s)])
    else:
        n = rng.integers(5, 7)
        t = np.arange(n) * math.tau / n
        v = rng.uniform(26, 44) * np.stack([np.cos(t), np.sin(t)], axis=1)
    a = rng.uniform(0, math.tau)
    turn = np.array([[math.cos(a), math.sin(a)], [-math.sin(a), math.cos(a)]])
    return (v - v.mean(axis=0)) @ turn + 60.0 + rng.uniform(-0.5, 0.5, 2)


def ours(picture: np.ndarray) -> np.ndarray:
    records = [r for o in extract(picture).objects for r in object_records(o)]
    found = [e.start for r in records if isinstance(r, PolygonRecord) for e in r.edges]
    return np.array(found).reshape(-1, 2)


def the_paper(picture: np.ndarray) -> np.ndarray:
    records = [r for o in extract(picture, mode="paper").objects for r in object_records(o)]
    found = [e.start for r in records if isinstance(r, PolygonRecord) for e in r.edges]
    return np.array(found).reshape(-1, 2)


def opencv_corners(picture: np.ndarray) -> np.ndarray:
    contour = largest(picture)
    return cv2.approxPolyDP(contour, 2.0, True).reshape(-1, 2).astype(float)


def largest(picture: np.ndarray) -> np.ndarray:
    binary = cv2.threshold(cv2.medianBlur(picture, 3), 127, 255, cv2.THRESH_BINARY_INV)[1]
    contours = cv2.findContours(binary, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)[0]
    return max(contours, key=len)


def corner_table(count: int) -> list[str]:
    lines = [
        "| blur / noise | method | corners rms px | missed | false |",
        "|---|---|---|---|---|",
    ]
    methods: dict[str, Callable[[np.ndarray], np.ndarray]] = {
        "clearway": ours,
        "clearway --paper": the_paper,
        "cv2.approxPolyDP, 2 px": opencv_corners,
    }
    for blur, noise in CELLS:
        results: dict[str, list[float]] = {name: [0.0, 0.0, 0.0, 0.0] for name in methods}
        total = 0
        for i in range(count):
            rng = np.random.default_rng([SEED, i, int(blur * 10), int(noise)])
            truth = shape(rng)
            picture = draw([polygon(truth)], (120, 120), blur=blur, noise=noise, rng=rng)
            total += len(truth)
            for name, method in methods.items():
                score = results[name]
                found = method(picture)
                used = set()
                for corner in truth:
                    d = np.hypot(*(found - corner).T) if len(found) else np.array([math.inf])
                    if d.min() < NEAR_PX:
                        score[0] += float(d.min() ** 2)
                        score[1] += 1
                        used.add(int(d.argmin()))
                    else:
                        score[2] += 1
                score[3] += len(found) - len(used)
        for name, (square, hits, missed, false) in results.items():
            rms = math.sqrt(square / max(hits, 1))
            lines.append(
                f"| {blur} / {noise:.0f} | {name} | {rms:.3f} | {missed / total:.1%} "
                f"| {false / total:.1%} |"
            )
    return lines


def circle_table(count: int) -> list[str]:
    lines = [
        "| radius, noise | method | found | radius rms px | centre rms px |",
        "|---|---|---|---|---|",
    ]
    for radius in (5, 8, 20, 50, 100):
        for noise in (0.0, 10.0, 20.0):
            rows: dict[str, list[tuple[float, float]]] = {
                "clearway": [], "cv2.fitEllipse": [], "cv2.minEnclosingCircle": [],
                "cv2.HoughCircles": [],
            }  # fmt: skip
            size = 2 * radius + 40
            for i in range(count if radius < 100 else count // 4):
                rng = np.random.default_rng([SEED, i, radius, int(noise)])
                center = size / 2 + rng.uniform(-0.5, 0.5, 2)
                record = CircleRecord((float(center[0]), float(center[1])), float(radius))
                picture = draw([record], (size, size), noise=noise, rng=rng)
                for name, found in circles(picture, radius).items():
                    if found is not None:
                        x, y, r = found
                        error = (r - radius, math.hypot(x - center[0], y - center[1]))
                        rows[name].append(error)
            tried = count if radius < 100 else count // 4
            for name, errors in rows.items():
                rms = np.sqrt(np.mean(np.square(errors), axis=0)) if errors else (math.nan,) * 2
                lines.append(
                    f"| {radius}, {noise:.0f} | {name} | {len(errors) / tried:.0%} "
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


def speed_table() -> list[str]:
    lines = [
        "| frame | objects | border px | OpenCV ms | clearway ms | ratio | us a border px |",
        "|---|---|---|---|---|---|---|",
    ]
    cv2.setNumThreads(1)
    for size, count in [
        ((640, 480), 7), ((640, 480), 20), ((1280, 960), 20), ((1920, 1080), 60),
        ((3840, 2160), 200), ((3840, 2160), 800),
    ]:  # fmt: skip
        frames = [arena(size, count, seed) for seed in range(4)]
        reference = median_ms(opencv_contours, frames)
        own = median_ms(extract, frames)
        scene = extract(frames[0])
        right = all(len(extract(f).objects) == count for f in frames)
        lines.append(
            f"| {size[0]}x{size[1]} | {count}{'' if right else ' (WRONG)'} "
            f"| {scene.border_pixels} | {reference:.2f} | {own:.2f} | {own / reference:.1f} "
            f"| {1e3 * own / scene.border_pixels:.2f} |"
        )
    return lines


def opencv_contours(picture: np.ndarray) -> object:
    binary = cv2.threshold(cv2.medianBlur(picture, 3), 127, 255, cv2.THRESH_BINARY_INV)[1]
    return cv2.findContours(binary, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)


def median_ms(function: Callable[[np.ndarray], object], frames: list[np.ndarray]) -> float:
    function(frames[0])
    times = []
    for i in range(20):
        begin = time.perf_counter()
        function(frames[i % len(frames)])
        times.append(1e3 * (time.perf_counter() - begin))
    return float(np.median(times))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--sections", default="corners,circles,speed")
    options = parser.parse_args()
    tables = {
        "corners": lambda: corner_table(options.count),
        "circles": lambda: circle_table(options.count),
        "speed": speed_table,
    }
    text = [f"# Vision, {options.count} scenes a cell, OpenCV {cv2.__version__}", ""]
    for name in options.sections.split(","):
        text += [f"## {name}", "", *tables[name](), ""]
    print("\n".join(text))
    results = Path(__file__).with_name("results")
    results.mkdir(exist_ok=True)
    (results / "vision.md").write_text("\n".join(text), encoding="utf-8")


if __name__ == "__main__":
    main()
