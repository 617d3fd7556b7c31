"""How many pictures have as many objects as were drawn, in even and uneven light."""

from __future__ import annotations

import math

import cv2
import numpy as np

from benchmarks.vision.pictures import SEED, arena, opencv_contours, taken, wanted
from planner.scene import CircleRecord
from tests.support.drawn.render import coverage, outline_points, ramp
from vision import extract


def count_table(count: int, cells: list[str]) -> list[str]:
    """How many pictures have as many objects as were drawn."""
    lines = ["| noise | method | counted right |", "|---|---|---|"]
    for noise in (0.0, 5.0, 10.0, 20.0):
        if not wanted(f"{noise:.0f}", cells):
            continue
        right = {"clearway": 0, "cv2.findContours": 0}
        for i in range(count):
            rng = np.random.default_rng([SEED, i, int(noise)])
            objects = int(rng.integers(3, 25))
            picture = taken(arena((640, 480), objects, i), noise, rng)
            right["clearway"] += len(extract(picture).objects) == objects
            right["cv2.findContours"] += len(opencv_contours(picture)[0]) == objects
        lines += [f"| {noise:.0f} | {name} | {hits / count:.1%} |" for name, hits in right.items()]
    return lines


def ramp_table(count: int, cells: list[str]) -> list[str]:
    """The same where light falls off across the picture; at most 20 scenes a cell."""
    count = min(count, 20)
    lines = [
        f"{count} scenes a cell, of 1 to 12 discs.",
        "",
        "| ramp, noise, share | dark counted right | light counted right |",
        "|---|---|---|",
    ]
    size = (640, 480)
    for share in (0.0005, 0.005, 0.05, 0.3):
        scenes = [discs(size, share, np.random.default_rng([SEED, i])) for i in range(count)]
        covers = [coverage([outline_points(d) for d in scene], size, lines=4) for scene in scenes]
        for fall in (0.0, 0.6, 0.8):
            for noise in (0.0, 10.0, 20.0):
                name = f"{fall:.0%}, {noise:.0f}, {share:.2%}"
                if not wanted(name.replace(" ", ""), cells):
                    continue
                right = {"dark": 0, "light": 0}
                for i, (scene, cover) in enumerate(zip(scenes, covers, strict=True)):
                    rng = np.random.default_rng([SEED, i, int(noise)])
                    lit = ramp(size, fall, rng.uniform(0.0, math.tau))
                    for side in right:
                        dark, light = (40.0, 215.0) if side == "dark" else (215.0, 40.0)
                        grey = cv2.GaussianBlur(light + (dark - light) * cover, (0, 0), 0.7) * lit
                        grey += rng.normal(0.0, noise, grey.shape)
                        picture = np.clip(np.rint(grey), 0, 255).astype(np.uint8)
                        objects = extract(picture, polarity=side).objects
                        whole = not any(one.holes for one in objects)
                        right[side] += len(objects) == len(scene) and whole
                lines.append(f"| {name} | {right['dark']} | {right['light']} |")
    return lines


def discs(size: tuple[int, int], share: float, rng: np.random.Generator) -> list[CircleRecord]:
    """Discs of one size that cover a share of the picture, each in a cell of its own."""
    columns, rows = (1, 1) if share < 0.001 else (2, 2) if share < 0.002 else (4, 3)
    width, height = size[0] / columns, size[1] / rows
    radius = math.sqrt(share * width * height / math.pi)
    slack = min(20.0, min(width, height) / 2.0 - radius - 4.0)
    return [
        CircleRecord(
            (
                float((i + 0.5) * width + rng.uniform(-slack, slack)),
                float((j + 0.5) * height + rng.uniform(-slack, slack)),
            ),
            radius,
        )
        for i in range(columns)
        for j in range(rows)
    ]
