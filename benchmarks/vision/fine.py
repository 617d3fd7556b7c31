"""Walls and ways of a few pixels: ``python -m benchmarks.vision.fine [--cells N] [--mazes N]``.

Mazes of walls and ways equally wide, blurred and noisy. A wall cell is lost where less than half of
it lies in an obstacle, a way is blocked where more than half of it does. The largest obstacle that
may be, the whole picture, loses none and is counted as blocked.
"""

from __future__ import annotations

import argparse
import itertools
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.vision.pictures import SEED
from planner.scene import PointRecord, Scene, SegmentRecord, object_records
from tests.support.drawn.render import scene_coverage
from tests.support.scenes.mazes import maze
from vision import PictureError, extract

WIDTHS_PX = (1, 2, 3, 4, 6)
NOISES = (0.0, 2.0, 5.0, 10.0)
BLURS_PX = (0.0, 0.5, 1.0)
DARK, LIGHT = 32.0, 207.0


class Cells(NamedTuple):
    """Cells of mazes: walls, how many of them are lost, ways, how many of them are blocked."""

    walls: int
    lost: int
    ways: int
    blocked: int


def pictured(
    wall: NDArray[np.bool_], px: int, blur: float, noise: float, rng: np.random.Generator
) -> NDArray[np.uint8]:
    """A grid as a camera sees it, ``px`` pixels a cell."""
    grey = np.kron(np.where(wall, DARK, LIGHT), np.ones((px, px)))
    if blur > 0.0:
        grey = cv2.GaussianBlur(grey, (0, 0), blur)
    grey = grey + rng.normal(0.0, 1.0, grey.shape) * noise
    return np.clip(np.rint(grey), 0.0, 255.0).astype(np.uint8)


def cover(scene: Scene, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """The share of each pixel (h, w) that is obstacle; a point, or a thin line, is a pixel wide."""
    covered = scene_coverage(scene, (shape[1], shape[0]), lines=4)
    for record in (one for each in scene.objects for one in object_records(each)):
        if isinstance(record, PointRecord):
            ends = np.array([record.at, record.at])
        elif isinstance(record, SegmentRecord):
            ends = np.array([record.start, record.end])
        else:
            continue
        steps = np.linspace(0.0, 1.0, 1 + 2 * int(np.ceil(np.abs(ends[1] - ends[0]).max())))
        along = np.rint(ends[0] + steps[:, None] * (ends[1] - ends[0])).astype(np.int64)
        covered[along[:, 1].clip(0, shape[0] - 1), along[:, 0].clip(0, shape[1] - 1)] = 1.0
    return covered


def cells_of(side: int, px: int, blur: float, noise: float, seed: int) -> Cells:
    """The fate of the cells of one maze of ``side`` times ``side``."""
    rng = np.random.default_rng([SEED, seed, px])
    wall = maze(side, rng)
    picture = pictured(wall, px, blur, noise, rng)
    try:
        scene = extract(picture)
    except PictureError:
        return Cells(int(wall.sum()), 0, int((~wall).sum()), int((~wall).sum()))
    covered = cover(scene, picture.shape)
    covered = covered.reshape(side, px, side, px).mean(axis=(1, 3))
    lost, blocked = wall & (covered < 0.5), ~wall & (covered > 0.5)
    return Cells(*(int(one.sum()) for one in (wall, lost, ~wall, blocked)))


def table(side: int, mazes: int) -> tuple[list[str], int]:
    """A row for every width and blur, and how many wall cells are lost in all."""
    head = " | ".join(f"noise {noise:.0f}" for noise in NOISES)
    lines = [f"| px | blur | {head} |", "|---|---|" + "---|" * len(NOISES)]
    every = 0
    for px, blur in itertools.product(WIDTHS_PX, BLURS_PX):
        shown = []
        for noise in NOISES:
            found = [cells_of(side, px, blur, noise, seed) for seed in range(mazes)]
            walls, lost, ways, blocked = (sum(one) for one in zip(*found, strict=True))
            shown.append(f"{lost} of {walls}, {blocked / ways:.1%}")
            every += lost
        lines.append(f"| {px} | {blur:g} | " + " | ".join(shown) + " |")
    return lines, every


def main() -> int:
    """Print the table; 1 where a wall cell is lost."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cells", type=int, default=41, help="cells along a side, odd")
    parser.add_argument("--mazes", type=int, default=3, help="mazes of each kind")
    options = parser.parse_args()
    lines, lost = table(options.cells, options.mazes)
    print(f"{options.mazes} mazes of {options.cells} x {options.cells} cells of each kind.")
    print("Wall cells lost, and the share of ways that is blocked.\n")
    print("\n".join(lines))
    print(f"\nWall cells lost: {lost}.")
    return 1 if lost else 0


if __name__ == "__main__":
    raise SystemExit(main())
