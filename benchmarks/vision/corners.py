"""Corners of polygons: how far off, how many missed, how many false."""

from __future__ import annotations

import math
from collections.abc import Callable

import cv2
import numpy as np

from benchmarks.vision.pictures import SEED, largest, wanted
from planner.scene import PolygonRecord, object_records
from tests.support.drawn.render import draw, polygon
from vision import extract

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


def corner_table(count: int, cells: list[str]) -> list[str]:
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
        if not wanted(f"{blur}/{noise:.0f}", cells):
            continue
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
