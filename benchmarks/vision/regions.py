"""Which regions binarisation takes for obstacles, over pictures that were not used for its limits.

Run ``python -m benchmarks.vision.regions [--count 40] [--only shadow,texture] [--tuning]``, or as
section ``regions`` of ``python -m benchmarks.vision``. Obstacles on a floor, in light that is even,
falls off, or is shadowed; plain or faint, in focus or not, in noise and on textures. An obstacle is
found where a region of the mask covers half of both together; a region that is nobody's is false.
``--tuning`` draws other pictures of the same kinds: limits are set by those alone, so that the
held-out ones judge them. ``--set vision.binarise.regions.judge.FAINT=0.4`` gives a named number
another value, wherever it is imported (in Python, not in compiled kernels).
"""

from __future__ import annotations

import argparse
import importlib
import math
import sys
from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.vision.pictures import wanted
from tests.support.drawn.render import coverage
from vision import PictureError
from vision.binarise.binarise import binarise

HELD_OUT, TUNING = 4711, 1147
SIZE = (480, 360)
COLUMNS, ROWS = 4, 3
KINDS = ("plain", "faint")
Grey = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Family:
    """How pictures of one kind are drawn: shares and pixels, each from .. to."""

    light: str = "even"
    blur_px: tuple[float, float] = (0.5, 1.2)
    faint: float = 0.0
    """The chance of an obstacle to be faint."""
    noise: tuple[float, float] = (0.0, 4.0)
    texture: str = "none"
    cables: bool = False
    """Whether a cable of half the obstacles' contrast lies across the picture, which is faint."""


FAMILIES = {
    "even": Family(),
    "even, faint": Family(faint=0.4),
    "even, unsharp": Family(blur_px=(2.0, 4.0), faint=0.3),
    "ramp": Family("ramp"),
    "ramp, faint": Family("ramp", faint=0.4),
    "ramp, unsharp": Family("ramp", blur_px=(2.0, 4.0)),
    "ramp, unsharp and faint": Family("ramp", blur_px=(2.0, 4.0), faint=0.4),
    "ramp, noise": Family("ramp", faint=0.2, noise=(6.0, 14.0)),
    "spot": Family("spot", faint=0.2),
    "spot, unsharp and faint": Family("spot", blur_px=(2.0, 4.0), faint=0.4),
    "shadow": Family("shadow"),
    "shadow, faint": Family("shadow", faint=0.4),
    "shadow, unsharp and faint": Family("shadow", blur_px=(2.0, 4.0), faint=0.4),
    "shadow, noise": Family("shadow", faint=0.2, noise=(6.0, 14.0)),
    "cloth": Family("ramp", faint=0.2, texture="cloth"),
    "joints": Family("ramp", faint=0.0, texture="joints"),
    "grain": Family("shadow", faint=0.0, texture="grain"),
    "cables": Family(cables=True),
    "cables, ramp": Family("ramp", cables=True),
    "cables, noise": Family(cables=True, noise=(4.0, 8.0)),
    "cables, joints": Family(cables=True, texture="joints"),
    "dark joints": Family(texture="dark joints"),
}


def shape(x: float, y: float, radius: float, rng: np.random.Generator) -> Grey:
    """A polygon (n, 2) or what stands for a disc around a point."""
    n = int(rng.choice([3, 4, 4, 5, 6, 40, 40]))
    turn = rng.uniform(0.0, math.tau)
    apart = rng.uniform(-0.25, 0.25, n) if n < 40 else 0.0
    angles = turn + (np.arange(n) + apart) * math.tau / n
    flat = rng.uniform(0.5, 1.0)
    along, across = radius * np.cos(angles), radius * flat * np.sin(angles)
    c, s = math.cos(turn), math.sin(turn)
    return np.stack([x + c * along - s * across, y + s * along + c * across], axis=1)


def cable(rng: np.random.Generator) -> Grey:
    """The outline (2 n, 2) of a cable of 2 px that hangs across the middle row of cells."""
    width, height = SIZE
    x = np.linspace(rng.uniform(20.0, 150.0), width - rng.uniform(20.0, 150.0), 60)
    wave, begin = rng.uniform(60.0, 160.0), rng.uniform(0.0, math.tau)
    high = rng.uniform(4.0, 25.0)
    y = 0.5 * height + high * np.sin(begin + x / wave * math.tau)
    slope = high / wave * math.tau * np.cos(begin + x / wave * math.tau)
    across = np.stack([-slope, np.ones_like(slope)]) / np.hypot(1.0, slope)
    middle = np.stack([x, y])
    return np.concatenate([(middle + across).T, (middle - across).T[::-1]])


def light_of(kind: str, rng: np.random.Generator) -> Grey:
    """The light's factor per pixel (h, w)."""
    width, height = SIZE
    y, x = np.mgrid[0:height, 0:width].astype(float)
    angle = rng.uniform(0.0, math.tau)
    along = (x - width / 2) * math.cos(angle) + (y - height / 2) * math.sin(angle)
    if kind == "even":
        return np.ones((height, width))
    if kind == "ramp":
        return np.asarray(1.0 - rng.uniform(0.3, 0.8) * (along - along.min()) / np.ptp(along))
    if kind == "spot":
        away = (x - rng.uniform(0, width)) ** 2 + (y - rng.uniform(0, height)) ** 2
        wide = rng.uniform(130.0, 260.0)
        return np.asarray(1.0 - rng.uniform(0.4, 0.7) * (1.0 - np.exp(-0.5 * away / wide**2)))
    # a penumbra's edge is logistic; wider than what a lens out of focus makes of an obstacle's
    wide = math.exp(rng.uniform(math.log(4.0), math.log(40.0)))
    at = rng.uniform(-0.3, 0.3) * width
    edge = 1.0 / (1.0 + np.exp(-(along - at) / wide))
    if rng.random() < 0.4:
        # of a beam: lit again behind it
        edge *= 1.0 / (1.0 + np.exp((along - at - rng.uniform(6.0, 14.0) * wide) / wide))
    return np.asarray(1.0 - rng.uniform(0.2, 0.65) * edge)


def texture_of(kind: str, rng: np.random.Generator) -> Grey:
    """The floor's own share of light that it gives back, around 1 (h, w)."""
    width, height = SIZE
    floor = np.ones((height, width))
    if kind == "cloth":
        wide = rng.uniform(0.6, 1.5)
        weave = cv2.GaussianBlur(rng.normal(0.0, 1.0, floor.shape), (0, 0), wide)
        return np.asarray(floor + rng.uniform(0.01, 0.03) * weave / weave.std())
    if kind in ("joints", "dark joints"):
        depths = (0.05, 0.14) if kind == "joints" else (0.14, 0.22)
        depth, pitch = rng.uniform(*depths), int(rng.integers(36, 70))
        for k in range(int(rng.integers(1, 4))):
            floor[int(rng.integers(pitch)) % pitch + k :: pitch] = 1.0 - depth
        return floor
    if kind == "grain":
        # wood: long streaks
        streaks = cv2.GaussianBlur(rng.normal(0.0, 1.0, floor.shape), (0, 0), 25.0, sigmaY=2.0)
        return np.asarray(floor + rng.uniform(0.01, 0.03) * streaks / streaks.std())
    return floor


@dataclass(frozen=True, slots=True)
class Drawn:
    """A picture (h, w) uint8 and its obstacles: covers (h, w), and whether each is faint."""

    picture: NDArray[np.uint8]
    obstacles: list[NDArray[np.bool_]]
    faint: list[bool]


def drawn(family: Family, rng: np.random.Generator) -> Drawn:
    """A picture of the family; its step, faint or not, is three times the noise at the least."""
    width, height = SIZE
    floor, noise = rng.uniform(170.0, 230.0), rng.uniform(*family.noise)
    light = light_of(family.light, rng)
    seen = texture_of(family.texture, rng)
    dark = rng.uniform(0.1, 0.4)
    obstacles, faint = [], []
    for cell in rng.permutation(COLUMNS * ROWS)[: int(rng.integers(0, 10))]:
        if family.cables and cell // COLUMNS == ROWS // 2:
            continue
        x = (cell % COLUMNS + 0.5) * width / COLUMNS + rng.uniform(-12.0, 12.0)
        y = (cell // COLUMNS + 0.5) * height / ROWS + rng.uniform(-12.0, 12.0)
        cover = coverage([shape(x, y, rng.uniform(14.0, 42.0), rng)], SIZE, lines=4)
        is_faint = rng.random() < family.faint
        share = rng.uniform(0.15, 0.35) if is_faint else 1.0 - dark
        middle = light[cover > 0.5].min() * floor
        if share * middle < 3.0 * noise + 8.0:
            continue
        seen = seen * (1.0 - share * cover)
        obstacles.append(cover >= 0.5)
        faint.append(bool(is_faint))
    if family.cables:
        cover = coverage([cable(rng)], SIZE, lines=4)
        seen = seen * (1.0 - 0.5 * (1.0 - dark) * cover)
        obstacles.append(cover >= 0.5)
        faint.append(True)
    grey = cv2.GaussianBlur(seen, (0, 0), rng.uniform(*family.blur_px)) * light * floor
    grey += rng.normal(0.0, noise, grey.shape)
    return Drawn(np.clip(np.rint(grey), 0, 255).astype(np.uint8), obstacles, faint)


def thin_edge(cover: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The pixels (h, w) beside an obstacle where it is no more than 4 px wide; else none."""
    inside = cover.astype(np.uint8)
    if cv2.erode(inside, np.ones((5, 5), np.uint8)).any():
        return np.zeros_like(cover)
    wider = cv2.dilate(inside, np.ones((3, 3), np.uint8))
    return np.asarray((wider != 0) & ~cover)


def looked_at(one: Drawn, inside: NDArray[np.uint8] | None = None) -> tuple[list[bool], int]:
    """Which of the obstacles are found ``inside`` (h, w), and how many regions are nobody's."""
    if inside is None:
        try:
            inside = binarise(one.picture).inside
        except PictureError:
            return [False] * len(one.obstacles), 1
    count, labels = cv2.connectedComponents(inside, connectivity=8)
    areas = np.bincount(labels.ravel(), minlength=count)
    false = set(range(1, count))
    found = []
    for cover in one.obstacles:
        common = np.bincount(labels[cover], minlength=count)
        common[0] = 0
        best = int(common.argmax())
        # what is thin may be a pixel wider, and a pixel off
        edge = thin_edge(cover)
        beside = np.bincount(labels[edge], minlength=count)[best]
        both = int(cover.sum()) + areas[best] - common[best] - beside
        found.append(bool(common[best] > 0.5 * both))
        # a part of an obstacle is no obstacle beside it
        near = common + np.bincount(labels[edge], minlength=count)
        near[0] = 0
        false -= set(np.flatnonzero(near > 0.5 * areas).tolist())
        false -= {best} if found[-1] else set()
    return found, len(false)


def region_table(count: int, cells: Iterable[str] = (), seed: int = HELD_OUT) -> list[str]:
    """Obstacles found, plain and faint, false regions, and pictures that are right, a family."""
    lines = [
        "| family | plain found | faint found | false regions | pictures all right |",
        "|---|---|---|---|---|",
    ]
    total = np.zeros(7, np.int64)
    for number, (name, family) in enumerate(FAMILIES.items()):
        if not wanted(name, list(cells)):
            continue
        sums = np.zeros(7, np.int64)
        for i in range(count):
            one = drawn(family, np.random.default_rng([seed, number, i]))
            found, false = looked_at(one)
            is_faint = np.array(one.faint, dtype=np.bool_)
            hits = np.array(found, dtype=np.bool_)
            right = bool(hits.all()) and not false
            sums += [
                *((hits & ~is_faint).sum(), (~is_faint).sum()),
                *((hits & is_faint).sum(), is_faint.sum()),
                *(false, right, 1),
            ]
        lines.append(_row(name, sums))
        total += sums
    return [*lines, _row("all", total)]


def _row(name: str, sums: NDArray[np.int64]) -> str:
    plain, plains, faint, faints, false, right, pictures = sums.tolist()
    return (
        f"| {name} | {plain} of {plains} | {faint} of {faints} | {false} | {right} of {pictures} |"
    )


def set_number(words: str) -> None:
    """Give a named number another value, in every module that has it from there."""
    place, _, value = words.partition("=")
    module, _, name = place.rpartition(".")
    old = getattr(importlib.import_module(module), name)
    for other in [m for n, m in sys.modules.items() if n.startswith("vision.")]:
        if getattr(other, name, None) is old:
            setattr(other, name, float(value) if isinstance(old, float) else int(value))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=40, help="pictures a family")
    parser.add_argument("--only", default="", help="beginnings of families, with commas between")
    parser.add_argument("--tuning", action="store_true", help="the pictures to set limits by")
    parser.add_argument("--set", action="append", default=[], help="package.module.NAME=value")
    given = parser.parse_args()
    for words in given.set:
        set_number(words)
    families = [one for one in given.only.split(",") if one]
    seed = TUNING if given.tuning else HELD_OUT
    print("\n".join(region_table(given.count, families, seed)))


if __name__ == "__main__":
    main()
