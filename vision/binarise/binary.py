"""A picture in black and white, and how it is made once the level is known.

Rules and units
- A pixel is obstacle where its grey value lies below the level.
- Where noise alone could cross the level it is compared in a smoothed picture; dots that are too
  small for that are added by their depth.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from planner.scene import Binarisation
from vision.binarise.grey_picture import CALMINGS, NO_CALMING, SAFE_MARGIN_SIGMAS, Look


@dataclass(frozen=True, slots=True)
class Binary:
    """A picture in black and white.

    ``mask`` (h + 2, w') uint8: 1 is obstacle, with a margin of free pixels and rows of a
    multiple of eight bytes; ``grey`` (h, w), obstacles dark, ``level`` in its values;
    ``noise`` its standard deviation and ``contrast`` the step between free and obstacle.
    ``by_level``: the mask is what lies below the level in ``grey``, no more and no less.
    ``doubtful``: even smoothed as far as may be, the noise alone could have made single pixels.
    """

    mask: NDArray[np.uint8]
    grey: NDArray[Any]
    level: float
    noise: float
    contrast: float
    how: Binarisation
    remarks: tuple[str, ...] = ()
    by_level: bool = False
    doubtful: bool = False

    @property
    def size(self) -> tuple[int, int]:
        """The picture's (width, height)."""
        return self.grey.shape[1], self.grey.shape[0]

    @property
    def inside(self) -> NDArray[np.uint8]:
        """The mask without its margin, (h, w)."""
        return self.mask[1:-1, 1 : self.grey.shape[1] + 1]


def black_and_white(
    look: Look,
    level: float,
    contrast: float,
    how: Binarisation,
    *,
    noise: float | None = None,
    strongest_noise: float | None = None,
    margin: float | None = None,
) -> Binary:
    """Compare with the level, in a smoothed picture where noise alone could cross it."""
    remarks: tuple[str, ...] = ()
    noise = look.noise if noise is None else noise
    strongest = noise if strongest_noise is None else strongest_noise
    margin = 0.5 * contrast if margin is None else margin
    safe = [one for one in CALMINGS if SAFE_MARGIN_SIGMAS * strongest * one.left <= margin]
    calming = safe[0] if safe else CALMINGS[-1]
    if calming is not NO_CALMING:
        remarks = (
            f"noise of up to {strongest:.0f} grey levels at a contrast of {contrast:.0f}: the "
            f"picture was smoothed by {calming.sigma_px:.0f} px before the level was applied",
        )
    mask = look.mask_below(level, calming, strongest)
    by_level = calming is NO_CALMING
    return Binary(mask, look.grey, level, noise, contrast, how, remarks, by_level, not safe)
