"""The grey rectangle that every small picture shows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

WIDTH, HEIGHT = 32, 24
DARK, LIGHT = 30, 220

Grey = NDArray[np.uint8]


def grey_picture() -> Grey:
    """(24, 32): a rectangle from (8, 6) to (18, 15)."""
    grey = np.full((HEIGHT, WIDTH), LIGHT, np.uint8)
    grey[6:16, 8:19] = DARK
    return grey
