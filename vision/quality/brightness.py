"""Noise, flicker and clipping of a camera's pictures.

Rules and units
- Grey levels 0..255. Noise is the standard deviation of an unchanging pixel, from the differences
  of consecutive pictures; movement is left out by its size.
- Lamps on the mains flicker at twice its frequency, far above the picture rate. The search is for a
  wave of 100 or 120 Hz at the pictures' times, row by row: a rolling shutter shows bands. A wave
  motionless in the pictures is unseen.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from planner.scene import FloatArray
from vision.camera.camera import Image

WHITE: Final = 250
BLACK: Final = 5
FLICKERS_HZ: Final = (100.0, 120.0)
BESIDE_HZ: Final = (-1.3, -0.7, 0.7, 1.3)
"""Offsets from a lamp's frequency at which only noise and motion are."""
CLEAR: Final = 4.0
"""Factor by which flicker exceeds its neighbours."""
LEAST_CYCLES: Final = 2.0
"""Least number of beats between flicker and pictures in the time watched."""


@dataclass(frozen=True, slots=True)
class Flicker:
    """``share`` is the wave's amplitude as a share of the brightness; 0.0 if none is seen.

    ``unseen_hz`` are frequencies that stand still at this rate and remain unknown.
    """

    frequency_hz: float
    share: float
    unseen_hz: tuple[float, ...]


def noise_of(differences: list[Image]) -> float | None:
    """Noise in grey levels from absolute differences of consecutive pictures; None without any.

    The mean of the smaller half of |a - b| is 0.4523 sigma of the noise of both, without rounding.
    """
    if not differences:
        return None
    counts = np.zeros(256)
    for difference in differences:
        counts += np.bincount(difference.ravel(), minlength=256)[:256]
    # a rounded difference d is one of d - 1/2 .. d + 1/2: the share up to a level gives sigma
    shares = np.cumsum(counts) / counts.sum()
    level = int(np.searchsorted(shares, 0.6))
    inside = float(shares[level])
    if inside >= 1.0:
        return 0.0
    return (level + 0.5) / (math.sqrt(2.0) * _two_sided_quantile(inside))


def _two_sided_quantile(share: float) -> float:
    """z with P(|N(0, 1)| <= z) = share, by bisection; at least a hundredth."""
    low, high = 0.01, 10.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if math.erf(middle / math.sqrt(2.0)) < share else (low, middle)
    return low


def flicker_of(times_s: FloatArray, rows: FloatArray) -> Flicker:
    """Flicker in rows' mean brightness (n, h) at even times (n,)."""
    seconds = float(times_s[-1] - times_s[0]) if len(times_s) > 1 else 0.0
    rate_hz = (len(times_s) - 1) / seconds if seconds > 0.0 else 0.0
    unseen = tuple(f for f in FLICKERS_HZ if _beat_hz(f, rate_hz) * seconds < LEAST_CYCLES)
    bright = max(float(rows.mean()), 1.0)
    best = Flicker(0.0, 0.0, unseen)
    if len(times_s) < 30:
        return Flicker(0.0, 0.0, FLICKERS_HZ)
    window = np.hanning(len(times_s) + 2)[1:-1]
    level = (window @ rows) / window.sum()
    changes = (rows - level) * window[:, None] / window.sum()
    for frequency_hz in FLICKERS_HZ:
        if frequency_hz in unseen:
            continue
        wave = _amplitude(times_s, changes, frequency_hz)
        beside = max(_amplitude(times_s, changes, frequency_hz + beside) for beside in BESIDE_HZ)
        if wave > CLEAR * beside and wave / bright > best.share:
            best = Flicker(frequency_hz, wave / bright, unseen)
    return best


def _beat_hz(frequency_hz: float, rate_hz: float) -> float:
    if rate_hz <= 0.0:
        return 0.0
    return abs(math.remainder(frequency_hz, rate_hz))


def _amplitude(times_s: FloatArray, changes: FloatArray, frequency_hz: float) -> float:
    wave = np.exp(-2j * math.pi * frequency_hz * (times_s - times_s[0]))
    return 2.0 * float(np.sqrt(np.mean(np.abs(wave @ changes) ** 2)))


def clipped_of(image: Image, mask: Image | None = None) -> tuple[float, float]:
    """Shares of pixels within a mask that are clipped to white and to black."""
    whole = float(np.count_nonzero(mask)) if mask is not None else float(image.size)
    if whole == 0.0:
        return 0.0, 0.0
    white = cv2.inRange(image, np.array([WHITE]), np.array([255]))
    black = cv2.inRange(image, np.array([0]), np.array([BLACK]))
    if mask is not None:
        white, black = cv2.bitwise_and(white, mask), cv2.bitwise_and(black, mask)
    return np.count_nonzero(white) / whole, np.count_nonzero(black) / whole
