"""A first look at a picture: its noise, its histogram, and itself with less noise.

Grey values are 0 .. 255; noise is its standard deviation in grey levels.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.binarise_kernels import noise_sigma, sampled_histogram
from vision.room import Room

SAFE_MARGIN_SIGMAS = 6.0
"""From here on no pixel of a whole picture crosses the level by noise alone."""
CALM_NOISE, WILD_NOISE = 4.0, 25.0
"""Noise, in grey levels, from which a picture is smoothed by 1 and by 2 px where noise counts."""
LEFT_BY_GAUSSIAN = 0.2821
"""The share of white noise that a Gaussian of sigma 1 leaves; less for a wider one."""
LEFT_BY_BINOMIAL = 0.2734
"""The same for the binomial of 5 x 5 pixels, whose sigma is 1 too."""


class Look:
    """A grey picture, its noise and its histogram; smoothed once for every sigma asked for."""

    def __init__(self, grey: NDArray[Any], room: Room | None = None) -> None:
        self.grey = grey
        self.room = Room() if room is None else room
        self.counts: NDArray[np.int64] = sampled_histogram(grey)
        # two values only: drawn, not taken; what looks like noise is texture
        drawn = np.count_nonzero(self.counts) <= 2
        self.noise = 0.0 if drawn else float(noise_sigma(grey))
        self._smoothed: dict[float, NDArray[Any]] = {}

    def calmed(self, noise: float) -> tuple[NDArray[Any], float]:
        """The picture smoothed as noise demands, and the share of the noise that is left."""
        if noise < CALM_NOISE:
            return self.grey, 1.0
        sigma = 1.0 if noise < WILD_NOISE else 2.0
        if sigma not in self._smoothed:
            # the binomial takes half the time of the Gaussian of its width
            self._smoothed[sigma] = (
                cv2.GaussianBlur(self.grey, (5, 5), 0.0)
                if sigma == 1.0
                else cv2.GaussianBlur(self.grey, (0, 0), sigma)
            )
        return self._smoothed[sigma], LEFT_BY_BINOMIAL if sigma == 1.0 else LEFT_BY_GAUSSIAN / sigma
