"""Picture to scene against median blur, threshold and findContours on the same frames."""

from __future__ import annotations

import math
import time

import cv2
import numpy as np

from benchmarks.vision.pictures import SEED, arena, opencv_contours, taken, wanted
from vision import extract


def speed_table(cells: list[str]) -> list[str]:
    """Picture to scene against median blur, threshold and findContours on the same frames."""
    lines = [
        "| frame | objects | picture | border px | OpenCV ms | clearway ms | ratio "
        "| fit, ns a border px | all, ns a border px |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    cv2.setNumThreads(1)
    for size, count in [
        ((640, 480), 7), ((640, 480), 20), ((1280, 960), 20), ((1920, 1080), 60),
        ((3840, 2160), 200), ((3840, 2160), 800),
    ]:  # fmt: skip
        frame = f"{size[0]}x{size[1]}"
        if not wanted(frame, cells):
            continue
        rng = np.random.default_rng([SEED, count])
        drawn = arena(size, count, 0)
        pictures = {
            "anti-aliased": drawn,
            "black and white": cv2.threshold(drawn, 127, 255, cv2.THRESH_BINARY)[1],
            "noise 5": taken(drawn, 5.0, rng),
            "noise 20": taken(drawn, 20.0, rng),
        }
        for name, picture in pictures.items():
            reference, own, fit = least_ms(picture)
            scene = extract(picture)
            note = "" if len(scene.objects) == count else " (WRONG)"
            pixels = scene.border_pixels
            lines.append(
                f"| {frame} | {count}{note} | {name} | {pixels} | {reference:.2f} | {own:.2f} "
                f"| {own / reference:.1f} | {1e6 * fit / pixels:.0f} | {1e6 * own / pixels:.0f} |"
            )
    return lines


def least_ms(picture: np.ndarray) -> tuple[float, float, float]:
    """The least processor time of OpenCV and of ours, and the least wall time of our fit."""
    reference = own = fit = math.inf
    extract(picture)
    for _ in range(15):
        begin = time.process_time()
        opencv_contours(picture)
        middle = time.process_time()
        scene = extract(picture)
        end = time.process_time()
        reference = min(reference, 1e3 * (middle - begin))
        own = min(own, 1e3 * (end - middle))
        fit = min(fit, scene.timings_ms["geometry"])
    return reference, own, fit
