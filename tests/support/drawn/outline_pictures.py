"""Pictures whose borders are hard to follow: slits, seams, needles, combs, rags, threads.

Rules and units
- Pixels, centres at integers, y down. A mask is drawn four times as fine and shrunk: its values
  are the share of every pixel that is obstacle.
- ``shown`` makes a picture of it: dark or light obstacles, grey or black and white, blur (a
  Gaussian's sigma in pixels), then noise (grey levels).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

FINE = 4
DARK, LIGHT = 50.0, 215.0
Picture = NDArray[np.uint8]
Share = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Look:
    """How a mask is shown."""

    blur_px: float
    noise: float
    light: bool
    """Light obstacles on a dark floor."""
    grey: bool
    """False: black and white only, no blur, no noise."""

    @property
    def polarity(self) -> Literal["dark", "light"]:
        """The extractor's word for it."""
        return "light" if self.light else "dark"


CAMERAS = ((0.5, 0.0), (0.7, 3.0), (0.7, 12.0), (1.5, 0.0), (1.5, 6.0), (2.5, 3.0))
"""Blur and noise."""
LOOKS = (
    *(Look(blur_px, noise, False, True) for blur_px, noise in CAMERAS),
    *(Look(blur_px, noise, True, True) for blur_px, noise in CAMERAS),
    Look(0.0, 0.0, False, False),
    Look(0.0, 0.0, True, False),
)


def shown(share: Share, look: Look, rng: np.random.Generator) -> Picture:
    """A picture (h, w) uint8 of the obstacles' share of every pixel."""
    if not look.grey:
        share = (share >= 0.5).astype(np.float64)
    dark, light = (DARK, LIGHT) if look.grey else (0.0, 255.0)
    grey = light + (dark - light) * share
    if look.light:
        grey = 255.0 - grey
    if look.blur_px > 0.0:
        grey = cv2.GaussianBlur(grey, (0, 0), look.blur_px)
    if look.noise > 0.0:
        grey = grey + rng.normal(0.0, look.noise, grey.shape)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def slits(rng: np.random.Generator) -> Picture:
    """A dark block, 400 x 300, with one to eight bright slits a pixel or two wide."""
    image = np.full((300, 400), LIGHT)
    image[60:240, 60:340] = DARK
    for _ in range(int(rng.integers(1, 9))):
        x, y = rng.uniform(80.0, 300.0), rng.uniform(80.0, 220.0)
        angle, length = rng.uniform(-math.pi, math.pi), rng.uniform(10.0, 90.0)
        end = round(x + length * math.cos(angle)), round(y + length * math.sin(angle))
        bright = float(rng.integers(130, 215))
        cv2.line(image, (round(x), round(y)), end, bright, int(rng.integers(1, 3)))
    image = cv2.GaussianBlur(image, (0, 0), float(rng.uniform(0.5, 1.0)))
    noisy = image + rng.normal(0.0, float(rng.uniform(0.0, 6.0)), image.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


def scratches(rng: np.random.Generator) -> Share:
    """A block with scratches that bend, and seams from side to side."""
    fine = _canvas(300, 220)
    _fill(fine, [(40, 40), (260, 40), (260, 180), (40, 180)])
    for _ in range(int(rng.integers(1, 5))):
        t = np.linspace(0.0, 1.0, 12)
        x = rng.uniform(30, 200) + t * rng.uniform(20, 120)
        y = rng.uniform(50, 170) + np.cumsum(rng.normal(0.0, 3.0, 12))
        _stroke(fine, np.stack([x, y], axis=1), rng.uniform(0.8, 2.5), 0)
    return _shrunk(fine)


def needles(rng: np.random.Generator) -> Share:
    """Stars and wedges with points down to a few degrees."""
    fine = _canvas(260, 260)
    for at in ((75, 75), (185, 85), (130, 190)):
        many = int(rng.integers(3, 9))
        turn = rng.uniform(0.0, math.tau)
        angles = turn + np.arange(2 * many) * math.pi / many
        outer, inner = rng.uniform(30, 62), rng.uniform(4, 22)
        reach = np.where(np.arange(2 * many) % 2 == 0, outer, inner)
        _fill(fine, np.stack([np.cos(angles), np.sin(angles)], axis=1) * reach[:, None] + at)
    return _shrunk(fine)


def round_things(rng: np.random.Generator) -> Share:
    """Discs, rings, crescents, ellipses and cut discs from a radius of 3 on."""
    fine = _canvas(300, 300)
    for at in ((70, 70), (220, 80), (80, 220), (215, 215)):
        center = np.array(at) + rng.uniform(-6, 6, 2)
        radius = float(np.exp(rng.uniform(math.log(3.0), math.log(60.0))))
        kind = int(rng.integers(0, 5))
        axes = (radius, radius * (rng.uniform(0.1, 1.0) if kind == 1 else 1.0))
        _ellipse(fine, center, axes, rng.uniform(0, 180), 1)
        if kind in (2, 3):
            shift = rng.uniform(0.0, 1.2, 2) * radius if kind == 3 else np.zeros(2)
            _ellipse(fine, center + shift, (radius * rng.uniform(0.2, 0.95),) * 2, 0.0, 0)
        if kind == 4:
            _stroke(fine, [center - (70, 0), np.add(center, (70, rng.uniform(-40, 40)))], 2.0, 0)
    return _shrunk(fine)


def combs(rng: np.random.Generator) -> Share:
    """Bars, teeth, thin walls and gaps of one to six pixels at any angle."""
    fine = _canvas(280, 220)
    turn = rng.uniform(-0.6, 0.6)
    along, across = (
        np.array([math.cos(turn), math.sin(turn)]),
        np.array([-math.sin(turn), math.cos(turn)]),
    )
    at = np.array([60.0, 60.0])
    _stroke(fine, [at, at + 150 * along], rng.uniform(3, 9), 1)
    step = 0.0
    while step < 150.0:
        width = rng.uniform(1.0, 6.0)
        start = at + step * along
        _stroke(fine, [start, start + rng.uniform(10, 80) * across], width, 1)
        step += width + rng.uniform(1.5, 9.0)
    return _shrunk(fine)


def rags(rng: np.random.Generator) -> Share:
    """The level set of smoothed noise: holes, islands and tongues of every size."""
    field = cv2.GaussianBlur(rng.standard_normal((800, 1000)), (0, 0), float(rng.uniform(10, 50)))
    return _shrunk((field > np.quantile(field, rng.uniform(0.4, 0.9))).astype(np.uint8))


def threads(rng: np.random.Generator) -> Share:
    """Thin curves, closed and open, one to three pixels wide, and letters."""
    fine = _canvas(280, 220)
    for _ in range(5):
        t = np.linspace(0.0, 1.0, 60)
        center, radius = rng.uniform(50, 170, 2), rng.uniform(8, 45)
        angles = rng.uniform(0, math.tau) + t * rng.uniform(1.0, 1.1 * math.tau)
        curve = center + radius * np.stack(
            [np.cos(angles), rng.uniform(0.3, 1) * np.sin(angles)], 1
        )
        _stroke(fine, curve, rng.uniform(1.0, 3.0), 1)
    scale = float(rng.uniform(1.0, 3.0)) * FINE
    text = "".join(chr(int(c)) for c in rng.integers(48, 123, 3))
    cv2.putText(
        fine,
        text,
        (120 * FINE, 180 * FINE),
        int(rng.integers(0, 5)),
        scale,
        1,
        int(rng.integers(2, 30)),
    )
    return _shrunk(fine)


FAMILIES: dict[str, Callable[[np.random.Generator], Share]] = {
    "scratches": scratches,
    "needles": needles,
    "round": round_things,
    "combs": combs,
    "rags": rags,
    "threads": threads,
}


def every_look(family: str, count: int, seed: int) -> Iterator[tuple[str, Picture, Look]]:
    """``count`` masks of a family in every look: what each is called, the picture, its look."""
    for i in range(count):
        share = FAMILIES[family](np.random.default_rng([seed, i]))
        for number, look in enumerate(LOOKS):
            rng = np.random.default_rng([seed, i, number])
            yield f"{family} {i} in look {number}", shown(share, look, rng), look


def _canvas(width: int, height: int) -> Picture:
    return np.zeros((height * FINE, width * FINE), np.uint8)


def _fine(points: object) -> NDArray[np.int32]:
    """Points in pixels as ``cv2`` draws them on the fine canvas, with four bits of fraction."""
    there = (np.asarray(points, dtype=np.float64) + 0.5) * FINE - 0.5
    return np.rint(there * 16.0).astype(np.int32)


def _fill(fine: Picture, points: object) -> None:
    cv2.fillPoly(fine, [_fine(points)], 1, shift=4)


def _stroke(fine: Picture, points: object, width: float, value: int) -> None:
    cv2.polylines(fine, [_fine(points)], False, value, max(1, round(width * FINE)), shift=4)


def _ellipse(
    fine: Picture, center: Share, axes: tuple[float, float], turn_deg: float, value: int
) -> None:
    size = [round(a * FINE * 16.0) for a in axes]
    at = _fine(center).tolist()
    cv2.ellipse(fine, at, size, turn_deg, 0, 360, value, -1, shift=4)


def _shrunk(fine: Picture) -> Share:
    h, w = fine.shape
    return np.asarray(
        fine.reshape(h // FINE, FINE, w // FINE, FINE).mean(axis=(1, 3)), dtype=np.float64
    )
