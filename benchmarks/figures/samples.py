"""Draw the samples that come with Clearway: `python -m benchmarks.figures.samples [FOLDER]`."""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np

FOLDER = Path(__file__).parents[2] / "planner/samples"
WIDTH, HEIGHT = 640, 480
FINER = 4
"""Drawn so many times larger, then reduced: edges become grey as a lens shows them."""
CELL_PX, WALL_PX = 40, 6
"""The maze's cells and walls: a corridor is 34 pixels wide."""
ROOMS_YAML = """\
image: rooms.pgm
resolution: 0.05
origin: [-2.0, -1.5, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""


def arena() -> np.ndarray:
    """A disc, a box and a triangle; (480, 640) uint8."""
    large = np.full((HEIGHT * FINER, WIDTH * FINER), 225, np.uint8)
    cv2.circle(large, (1000, 800), 300, 45, -1)
    cv2.rectangle(large, (1640, 400), (1880, 1240), 45, -1)
    cv2.fillPoly(large, [np.array([(400, 1300), (900, 1500), (500, 1700)])], 45)
    return _reduced(large)


def photograph() -> np.ndarray:
    """Five obstacles in light from one side, with soft shadows; (480, 640) uint8."""
    obstacles = np.full((HEIGHT * FINER, WIDTH * FINER), 0, np.uint8)
    cv2.circle(obstacles, (1150, 640), 260, 255, -1)
    for corners in (
        [(420, 900), (900, 1020), (760, 1480), (380, 1380)],
        [(1560, 1000), (2140, 900), (2220, 1120), (1640, 1260)],
        [(1220, 1420), (1500, 1560), (1160, 1760)],
        [(1800, 180), (2160, 260), (2000, 560)],
    ):
        cv2.fillPoly(obstacles, [np.array(corners)], 255)
    covered = _reduced(obstacles) / 255.0
    shadow = cv2.GaussianBlur(np.roll(covered, (9, 12), axis=(0, 1)), (0, 0), 9.0)
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH]
    light = 1.0 - 0.22 * np.hypot(columns - 250, rows - 200) / 400
    floor = 205.0 * light * (1.0 - 0.25 * shadow)
    picture = cv2.GaussianBlur(floor * (1.0 - covered) + 55.0 * light * covered, (0, 0), 0.8)
    picture += np.random.default_rng(1).normal(0.0, 3.0, picture.shape)
    return np.clip(picture, 0, 255).astype(np.uint8)


def maze() -> np.ndarray:
    """One way between any two cells, 16 by 12 of them; (480, 640) uint8."""
    rng = np.random.default_rng(4)
    rows, columns = HEIGHT // CELL_PX, WIDTH // CELL_PX
    picture = np.full((HEIGHT, WIDTH), 20, np.uint8)
    way, seen = [(0, 0)], {(0, 0)}
    _open(picture, (0, 0), (0, 0))
    while way:
        row, column = way[-1]
        beside = [(row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)]
        new = [
            cell
            for cell in beside
            if cell not in seen and 0 <= cell[0] < rows and 0 <= cell[1] < columns
        ]
        if not new:
            way.pop()
            continue
        cell = new[rng.integers(len(new))]
        _open(picture, way[-1], cell)
        seen.add(cell)
        way.append(cell)
    return picture


def rooms() -> np.ndarray:
    """Two rooms with a door of 1 m, and a table in one, in cells of 0.05 m; (100, 160) uint8."""
    cells = np.full((100, 160), 254, np.uint8)
    cells[[0, -1], :] = cells[:, [0, -1]] = 0
    cells[:40, 80:83] = cells[60:, 80:83] = 0
    cells[30:55, 112:134] = 0
    return cells


def draw(folder: Path) -> None:
    """Write all of them."""
    cv2.imwrite(str(folder / "arena.png"), arena(), [cv2.IMWRITE_PNG_COMPRESSION, 9])
    cv2.imwrite(str(folder / "photograph.jpg"), photograph(), [cv2.IMWRITE_JPEG_QUALITY, 90])
    cv2.imwrite(str(folder / "maze.png"), maze(), [cv2.IMWRITE_PNG_COMPRESSION, 9])
    cv2.imwrite(str(folder / "rooms.pgm"), rooms())
    (folder / "rooms.yaml").write_text(ROOMS_YAML, encoding="utf-8")


def _reduced(large: np.ndarray) -> np.ndarray:
    return cv2.resize(large, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)


def _open(picture: np.ndarray, one: tuple[int, int], other: tuple[int, int]) -> None:
    """Clear two cells that are neighbours, and what is between them."""
    half = WALL_PX // 2
    top, left = (CELL_PX * min(pair) + half for pair in zip(one, other, strict=True))
    bottom, right = (CELL_PX * (max(pair) + 1) - half for pair in zip(one, other, strict=True))
    picture[top:bottom, left:right] = 235


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
